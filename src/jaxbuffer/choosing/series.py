"""Buildable values of a number: those of an E series, or whole multiples of a step."""

import math
import re
from collections.abc import Mapping
from typing import Any

from ..errors import InputError, as_number, check_number, shown
from ..fields import POSITIVE, Part, in_unit, limits_of, no_number, typed_unit, unit
from ..tuning.problem.problem import Problem
from ..value_text import interval_text, with_unit
from .catalogue import CataloguePart, PartsCatalogue

# IEC 60063: the values of E24 are rounded by hand, the finer series by rule.
E24 = (
    *(1.0, 1.1, 1.2, 1.3, 1.5, 1.6, 1.8, 2.0, 2.2, 2.4, 2.7, 3.0),
    *(3.3, 3.6, 3.9, 4.3, 4.7, 5.1, 5.6, 6.2, 6.8, 7.5, 8.2, 9.1),
)
SERIES = {
    **{f"E{count}": E24[:: 24 // count] for count in (3, 6, 12, 24)},
    **{f"E{count}": tuple(round(10 ** (k / count), 2) for k in range(count)) for count in (48, 96)},
}
EXAMPLE = '"E24", or a step such as "5 N/m"'
BESIDE = 2  # values below a number, and above it, that are tried
MOST = 4096  # combinations of them; with more, one value on either side is tried


def check_rule(where: str, path: str, given: Any, design: Part) -> str | float:
    """Return a rounding rule of a number: the name of a series, or a step in the number's unit.

    **Raises:** `InputError` for what is neither.
    """
    symbol = unit(design, path)
    if not symbol:
        raise InputError(f"{where}: {path} is {no_number(design, path)}; only numbers can be rounded")
    if isinstance(given, str) and re.fullmatch(r"[Ee]\d+", given.strip()):
        name = given.strip().upper()
        if name not in SERIES:
            raise InputError(f"{where} = {shown(given)} is no series; known: {', '.join(SERIES)}")
        return name
    step = as_number(in_unit(where, given, symbol))
    if type(step) is not float:
        raise InputError(f"{where} = {shown(given)} is no rounding; write {EXAMPLE}")
    check_number(where, step, symbol, **POSITIVE)
    return step


def beside(value: float, rule: str | float, count: int = BESIDE) -> list[float]:
    """Return the buildable values at a number or next to it, ``count`` on either side, rising.

    **Example:**

    >>> from jaxbuffer.choosing.series import beside
    >>> beside(520.0, "E12", 1), beside(7.3, 0.5)
    ([470.0, 560.0], [6.5, 7.0, 7.5, 8.0])
    """
    if isinstance(rule, str):
        decade = math.floor(math.log10(value))
        # The decades beside the number's own too, for what is near one of its ends.
        every = [float(f"{base}e{power}") for power in range(decade - 1, decade + 2) for base in SERIES[rule]]
    else:
        nearest = math.floor(value / rule)
        # Rounded to the digits of the step, so that 3 × 0.1 is 0.3.
        every = [float(f"{k * rule:.12g}") for k in range(nearest - count - 1, nearest + count + 3)]
    # A value that differs by floating-point error alone is the number itself, and none of its neighbours.
    below = [it for it in every if it < value and not math.isclose(it, value, rel_tol=1e-12)]
    above = [it for it in every if it > value and not math.isclose(it, value, rel_tol=1e-12)]
    exact = [it for it in every if math.isclose(it, value, rel_tol=1e-12)]
    # Steps down from a small number lead to zero and below, of which nothing is built.
    return [*(it for it in below[-count:] if it > 0.0), *exact, *above[:count]]


def nearest(value: float, values: list[float]) -> int:
    """Return which of some values is nearest to a number, by ratio; beside zero by difference."""
    if value == 0.0:
        return min(range(len(values)), key=lambda k: values[k])
    return min(range(len(values)), key=lambda k: abs(math.log(values[k] / value)))


def rounded_catalogues(
    problem: Problem, numbers: Mapping[str, float], rules: Mapping[str, str | float]
) -> tuple[tuple[PartsCatalogue, ...], tuple[int, ...]]:
    """Return a catalogue of buildable values for each number, and the place of the nearest one in each.

    **Arguments:** ``numbers``: the continuous ones, by path; ``rules``: as of `check_rule`, by path.
    """
    count = BESIDE if (2 * BESIDE) ** len(rules) <= MOST else 1
    if 2 ** len(rules) > MOST:
        raise InputError(f"{len(rules)} numbers to round have {2 ** len(rules)} combinations, above {MOST}; fix some")
    catalogues, places = [], []
    for path, rule in rules.items():
        values = _allowed(problem, path, numbers[path], rule, count)
        symbol = problem.units.get(path, "")
        parts = [CataloguePart(with_unit(*problem.shown(path, it), 12), {path: it}) for it in values]
        catalogues.append(PartsCatalogue(path, tuple(parts), {path: symbol} if typed_unit(f"1 {symbol}") else {}))
        places.append(nearest(numbers[path], values))
    return tuple(catalogues), tuple(places)


def _allowed(problem: Problem, path: str, value: float, rule: str | float, count: int) -> list[float]:
    """Return the buildable values beside a number that its range allows. **Raises:** `InputError` where none is."""
    limits = limits_of(problem.design, path)
    # A series has positive values only, and zero is the one other number that is a multiple of every step.
    usable = value > 0.0 or (value == 0.0 and not isinstance(rule, str))

    def inside(it: float) -> bool:
        low, high = limits.get("low", -math.inf), limits.get("high", math.inf)
        above = it > low if limits.get("low_open") else it >= low
        return above and (it < high if limits.get("high_open") else it <= high)

    values = [it for it in beside(value, rule, count) if inside(it)] if usable else []
    if values:
        return values
    symbol = unit(problem.design, path)
    low, high = max(limits.get("low", 0.0), 0.0), limits.get("high", math.inf)
    if isinstance(rule, str):
        text, hint = rule, f'round by a step, "{with_unit(1.0, symbol)}" say'
    else:
        text, hint = f"the multiples of {with_unit(*problem.shown(path, rule))}", "give a smaller step"
    raise InputError(
        f"roundings.{path}: no value of {text} lies beside {path} = {with_unit(*problem.shown(path, value))}; allowed:"
        f" {interval_text(low, high, symbol)}; {hint}, or leave {path} out of the roundings"
    )
