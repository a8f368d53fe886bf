"""What axes and values are called in figures, in their units: angles in degrees, forces from 10 kN on in kN."""

import itertools
import math
import string
from collections.abc import Sequence
from typing import Any

import numpy as np

from .._types import Axes
from ..fields import as_typed
from ..labelled.record import heading
from ..value_text import degrees_text, unit_by_size, with_unit
from .style import BLUE, GREEN, ORANGE, PURPLE, SKY

FORCE_UNITS, TIME_UNITS = (("kN", 1e-3), ("N", 1.0)), (("s", 1.0), ("ms", 1e3), ("µs", 1e6))
MARKERS = ("X", "^", "P", "v", "D", "<", ">")  # of outcomes other than success, in their order
FURTHER = ("s", "o", "p", "h", "d", "8", "H")  # of what else runs are marked for
SUCCESSES = (("o", BLUE), ("*", "#000000"), ("d", GREEN))  # marker and colour of successes, the best first
ENDED = (ORANGE, PURPLE, GREEN, SKY, BLUE)


def shown(quantity: Any) -> tuple[str, str, float]:
    """Return a quantity's title, its unit in figures, and how many of those a unit of it is."""
    unit, factor = quantity.in_figures
    return quantity.title, "°" if unit == "deg" else unit, factor


def in_figures(unit: str, typed: str = "") -> tuple[str, float]:
    """Return a field's unit in figures, and how many of those one of its own is.

    Angles are shown in degrees, all else in the unit that it was ``typed`` in, "" for its own.
    """
    if unit == "rad":
        return "°", 180.0 / math.pi
    factor, symbol = as_typed(1.0, unit, typed)
    return symbol, factor


def called(name: str) -> str:
    """Return a field's name in words; symbols such as k_A stay."""
    return name.replace("_", " ") if name.islower() else name


def field_axis(name: str, unit: str, typed: str = "") -> str:
    """Return the label of an axis over a field: "approach speed [m/s]"."""
    return heading(called(name), in_figures(unit, typed)[0])


def value_in_words(value: float, unit: str, typed: str = "") -> str:
    """Return a field's value in words: "0.2 m/s", "+3°"."""
    symbol, factor = in_figures(unit, typed)
    return degrees_text(factor * value) if symbol == "°" else with_unit(factor * value, symbol, 4)


def newtons(largest: float) -> tuple[str, float]:
    """Return the unit of forces as large as this [N]: N, from 10 kN on kN; and how many of it a newton is."""
    return unit_by_size(abs(largest), FORCE_UNITS, 10.0)


def in_thousands(symbol: str, *values: float) -> tuple[str, float]:
    """Return the unit in which people read values of one unit, and how many of it that one is: of forces, stiffness and
    damping with a value of 10 000 or more kN, kN/m and so on, so that none needs an exponent."""
    if symbol[:1] != "N":
        return symbol, 1.0
    return unit_by_size(max(map(abs, values)), ((f"k{symbol}", 1e-3), (symbol, 1.0)), 10.0)


def seconds(longest: float) -> tuple[str, float]:
    """Return the unit of a time axis as long as this [s]: s, ms or µs; and how many of it a second is."""
    return unit_by_size(longest, TIME_UNITS, 0.1)


def force_text(force: float, largest: float | None = None) -> str:
    """Return a force [N] with four digits: "253.1 N", "45.87 kN"; ``largest``: of those beside it, which chooses the
    unit."""
    unit, factor = newtons(force if largest is None else largest)
    return with_unit(factor * force, unit, 4)


def time_text(time: float) -> str:
    """Return a time [s] with four digits: "0.7193 s", "12 ms"."""
    unit, factor = seconds(time)
    return with_unit(factor * time, unit, 4)


def scaled(axes: Axes, which: str, scale: str, low: float, high: float) -> None:
    """Set the scale of the "x" or the "y" axis; a logarithmic one has few and plain numbers along it."""
    getattr(axes, f"set_{which}scale")(scale)
    if scale != "log":
        return
    from matplotlib.ticker import LogLocator, NullFormatter

    axis = getattr(axes, f"{which}axis")
    # Over less than two decades powers of ten alone would be too few.
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 100.0 * low else (1.0,)))
    axis.set_major_formatter("{x:g}")
    # Over less than a decade matplotlib labels minor ticks too, which would crowd the axis.
    axis.set_minor_formatter(NullFormatter())


def outcome_marks(mechanism: Any) -> dict[str, tuple[str, str]]:
    """Return marker and colour of each outcome that is neither a failure nor what should be: the same in every
    figure."""
    aims = mechanism.successes or (mechanism.outcomes.time_is_up(),)
    ended = [outcome.name for outcome in mechanism.outcomes if not outcome.failed and outcome.name not in aims]
    return {name: (MARKERS[k % len(MARKERS)], ENDED[k % len(ENDED)]) for k, name in enumerate(ended)}


def success_marks(names: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Return marker and colour of each success, the best first: the strictest end before the others."""
    return {name: SUCCESSES[k % len(SUCCESSES)] for k, name in enumerate(names)}


def reason_marks(mechanism: Any, reasons: Sequence[str]) -> dict[str, str]:
    """Return a marker for each reason why runs are not safe, none twice: that of an outcome, or one that no outcome
    has."""
    outcomes = {name: marker for name, (marker, _) in outcome_marks(mechanism).items()}
    free = (marker for marker in (*FURTHER, *MARKERS) if marker not in outcomes.values())
    letters = (f"${letter}$" for letter in string.ascii_letters)  # where all others are taken
    others = itertools.chain(free, letters)
    return {reason: outcomes.get(reason.replace(" ", "_")) or next(others, "$?$") for reason in reasons}


def edges(values: np.ndarray, scale: str) -> np.ndarray:
    """Return borders of the cells around sorted values, halfway between them on their scale."""
    places = np.log(values) if scale == "log" else values
    middles = 0.5 * (places[1:] + places[:-1])
    borders = np.concatenate([[2.0 * places[0] - middles[0]], middles, [2.0 * places[-1] - middles[-1]]])
    return np.exp(borders) if scale == "log" else borders
