"""The modes in which rod and slider bend: whether they are fast enough for a peak."""

from typing import Any

import numpy as np

from ..bending import build_up, force_line, highest_of_free, modes_line, period, too_few
from ..run import Run
from ..validity import ValidityLimit
from . import shapes
from .design import SliderCrank
from .shapes import highest_period


def rise_time(design: SliderCrank, peak_force: Any, penetration: Any) -> Any:
    """Return how long a contact force takes to its peak [s], with the reduced mass of slider and rod.

    **Arguments:** ``peak_force`` [N]; ``penetration``: the deepest [m]; arrays broadcast.
    """
    slider, rod = np.asarray(design.slider.body.mass), np.asarray(design.rod.body.mass)
    return build_up(slider * rod / (slider + rod), peak_force, penetration)


def rod_period(design: SliderCrank) -> Any:
    """Return the period [s] of the highest of the free rod's modes."""
    if design.rod.shape is not None:
        return highest_period(design.rod, shapes.ROD, design.rod.size)
    return period(design.rod.bar, highest_of_free(design.rod.modes))


def bending_parts(design: SliderCrank) -> list[tuple[str, int, Any]]:
    """Return each part that bends: its name, how many modes, the period of the highest [s]."""
    slider, parts = design.slider, [("rod", design.rod.modes, rod_period(design))] if design.rod.modes else []
    if slider.modes:
        parts.append(("slider", slider.modes, highest_period(slider, shapes.SLIDER, slider.scale)))
    return parts


def limits(design: SliderCrank, peak_force: Any, penetration: Any) -> list[ValidityLimit]:
    """Return how each part's highest mode's period compares with the time that the force takes to its peak."""
    parts = bending_parts(design)
    if not parts or penetration is None:
        return []
    time = rise_time(design, peak_force, penetration)
    return [too_few(name, modes, highest, time) for name, modes, highest in parts]


def mode_lines(run: Run, penetration: float) -> list[str]:
    """Return the number of modes of each part that bends, and the highest's period beside the time the force took."""
    lines = [modes_line(name, str(modes), highest) for name, modes, highest in bending_parts(run.design)]
    if lines and int(run.impact_count):
        lines.append(force_line(rise_time(run.design, float(run.peak_force), penetration)))
    return lines
