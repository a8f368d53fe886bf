"""Dotted paths into designs and scenarios: "buffer.k_A", as in TOML and on the command line."""

import dataclasses
from collections.abc import Collection, Iterator, Mapping
from typing import Any, TypeVar

import equinox as eqx

from ..errors import InputError, check_type, shown, suggest

T = TypeVar("T", bound=eqx.Module)


def paths(module: eqx.Module, prefix: str = "") -> Iterator[str]:
    """All dotted paths of a design or scenario, static choices included."""
    for name in (field.name for field in dataclasses.fields(module)):
        value = getattr(module, name)
        if isinstance(value, eqx.Module):
            yield from paths(value, f"{prefix}{name}.")
        else:
            yield prefix + name


def check_path(module: eqx.Module, path: str) -> None:
    """Raise `InputError` with the nearest name unless ``path`` exists."""
    if not isinstance(path, str):
        raise InputError(f"{shown(path)} is not a dotted path such as 'buffer.k_A'")
    known = list(paths(module))
    if path not in known:
        sections = {p.rsplit(".", 1)[0] for p in known if "." in p}
        hint = " is a section; name one of its fields" if path in sections else " is unknown" + suggest(path, known)
        raise InputError(f"{path}{hint}")


def get(module: eqx.Module, path: str) -> Any:
    """The value at a dotted path."""
    check_type("design or scenario", module, eqx.Module, "get(jb.table2(), 'buffer.k_A')")
    check_path(module, path)
    for name in path.split("."):
        module = getattr(module, name)
    return module


def limits_of(module: eqx.Module, path: str) -> Mapping[str, Any]:
    """The declared range of a path's numbers, as keywords of `check_number`."""
    *owners, name = path.split(".")
    for owner in owners:
        module = getattr(module, owner)
    limits: Mapping[str, Any] = {f.name: f.metadata for f in dataclasses.fields(module)}[name].get("limits", {})
    return limits


def unit(module: eqx.Module, path: str) -> str:
    """The unit of a path, "" for a choice."""
    *owners, name = path.split(".")
    for owner in owners:
        module = getattr(module, owner)
    metadata = {field.name: field.metadata for field in dataclasses.fields(module)}
    return metadata[name].get("unit", "")


def replace(module: T, values: Mapping[str, Any]) -> T:
    """A copy with the values at dotted paths replaced, validated like a new one; works on traced values.

    Example: ``replace(table2(), {"buffer.k_A": 800.0, "probe.tip_mass": 0.05})``.
    """
    check_type("design or scenario", module, eqx.Module, "replace(jb.table2(), {'buffer.k_A': 800.0})")
    check_type("values", values, Mapping, "replace(jb.table2(), {'buffer.k_A': 800.0})")
    for path in values:
        check_path(module, path)
    return _replace(module, {tuple(path.split(".")): value for path, value in values.items()})


def by_path(table: Mapping[str, Any], values: Collection[str] = (), where: str = "") -> dict[str, Any]:
    """TOML's nested tables as dotted paths: to it an unquoted ``buffer.k_A = …`` is a table in a table.

    **Arguments:** ``values``: keys that make a table a value itself; ``where``: the table's name in an error.
    **Raises:** `InputError` for a path given twice, as ``buffer.k_A`` and as ``"buffer.k_A"``.
    """
    flat: dict[str, Any] = {}
    for name, value in table.items():
        nested = isinstance(value, Mapping) and not set(value) & set(values)
        inner = (
            {f"{name}.{rest}": it for rest, it in by_path(value, values, where).items()} if nested else {name: value}
        )
        for path in inner:
            if path in flat:
                raise InputError(f'{where}: {path} is given twice, as {path} and as "{path}"; keep one')
        flat |= inner
    return flat


def _replace(module: T, values: dict[tuple[str, ...], Any]) -> T:
    fields = {}
    for name in (field.name for field in dataclasses.fields(module)):
        inner = {key[1:]: value for key, value in values.items() if key[0] == name}
        current = getattr(module, name)
        if () in inner:
            fields[name] = inner[()]
        else:
            fields[name] = _replace(current, inner) if inner else current
    return type(module)(**fields)
