"""Dotted paths into designs and scenarios: "buffer.k_A", as in TOML and on the command line."""

import dataclasses
import functools
from collections.abc import Collection, Iterator, Mapping
from typing import Any, TypeVar

import equinox as eqx

from ..errors import InputError, check_type, shown, suggest
from ..suggestions import Meaning
from .curve import Curve, number_metadata

T = TypeVar("T", bound=eqx.Module)


def paths(module: eqx.Module, prefix: str = "") -> Iterator[str]:
    """Yield all dotted paths of a design or scenario, static choices included; a measured curve has one.

    **Arguments:**

    - ``module``: the design or scenario.
    - ``prefix``: put before each path.

    **Example:**

    >>> list(jb.paths(jb.BarDropScenario()))
    ['height', 'gravity']
    """
    for name in (field.name for field in dataclasses.fields(module)):
        value = getattr(module, name)
        if isinstance(value, eqx.Module) and not isinstance(value, Curve):
            yield from paths(value, f"{prefix}{name}.")
        else:
            yield prefix + name


def point_paths(module: eqx.Module) -> Iterator[str]:
    """Yield the paths of the numbers of a design's measured curves, such as "buffer.spring_curve.force[2]"."""
    for path in paths(module):
        value = _at(module, path)
        if isinstance(value, Curve):
            yield from (f"{path}.{address}" for address in value.addresses())


def check_path(module: eqx.Module, path: str) -> None:
    """Check that ``path`` is a dotted path of ``module``. **Raises:** `InputError` with the nearest name."""
    if not isinstance(path, str):
        raise InputError(f"{shown(path)} is not a dotted path such as 'buffer.k_A'")
    if has_path(module, path):
        return
    known = [*paths(module), *(point_paths(module) if "[" in path else ())]
    if path not in known:
        sections = {p.rsplit(".", 1)[0] for p in known if "." in p}
        is_section = path in sections and path not in paths(module)
        hint = (
            " is a section; name one of its fields"
            if is_section
            else unknown(module, path, known, lambda it: meaning(module, it))
        )
        raise InputError(f"{path}{hint}")


@functools.cache
def _declared(kind: type[eqx.Module]) -> Mapping[str, Mapping[str, Any]]:
    """Return what each field of a class declares of itself, by name."""
    return {field.name: field.metadata for field in dataclasses.fields(kind)}


def has_path(module: eqx.Module, path: str) -> bool:
    """Return whether ``path`` is one of `paths`, without listing them: a tuning asks this thousands of times."""
    value: Any = module
    for name in path.split("."):
        if not isinstance(value, eqx.Module) or isinstance(value, Curve) or name not in _declared(type(value)):
            return False
        value = getattr(value, name)
    return not isinstance(value, eqx.Module) or isinstance(value, Curve)


def unknown(module: eqx.Module, path: str, known: Collection[str], means: Meaning) -> str:
    """Return what to say of a path that is none of the ``known`` ones: the nearest, or that its curve is not set;
    ``means`` says in words what a known one means."""
    curve = path.rpartition(".")[0]
    if curve in paths(module) and "curve" in metadata(module, curve):
        value = _at(module, curve)
        if value is None:
            return f" is unknown: {curve} is not set; give its points first"
        numbers = value.addresses()
        return f" is unknown; {curve} has {numbers[0]} to {numbers[-1]}"
    return " is unknown" + suggest(path, known, means)


def no_number(module: eqx.Module, path: str) -> str:
    """Return what a field without a number of its own is, and for a curve which numbers it has instead."""
    axes = metadata(module, path).get("curve")
    return "a choice" if axes is None else f"a measured curve, whose numbers are {path}.{axes[1][0]}[0] and so on"


def get(module: eqx.Module, path: str) -> Any:
    """Return the value at a dotted path.

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
    return _at(module, path)


def _at(module: eqx.Module, path: str) -> Any:
    """Return the value at a path that is known to exist."""
    value: Any = module
    for name in path.split("."):
        value = value.get(name) if isinstance(value, Curve) else getattr(value, name)
    return value


def metadata(module: eqx.Module, path: str) -> Mapping[str, Any]:
    """Return what the field at ``path`` of ``module`` declares of itself: unit, limits, choices; for a number of a
    curve also where that is not set."""
    *owners, name = path.split(".")
    if "[" in name:
        return number_metadata(metadata(module, ".".join(owners))["curve"], name)
    owner: Any = _at(module, ".".join(owners)) if owners else module
    return _declared(owner.__class__)[name]


def meaning(module: eqx.Module, path: str) -> str:
    """Return what the field at ``path`` of ``module`` means, in a few words; its name where it declares none."""
    return metadata(module, path).get("doc") or path.rpartition(".")[2].replace("_", " ")


def limits_of(module: eqx.Module, path: str) -> Mapping[str, Any]:
    """Return the declared range of the numbers at ``path`` of ``module``, as keywords of `check_number`."""
    limits: Mapping[str, Any] = metadata(module, path).get("limits", {})
    return limits


def unit(module: eqx.Module, path: str) -> str:
    """Return the unit of what is at ``path`` of ``module``, "" for a choice."""
    return metadata(module, path).get("unit", "")


def replace(module: T, values: Mapping[str, Any]) -> T:
    """Return a copy with the values at dotted paths replaced, validated like a new one; works on traced values.

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


def by_path(
    table: Mapping[str, Any],
    values: Collection[str] = (),
    where: str = "",
    fields: Collection[str] = (),
    prefix: str = "",
) -> dict[str, Any]:
    """Return TOML's nested tables as dotted paths: in TOML an unquoted ``buffer.k_A = …`` is a table in a table.

    **Arguments:**

    - ``table``: as TOML gives it.
    - ``values``: keys that make a table a value itself.
    - ``where``: the table's name in an error.
    - ``fields``: paths at which a table is a value itself, whatever its keys are.
    - ``prefix``: of the table's own keys.

    **Raises:** `InputError` for a path given twice, as ``buffer.k_A`` and as ``"buffer.k_A"``.
    """
    flat: dict[str, Any] = {}
    for name, value in table.items():
        path = f"{prefix}{name}"
        nested = isinstance(value, Mapping) and not set(value) & set(values) and path not in fields
        inner = by_path(value, values, where, fields, f"{path}.") if nested else {path: value}
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
        # The empty rest of a path is the field itself.
        if () in inner and len(inner) > 1:
            raise InputError(f"{name} and single numbers of it are given together; keep one")
        if () in inner:
            fields[name] = inner[()]
        elif not inner:
            fields[name] = current
        elif isinstance(current, Curve):
            fields[name] = current.replaced({key[0]: value for key, value in inner.items()})
        else:
            fields[name] = _replace(current, inner)
    given = {key[0] for key in values}
    return type(module)(**fields | _left_out(module, fields, given))


def _left_out(module: eqx.Module, fields: Mapping[str, Any], given: Collection[str]) -> dict[str, None]:
    """Return None for each number that a newly given curve stands for, unless that number is given too."""
    declared = {field.name: field.metadata.get("instead_of", ()) for field in dataclasses.fields(module)}
    return {
        number: None for name in given if fields[name] is not None for number in declared[name] if number not in given
    }
