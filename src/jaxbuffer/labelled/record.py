"""Records and table headings, which have each number's unit behind its name: "stroke [m]". Written and read here."""

import json
import math
from collections.abc import Mapping
from typing import Any, TypeVar

import equinox as eqx

from ..fields import Curve, get, paths, replace, unit
from .arrays import Labelled

T = TypeVar("T", bound=eqx.Module)


def heading(name: str, symbol: str) -> str:
    """Return a name with its unit, "stroke [m]"; without a unit, as of a choice, the name as it is."""
    return f"{name} [{symbol}]" if symbol else name


def parts(text: str) -> tuple[str, str]:
    """Return the name and the unit, "" for none, of what `heading` put together."""
    # A curve's point has a bracket too, "force[2]", but no space before it.
    name, _, symbol = text.partition(" [")
    return name, symbol.removesuffix("]")


def headings(units: Mapping[str, str]) -> list[str]:
    """Return a heading for each name. ``units``: by name."""
    return [heading(name, symbol) for name, symbol in units.items()]


def json_number(value: Any) -> float | None:
    """Return a number as JSON has it; None where there is none or it is not finite."""
    if value is None:
        return None
    real = float(value)
    return real if math.isfinite(real) else None


def numbers(table: Mapping[str, Labelled]) -> dict[str, float | None]:
    """Return single numbers as a record."""
    return {heading(name, it.unit): json_number(it.values) for name, it in table.items()}


def rows(table: Mapping[str, Labelled]) -> list[dict[str, float | None]]:
    """Return arrays along one axis as records, one for each entry."""
    entries = zip(*(it.values for it in table.values()), strict=True)
    keys = headings({name: it.unit for name, it in table.items()})
    return [dict(zip(keys, map(json_number, entry), strict=True)) for entry in entries]


class Record(dict[str, Any]):
    """A record of a result file. It is asked by names: ``record["stroke"]`` is the number under "stroke [m]".

    Its keys are those of the file, with units. Records inside it are `Record`s too.

    **Example:**

    >>> from jaxbuffer.labelled.record import Record
    >>> run = Record.of({"stroke [m]": 0.02, "impacts": [{"time [s]": 0.1}]})
    >>> run["stroke"], run["impacts"][0]["time"], "end_time" in run
    (0.02, 0.1, False)
    """

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> "Record":
        """Return a plain record, and all records in it, as `Record`s."""
        # By way of JSON, whose reader makes a `Record` of every mapping, however deep it lies.
        return record if isinstance(record, cls) else cls.from_json(json.dumps(record))

    @classmethod
    def from_json(cls, text: str) -> Any:
        """Return what JSON holds. **Raises:** `ValueError` for what is no JSON."""
        return json.loads(text, object_hook=cls)

    def __missing__(self, name: str) -> Any:
        # Asked for again under its own name, what no key has would come back here without end.
        if (key := self._key(name)) == name:
            raise KeyError(name)
        return self[key]

    def __contains__(self, name: object) -> bool:
        # A dictionary's own `in` and `get` do not ask `__missing__`.
        return super().__contains__(self._key(name))

    def get(self, name: str, default: Any = None) -> Any:
        """Return the value under a name, or ``default``."""
        return super().get(self._key(name), default)

    def _key(self, name: Any) -> Any:
        """Return the key that has this name; the name itself where none has it."""
        return name if super().__contains__(name) else next((key for key in self if parts(key)[0] == name), name)


def part_record(part: eqx.Module) -> dict[str, Any]:
    """Return every field by its dotted path with its unit: ``{"buffer.k_A [N/m]": 500.0, "contact.law": "hertz"}``.

    Numbers that are not finite, which JSON lacks, become None.
    """
    units = {path: unit(part, path) for path in paths(part)}
    return {heading(path, symbol): _plain(get(part, path), bool(symbol)) for path, symbol in units.items()}


def part_json(part: eqx.Module) -> str:
    """Return the `part_record` as one line of JSON, numbers to the last digit."""
    return json.dumps(part_record(part), ensure_ascii=False, allow_nan=False)


def part_from_json(default: T, text: str) -> T:
    """Return the design or scenario that `part_json` wrote. ``default``: any of its kind; fields it lacks keep its
    values.

    **Raises:** `InputError` for fields that are unknown and values out of range; `ValueError` for what is no JSON.
    """
    record: Mapping[str, Any] = json.loads(text)
    return replace(default, {parts(key)[0]: value for key, value in record.items()})


def _plain(value: Any, is_number: bool) -> Any:
    if isinstance(value, Curve):
        return [[_plain(number, True) for number in point] for point in value.points()]
    return json_number(value) if is_number else value
