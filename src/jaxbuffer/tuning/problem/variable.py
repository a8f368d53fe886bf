"""Design variables: which numbers of a design are tuned, between which bounds and on which scale."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

from ...errors import InputError, check_choice, check_single, check_type
from ...fields import Curve, Part, as_typed, check_units_agree, ends_as_typed, get, in_unit, limits_of, replace, unit
from ...value_text import interval_text, with_unit
from .objective import ONE_LIMIT

SCALES = ("log", "linear")
AT_BOUND = 1e-5  # of a variable's range, on its scale


@dataclasses.dataclass(frozen=True)
class Variable:
    """A design variable: a number in the design to tune. `Problem` checks it.

    **Arguments:**

    - ``path``: its dotted path in the design.
    - ``low``, ``high``: its bounds, in its own unit or with one ("1 kN/m"), which `Problem` reads.
    - ``scale``: "log" or "linear", on which a step of given size counts the same everywhere between the bounds.

    **Example:**

    >>> jb.Variable("buffer.k_A", 100.0, 2000.0)  # N/m
    Variable(path='buffer.k_A', low=100.0, high=2000.0, scale='log')
    """

    path: str
    low: float
    high: float
    scale: str = "log"

    def read(self, design: Part) -> "Variable":
        """Return the variable with its bounds as numbers in its own unit. **Raises:** `InputError` for other units."""
        ends = self.low, self.high
        symbol, limits = unit(design, self.path), limits_of(design, self.path)
        if not symbol or not any(isinstance(end, str) for end in ends):
            return self
        check_units_agree(self.path, ends, lambda low, high: f'Variable("{self.path}", "{low}", "{high}")')
        low, high = (
            in_unit(f"{self.path} {side} bound", end, symbol, **limits)
            for side, end in zip(("low", "high"), ends, strict=True)
        )
        return dataclasses.replace(self, low=low, high=high)

    def value(self, scaled: float) -> float:
        """Return the number from its scaled value, 0 at the low bound, 1 at the high one; exact at both."""
        # The exponential of the logarithm would miss the bounds by rounding.
        if scaled <= 0.0 or scaled >= 1.0:
            return self.low if scaled <= 0.0 else self.high
        if self.scale == "log":
            return self.low * math.exp(scaled * math.log(self.high / self.low))
        return self.low + scaled * (self.high - self.low)

    def scaled(self, value: float) -> float:
        """Return the scaled value of a number: the inverse of `value`."""
        if self.scale == "log":
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def at_bound(self, value: float) -> str:
        """Return "at low bound" or "at high bound" for a value within `AT_BOUND` of the range from it, else ""."""
        scaled = self.scaled(value)
        return "at low bound" if scaled <= AT_BOUND else "at high bound" if scaled >= 1.0 - AT_BOUND else ""

    def slope(self, value: float) -> float:
        """Return d value / d scaled."""
        return value * math.log(self.high / self.low) if self.scale == "log" else self.high - self.low


def check_variables(design: Part, variables: Sequence[Variable], units: Mapping[str, str]) -> None:
    """Raise `InputError` for variables that cannot be tuned within their bounds, or whose bounds the design forbids."""
    names: set[str] = set()
    for variable in variables:
        check_type("variable", variable, Variable, "Variable('buffer.k_A', 100.0, 2000.0)")
        path, value = variable.path, get(design, variable.path)
        if path in names:
            raise InputError(f"{path} is named twice among the variables")
        names.add(path)
        if value is None or isinstance(value, (str, bool, Curve)):
            raise InputError(f"{path} = {value!r} is not a number that can be tuned")
        check_choice(f"{path} scale", variable.scale, SCALES)
        name, above_zero = unit(design, path), variable.scale == "log"
        lowest: dict[str, Any] = {"low": 0.0, "low_open": True} if above_zero else {}
        check_single(f"{path} low bound", variable.low, name, ONE_LIMIT, **lowest)
        check_single(f"{path} high bound", variable.high, name, ONE_LIMIT)
        typed = units.get(path, "")
        bounds = interval_text(*ends_as_typed(variable.low, variable.high, name, typed))
        if variable.low >= variable.high:
            raise InputError(f"{path}: the low bound of {bounds} must be less than the high one; are they swapped?")
        for bound in (variable.low, variable.high):
            replace(design, {path: bound})  # the design itself says what it does not allow
        check_single(path, value, name, "tuning starts from one design")
        if not variable.low <= value <= variable.high:
            start = with_unit(*as_typed(value, name, typed))
            raise InputError(f"the start, {path} = {start}, is outside its bounds {bounds}")
    _check_rising(design, {variable.path: variable for variable in variables})


def _check_rising(design: Part, variables: Mapping[str, Variable]) -> None:
    """Raise `InputError` where a curve might fall within the bounds of its points."""
    for path, variable in variables.items():
        curve, _, number = path.rpartition(".")
        if "[" not in number or (after := get(design, curve).following(number)) is None:
            continue
        later = variables.get(f"{curve}.{after}")
        if later is not None and variable.high >= later.low:
            name = unit(design, path)
            first, second = (interval_text(it.low, it.high, name) for it in (variable, later))
            raise InputError(
                f"{path} in {first} and {after} in {second} overlap: a curve's points rise, so the high bound of one"
                " must be below the low bound of the next"
            )
