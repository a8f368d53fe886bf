"""The structure of a program's arguments and result: which classes, which static values, and where the arrays are."""

import functools
import importlib
from collections.abc import Iterator
from typing import Any

import equinox as eqx
import jax
from jax.tree_util import PyTreeDef, default_registry

from . import identity

_JSON = (type(None), bool, int, float, str)
_BUILT_IN: dict[str, type] = {kind.__name__: kind for kind in (type(None), tuple, list, dict)}
_LEAF = jax.tree.structure(0)


class CannotSay(ValueError):
    """A structure that has no text."""


class _Empty(eqx.Module):
    """Shows how Equinox marks a module that wraps nothing."""


_UNWRAPPED = next(iter(jax.tree.structure(_Empty()).node_data()[1]))  # type: ignore[attr-defined]


def nested(structure: PyTreeDef) -> Any:
    """Return 0 for a leaf, else type and static values of the node, and a list of its children in the same way."""
    data = structure.node_data()
    if data is None:
        return 0
    kind, static = data
    if issubclass(kind, eqx.Module) and static[0] is _UNWRAPPED:
        static = static[1:]
    return kind, static, [nested(child) for child in structure.children()]


def user_code(*things: Any) -> str:
    """Return a hash of the user's code that numbers of these designs, mechanisms and classes depend on, the same in
    every process; "" where the packages have all of it."""
    structures = tuple(thing if isinstance(thing, type) else jax.tree.structure(thing) for thing in things)
    if not _of_user(structures):
        return ""
    trees = _trees(structures)
    return identity.source_hash(*(part for part in _flat(trees) if identity.Description(part).of_user))


# Remembered, because looking takes over a quarter of a sweep of one run, and the code of the packages does not change.
@functools.lru_cache(maxsize=64)
def _of_user(structures: tuple[Any, ...]) -> bool:
    """Return whether any of the user's code belongs to these structures and classes."""
    return identity.Description(_trees(structures)).of_user


def _trees(structures: tuple[Any, ...]) -> list[Any]:
    return [it if isinstance(it, type) else nested(it) for it in structures]


def _flat(parts: Any) -> Iterator[Any]:
    if isinstance(parts, (tuple, list)):
        for part in parts:
            yield from _flat(part)
    else:
        yield parts


def written(structure: PyTreeDef) -> Any:
    """Write the structure of a result for JSON: names of our classes and plain values, so that reading it runs no code.

    **Raises:** `CannotSay` for classes of others and other values.
    """
    return _plain(nested(structure))


def read(text: Any) -> PyTreeDef:
    """Read the structure that `written` wrote."""
    return _tree(_read(text))


def _tree(parts: Any) -> PyTreeDef:
    if parts == 0:
        return _LEAF
    kind, static, children = parts
    if issubclass(kind, eqx.Module):
        static = (_UNWRAPPED, *static)
    return PyTreeDef.from_node_data_and_children(default_registry, (kind, static), list(map(_tree, children)))


def _plain(value: Any) -> Any:
    """Write classes and static values for JSON; a list is as it is, and anything else that JSON lacks an object."""
    # By type, not by `isinstance`: a subclass would not be read back as itself.
    kind = type(value)
    if kind in _JSON:
        return value
    if kind is list:
        return list(map(_plain, value))
    if kind is tuple:
        return {"tuple": list(map(_plain, value))}
    if isinstance(value, type):
        name = value.__name__ if value in _BUILT_IN.values() else f"{value.__module__}:{value.__qualname__}"
        if _our_class(name) is value:
            return {"class": name}
    elif isinstance(value, str):  # a law, which is read by its name
        return {"word": str(value), "of": _plain(kind)}
    raise CannotSay(f"{value!r} is no class of this package and not a plain value")


def _read(text: Any) -> Any:
    if isinstance(text, list):
        return list(map(_read, text))
    if not isinstance(text, dict):
        return text
    if "word" in text:
        return _read(text["of"])(text["word"])
    return _our_class(text["class"]) if "class" in text else tuple(map(_read, text["tuple"]))


def _our_class(name: str) -> type:
    """Find a class by its name; nothing outside this package is looked up or imported."""
    if name in _BUILT_IN:
        return _BUILT_IN[name]
    module, _, path = name.partition(":")
    target: Any = importlib.import_module(module) if module.split(".")[0] in identity.OURS else None
    for part in path.split("."):
        target = getattr(target, part, None)
    if not (isinstance(target, type) and issubclass(target, (eqx.Module, tuple, str))):
        raise CannotSay(f"{name} is not a class of this package")
    return target
