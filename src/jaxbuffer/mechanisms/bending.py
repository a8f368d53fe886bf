"""Modes in which a part bends: how fast the highest of them is, and whether that is fast enough for a peak force."""

import functools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..multibody.flexible import Bar, free_bar, plate_strip
from .validity import ValidityLimit

UNIT = Bar.rectangle(1.0, 1.0, math.sqrt(12.0), 1.0, 1.0)  # of radius of gyration, length and speed of sound 1


def build_up(mass: Any, peak_force: Any, penetration: Any) -> Any:
    """Return √(m δ/F) [s], how long a force takes to its peak, with a spring or with a damper; arrays broadcast.

    **Arguments:** ``mass``: m that it stops [kg]; ``peak_force``: F [N]; ``penetration``: δ, the deepest [m].
    """
    # A run without a contact has no force to divide by.
    force = np.maximum(np.asarray(peak_force), 1e-300)
    return np.sqrt(np.asarray(mass) * np.maximum(np.asarray(penetration), 0.0) / force)


def period(bar: Bar, frequency: float) -> Any:
    """Return the period [s] of a bar's mode, from the mode's ``frequency`` [Hz] of `UNIT`."""
    sound = np.sqrt(np.asarray(bar.youngs_modulus) / np.asarray(bar.density))
    gyration = np.sqrt(np.asarray(bar.second_moment) / np.asarray(bar.area))
    return np.asarray(bar.length) ** 2 / (gyration * sound * frequency)


@functools.cache
def highest_of_free(modes: int) -> float:
    """Return the highest frequency of `UNIT` as a free bar in so many modes [Hz]."""
    return float(free_bar(UNIT, modes - 2).modes.frequencies()[-1])


@functools.cache
def highest_of_plate(which: tuple[int, ...], support: str) -> float:
    """Return the highest frequency of `UNIT` as a plate strip in these modes [Hz]."""
    return float(plate_strip(UNIT, which[-1:], support=support).modes.frequencies()[0])


class BendingPart(NamedTuple):
    """A part that bends.

    - ``name``: of the part.
    - ``modes``: in how many.
    - ``highest``: the period of the highest of them [s].
    - ``remark``: on their number, for a summary.
    """

    name: str
    modes: int
    highest: Any
    remark: str = ""


def mode_limits(parts: Sequence[BendingPart], time: Any) -> list[ValidityLimit]:
    """Return how the highest mode's period of each part compares with a force's ``time`` [s]: if it is slower, the
    modes are too few."""
    warning = "the {0.name}'s {0.modes} modes are too few for the peak: the highest is slower than the force"
    return [ValidityLimit(warning.format(part), part.highest / np.maximum(time, 1e-300)) for part in parts]


def mode_lines(parts: Sequence[BendingPart], time: Any = None) -> list[str]:
    """Return a summary's lines: each part's number of modes and the period of the highest, and if there are any, how
    long the force took, ``time`` [s]; None: nothing touched."""
    lines = []
    for part in parts:
        period_text = f"period of the highest {1e6 * float(part.highest):.3g} µs"
        lines.append(f"  {f'{part.name} modes':24} {part.modes}{part.remark}; {period_text}")
    if lines and time is not None:
        lines.append(f"  {'force rises within':24} {1e6 * float(time):.3g} µs")
    return lines
