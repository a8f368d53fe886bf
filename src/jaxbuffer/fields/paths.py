"""Dotted paths into designs and scenarios: "buffer.k_A", as in TOML and on the command line."""

import dataclasses
from collections.abc import Collection, Iterator, Mapping
from typing import Any, TypeVar

import equinox as eqx

from ..errors import InputError, check_type, shown, suggest

T = TypeVar("T", bound=eqx.Module)


def paths(module: eqx.Module, prefix: str = "") -> Iterator[str]:
    """All dotted paths of a design or scenario, static choices included.

    **Arguments:**

    - ``module``: the design or scenario.
    - ``prefix``: put before each path.

    **Example:**

    >>> list(jb.paths(jb.Scenario()))
    ['approach_speed', 'contact_distance', 'misalignment', 'passive_rate']
    """
    for name in (field.name for field in dataclasses.fields(module)):
        value = getattr(module, name)
        if isinstance(value, eqx.Module):
            yield from paths(value, f"{prefix}{name}.")
        else:
            yield prefix + name


def check_path(module: eqx.Module, path: str) -> None:
    """Check that ``path`` is a dotted path of ``module``. **Raises:** `InputError` with the nearest name."""
    if not isinstance(path, str):
        raise InputError(f"{shown(path)} is not a dotted path such as 'buffer.k_A'")
    known = list(paths(module))
    if path not in known:
        sections = {p.rsplit(".", 1)[0] for p in known if "." in p}
        hint = " is a section; name one of its fields" if path in sections else " is unknown" + suggest(path, known)
        raise InputError(f"{path}{hint}")


def get(module: eqx.Module, path: str) -> Any:
    """The value at a dotted path.

    **Arguments:**

    - ``module``: a design or scenario.
    - ``path``: such as "buffer.k_A".

    **Returns:** the value in the field's unit, or a part for the path of a section.

    **Raises:** `InputError` with the nearest name for a path that does not exist.

    **Example:**

    >>> jb.get(jb.table2(), "buffer.k_A")  # N/m
    500.0
    """
    check_type("design or scenario", module, eqx.Module, "get(jb.table2(), 'buffer.k_A')")
    check_path(module, path)
    for name in path.split("."):
        module = getattr(module, name)
    return module


def metadata(module: eqx.Module, path: str) -> Mapping[str, Any]:
    """What the field at ``path`` of ``module`` declares of itself: unit, limits, choices."""
    *owners, name = path.split(".")
    for owner in owners:
        module = getattr(module, owner)
    return {field.name: field.metadata for field in dataclasses.fields(module)}[name]


def meaning(module: eqx.Module, path: str) -> str:
    """What the field at ``path`` of ``module`` means, in a few words; its name where it declares none."""
    return metadata(module, path).get("doc") or path.rpartition(".")[2].replace("_", " ")


def limits_of(module: eqx.Module, path: str) -> Mapping[str, Any]:
    """The declared range of the numbers at ``path`` of ``module``, as keywords of `check_number`."""
    limits: Mapping[str, Any] = metadata(module, path).get("limits", {})
    return limits


def unit(module: eqx.Module, path: str) -> str:
    """The unit of what is at ``path`` of ``module``, "" for a choice."""
    return metadata(module, path).get("unit", "")


def replace(module: T, values: Mapping[str, Any]) -> T:
    """A copy with the values at dotted paths replaced, validated like a new one; works on traced values.

    **Arguments:**

    - ``module``: a design or scenario.
    - ``values``: by path, in the field's unit.

    **Raises:** `InputError` for a path that does not exist and a value out of its range.

    **Example:**

    >>> design = jb.replace(jb.table2(), {"buffer.k_A": 800.0, "probe.tip_mass": 0.05})
    >>> design.buffer.k_A
    800.0
    """
    check_type("design or scenario", module, eqx.Module, "replace(jb.table2(), {'buffer.k_A': 800.0})")
    check_type("values", values, Mapping, "replace(jb.table2(), {'buffer.k_A': 800.0})")
    for path in values:
        check_path(module, path)
    return _replace(module, {tuple(path.split(".")): value for path, value in values.items()})


def by_path(table: Mapping[str, Any], values: Collection[str] = (), where: str = "") -> dict[str, Any]:
    """TOML's nested tables as dotted paths: in TOML an unquoted ``buffer.k_A = …`` is a table in a table.

    **Arguments:**

    - ``table``: as TOML gives it.
    - ``values``: keys that make a table a value itself.
    - ``where``: the table's name in an error.

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
