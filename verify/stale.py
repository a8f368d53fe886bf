"""Breakages that no longer break anything: what they replace is gone, or takes other arguments.

`python -m verify.stale` names them. Such a breakage ends its checks with an error of its own, not with a failure. It
runs in a process of its own, since it applies every breakage, one after the other.
"""

import importlib
import inspect
import pkgutil
import sys
import types
from collections.abc import Iterator
from typing import Any

import jaxbuffer

from .breakage import Breakage
from .breakages import BREAKAGES

Owner = types.ModuleType | type


def main() -> int:
    """Print what is stale; the exit status."""
    for module in pkgutil.walk_packages(jaxbuffer.__path__, "jaxbuffer."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    found = [line for breakage in BREAKAGES for line in _stale(breakage, list(_owners()))]
    print(*found, sep="\n", end="\n" if found else "")
    return int(bool(found))


def _owners() -> Iterator[Owner]:
    """Yield our modules and their classes, whose attributes breakages replace."""
    for name, module in list(sys.modules.items()):
        if name.startswith("jaxbuffer"):
            yield module
            yield from (it for it in vars(module).values() if isinstance(it, type) and it.__module__ == name)


def _stale(breakage: Breakage, owners: list[Owner]) -> list[str]:
    """Apply a breakage, undo it, and return what is wrong with it, a line each."""
    before = {id(owner): dict(vars(owner)) for owner in owners}
    try:
        breakage.apply()
    except (AttributeError, ImportError) as error:
        return [f"{breakage.name}: {error}"]
    lines, replaced = list[str](), 0
    for owner in owners:
        for name, new in dict(vars(owner)).items():
            old = before[id(owner)].get(name)
            # Importing a submodule adds its name; a class notes things about itself.
            if new is old or isinstance(new, types.ModuleType) or name in ("__annotations__", "__abstractmethods__"):
                continue
            replaced += 1
            if old is None:
                delattr(owner, name)
                old = getattr(owner, name, None) if isinstance(owner, type) else None
            else:
                setattr(owner, name, old)
            if old is None:
                lines.append(f"{breakage.name}: there is no {owner.__name__}.{name}")
            elif not _takes_the_same(old, new):
                lines.append(f"{breakage.name}: {owner.__name__}.{name} takes other arguments")
    return lines if replaced else [*lines, f"{breakage.name}: it replaces nothing"]


def _takes_the_same(old: Any, new: Any) -> bool:
    """Return whether a replacement takes the positional arguments that what it replaces needs, and needs no more."""
    both = [_positional(it) for it in (old, new)]
    if None in both:
        return True
    (taken, needed), (new_taken, new_needed) = both  # type: ignore[misc]
    return new_taken >= needed and new_needed <= taken


def _positional(function: Any) -> tuple[float, int] | None:
    """Return how many positional arguments a function takes, and needs; None of what is no function."""
    if not callable(function) or isinstance(function, type):
        return None
    parameters = inspect.signature(function).parameters.values()
    plain = [it for it in parameters if it.kind in (it.POSITIONAL_ONLY, it.POSITIONAL_OR_KEYWORD)]
    needed = sum(it.default is it.empty for it in plain)
    return (float("inf") if any(it.kind is it.VAR_POSITIONAL for it in parameters) else len(plain)), needed


if __name__ == "__main__":
    sys.exit(main())
