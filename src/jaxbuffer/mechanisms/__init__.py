"""Mechanisms, a folder each, and what they are made from.

A folder registers its `Mechanism` when it is imported; this is the list of those that come with the package.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .mechanism import Mechanism

FOLDERS = ("probe_cone", "bar_drop", "slider_crank", "tank_drop")


def all_mechanisms() -> "tuple[Mechanism, ...]":
    """All that come with the package, in the order above, and then those that were registered besides."""
    for folder in FOLDERS:
        importlib.import_module(f".{folder}", __name__)
    from .registry import all_registered

    place = {name: k for k, name in enumerate(FOLDERS)}
    return tuple(sorted(all_registered(), key=lambda it: place.get(it.name, len(place))))


def mechanism_named(name: Any) -> "Mechanism":
    """The mechanism of a name, such as "probe_cone". **Raises:** `InputError` that lists those there are."""
    all_mechanisms()
    from .registry import registered

    return registered(name)
