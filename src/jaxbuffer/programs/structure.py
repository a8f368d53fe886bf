"""The structure of a program's arguments and result: which classes, which static values, and where the arrays are."""

import importlib
from collections.abc import Iterable, Iterator
from typing import Any

import equinox as eqx
import jax
from jax.tree_util import PyTreeDef, default_registry

from . import identity

_JSON = (type(None), bool, int, float, str)
_BUILT_IN: dict[str, type] = {"none": type(None), "tuple": tuple, "list": list, "dict": dict}
_NAMES = {kind: name for name, kind in _BUILT_IN.items()}
_LEAF = jax.tree.structure(0)


class CannotSay(ValueError):
    """A structure that has no text."""


class _Empty(eqx.Module):
    """Shows how Equinox marks a module that wraps nothing."""


_UNWRAPPED = next(iter(jax.tree.structure(_Empty()).node_data()[1]))  # type: ignore[attr-defined]


def nodes(structure: PyTreeDef) -> Iterable[tuple[type, Any]]:
    """Yield type and static values of each node, from the root on."""
    data = structure.node_data()
    if data is not None:
        kind, static = data
        whole = issubclass(kind, eqx.Module) and static[0] is _UNWRAPPED
        yield kind, static[1:] if whole else static
        for child in structure.children():
            yield from nodes(child)


def user_code(*things: Any) -> str:
    """Return a hash of the user's code that numbers of these designs, mechanisms and classes depend on, the same in
    every process; "" where the packages have all of it."""
    used = [thing for thing in things if isinstance(thing, type)]
    for kind, static in (node for thing in things for node in nodes(jax.tree.structure(thing))):
        used += [kind, *_flat(static)]
    own = [part for part in used if not identity.lasts(part)]
    return identity.source_hash(*own) if own else ""


def _flat(static: Any) -> Iterator[Any]:
    if isinstance(static, (tuple, list)):
        for part in static:
            yield from _flat(part)
    else:
        yield static


def outline(structure: PyTreeDef) -> Any:
    """Return where leaves are among the nodes: 0 for a leaf, else a tuple with an outline for each child."""
    return 0 if structure.node_data() is None else tuple(map(outline, structure.children()))


def written(structure: PyTreeDef) -> Any:
    """Write the structure of a result for JSON: names of our classes and plain values, so that reading it runs no code.

    **Raises:** `CannotSay` for classes of others and other values.
    """
    data = structure.node_data()
    if data is None:
        return 0
    kind, static = data
    name = _NAMES.get(kind, f"{kind.__module__}:{kind.__qualname__}")
    if _our_class(name) is not kind:
        raise CannotSay(f"{name} is not a class of this package")
    if issubclass(kind, eqx.Module):
        if static[0] is not _UNWRAPPED:
            raise CannotSay(f"{name} wraps a function")
        static = static[1:]
    return [name, _plain(static), [written(child) for child in structure.children()]]


def read(text: Any) -> PyTreeDef:
    """Read the structure that `written` wrote."""
    if text == 0:
        return _LEAF
    name, values, children = text
    kind, static = _our_class(name), _static(values)
    if issubclass(kind, eqx.Module):
        static = (_UNWRAPPED, *static)
    return PyTreeDef.from_node_data_and_children(default_registry, (kind, static), [read(child) for child in children])


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


def _plain(value: Any) -> Any:
    """Write static values for JSON; a tuple becomes an object, to tell it from a list."""
    if type(value) in _JSON:
        return value
    # By type, not by `isinstance`: a subclass would not be read back as itself.
    if type(value) is tuple:
        return {"tuple": [_plain(part) for part in value]}
    if type(value) is list:
        return [_plain(part) for part in value]
    if isinstance(value, str):  # a law, which is read by its name
        return {"word": [f"{type(value).__module__}:{type(value).__qualname__}", str(value)]}
    raise CannotSay(f"{value!r} is not a plain value")


def _static(value: Any) -> Any:
    if isinstance(value, dict) and "word" in value:
        kind, word = value["word"]
        return _our_class(kind)(word)
    if isinstance(value, dict):
        return tuple(_static(part) for part in value["tuple"])
    return [_static(part) for part in value] if isinstance(value, list) else value
