"""What a docking in space looks like: from the side, as the plane's, and along the cone's axis."""

from types import SimpleNamespace
from typing import Any

import numpy as np
from jaxtyping import Float

from ..drawing import Detail, Disc, Drawing, Spot
from ..probe_cone.approach import turned
from ..probe_cone.bodies import P, T, probe_masses
from ..probe_cone.drawing import drawing as planar_drawing
from ..probe_cone.drawing import mouth
from .design import Design3D

ROOM = 1.15  # half of the view along the axis, in radii of the cone's mouth


def drawing(design: Design3D, bodies: tuple[str, ...] = ()) -> Drawing:
    """Return both views: the side one shows every body by the projections of its axis and its centre of mass."""
    shown: Any = design  # the plane's drawing takes what has the plane's fields
    side, front = planar_drawing(shown, bodies), float(probe_masses(design).front)
    wide, cone = mouth(shown)[1], design.cone

    def frames(history: Any) -> Float[np.ndarray, "steps frames 3"]:
        flat = side.frames(SimpleNamespace(position=from_the_side(history), others=history.others, state=None))
        return np.concatenate([flat, along_the_axis(history, front)], axis=1)

    # The frames along the axis stand behind all others: that of the cone, and that of the tip.
    count = side.frames(_at_rest(bodies)).shape[1]
    along = Detail(
        "along the cone's axis, with the ball's path",
        Spot(count),
        ROOM * wide,
        (
            # Of the probe's colour, below both edges of the cone.
            Disc(Spot(count + 1), float(design.probe.tip_radius), part="probe"),
            Disc(Spot(count), wide, filled=False, part="mouth and throat of the cone"),
            Disc(Spot(count), float(cone.throat_radius), filled=False),
        ),
        axes=("z [mm]", "y [mm]"),
        path=count + 1,
        framed=False,
    )
    return Drawing(side.shapes, names=side.names, detail=along, frames=frames)


def _at_rest(bodies: tuple[str, ...]) -> Any:
    """Return a history of one instant, all bodies at the origin: what the number of frames is asked of."""
    return SimpleNamespace(position=np.zeros((1, 4, 3)), others={}, state=None)


def from_the_side(history: Any) -> Float[np.ndarray, "steps bodies 3"]:
    """Return x and y of each body, and the angle of its axis as it is seen along z."""
    position = np.asarray(history.position)
    along = turned(position[..., 3:], np.array([1.0, 0.0, 0.0]))
    return np.concatenate([position[..., :2], np.arctan2(along[..., 1], along[..., 0])[..., None]], axis=-1)


def along_the_axis(history: Any, front: float) -> Float[np.ndarray, "steps 2 3"]:
    """Return the frames of a view in which the cone stands still, z to the right and y up: its own, and the tip's,
    ``front`` [m] before the probe's centre of mass."""
    position = np.asarray(history.position)
    tip = position[:, P, :3] + turned(position[:, P, 3:], np.array([front, 0.0, 0.0]))
    off = turned(-position[:, T, 3:], tip - position[:, T, :3])
    moved = np.stack([off[:, 2], off[:, 1], np.zeros(len(off))], axis=-1)
    return np.stack([np.zeros_like(moved), moved], axis=1)
