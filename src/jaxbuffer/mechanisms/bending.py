"""Modes in which a part bends: how fast the highest of them is, and whether that is fast enough for a peak force."""

import functools
import math
from typing import Any

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


def too_few(part: str, modes: int, highest: Any, time: Any) -> ValidityLimit:
    """Return how the highest mode's period [s], ``highest``, compares with a force's ``time`` [s]: if it is slower, the
    modes are too few."""
    warning = f"the {part}'s {modes} modes are too few for the peak: the highest is slower than the force"
    return ValidityLimit(warning, highest / np.maximum(time, 1e-300))


def modes_line(part: str, modes: str, highest: Any) -> str:
    """Return a summary's line: number of modes of a part, and the highest's period [s]."""
    return f"  {f'{part} modes':24} {modes}; period of the highest {1e6 * float(highest):.3g} µs"


def force_line(time: Any) -> str:
    """Return the line that goes with it: how long the force took [s]."""
    return f"  {'force rises within':24} {1e6 * float(time):.3g} µs"
