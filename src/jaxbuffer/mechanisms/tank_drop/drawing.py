"""What the drop onto a tank looks like."""

from typing import Any

import numpy as np
from jaxtyping import Float

from ..drawing import GROUND, Band, Drawing, Named, Outline, Spot, as_they_are, box
from .design import TankDrop
from .numbering import Numbering

SLIDER = 0  # its body
HIGH = 0.5  # of the tank's height: how high the slider is drawn


def drawing(design: TankDrop, bodies: tuple[str, ...] = ()) -> Drawing:
    """The wall as it bends, in front of the cushion that it is pressed into, the slider and the baffle."""
    wide, tall = 0.6 * float(design.tank.width), float(design.tank.height)
    soft = float(design.cushion.thickness) if design.cushion.kind == "layer" else 0.0
    numbers = Numbering.of(design)
    around, rows = tuple(range(1, 2 * len(numbers.wall) + 1)), len(numbers.plate)
    right, left = (tuple(range(around[-1] + 1 + k * rows, around[-1] + 1 + (k + 1) * rows)) for k in (0, 1))
    plates = [
        Band(each, float(design.plates.thickness), part) for each, part in ((right, "plates"), (left, "")) if each
    ]
    thickness = float(np.mean([float(getattr(design.wall, zone)) for zone in ("bottom", "lower_side", "top")]))
    shapes = (
        Outline(GROUND, box(-1.2 * wide, 1.2 * wide, -0.06 * tall, 0.0), part="baffle"),
        *([Outline(SLIDER, box(-wide, wide, -soft, 0.0), part="cushion")] if soft else []),
        Outline(SLIDER, box(-wide, wide, 0.0, HIGH * tall), part="slider"),
        Band(around, thickness, "tank"),
        *plates,
    )
    return Drawing(shapes, (), (Named(Spot(SLIDER, 0.0, 0.5 * HIGH * tall), "slider"),), frames=frames)


def frames(history: Any) -> Float[np.ndarray, "steps frames 3"]:
    """The slider, and the wall's columns: up on the right, down on the left; then both plates', likewise."""
    parts = [part for part in ("wall", "plate") if f"{part}_x" in history.others]
    both = [half for part in parts for half in _halves(*(history.others[f"{part}_{axis}"] for axis in "xy"))]
    return np.concatenate([as_they_are(history), *both], axis=1)


def _halves(x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
    """What goes through these points (steps, points) [m] on the right, as frames, and its mirror image backwards."""
    x, y = np.asarray(x), np.asarray(y)
    angle = np.arctan2(np.gradient(y, axis=1), np.gradient(x, axis=1))
    return np.stack([x, y, angle], axis=-1), np.stack([-x, y, -angle], axis=-1)[:, ::-1]
