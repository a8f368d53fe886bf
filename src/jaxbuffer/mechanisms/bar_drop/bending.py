"""The modes in which plate and bar bend: whether they are fast enough for a peak."""

from typing import Any

import numpy as np

from ..bending import build_up, force_line, highest_of_free, highest_of_plate, modes_line, period, too_few
from ..validity import ValidityLimit
from .design import BarDrop
from .run import BarDropRun
from .system import moving_modes


def rise_time(design: BarDrop, peak_force: Any, penetration: Any) -> Any:
    """Return how long the contact force takes to its peak [s], with the bar's mass at its end, m/3.

    **Arguments:** ``peak_force`` [N]; ``penetration``: the deepest [m]; arrays broadcast.
    """
    return build_up(np.asarray(design.bar.mass) / 3.0, peak_force, penetration)


def plate_period(design: BarDrop) -> Any:
    """Return the period [s] of the highest of the plate's modes that is carried."""
    return period(design.plate.strip, highest_of_plate(moving_modes(design), design.plate.support))


def bar_period(design: BarDrop) -> Any:
    """Return the period [s] of the highest of the bar's modes."""
    return period(design.bar.rod, highest_of_free(design.bar.modes))


def limits(design: BarDrop, peak_force: Any, penetration: Any) -> list[ValidityLimit]:
    """Return how the highest modes' periods compare with the time that the force takes to its peak."""
    time, lines = rise_time(design, peak_force, penetration), []
    for part, modes, highest in (("plate", design.plate.modes, plate_period), ("bar", design.bar.modes, bar_period)):
        if modes:
            lines.append(too_few(part, modes, highest(design), time))
    return lines


def mode_lines(run: BarDropRun) -> list[str]:
    """Return a line on each body that bends: number of modes, its highest period beside the time the force took."""
    design, lines = run.design, []
    if design.plate.modes:
        moving = f"{design.plate.modes}, of which {len(moving_modes(design))} move its middle"
        lines.append(modes_line("plate", moving, plate_period(design)))
    if design.bar.modes:
        lines.append(modes_line("bar", str(design.bar.modes), bar_period(design)))
    if lines:
        lines.append(force_line(rise_time(design, float(run.peak_force), float(run.maxima["penetration"]))))
    return lines
