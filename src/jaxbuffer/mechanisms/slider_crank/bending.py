"""The modes in which rod and slider bend, and the time that they are held against."""

from typing import Any

import numpy as np

from ..bending import BendingPart, build_up, highest_of_free, period
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


def bending_parts(design: SliderCrank) -> list[BendingPart]:
    """Return rod and slider, as far as they bend."""
    rod, slider, parts = design.rod, design.slider, []
    if rod.modes:
        parts.append(BendingPart("rod", rod.modes, rod_period(design)))
    if slider.modes:
        parts.append(BendingPart("slider", slider.modes, highest_period(slider, shapes.SLIDER, slider.scale)))
    return parts
