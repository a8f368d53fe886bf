"""The address of a number: a dotted path of the design, or "scenario." and a path of the scenario."""

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import equinox as eqx
import numpy as np

from ..errors import InputError, check_names, check_single
from .curve import Curve
from .declared import check_choosing
from .paths import get, meaning, metadata, paths, point_paths, replace, unit, unknown

SCENARIO = "scenario."

D = TypeVar("D", bound=eqx.Module)
S = TypeVar("S", bound=eqx.Module)


def addresses(design: eqx.Module, scenario: eqx.Module) -> list[str]:
    """Return the addresses of all fields of a design and a scenario, choices and the points of measured curves
    included."""
    return [*paths(design), *point_paths(design), *(SCENARIO + path for path in paths(scenario))]


def check_address(design: eqx.Module, scenario: eqx.Module, address: str, where: str = "") -> None:
    """Check that ``address`` is one of a design's or a scenario's.

    **Raises:** `InputError` with the nearest address if it is not; the message begins with ``where``.
    """
    known = addresses(design, scenario)
    if address not in known:
        # A section has fields and no number of its own.
        if any(path.startswith(f"{address}.") for path in known):
            raise InputError(f"{where}{address} is unknown: it is a section; name one of its fields")
        means = lambda it: meaning(*_owner(design, scenario, it))  # noqa: E731
        raise InputError(f"{where}{address}{unknown(design, address, known, means)}")


def single_fields(design: eqx.Module, scenario: eqx.Module) -> set[str]:
    """Return the addresses of all fields; those of a measured curve are the ones of its numbers."""
    return {*single_paths(design), *(SCENARIO + path for path in single_paths(scenario))}


def single_paths(part: eqx.Module) -> tuple[str, ...]:
    """Return the paths of a part; those of a measured curve are the ones of its numbers."""
    return tuple(path for path in (*paths(part), *point_paths(part)) if "curve" not in metadata(part, path))


def _owner(design: eqx.Module, scenario: eqx.Module, address: str) -> tuple[eqx.Module, str]:
    of_scenario = address.startswith(SCENARIO)
    return (scenario, address.removeprefix(SCENARIO)) if of_scenario else (design, address)


def value_at(design: eqx.Module, scenario: eqx.Module, address: str) -> Any:
    """Return the value at ``address``. **Raises:** `InputError` with the nearest path for one that is unknown."""
    return get(*_owner(design, scenario, address))


def unit_at(design: eqx.Module, scenario: eqx.Module, address: str) -> str:
    """Return the unit of what is at ``address``, "" for a choice."""
    return unit(*_owner(design, scenario, address))


def metadata_at(design: eqx.Module, scenario: eqx.Module, address: str) -> Mapping[str, Any]:
    """Return what the field at ``address`` declares of itself."""
    return metadata(*_owner(design, scenario, address))


def check_alone(design: eqx.Module, scenario: eqx.Module, address: str, value: Any) -> None:
    """Raise `InputError` unless a value is one that the choice at ``address`` takes, whatever the other fields are."""
    check_choosing(address, value, metadata_at(design, scenario, address))


def with_values(design: D, scenario: S, values: Mapping[str, Any]) -> tuple[D, S]:
    """Return design and scenario with the values at some addresses replaced, validated like new ones; traced values
    work.

    **Arguments:** ``values``: by address, in the field's unit. **Raises:** `InputError` as `replace` does.
    """
    # Each part is replaced once, with all of its values: singly, some might not fit what is there yet.
    of_scenario = {name.removeprefix(SCENARIO): v for name, v in values.items() if name.startswith(SCENARIO)}
    of_design = {name: v for name, v in values.items() if not name.startswith(SCENARIO)}
    return replace(design, of_design), replace(scenario, of_scenario)


def check_numbers(
    design: eqx.Module, scenario: eqx.Module, addresses: Sequence[str], instead: str
) -> tuple[tuple[str, ...], np.ndarray]:
    """Return the addresses to differentiate by, checked, and the values there, (addresses,).

    **Arguments:** ``addresses``: the addresses; ``instead``: what takes an array of numbers, for the message.

    **Raises:** `InputError` for addresses that are unknown, no single numbers or given twice.
    """
    paths = check_names("wrt", addresses, "buffer.k_A")
    for address in paths:
        value = value_at(design, scenario, address)
        if value is None or isinstance(value, (str, int, Curve)):  # a number is a float; whole ones choose
            raise InputError(f"{address} = {value!r} is not a number that can be differentiated")
        check_single(address, value, "", instead)
    return paths, np.array([float(value_at(design, scenario, address)) for address in paths])
