"""The values of one field to sweep, as TOML and the command line write them."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import (
    InputError,
    as_number,
    check_choice,
    check_masks,
    check_number,
    check_whole,
    shown,
    suggest,
    unit_of_library,
)
from ..fields import (
    Part,
    as_typed,
    check_address,
    check_alone,
    check_units_agree,
    errors_in_typed_units,
    in_unit,
    metadata,
    metadata_at,
    no_number,
    paths,
    typed_unit,
    unit_at,
    value_at,
    with_values,
)
from ..value_text import degrees_text, range_text, unit_text, with_unit

SPAN = ("from", "to", "count", "scale")
SCALES = ("linear", "log")
FEW = 5  # values that are listed in words
MOST = 10**15  # values of a field
EXAMPLE = "[0.1, 0.2] or {from = 0.1, to = 0.2, count = 5}"


@dataclasses.dataclass(frozen=True)
class Span:
    """``count`` values from ``start`` to ``stop``, both included, in equal steps or (``scale`` "log") equal ratios."""

    start: float
    stop: float
    count: int
    scale: str = "linear"

    def __len__(self) -> int:
        return self.count

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        spaced = np.geomspace if self.scale == "log" else np.linspace
        return spaced(self.start, self.stop, self.count, dtype=dtype)


@dataclasses.dataclass(frozen=True)
class Varied:
    """A field that differs between runs: its dotted ``path`` and ``unit``, "" of a choice."""

    path: str
    unit: str

    @property
    def name(self) -> str:
        """Return the field without its section: "approach_speed"."""
        return self.path.rsplit(".", 1)[-1]


@dataclasses.dataclass(frozen=True)
class Axis(Varied):
    """One field's values: the ``listed`` ones [unit], or a span; ``typed``: the unit that they were typed in, "" where
    none was."""

    listed: Span | tuple[Any, ...]
    scale: str = SCALES[0]  # on which it is drawn
    # Values are the same in whichever unit they were typed.
    typed: str = dataclasses.field(default="", compare=False)

    def __len__(self) -> int:
        return len(self.listed)

    @property
    def values(self) -> np.ndarray:
        """Return the values, shape (len,): numbers in the axis' unit, or a choice's words, truths or whole numbers."""
        return np.asarray(self.listed, float) if self.unit else np.asarray(self.listed)

    def words(self, value: Any, digits: int = 6) -> str:
        """Return one of the values in words: "0.1 m/s", "hertz", "true"."""
        if not self.unit:
            return str(value).lower() if isinstance(value, bool | np.bool_) else str(value)
        degrees = f" ({degrees_text(np.degrees(value), 3)})" if self.unit == "rad" and not self.typed else ""
        return with_unit(*as_typed(value, self.unit, self.typed), digits) + degrees

    def spanned(self) -> str:
        """Return all values in a few words: "5 to 30 cm/s, 6 values, linear"."""
        if not self.unit:
            return ", ".join(map(self.words, self.values))
        shown = [as_typed(value, self.unit, self.typed)[0] for value in self.values.tolist()]
        symbol = as_typed(0.0, self.unit, self.typed)[1]
        if len(shown) <= FEW:
            return f"{', '.join(f'{value:g}' for value in shown)}{unit_text(symbol)}"
        return f"{range_text(shown[0], shown[-1], symbol)}, {len(shown)} values, {self.scale}"


def axis_of(path: str, given: Any, design: Part, scenario: Part) -> Axis:
    """Return one axis, checked against the field's range."""
    check_address(design, scenario, path, "sweep: ")
    symbol = unit_at(design, scenario, path)
    if not symbol:
        return Axis(path, "", _chosen(path, given, design, scenario))
    values = span(f"sweep.{path}", given, symbol) if isinstance(given, Mapping) else _listed(path, given, symbol)
    # A span is monotonic, so that its two ends tell whether all of it is in range.
    ends = (values.start, values.stop) if isinstance(values, Span) else values
    made = Axis(path, symbol, values, values.scale if isinstance(values, Span) else SCALES[0], typed_unit(given))
    with errors_in_typed_units({path: made.typed}):
        with_values(design, scenario, {path: np.asarray(ends, float)})  # checks the range
    return made


def typed(text: str) -> tuple[str, Any]:
    """Split what was typed on a command line, PATH=FROM:TO:COUNT[:log] or PATH=VALUE,VALUE,…, into the path and its
    values."""
    path, equals, values = text.partition("=")
    if not equals or not values or not path:
        raise InputError(f"--over {text}: expected FIELD=FROM:TO:COUNT[:log] or FIELD=VALUE,VALUE,…")
    if ":" not in values:
        listed = [literal(value) for value in values.split(",")]
        check_units_agree(f"--over {text}", listed, lambda *each: f'--over "{path}={",".join(each)}"')
        return path, listed
    words = values.split(":")
    if len(words) not in (3, 4):
        raise InputError(f"--over {text}: expected {path}=FROM:TO:COUNT or {path}=FROM:TO:COUNT:log")
    ends, rest = [literal(word) for word in words[:2]], ":".join(words[2:])
    check_units_agree(f"--over {text}", ends, lambda low, high: f'--over "{path}={low}:{high}:{rest}"')
    return path, {name: literal(word) for name, word in zip(SPAN, words, strict=False)}


def span(where: str, table: Mapping[str, Any], unit: str, most: int = MOST) -> Span:
    """Return the span of {from, to, count, scale}, whose ends are in ``unit`` or have their own.

    ``where``: its name in messages, as in "sweep.scenario.approach_speed"; ``most``: values at most.
    """
    for name in table:
        if name not in SPAN:
            raise InputError(f"{where}: {name} is unknown{suggest(name, SPAN)}; expected {EXAMPLE}")
    for name in SPAN[:3]:
        if name not in table:
            raise InputError(f"{where}: {name} is missing; expected {EXAMPLE}")
    count, scale = table["count"], table.get("scale", SCALES[0])
    count = int(count) if isinstance(count, float) and count.is_integer() else count  # as typed on a command line
    check_whole(f"{where}: count", count, 1)
    if count > most:
        raise InputError(f"{where}: count = {count:.4g} is out of range; allowed: [1, {most:.0e}]")
    check_choice(f"{where}: scale", scale, SCALES)
    # Both ends have a unit or none: one alone would leave open what the other is in.
    ends = [table[name] for name in SPAN[:2]]
    check_units_agree(where, ends, lambda low, high: f'{{from = "{low}", to = "{high}", count = {count}}}')
    start, stop = (_number(f"{where}: {name}", end, unit) for name, end in zip(SPAN, ends, strict=False))
    if count == 1 and start != stop:
        raise InputError(f"{where}: one value cannot reach from {start:g} to {stop:g}; count must be at least 2")
    if scale == "log" and not (start > 0.0 and stop > 0.0):
        raise InputError(f"{where}: a logarithmic scale needs positive ends; found {start:g} and {stop:g}")
    return Span(start, stop, count, scale)


def _listed(path: str, given: Any, unit: str) -> tuple[float, ...]:
    # A masked entry is no measurement, and its number would be lost in a plain list.
    check_masks(f"sweep.{path}", given)
    values = _as_list(in_unit(f"sweep.{path}", given, unit) if unit_of_library(given) is not None else given)
    if not values:
        raise InputError(f"sweep.{path} is empty; expected {EXAMPLE}")
    check_units_agree(f"sweep.{path}", values)
    return tuple(_number(f"sweep.{path}", value, unit) for value in values)


def _chosen(path: str, given: Any, design: Part, scenario: Part) -> tuple[Any, ...]:
    """Return the values of a choice, each checked by itself: `Grid.batches` checks whether they go with the other
    fields."""
    if path in paths(design) and "curve" in metadata(design, path):
        raise InputError(f"sweep.{path} is {no_number(design, path)}; sweep one of these")
    now = value_at(design, scenario, path)
    remedy = f"list its values, as in {choices_example(metadata_at(design, scenario, path), now)}"
    if isinstance(given, Mapping):
        raise InputError(f"sweep.{path} is a choice; {remedy}")
    check_masks(f"sweep.{path}", given)
    values = tuple(_as_choice(value, now) for value in _as_list(given))
    if not values:
        raise InputError(f"sweep.{path} is empty; {remedy}")
    for value in values:
        check_alone(design, scenario, path, value)
        # `Grid.batches` selects the runs of a choice by its value, so that each may be there once only.
        if values.count(value) > 1:
            raise InputError(f"sweep.{path} names {str(value).lower()} twice; keep one")
    return values


def choices_example(known: Mapping[str, Any], now: Any) -> str:
    """Return an example of a choice's values as TOML lists them: ["contact", "free"]; for a whole number its value
    ``now``."""
    if "choices" in known:
        return "[" + ", ".join(f'"{word}"' for word in known["choices"]) + "]"
    return "[true, false]" if "flag" in known else f"[{now}]"


def _as_list(given: Any) -> list[Any]:
    """Return what was given as a list; a single value becomes its only entry."""
    given = given.tolist() if isinstance(given, np.ndarray) and unit_of_library(given) is None else given
    return list(given) if isinstance(given, Sequence) and not isinstance(given, str | bytes) else [given]


def _as_choice(value: Any, now: Any) -> Any:
    """Return a value typed on a command line in the type of the field's present value, or unchanged where it does not
    fit."""
    if isinstance(now, bool) and value in ("true", "false"):
        return value == "true"
    whole = isinstance(value, float) and not isinstance(now, bool) and isinstance(now, int) and value.is_integer()
    return int(value) if whole else value


def _number(path: str, value: Any, unit: str) -> float:
    number = as_number(in_unit(path, value, unit))
    if type(number) is not float:
        raise InputError(f"{path}: {shown(value)} is not a number; expected {EXAMPLE}")
    check_number(path, number, "-")
    return number


def literal(text: str) -> float | str:
    """Return a word of the command line as a number, or unchanged where it is none."""
    try:
        return float(text)
    except ValueError:
        return text
