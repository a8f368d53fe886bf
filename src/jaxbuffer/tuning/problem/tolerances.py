"""Tolerances: how far built numbers may be from the drawn ones, and the corners in which each is at one of its ends."""

import dataclasses
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from ...errors import InputError, OutOfRange, as_number, check_type, shown
from ...fields import (
    SCENARIO,
    Curve,
    Part,
    as_displayed,
    as_typed,
    check_address,
    check_units_agree,
    in_unit,
    metadata_at,
    no_number,
    replace,
    typed_unit,
    unit_at,
    value_at,
)
from ...value_text import with_unit
from .cases import Case

EXAMPLE = '"10 %", "0.5 mm" or ["-1 mm", "2 mm"]'
SIGN = re.compile(r"^\s*(±|\+/-|\+-)\s*")


@dataclasses.dataclass(frozen=True)
class Tolerance:
    """A tolerance: by how much a built number may differ from the drawn one.

    **Arguments:**

    - ``low``, ``high``: the change at either end, at most 0 and at least 0, in the number's unit.
    - ``relative``: whether the ends are shares of the drawn number [-] instead.

    **Raises:** `InputError` for ends that are not finite, on the wrong side of 0, or both 0.

    **Example:**

    >>> jb.Tolerance(-0.1, 0.1, relative=True).ends(500.0)  # N/m
    (450.0, 550.0)
    """

    low: float
    high: float
    relative: bool = False

    def __post_init__(self) -> None:
        for name, value in (("low", self.low), ("high", self.high)):
            if not isinstance(value, (int, float)) or isinstance(value, bool) or not math.isfinite(value):
                raise InputError(f"tolerance's {name} end = {shown(value)} is not a finite number")
        if not self.low <= 0.0 <= self.high or self.low == self.high:
            raise InputError(
                f"tolerance from {self.low:g} to {self.high:g}: it must go from at most 0 to at least 0, and not be 0"
            )

    def change(self, sign: float) -> float:
        """Return the change at an end, -1 the low one and 1 the high one, or at a share of the way to it."""
        return self.high * sign if sign > 0 else -self.low * sign

    def ends(self, value: float) -> tuple[float, float]:
        """Return the lowest and the highest built number for a drawn one."""
        if self.relative:
            # Of a negative number the low share gives the higher end.
            low, high = sorted((value + value * self.low, value + value * self.high))
            return low, high
        return value + self.low, value + self.high

    def half_width(self, value: float) -> float:
        """Return half the distance from the low to the high end; negative for a share of a negative number."""
        half = 0.5 * (self.high - self.low)
        return half * value if self.relative else half

    def in_words(self, unit: str, typed: str = "") -> str:
        """Return it in words: "±10 %", "-1 to +2 mm". ``unit``: of the number; ``typed``: in which it was given."""

        def shown(value: float) -> tuple[float, str]:
            if self.relative:
                return 100.0 * value, "%"
            return as_typed(value, unit, typed) if typed and typed != "%" else as_displayed(value, unit)

        if self.low == -self.high:
            return f"±{with_unit(*shown(self.high), 4)}"
        return f"{shown(self.low)[0] + 0.0:+.4g} to {with_unit(*shown(self.high), 4, sign=True)}"


def read_tolerance(where: str, given: Any, symbol: str) -> Tolerance:
    """Read a tolerance: a text with a unit or in per cent, a pair of them for unequal sides, or a `Tolerance`.

    **Arguments:** ``where``: its address, for messages; ``symbol``: unit of the number, of which a plain one takes bare
    numbers too.

    **Raises:** `InputError` for anything else, with what to write.
    """
    if isinstance(given, Tolerance):
        return given
    pair = isinstance(given, (list, tuple))
    parts = list(given) if pair else [given]
    if len(parts) != (2 if pair else 1):
        raise InputError(f"{where} = {shown(given)} is no tolerance; write {EXAMPLE}")
    parts = [SIGN.sub("", it) if isinstance(it, str) and not pair else it for it in parts]
    check_units_agree(where, parts)
    shares = [typed_unit(it) == "%" for it in parts if isinstance(it, str)]
    relative = any(shares)
    if relative and not all(shares):
        unit = "plain numbers" if symbol == "-" else symbol
        raise InputError(f"{where} = {shown(given)}: write both sides in per cent, or both in {unit}")
    ends = [_end(where, it, "-" if relative else symbol) for it in parts]
    if not pair:
        (half,) = ends
        if not half > 0.0:
            sides = "a pair, as in [-1, 2] with units, has unequal sides"
            raise InputError(f"{where} = {shown(given)}: a tolerance is above 0; {sides}")
        ends = [-half, half]
    low, high = ends
    if not low <= 0.0 <= high or low == high:
        raise InputError(
            f"{where} = {shown(given)}: a pair goes from at most 0 to at least 0, and is not 0 on both sides"
        )
    return Tolerance(low, high, relative)


def _end(where: str, given: Any, symbol: str) -> float:
    """Return one side as a number in ``symbol``. **Raises:** `InputError` for what is none, or has no unit."""
    number = as_number(in_unit(where, given, symbol))
    if type(number) is not float or not math.isfinite(number):
        raise InputError(f"{where} = {shown(given)} is no tolerance; write {EXAMPLE}")
    if symbol != "-" and number != 0.0 and not isinstance(given, str):
        texts = f'"{number:g} {symbol}", or "{number:g} %" of the number'
        raise InputError(f"{where} = {shown(given)} has no unit; write {texts}")
    return number


def read_tolerances(given: Mapping[str, Any], design: Part, scenario: Part) -> dict[str, Tolerance]:
    """Return tolerances by the address of their number, checked against a design and a scenario.

    **Raises:** `InputError` for addresses that are unknown or no numbers, numbers that are not set, and what
    `read_tolerance` refuses.
    """
    check_type("tolerances", given, Mapping, "{'buffer.k_A': '10 %'}")
    read = {}
    for address, value in given.items():
        where = f"tolerances.{address}"
        if not isinstance(address, str):
            raise InputError(f"tolerances: {shown(address)} is not a dotted path such as 'buffer.k_A'")
        check_address(design, scenario, address, "tolerances: ")
        symbol, number = unit_at(design, scenario, address), value_at(design, scenario, address)
        if not symbol or isinstance(number, Curve) or "curve" in metadata_at(design, scenario, address):
            owner = scenario if address.startswith(SCENARIO) else design
            what = no_number(owner, address.removeprefix(SCENARIO))
            raise InputError(f"{where}: {address} is {what}; only numbers have tolerances")
        if number is None:
            raise InputError(
                f"{where}: {address} is not set, so that nothing can differ from it; give it a value first"
            )
        read[address] = read_tolerance(where, value, symbol)
    return read


def moved(case: Case, tolerances: Mapping[str, Tolerance], signs: Sequence[float]) -> Case:
    """Return a load case with each toleranced number at an end, -1 the low one and 1 the high one, or between them."""
    factors, shifts, scenario = dict(case.factors), dict(case.shifts), dict[str, float]()
    for (address, tolerance), sign in zip(tolerances.items(), signs, strict=True):
        change = tolerance.change(float(sign))
        if address.startswith(SCENARIO):
            name = address.removeprefix(SCENARIO)
            value = float(getattr(case.scenario, name))
            scenario[name] = value + value * change if tolerance.relative else value + change
        elif tolerance.relative:
            factors[address] = factors.get(address, 1.0) * (1.0 + change)
        else:
            shifts[address] = shifts.get(address, 0.0) + change
    return dataclasses.replace(
        case,
        scenario=dataclasses.replace(case.scenario, **scenario) if scenario else case.scenario,
        factors=tuple(factors.items()),
        shifts=tuple(shifts.items()),
    )


def corner_cases(
    cases: Sequence[Case], tolerances: Mapping[str, Tolerance], signs: Float[np.ndarray, "corners numbers"]
) -> tuple[Case, ...]:
    """Return every corner of the tolerances at every load case, those of the first one first."""
    return tuple(moved(case, tolerances, row) for case in cases for row in signs)


def check_ends(
    tolerances: Mapping[str, Tolerance], design: Part, cases: Sequence[Case], bounds: Mapping[str, tuple[float, float]]
) -> None:
    """Raise `InputError` for a tolerance that leads out of its number's allowed range, or is a share of 0.

    **Arguments:** ``cases``: without tolerances; ``bounds``: of the numbers that are tuned, by path, which the
    tolerance follows from one to the other.
    """
    for address, tolerance in tolerances.items():
        scenarios = address.startswith(SCENARIO)
        if scenarios:
            values = sorted({float(getattr(case.scenario, address.removeprefix(SCENARIO))) for case in cases})
        else:
            drawn = value_at(design, cases[0].scenario, address)
            values = sorted({float(dict(case.values).get(address, drawn)) for case in cases})
        values = list(bounds.get(address, (values[0], values[-1])))
        symbol = unit_at(design, cases[0].scenario, address)
        words = f"tolerances.{address} = {tolerance.in_words(symbol)}"
        if tolerance.relative and any(value == 0.0 for value in values):
            unit = f"in {symbol}" if symbol != "-" else "as a plain number"
            raise InputError(f"{words}: {address} is 0, of which a share is nothing; give the tolerance {unit}")
        for value in (end for drawn in values for end in tolerance.ends(drawn)):
            owner, name = (cases[0].scenario, address.removeprefix(SCENARIO)) if scenarios else (design, address)
            try:
                replace(owner, {name: value})
            except OutOfRange as error:
                raise error.between(f"{words} leads out of the allowed range: ") from None
            except InputError as error:
                raise error.between(f"{words}: ") from None
