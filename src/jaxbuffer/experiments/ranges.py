"""Ranges to sample: a field of design or scenario, its two ends, and the scale on which it is spread evenly."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from ..errors import InputError, as_number, check_choice, check_number, check_type, shown
from ..fields import (
    Part,
    check_address,
    check_units_agree,
    ends_as_typed,
    errors_in_typed_units,
    in_unit,
    no_number,
    typed_unit,
    unit_at,
    with_values,
)
from ..sweeps.axis import SCALES, Varied, literal
from ..value_text import interval_text, range_text

EXAMPLE = '[200, 2000] or [200, 2000, "log"]'
DECADE = 10.0  # a range whose ends are further apart than this factor is spread on a logarithmic scale


@dataclasses.dataclass(frozen=True)
class Range(Varied):
    """A number that is sampled: its ends ``low`` and ``high`` [unit], and the ``scale`` ("linear" or "log") on which
    every part of the range is as likely as any other; ``typed``: the unit that its ends were typed in, "" where none
    was."""

    low: float
    high: float
    scale: str = SCALES[0]
    # A range is the same in whichever unit its ends were typed.
    typed: str = dataclasses.field(default="", compare=False)

    def at(self, shares: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
        """Return the values [unit] at shares of the range [-]: 0 is the low end, 1 the high one."""
        if self.scale == "log":
            values = self.low * np.exp(shares * math.log(self.high / self.low))
        else:
            values = self.low + shares * (self.high - self.low)
        return np.clip(values, self.low, self.high)  # rounding leads beyond no end

    def shares(self, values: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
        """Return the shares of the range [-] at which ``values`` lie: the inverse of `at`."""
        if self.scale == "log":
            return np.log(values / self.low) / math.log(self.high / self.low)
        return (values - self.low) / (self.high - self.low)

    def __str__(self) -> str:
        scale = ", log scale" if self.scale == "log" else ""
        return range_text(*ends_as_typed(self.low, self.high, self.unit, self.typed), to=" … ") + scale


def ranges(given: Mapping[str, Any], design: Part, scenario: Part) -> tuple[Range, ...]:
    """Read ranges from pairs (low, high) or triples (low, high, scale) by dotted path, "scenario.…" for the scenario's.

    **Raises:** `InputError` for what is no such pair, paths that are unknown or choices, ends out of a field's range.
    """
    check_type("ranges", given, Mapping, 'ranges={"buffer.k_A": (200, 2000)}')
    if not given:
        raise InputError("nothing to sample; name a field and its range, such as buffer.k_A = [200, 2000]")
    return tuple(_range(path, ends, design, scenario) for path, ends in given.items())


def _range(path: str, given: Any, design: Part, scenario: Part) -> Range:
    check_address(design, scenario, path, "sample: ")
    symbol = unit_at(design, scenario, path)
    if not symbol:
        raise InputError(f"sample: {path} is {no_number(design, path)}; only numbers can be sampled")
    parts = list(given) if isinstance(given, Sequence) and not isinstance(given, (str, bytes)) else []
    scale = parts.pop() if len(parts) == 3 else None
    check_units_agree(f"sample.{path}", parts)
    numbers = [as_number(in_unit(f"sample.{path}", part, symbol)) for part in parts]
    for number in numbers:
        if isinstance(number, str):  # with a unit that fits it would be a number
            check_number(f"sample.{path}", number, symbol)
    if len(numbers) != 2 or not all(type(number) is float for number in numbers):
        raise InputError(f"sample.{path} = {shown(given)} must be low and high end in {symbol}: {EXAMPLE}")
    low, high = numbers
    for end in numbers:
        check_number(f"sample.{path}", end, symbol)
    if not low < high:
        bounds = interval_text(*ends_as_typed(low, high, symbol, typed_unit(given)))
        raise InputError(f"sample.{path} = {bounds}: the low end must be below the high one")
    unit_typed = typed_unit(given)
    with errors_in_typed_units({path: unit_typed}):
        with_values(design, scenario, {path: np.array([low, high])})  # checks the field's own range
    if scale is None:
        scale = "log" if low > 0.0 and high > DECADE * low else "linear"
    check_choice(f"sample.{path}: scale", scale, SCALES)
    if scale == "log" and low <= 0.0:
        raise InputError(f"sample.{path}: a logarithmic scale needs positive ends; found {low:g} and {high:g} {symbol}")
    return Range(path, symbol, low, high, scale, unit_typed)


def typed(text: str) -> tuple[str, list[Any]]:
    """Read a path and its range as typed on a command line: PATH=LOW:HIGH or PATH=LOW:HIGH:SCALE."""
    path, equals, values = text.partition("=")
    words = values.split(":")
    if not path or not equals or len(words) not in (2, 3):
        raise InputError(f"--over {text}: expected FIELD=LOW:HIGH or FIELD=LOW:HIGH:log, buffer.k_A=200:2000 say")
    return path, [*map(literal, words[:2]), *words[2:]]
