"""The modes in which the rod bends: how fast the highest is, and whether that is fast enough for a peak."""

import functools
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ...multibody.flexible import Bar, free_bar
from ..validity import Limit
from .design import SliderCrank

if TYPE_CHECKING:
    from ..run import Run

UNIT = Bar.rectangle(1.0, 1.0, math.sqrt(12.0), 1.0, 1.0)  # of radius of gyration, length and speed of sound 1


def build_up(design: SliderCrank, peak_force: Any, penetration: Any) -> Any:
    """√(m δ/F) [s]: how long a force takes to its peak, m the reduced mass of slider and rod.

    **Arguments:** ``peak_force``: F [N]; ``penetration``: δ, the deepest [m]; arrays broadcast.
    """
    slider, rod = np.asarray(design.slider.mass), np.asarray(design.rod.body.mass)
    force = np.maximum(np.asarray(peak_force), 1e-300)
    return np.sqrt(slider * rod / (slider + rod) * np.maximum(np.asarray(penetration), 0.0) / force)


def rod_period(design: SliderCrank) -> Any:
    """Period [s] of the highest of the free rod's modes."""
    rod = design.rod
    assert rod.depth is not None
    sound = np.sqrt(np.asarray(rod.young_modulus) / np.asarray(rod.density))
    gyration = np.asarray(rod.depth) / math.sqrt(12.0)
    return np.asarray(rod.length) ** 2 / (gyration * sound * _highest(rod.modes))


@functools.cache
def _highest(modes: int) -> float:
    """Its frequency for gyration, length and sound of 1 [Hz]."""
    return float(free_bar(UNIT, modes - 2).modes.frequencies()[-1])


def limits(design: SliderCrank, peak_force: Any, penetration: Any) -> list[Limit]:
    """How the highest mode's period compares with the time the force takes to its peak: a slower one is too few."""
    if not design.rod.modes or penetration is None:
        return []
    time = build_up(design, peak_force, penetration)
    said = f"the rod's {design.rod.modes} modes are too few for the peak: the highest is slower than the force"
    return [Limit(said, rod_period(design) / np.maximum(time, 1e-300))]


def told(run: "Run", penetration: float) -> list[str]:
    """Number of modes of a rod that bends, and the highest's period beside the time the force took."""
    design = run.design
    if not design.rod.modes:
        return []
    lines = [f"  {'rod modes':24} {design.rod.modes}; period of the highest {1e6 * float(rod_period(design)):.3g} µs"]
    if int(run.impact_count):
        time = 1e6 * float(build_up(design, float(run.peak_force), penetration))
        lines.append(f"  {'force rises within':24} {time:.3g} µs")
    return lines
