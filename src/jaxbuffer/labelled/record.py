"""Records, in which a number is ``{"value": 0.02, "unit": "m"}``, written and read here; headings of tables."""

import json
import math
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any, TypeVar

import equinox as eqx

from ..errors import InputError
from ..fields import Curve, get, paths, replace, unit
from .arrays import Labelled

T = TypeVar("T", bound=eqx.Module)
AMOUNT = {"value", "unit"}  # the keys of a number


def heading(name: str, symbol: str) -> str:
    """Return a name with its unit, "stroke [m]"; without a unit, as of a choice, the name as it is."""
    return f"{name} [{symbol}]" if symbol else name


def headings(units: Mapping[str, str]) -> list[str]:
    """Return a heading for each name. ``units``: by name."""
    return [heading(name, symbol) for name, symbol in units.items()]


def amount(value: Any, symbol: str) -> Any:
    """Return a value with its unit, as a record has it; without a unit the value as it is.

    Of a number that is not finite, which JSON lacks, the value is None.
    """
    return {"value": _plain(value), "unit": symbol} if symbol else value


def amounts(units: Mapping[str, str], values: Iterable[Any]) -> dict[str, Any]:
    """Return values by name, each with its unit. ``units``: by name, in the values' order."""
    return {name: amount(value, symbol) for (name, symbol), value in zip(units.items(), values, strict=True)}


def json_number(value: Any) -> float | None:
    """Return a number as JSON has it; None where there is none or it is not finite."""
    if value is None:
        return None
    real = float(value)
    return real if math.isfinite(real) else None


def numbers(table: Mapping[str, Labelled]) -> dict[str, Any]:
    """Return single numbers as a record."""
    return {name: amount(json_number(it.values), it.unit) for name, it in table.items()}


def rows(table: Mapping[str, Labelled]) -> list[dict[str, Any]]:
    """Return arrays along one axis as records, one for each entry."""
    units = {name: it.unit for name, it in table.items()}
    entries = zip(*(it.values for it in table.values()), strict=True)
    return [amounts(units, map(json_number, entry)) for entry in entries]


class Record(dict[str, Any]):
    """A record of a result file as it is read: each number under its name, its unit under the same name in ``units``.

    Records inside it are `Record`s too.

    **Example:**

    >>> from jaxbuffer.labelled.record import Record, amount
    >>> run = Record.of({"stroke": amount(0.02, "m"), "impacts": [{"time": amount(0.1, "s")}]})
    >>> run["stroke"], run.units["stroke"], run["impacts"][0]["time"]
    (0.02, 'm', 0.1)
    """

    def __init__(self, record: Mapping[str, Any] = MappingProxyType({})) -> None:
        of_numbers = {name: it for name, it in record.items() if isinstance(it, Mapping) and it.keys() == AMOUNT}
        super().__init__({name: it["value"] if name in of_numbers else it for name, it in record.items()})
        self.units: dict[str, str] = {name: it["unit"] for name, it in of_numbers.items()}

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> "Record":
        """Return a plain record, and all records in it, as `Record`s."""
        # By way of JSON, whose reader makes a `Record` of every mapping, however deep it lies.
        return record if isinstance(record, cls) else cls.from_json(json.dumps(record))

    @classmethod
    def from_json(cls, text: str) -> Any:
        """Return what JSON holds. **Raises:** `ValueError` for what is no JSON."""
        # A number alone is a record of two entries until the record around it takes its unit.
        return json.loads(text, object_hook=cls)


def part_record(part: eqx.Module) -> dict[str, Any]:
    """Return every field by its dotted path: ``{"buffer.k_A": {"value": 500.0, "unit": "N/m"}, "contact.law":
    "hertz"}``.

    Numbers that are not finite, which JSON lacks, become None.
    """
    values = {path: get(part, path) for path in paths(part)}
    # Of a curve, whose points have two units, the points alone.
    return {
        path: _plain(value) if isinstance(value, Curve) else amount(value, unit(part, path))
        for path, value in values.items()
    }


def part_json(part: eqx.Module) -> str:
    """Return the `part_record` as one line of JSON, numbers to the last digit."""
    return json.dumps(part_record(part), ensure_ascii=False, allow_nan=False)


def part_from_json(default: T, text: str) -> T:
    """Return the design or scenario that `part_json` wrote. ``default``: any of its kind; fields it lacks keep its
    values.

    **Raises:** `InputError` for fields that are unknown and values out of range, and for what an earlier version wrote;
    `ValueError` for what is no JSON.
    """
    record = Record.from_json(text)
    if has_headings(record):
        raise InputError("it was written by an earlier version of jaxbuffer; make it again")
    return replace(default, record)


def has_headings(record: Mapping[str, Any]) -> bool:
    """Return whether names of a record have units behind them, as in ``"stroke [m]"``, which earlier versions wrote."""
    # A curve's point has a bracket too, "force[2]", but no space before it.
    return any(" [" in name for name in record)


def _plain(value: Any) -> Any:
    if isinstance(value, Curve):
        return [[json_number(number) for number in point] for point in value.points()]
    return json_number(value)
