"""What a docking in space looks like: from the side, as the plane's, and along the cone's axis."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
from jaxtyping import Float

from ..drawing import Arrows, Detail, Disc, Drawing, Spot
from ..probe_cone.approach import turned
from ..probe_cone.bodies import TIP, P, T, probe_masses
from ..probe_cone.drawing import drawing as planar_drawing
from ..probe_cone.drawing import mouth
from ..probe_cone.parts import parts_of
from ..probe_cone.parts.part import DrawnPart
from .design import Design3D

Places = Float[np.ndarray, "steps 3"]
TIP_FORCE = tuple(f"{TIP}_force_{axis}" for axis in "xyz")  # in a history, in inertial axes [N]
ROOM = 1.15  # half of the view along the axis, in radii of the cone's mouth


def drawing(design: Design3D, bodies: tuple[str, ...] = ()) -> Drawing:
    """Return both views: the side one shows every body by the projections of its axis and its centre of mass."""
    shown: Any = design  # the plane's drawing takes what has the plane's fields
    side, front = planar_drawing(shown, bodies), float(probe_masses(design).front)
    wide, cone = mouth(shown)[1], design.cone
    # The frames along the axis stand behind all others: that of the cone, that of the tip, and those of parts.
    count = side.frames(_at_rest(bodies)).shape[1]
    parts = list[DrawnPart]()
    for part in parts_of(design):
        parts.append(part.end_on(design, count + 2 + sum(it.frames for it in parts)))

    def frames(history: Any) -> Float[np.ndarray, "steps frames 3"]:
        flat = side.frames(SimpleNamespace(position=from_the_side(history), others=history.others, state=None))
        poses = np.concatenate([flat, along_the_axis(history, front)], axis=1)
        for part in parts:
            poses = part.with_frames(poses, history)
        return poses

    along = Detail(
        "along the cone's axis, with the ball's path",
        Spot(count),
        ROOM * wide,
        (
            # Of the probe's colour, below latches and both edges of the cone.
            Disc(Spot(count + 1), float(design.probe.tip_radius), part="probe"),
            *(shape for part in parts for shape in part.shapes),
            Disc(Spot(count), wide, filled=False, part="mouth and throat of the cone"),
            Disc(Spot(count), float(cone.throat_radius), filled=False),
        ),
        axes=("z [mm]", "y [mm]"),
        path=count + 1,
        framed=False,
    )
    return Drawing(
        side.shapes,
        names=side.names,
        detail=along,
        frames=frames,
        arrows=lambda history: arrows(design, history, front),
    )


def _at_rest(bodies: tuple[str, ...]) -> Any:
    """Return a history of one instant, all bodies at the origin: what the number of frames is asked of."""
    return SimpleNamespace(position=np.zeros((1, 4, 3)), others={}, state=None)


def from_the_side(history: Any) -> Float[np.ndarray, "steps bodies 3"]:
    """Return x and y of each body, and the angle of its axis as it is seen along z."""
    position = np.asarray(history.position)
    along = turned(position[..., 3:], np.array([1.0, 0.0, 0.0]))
    return np.concatenate([position[..., :2], np.arctan2(along[..., 1], along[..., 0])[..., None]], axis=-1)


def arrows(design: Design3D, history: Any, front: float) -> Arrows:
    """Return where the contact force acts on the cone, and its components, from the side and along the axis."""
    position, off = np.asarray(history.position), in_the_cone(history, front)
    cone = position[:, T, 3:]
    nothing = np.zeros(len(position))
    force = np.stack([np.asarray(history.others.get(name, nothing)) for name in TIP_FORCE], axis=-1)
    foot = _foot(design, off)
    from_side = np.concatenate([(position[:, T, :3] + turned(cone, foot))[:, :2], force[:, :2]], axis=-1)
    along = np.concatenate([foot[:, :0:-1], turned(-cone, force)[:, :0:-1]], axis=-1)  # z, then y
    return np.stack([from_side, along], axis=1)[:, :, None]


def _foot(design: Design3D, off: Places) -> Places:
    """Return the point of the cone that is nearest to the tip's centre ``off`` its origin [m]."""
    start = np.array([-float(design.cone.offset), float(design.cone.throat_radius)])
    flank = np.array(mouth(cast(Any, design))) - start
    radius = np.hypot(off[:, 1], off[:, 2])
    share = np.clip((np.stack([off[:, 0], radius], axis=-1) - start) @ flank / (flank @ flank), 0.0, 1.0)
    x, rho = (start + share[:, None] * flank).T
    # On the axis itself nothing touches, and any direction will do.
    around = off[:, 1:] / np.maximum(radius, 1e-300)[:, None]
    return np.concatenate([x[:, None], rho[:, None] * around], axis=-1)


def in_the_cone(history: Any, front: float) -> Places:
    """Return the tip's centre in the axes of T [m], ``front`` [m] before the probe's centre of mass."""
    position = np.asarray(history.position)
    tip = position[:, P, :3] + turned(position[:, P, 3:], np.array([front, 0.0, 0.0]))
    return turned(-position[:, T, 3:], tip - position[:, T, :3])


def along_the_axis(history: Any, front: float) -> Float[np.ndarray, "steps 2 3"]:
    """Return the frames of a view in which the cone stands still, z to the right and y up: its own, and the tip's."""
    off = in_the_cone(history, front)
    moved = np.stack([off[:, 2], off[:, 1], np.zeros(len(off))], axis=-1)
    return np.stack([np.zeros_like(moved), moved], axis=1)
