"""A design or scenario as a flat record, each number with its unit in the name, and back."""

import json
import math
from collections.abc import Mapping
from typing import Any, TypeVar

import equinox as eqx

from .curve import Curve
from .paths import get, paths, replace, unit

T = TypeVar("T", bound=eqx.Module)


def record(part: eqx.Module) -> dict[str, Any]:
    """Return every field by its dotted path with its unit: ``{"buffer.k_A [N/m]": 500.0, "contact.law": "hertz"}``.

    Numbers that are not finite, which JSON lacks, become None.
    """
    return {named(part, path): _plain(get(part, path), bool(unit(part, path))) for path in paths(part)}


def named(part: eqx.Module, path: str) -> str:
    """Return a path with the unit of what is there, as in ``"buffer.k_A [N/m]"``; a choice's path as it is."""
    symbol = unit(part, path)
    return f"{path} [{symbol}]" if symbol else path


def without_unit(name: str) -> tuple[str, str]:
    """Return a path, or any name, and the unit that stands behind it, "" for none: what `named` put together."""
    # A curve's point has a bracket too, "force[2]", but no space before it.
    path, _, symbol = name.partition(" [")
    return path, symbol.removesuffix("]")


def json_record(part: eqx.Module) -> str:
    """Return the `record` as one line of JSON, numbers to the last digit."""
    return json.dumps(record(part), ensure_ascii=False, allow_nan=False)


def from_json(default: T, text: str) -> T:
    """Return the design or scenario that `json_record` wrote. ``default``: any of its kind; fields it lacks keep its
    values.

    **Raises:** `InputError` for fields that are unknown and values out of range; `ValueError` for what is no JSON.
    """
    record: Mapping[str, Any] = json.loads(text)
    return replace(default, {without_unit(name)[0]: value for name, value in record.items()})


def _plain(value: Any, is_number: bool) -> Any:
    if isinstance(value, Curve):
        return [[_plain(number, True) for number in point] for point in value.points()]
    if value is None or not is_number:
        return value
    single = float(value)
    return single if math.isfinite(single) else None
