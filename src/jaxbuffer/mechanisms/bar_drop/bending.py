"""The modes in which plate and bar bend, and the time that they are held against."""

from typing import Any

import numpy as np

from ..bending import BendingPart, build_up, highest_of_free, highest_of_plate, period
from .design import BarDrop


def rise_time(design: BarDrop, peak_force: Any, penetration: Any) -> Any:
    """Return how long the contact force takes to its peak [s], with the bar's mass at its end, m/3.

    **Arguments:** ``peak_force`` [N]; ``penetration``: the deepest [m]; arrays broadcast.
    """
    return build_up(np.asarray(design.bar.mass) / 3.0, peak_force, penetration)


def bending_parts(design: BarDrop) -> list[BendingPart]:
    """Return plate and bar, as far as they bend."""
    plate, bar, parts = design.plate, design.bar, []
    if plate.modes:
        moving = plate.moving_modes
        highest = period(plate.strip, highest_of_plate(moving, plate.support))
        parts.append(BendingPart("plate", plate.modes, highest, f", of which {len(moving)} move its middle"))
    if bar.modes:
        parts.append(BendingPart("bar", bar.modes, period(bar.rod, highest_of_free(bar.modes))))
    return parts
