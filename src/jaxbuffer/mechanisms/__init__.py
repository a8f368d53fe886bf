"""Mechanisms, a folder each, and what they are made from.

A folder, or a package of another distribution, registers its `Mechanism` when it is imported. Which of the latter there
are is said by their entry points in the group ``jaxbuffer.mechanisms``: the name is the mechanism's kind, the value the
module to import. The drop onto a tank comes in by that door, too.
"""

import functools
import importlib
import sys
import warnings
from importlib.metadata import EntryPoint, EntryPoints, entry_points
from typing import TYPE_CHECKING, Any

from ..errors import InputError

if TYPE_CHECKING:
    from .mechanism import Mechanism

FOLDERS = ("probe_cone", "docking3d", "bar_drop", "slider_crank")
GROUP = "jaxbuffer.mechanisms"


def all_mechanisms() -> "tuple[Mechanism, ...]":
    """Return the mechanisms of the folders, in the order above, and then all others by name.

    A package whose mechanism cannot be imported is warned of and left out: the others are not to suffer from it.
    """
    from .registry import all_registered  # imports JAX, which the package's own import must not

    for folder in FOLDERS:
        importlib.import_module(f".{folder}", __name__)
    for entry in entries():
        try:
            _load(entry)
        except InputError as error:
            warnings.warn(str(error), RuntimeWarning, stacklevel=2)
    place = {name: k for k, name in enumerate(FOLDERS)}
    return tuple(sorted(all_registered(), key=lambda it: (place.get(it.name, len(place)), it.name)))


def mechanism_named(name: Any) -> "Mechanism":
    """Return the mechanism of a kind, such as "probe_cone".

    **Raises:** `InputError` that lists the kinds there are, and for a package whose mechanism cannot be imported.
    """
    from .registry import registered  # imports JAX, see above

    if name in FOLDERS:
        importlib.import_module(f".{name}", __name__)
    else:
        for entry in entries():
            if entry.name == name:
                _load(entry)
        all_mechanisms()
    return registered(name)


def entries() -> EntryPoints:
    """Return the entry points of mechanisms in other packages, or in this one behind the same door."""
    return _entries(tuple(sys.path))


@functools.cache
def _entries(path: tuple[str, ...]) -> EntryPoints:
    """Return the entry points of the distributions on a path, read once: a file is opened for all that is installed."""
    return entry_points(group=GROUP)


def _load(entry: EntryPoint) -> None:
    """Import the module of an entry point. **Raises:** `InputError` where that fails, whatever the reason."""
    try:
        entry.load()
    except Exception as error:
        package = entry.dist.name if entry.dist is not None else entry.value
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise InputError(f"kind = {entry.name!r}: the package {package} cannot be imported ({reason})") from error
