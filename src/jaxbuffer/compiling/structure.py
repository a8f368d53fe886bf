"""The structure of a result as text, so that a program's file says it without code: names of classes and plain values.

A name stands for a class of this package or for one that the program's arguments have; nothing else is looked up, and
nothing is called.
"""

import importlib
from collections.abc import Iterable, Mapping
from typing import Any

import equinox as eqx
import jax
from jax.tree_util import PyTreeDef, default_registry

PLAIN = (type(None), bool, int, float, str)
_BUILT_IN: dict[str, type] = {"none": type(None), "tuple": tuple, "list": list, "dict": dict}
_NAMES = {kind: name for name, kind in _BUILT_IN.items()}
_LEAF = jax.tree.structure(0)


class _Empty(eqx.Module):
    """Shows how Equinox marks a module that wraps nothing."""


_UNWRAPPED = next(iter(jax.tree.structure(_Empty()).node_data()[1]))  # type: ignore[attr-defined]


class CannotSay(ValueError):
    """A structure that has no such text."""


def nodes(structure: PyTreeDef) -> Iterable[tuple[type, Any]]:
    """Type and static values of each node, from the root on."""
    data = structure.node_data()
    if data is not None:
        kind, static = data
        whole = issubclass(kind, eqx.Module) and static[0] is _UNWRAPPED
        yield kind, static[1:] if whole else static
        for child in structure.children():
            yield from nodes(child)


def outline(structure: PyTreeDef) -> Any:
    """Where leaves are among the nodes: 0 for a leaf, else a tuple with an outline for each child."""
    return 0 if structure.node_data() is None else tuple(map(outline, structure.children()))


def written(structure: PyTreeDef, arguments: PyTreeDef) -> Any:
    """A structure as lists, numbers and words; classes that neither this package nor the arguments have are refused."""
    classes = _classes(arguments)

    def node(structure: PyTreeDef) -> Any:
        data = structure.node_data()
        if data is None:
            return 0
        kind, static = data
        name = next(
            (name for name, known in _BUILT_IN.items() if known is kind), f"{kind.__module__}:{kind.__qualname__}"
        )
        if _class(name, classes) is not kind:
            raise CannotSay(f"{name} is not a class of this package or of the arguments")
        if issubclass(kind, eqx.Module):
            if static[0] is not _UNWRAPPED:
                raise CannotSay(f"{name} wraps a function")
            static = static[1:]
        return [name, _plain(static), [node(child) for child in structure.children()]]

    return node(structure)


def read(text: Any, arguments: PyTreeDef) -> PyTreeDef:
    """The structure that `written` wrote."""
    classes = _classes(arguments)

    def node(text: Any) -> PyTreeDef:
        if text == 0:
            return _LEAF
        name, values, children = text
        kind, static = _class(name, classes), _static(values)
        if issubclass(kind, eqx.Module):
            static = (_UNWRAPPED, *static)
        return PyTreeDef.from_node_data_and_children(
            default_registry, (kind, static), [node(child) for child in children]
        )

    return node(text)


def _classes(structure: PyTreeDef) -> dict[str, type]:
    return {f"{kind.__module__}:{kind.__qualname__}": kind for kind, _ in nodes(structure)}


def _class(name: str, classes: Mapping[str, type]) -> type:
    if name in _BUILT_IN:
        return _BUILT_IN[name]
    if name in classes:
        return classes[name]
    module, _, path = name.partition(":")
    found: Any = importlib.import_module(module) if module.split(".")[0] == __name__.split(".")[0] else None
    for part in path.split("."):
        found = getattr(found, part, None)
    if not (isinstance(found, type) and issubclass(found, (eqx.Module, tuple))):
        raise CannotSay(f"{name} is not a class of this package or of the arguments")
    return found


def _plain(value: Any) -> Any:
    """Static values as JSON has them; a tuple as an object, to tell it from a list."""
    if type(value) in PLAIN:
        return value
    if type(value) is tuple:
        return {"tuple": [_plain(part) for part in value]}
    if type(value) is list:
        return [_plain(part) for part in value]
    raise CannotSay(f"{value!r} is not a plain value")


def _static(value: Any) -> Any:
    if isinstance(value, dict):
        return tuple(_static(part) for part in value["tuple"])
    return [_static(part) for part in value] if isinstance(value, list) else value
