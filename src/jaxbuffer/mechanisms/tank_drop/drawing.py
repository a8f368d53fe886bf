"""What the drop onto a tank looks like."""

from typing import Any

import numpy as np
from jaxtyping import Float

from ..drawing import GROUND, Band, Drawing, Named, Outline, Spot, as_they_are, box
from .design import TankDrop
from .section import BOTTOM, CORNER, DRY, WET

SLIDER = 0  # its body
HIGH = 0.5  # of the tank's height: how high the slider is drawn


def drawing(design: TankDrop, bodies: tuple[str, ...] = ()) -> Drawing:
    """The wall as it bends, in front of the cushion that it is pressed into, the slider and the baffle."""
    wide, tall = 0.6 * float(design.tank.width), float(design.tank.height)
    soft = float(design.cushion.thickness)
    columns = design.mesh.refinement * (BOTTOM + CORNER + WET + DRY) + 1
    around = tuple(range(1, 2 * columns + 1))
    thickness = float(np.mean([float(getattr(design.wall, zone)) for zone in ("bottom", "lower_side", "top")]))
    shapes = (
        Outline(GROUND, box(-1.2 * wide, 1.2 * wide, -0.06 * tall, 0.0), part="baffle"),
        Outline(SLIDER, box(-wide, wide, -soft, 0.0), part="cushion"),
        Outline(SLIDER, box(-wide, wide, 0.0, HIGH * tall), part="slider"),
        Band(around, thickness, "tank"),
    )
    return Drawing(shapes, (), (Named(Spot(SLIDER, 0.0, 0.5 * HIGH * tall), "slider"),), frames=frames)


def frames(history: Any) -> Float[np.ndarray, "steps frames 3"]:
    """The slider, and the wall's columns: up on the right, down on the left."""
    x, y = (np.asarray(history.others[name]) for name in ("wall_x", "wall_y"))
    angle = np.arctan2(np.gradient(y, axis=1), np.gradient(x, axis=1))
    halves = np.stack([x, y, angle], axis=-1), np.stack([-x, y, -angle], axis=-1)[:, ::-1]
    return np.concatenate([as_they_are(history), *halves], axis=1)
