"""The modes in which plate and bar bend: how many, how fast the highest is, and whether that is fast enough."""

import functools
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ...multibody.flexible import Bar
from ..validity import Limit
from .design import BarDrop
from .system import free_bar, moving_modes, plate_strip

if TYPE_CHECKING:
    from .run import BarDropRun

UNIT = Bar.rectangle(1.0, 1.0, math.sqrt(12.0), 1.0, 1.0)  # of radius of gyration, length and speed of sound 1


def build_up(design: BarDrop, peak_force: Any, penetration: Any) -> Any:
    """√(m_eff δ/F) [s]: how long a force takes to its peak, with a spring or with a damper (M_eff = m/3).

    **Arguments:** ``peak_force``: F [N]; ``penetration``: δ, the deepest [m]; arrays broadcast.
    """
    force = np.maximum(np.asarray(peak_force), 1e-300)
    return np.sqrt(np.asarray(design.bar.mass) / 3.0 * np.maximum(np.asarray(penetration), 0.0) / force)


def plate_period(design: BarDrop) -> Any:
    """Period [s] of the highest of the plate's modes that is carried."""
    plate = design.plate
    gyration = np.asarray(plate.thickness) / math.sqrt(12.0)
    sound = np.sqrt(np.asarray(plate.young_modulus) / np.asarray(plate.density))
    return np.asarray(plate.length) ** 2 / (gyration * sound * _highest_of_plate(moving_modes(design), plate.support))


def bar_period(design: BarDrop) -> Any:
    """Period [s] of the highest of the bar's modes."""
    bar = design.bar
    sound = np.sqrt(np.asarray(bar.young_modulus) / np.asarray(bar.density))
    return np.asarray(bar.length) ** 2 / (np.asarray(bar.diameter) / 4.0 * sound * _highest_of_bar(bar.modes))


@functools.cache
def _highest_of_plate(which: tuple[int, ...], support: str) -> float:
    """Its frequency for gyration, length and sound of 1 [Hz]."""
    return float(plate_strip(UNIT, which[-1:], support=support).modes.frequencies()[0])


@functools.cache
def _highest_of_bar(modes: int) -> float:
    return float(free_bar(UNIT, modes - 2).modes.frequencies()[-1])


def limits(design: BarDrop, peak_force: Any, penetration: Any) -> list[Limit]:
    """How the highest modes' periods compare with the time the force takes to its peak: slower ones are too few."""
    time, found = build_up(design, peak_force, penetration), []
    for body, modes, period in (("plate", design.plate.modes, plate_period), ("bar", design.bar.modes, bar_period)):
        if modes:
            said = f"the {body}'s {modes} modes are too few for the peak: the highest is slower than the force"
            found.append(Limit(said, period(design) / np.maximum(time, 1e-300)))
    return found


def told(run: "BarDropRun") -> list[str]:
    """A line on each body that bends: number of modes, its highest period beside the time the force took."""
    design, lines = run.design, []
    time = 1e6 * float(build_up(design, float(run.peak_force), float(run.maxima["penetration"])))
    if design.plate.modes:
        moving = len(moving_modes(design))
        said = f"{design.plate.modes}, of which {moving} move its middle; period of the highest"
        lines.append(f"  {'plate modes':24} {said} {1e6 * float(plate_period(design)):.3g} µs")
    if design.bar.modes:
        said = f"{design.bar.modes}; period of the highest"
        lines.append(f"  {'bar modes':24} {said} {1e6 * float(bar_period(design)):.3g} µs")
    if lines:
        lines.append(f"  {'force rises within':24} {time:.3g} µs")
    return lines
