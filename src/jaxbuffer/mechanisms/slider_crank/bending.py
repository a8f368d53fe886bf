"""The modes in which the rod bends: whether they are fast enough for a peak."""

from typing import Any

import numpy as np

from ..bending import build_up, force_line, highest_of_free, modes_line, period, too_few
from ..run import Run
from ..validity import Limit
from .design import SliderCrank


def rise_time(design: SliderCrank, peak_force: Any, penetration: Any) -> Any:
    """How long a contact force takes to its peak [s], with the reduced mass of slider and rod.

    **Arguments:** ``peak_force`` [N]; ``penetration``: the deepest [m]; arrays broadcast.
    """
    slider, rod = np.asarray(design.slider.mass), np.asarray(design.rod.body.mass)
    return build_up(slider * rod / (slider + rod), peak_force, penetration)


def rod_period(design: SliderCrank) -> Any:
    """Period [s] of the highest of the free rod's modes."""
    return period(design.rod.bar, highest_of_free(design.rod.modes))


def limits(design: SliderCrank, peak_force: Any, penetration: Any) -> list[Limit]:
    """How the highest mode's period compares with the time the force takes to its peak."""
    if not design.rod.modes or penetration is None:
        return []
    time = rise_time(design, peak_force, penetration)
    return [too_few("rod", design.rod.modes, rod_period(design), time)]


def told(run: Run, penetration: float) -> list[str]:
    """Number of modes of a rod that bends, and the highest's period beside the time the force took."""
    design = run.design
    if not design.rod.modes:
        return []
    lines = [modes_line("rod", str(design.rod.modes), rod_period(design))]
    if int(run.impact_count):
        lines.append(force_line(rise_time(design, float(run.peak_force), penetration)))
    return lines
