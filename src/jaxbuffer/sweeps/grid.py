"""Grids to sweep: every combination of the values of some fields of design and scenario, choices included."""

import dataclasses
import itertools
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..errors import InputError, as_number, check_choice, check_number, check_whole, shown, suggest
from ..fields import (
    Part,
    as_typed,
    check_address,
    check_alone,
    check_units_agree,
    errors_in_typed_units,
    in_unit,
    in_words,
    metadata,
    no_number,
    paths,
    typed_unit,
    unit_at,
    value_at,
    with_values,
)
from ..mechanisms.registry import mechanism_of
from ..run.request import check_pair

SPAN = ("from", "to", "count", "scale")
SCALES = ("linear", "log")
FEW = 5  # values that are listed in words
BYTES = 2000  # for each run: inputs, results, its row of text while files are written
MOST = 10**15  # values of a field, and runs of a grid
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
        """The field without its section: "approach_speed"."""
        return self.path.rsplit(".", 1)[-1]

    @property
    def heading(self) -> str:
        """The path with its unit: "scenario.approach_speed [m/s]"."""
        return f"{self.path} [{self.unit}]" if self.unit else self.path


@dataclasses.dataclass(frozen=True)
class Axis(Varied):
    """One field's values: the ``listed`` ones [unit], or a span; ``typed``: the unit that they were typed in, "" where
    none was."""

    listed: Span | tuple[Any, ...]
    scale: str = SCALES[0]  # on which it is drawn
    typed: str = dataclasses.field(default="", compare=False)

    def __len__(self) -> int:
        return len(self.listed)

    @property
    def values(self) -> np.ndarray:
        """The values, shape (len,): numbers in the axis' unit, or a choice's words, truths or whole numbers."""
        return np.asarray(self.listed, float) if self.unit else np.asarray(self.listed)

    def words(self, value: Any, digits: int = 6) -> str:
        """One of the values in words: "0.1 m/s", "hertz", "true"."""
        if not self.unit:
            return str(value).lower() if isinstance(value, bool | np.bool_) else str(value)
        degrees = f" ({np.degrees(value):+.3g}°)" if self.unit == "rad" and not self.typed else ""
        return in_words(value, self.unit, self.typed, digits) + degrees

    def spanned(self) -> str:
        """All values in a few words: "5 to 30 cm/s, 6 values, linear"."""
        if not self.unit:
            return ", ".join(map(self.words, self.values))
        shown = [as_typed(value, self.unit, self.typed)[0] for value in self.values.tolist()]
        symbol = as_typed(0.0, self.unit, self.typed)[1]
        if len(shown) <= FEW:
            return f"{', '.join(f'{value:g}' for value in shown)} {symbol}".rstrip(" -")
        return f"{shown[0]:g} to {shown[-1]:g} {symbol}".rstrip(" -") + f", {len(shown)} values, {self.scale}"


class Batch(NamedTuple):
    """Runs of one program: their ``places`` (n,) in the results (None: all, in order), ``design`` and ``scenarios``
    with arrays (n,) for the numbers that differ."""

    places: np.ndarray | None
    design: Part
    scenarios: Part


class Places(Protocol):
    """Where runs lie: a grid, or points spread over ranges."""

    @property
    def axes(self) -> Sequence[Any]:
        """The fields that differ, each with its ``path``, ``unit``, ``name`` and ``heading``."""
        ...

    def __len__(self) -> int: ...

    def columns(self) -> dict[str, np.ndarray]:
        """Each field's value in every run, shape (n,), by its path."""
        ...

    def point(self, index: int) -> str:
        """One run's values in words."""
        ...

    def batches(self, design: Part, scenario: Part) -> list[Batch]:
        """All runs, those of one program together."""
        ...

    def applied(self, design: Part, scenario: Part) -> tuple[Part, Part]:
        """Design and scenario with an array (n,) for each field that differs."""
        ...


@dataclasses.dataclass(frozen=True)
class Grid:
    """The product of its axes, the last one changing fastest.

    ``in_memory``: whether there will be arrays in memory with an entry for each run.
    """

    axes: tuple[Axis, ...]
    in_memory: bool = True

    def __post_init__(self) -> None:
        if not self.axes:
            raise InputError("nothing to sweep; name a field and its values")
        runs = math.prod(self.shape)
        need, have = BYTES * runs, _free_memory()
        size = f"the grid has {' × '.join(map(str, self.shape))} = {runs:.4g} runs"
        if self.in_memory and need > have:
            raise InputError(f"{size}, which need {_size(need)} of memory; {_size(have)} are free")
        if runs > MOST:
            raise InputError(f"{size}; at most {MOST:.0e} are allowed")

    def __len__(self) -> int:
        return math.prod(self.shape)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(len(axis) for axis in self.axes)

    def columns(self) -> dict[str, np.ndarray]:
        """Each path's value in every run, shape (n,)."""
        meshed = np.meshgrid(*(axis.values for axis in self.axes), indexing="ij")
        return {axis.path: values.ravel() for axis, values in zip(self.axes, meshed, strict=True)}

    def point(self, index: int) -> str:
        """One run's values in words: "approach_speed 0.1 m/s, misalignment 0 rad"."""
        places = np.unravel_index(index, self.shape)
        shown = (f"{it.name} {it.words(it.values[place])}" for it, place in zip(self.axes, places, strict=True))
        return ", ".join(shown)

    def batches(self, design: Part, scenario: Part) -> list[Batch]:
        """All runs: a batch for each combination of choices, which change the program, with an array (n,) for each
        field of the grid that is a number."""
        chosen, columns = [axis for axis in self.axes if not axis.unit], self.columns()
        numbers = {axis.path: columns[axis.path] for axis in self.axes if axis.unit}
        made = []
        for values in itertools.product(*(axis.values.tolist() for axis in chosen)):
            mine = np.ones(len(self), bool)
            for axis, value in zip(chosen, values, strict=True):
                mine &= columns[axis.path] == value
            places = np.flatnonzero(mine)
            choices = {axis.path: value for axis, value in zip(chosen, values, strict=True)}
            swept = with_values(design, scenario, choices | {path: it[places] for path, it in numbers.items()})
            check_pair(mechanism_of(design), *swept)
            made.append(Batch(places, *swept))
        return made

    def applied(self, design: Part, scenario: Part) -> tuple[Part, Part]:
        """Design and scenario with an array (n,) for each field of the grid, the others as they are; of a grid without
        choices."""
        ((_, design, scenario),) = self.batches(design, scenario)
        return design, scenario


def grid(over: Mapping[str, Any], design: Part, scenario: Part, in_memory: bool = True) -> Grid:
    """A grid from values as TOML writes them: a number, a list, or {from, to, count, scale = "linear" | "log"}.

    Of a choice the values are a word, a truth, a whole number, or a list of them.

    **Arguments:** ``over``: dotted path to values, "scenario.…" for the scenario's; ``design``, ``scenario``: whose
    fields they are; ``in_memory`` as of `Grid`.

    **Raises:** `InputError` for paths that are unknown, empty lists, values out of range, and for a grid that does not
    fit into memory.
    """
    return Grid(tuple(axis(path, values, design, scenario) for path, values in over.items()), in_memory)


def axis(path: str, given: Any, design: Part, scenario: Part) -> Axis:
    """One axis, checked against the field's range."""
    check_address(design, scenario, path, "sweep: ")
    symbol = unit_at(design, scenario, path)
    if not symbol:
        return Axis(path, "", _chosen(path, given, design, scenario))
    values = span(f"sweep.{path}", given, symbol) if isinstance(given, Mapping) else _listed(path, given, symbol)
    ends = (values.start, values.stop) if isinstance(values, Span) else values
    made = Axis(path, symbol, values, values.scale if isinstance(values, Span) else SCALES[0], typed_unit(given))
    with errors_in_typed_units({path: made.typed}):
        with_values(design, scenario, {path: np.asarray(ends, float)})  # checks the range
    return made


def typed(text: str) -> tuple[str, Any]:
    """A path and its values as typed on a command line: PATH=FROM:TO:COUNT[:log] or PATH=VALUE,VALUE,…"""
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
    """A span from {from, to, count, scale}, its ends in ``unit`` or with their own.

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
    ends = [table[name] for name in SPAN[:2]]
    check_units_agree(where, ends, lambda low, high: f'{{from = "{low}", to = "{high}", count = {count}}}')
    start, stop = (_number(f"{where}: {name}", end, unit) for name, end in zip(SPAN, ends, strict=False))
    if count == 1 and start != stop:
        raise InputError(f"{where}: one value cannot reach from {start:g} to {stop:g}; count must be at least 2")
    if scale == "log" and not (start > 0.0 and stop > 0.0):
        raise InputError(f"{where}: a logarithmic scale needs positive ends; found {start:g} and {stop:g}")
    return Span(start, stop, count, scale)


def _listed(path: str, given: Any, unit: str) -> tuple[float, ...]:
    values = _as_list(given)
    if not values:
        raise InputError(f"sweep.{path} is empty; expected {EXAMPLE}")
    check_units_agree(f"sweep.{path}", values)
    return tuple(_number(f"sweep.{path}", value, unit) for value in values)


def _chosen(path: str, given: Any, design: Part, scenario: Part) -> tuple[Any, ...]:
    """Values of a choice, each checked by itself: whether they go with others, `Grid.batches` checks."""
    if path in paths(design) and "curve" in metadata(design, path):
        raise InputError(f"sweep.{path} is {no_number(design, path)}; sweep one of these")
    now = value_at(design, scenario, path)
    remedy = f"list its values, as in [{shown(now)}]"
    if isinstance(given, Mapping):
        raise InputError(f"sweep.{path} is a choice; {remedy}")
    values = tuple(_as_choice(value, now) for value in _as_list(given))
    if not values:
        raise InputError(f"sweep.{path} is empty; {remedy}")
    for value in values:
        check_alone(design, scenario, path, value)
        if values.count(value) > 1:
            raise InputError(f"sweep.{path} names {str(value).lower()} twice; keep one")
    return values


def _as_list(given: Any) -> list[Any]:
    """What was given as a list, a single value as the only one."""
    given = given.tolist() if isinstance(given, np.ndarray) else given
    return list(given) if isinstance(given, Sequence) and not isinstance(given, str | bytes) else [given]


def _as_choice(value: Any, now: Any) -> Any:
    """A value as typed on a command line in the type of the field's present one; what does not fit, as it is."""
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
    """A word of the command line as a number, or as it is."""
    try:
        return float(text)
    except ValueError:
        return text


def _free_memory() -> int:
    """Bytes that can still be had."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    except (OSError, StopIteration):
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _size(count: float) -> str:
    for symbol in ("B", "KiB", "MiB", "GiB"):
        if count < 1024:
            return f"{count:.3g} {symbol}"
        count /= 1024
    return f"{count:.4g} TiB"
