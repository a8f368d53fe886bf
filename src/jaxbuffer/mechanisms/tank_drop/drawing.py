"""What the drop onto a tank looks like."""

from typing import Any

import numpy as np
from jaxtyping import Float

from ..drawing import GROUND, Band, Drawing, Named, Outline, Spot, as_they_are, box
from .design import TankDrop
from .node_sets import NodeSets
from .numbering import Numbering

SLIDER = 0  # its body
HIGH = 0.5  # of the tank's height: how high the slider is drawn


def drawing(design: TankDrop, bodies: tuple[str, ...] = ()) -> Drawing:
    """Return the wall as it bends, in front of the cushion that it is pressed into, the slider and the baffle."""
    wide, tall = 0.6 * float(design.tank.width), float(design.tank.height)
    soft = float(design.cushion.thickness) if design.cushion.kind == "layer" else 0.0
    numbers, sets = Numbering.of(design), NodeSets.of(design)
    whole, rows = design.mesh.extent == "whole", len(numbers.plate)
    # Frame 0 is the slider's. Of a half both sides are drawn, so that its columns count twice.
    around = tuple(range(1, (1 if whole else 2) * len(sets.inner) + 1))
    right, left = (tuple(range(around[-1] + 1 + k * rows, around[-1] + 1 + (k + 1) * rows)) for k in (0, 1))
    plates = [
        Band(each, float(design.plates.thickness), part) for each, part in ((right, "plates"), (left, "")) if each
    ]
    # A band has one width, so that the mean of bottom, side and top stands for all zones.
    thickness = float(np.mean([float(getattr(design.wall, zone)) for zone in ("bottom", "lower_side", "top")]))
    shapes = (
        Outline(GROUND, box(-1.2 * wide, 1.2 * wide, -0.06 * tall, 0.0), part="baffle"),
        *([Outline(SLIDER, box(-wide, wide, -soft, 0.0), part="cushion")] if soft else []),
        Outline(SLIDER, box(-wide, wide, 0.0, HIGH * tall), part="slider"),
        Band(around, thickness, "tank"),
        *plates,
    )
    return Drawing(
        shapes, (), (Named(Spot(SLIDER, 0.0, 0.5 * HIGH * tall), "slider"),), frames=frames if whole else both_halves
    )


def frames(history: Any) -> Float[np.ndarray, "steps frames 3"]:
    """Return the frames of the slider, and of the wall's columns: up on the right, down on the left; then both plates',
    likewise."""
    return np.concatenate([as_they_are(history), *_lines(history)], axis=1)


def both_halves(history: Any) -> Float[np.ndarray, "steps frames 3"]:
    """Return the same `frames` of a history that has the right half alone."""
    # Mirrored and followed backwards the left half goes on where the right one ends; its angles change sign.
    both = [half for line in _lines(history) for half in (line, line[:, ::-1] * np.array([-1.0, 1.0, -1.0]))]
    return np.concatenate([as_they_are(history), *both], axis=1)


def _lines(history: Any) -> list[np.ndarray]:
    """Return what goes through the wall's and the plates' points, as frames (steps, points, 3)."""
    lines = []
    for part in ("wall", "plate"):
        if f"{part}_x" in history.others:
            x, y = (np.asarray(history.others[f"{part}_{axis}"]) for axis in "xy")
            lines.append(np.stack([x, y, np.arctan2(np.gradient(y, axis=1), np.gradient(x, axis=1))], axis=-1))
    return lines
