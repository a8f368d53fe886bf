"""What the dropped bar looks like."""

from typing import Any

import numpy as np
from jaxtyping import Float

from ...multibody import Coordinates
from ..drawing import (
    GROUND,
    Band,
    Detail,
    Disc,
    Drawing,
    Named,
    Outline,
    RodShape,
    Spot,
    Touch,
    box,
    stations,
    with_stations,
)
from .assembly import BAR, PLATE, ball_on_plate
from .design import BarDrop

CLOSER = 4.0  # half of the detail's width, in radii of the ball


def drawing(design: BarDrop, bodies: tuple[str, ...] = ()) -> Drawing:
    """Return the bar on its hinge, the ball end, and the plate below it, in the design's lengths; bent as far as they
    bend."""
    bar, plate = design.bar, design.plate
    half, ball, wide = float(bar.length) / 2.0, float(bar.ball_radius), float(bar.diameter)
    end, hinge, struck = Spot(BAR, half), Spot(GROUND), Spot(GROUND, 2.0 * half, -ball)
    reach, thick = float(plate.length) / 2.0, float(plate.thickness)
    slab: Outline | Band = Outline(GROUND, box(struck.x - reach, struck.x + reach, -ball - thick, -ball), part="plate")
    rod: RodShape | Band = RodShape(Spot(BAR, -half), end, wide, "bar")
    frames, surface = 1 + bool(plate.modes), struck
    if bar.modes:
        rod = Band(stations(frames), wide, "bar")
        # In the order in which `with_bending` appends them: the bar's stations, then the plate's.
        frames, end = frames + len(rod.stations), Spot(rod.stations[-1])
    if plate.modes:
        slab = Band(stations(frames), thick, "plate")
        # the middle station lies in the middle of the plate's thickness, the contact on its top
        surface = Spot(slab.stations[len(slab.stations) // 2], 0.0, 0.5 * thick)
    return Drawing(
        shapes=(
            slab,
            rod,
            Disc(end, ball, part="ball end"),
            Disc(hinge, 1.5 * wide, filled=False, part="hinge"),
        ),
        touches=(Touch(end, surface, ball_on_plate(design).shape, -1.0, ball),),
        names=(Named(hinge, "hinge"), Named(struck, "where it strikes")),
        detail=Detail("where the ball strikes", struck, CLOSER * ball),
        frames=lambda history: with_bending(design, history),
    )


def with_bending(design: BarDrop, history: Any) -> Float[np.ndarray, "steps frames 3"]:
    """Return the bodies' frames, and those of stations along the bar and along the plate, where they bend."""
    frames, parts = np.asarray(history.position), (design.bar, design.plate)
    order = Coordinates(frames.shape[1], tuple(part.bent.modes.size if part.modes else 0 for part in parts))
    if design.bar.modes:
        frames = with_stations(frames, history, order, design.bar.bent, BAR)
    if design.plate.modes:
        frames = with_stations(frames, history, order, design.plate.bent, PLATE)
        frames[:, -len(stations(0)) :, 1] -= 0.5 * float(design.plate.thickness)  # the frame lies in the plate's top
    return frames
