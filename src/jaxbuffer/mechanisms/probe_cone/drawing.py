"""What the capture mechanism looks like. Lengths are the design's; what it leaves open is said below."""

import math
from typing import Any

import numpy as np
from jaxtyping import Float

from ...contact import Segment
from ...multibody import Coordinates
from ..drawing import (
    Band,
    Coil,
    Detail,
    Disc,
    Drawing,
    Named,
    Outline,
    RodShape,
    Spot,
    Spring,
    Touch,
    box,
    stations,
    with_stations,
)
from .assembly import SIDE
from .bodies import B, P, S, T, probe_masses
from .design import Design
from .parts import parts_of
from .parts.part import DrawnPart
from .parts.rod import CYLINDER_WIDTH, ROD_WIDTH

TIP = 4  # the frame behind those of the bodies: the tip's, off the probe's axis where the probe bends
CLOSER = 3.0  # half of the detail's width, in radii of the tip
# A vehicle is drawn no higher and no longer than lets probe and cone be seen beside it: half as high, and as long, as
# so many half-widths of the cone's mouth, and no shorter than the cylinder in it with some room.
LARGEST, ROOMY = 4.5, 1.25
TEETH, TOOTH = 8, 0.02  # of a break line: how many, and how deep, of the largest half-height


def drawing(design: Design, bodies: tuple[str, ...] = ()) -> Drawing:
    """Return both vehicles as far as they fit beside the rest; hinge, buffer, probe, cone and parts, in the design's
    lengths."""
    masses = probe_masses(design)
    front, rear = float(masses.front), float(masses.rear)
    tip, half = float(design.probe.tip_radius), float(design.buffer.cylinder_length) / 2.0
    tall, hinge = 0.5 * CYLINDER_WIDTH * tip, Spot(B, half)
    wide, bending = ROD_WIDTH * tip, masses.bending
    rod = RodShape(Spot(P, -rear), Spot(TIP), wide, "probe")
    bent = Band(stations(TIP + 1), wide, "probe", clamped=True)
    behind = TIP + 1 + (0 if bending is None else len(stations(TIP + 1)))  # the frames of the parts
    parts = _drawn(design, behind)
    shapes = (
        active(design),
        *passive(design),
        Outline(B, box(-half, half, -tall, tall), part="cylinder"),
        Spring(Spot(B, -half), Spot(P, -rear), 1.4 * tall, "axial spring and damper"),
        Coil(hinge, 1.5 * tall, "hinge with torsional spring and damper"),
        rod if bending is None else bent,
        Disc(Spot(TIP), tip),
        *(shape for part in parts for shape in part.shapes),
    )
    names = (Named(hinge, "hinge"), Named(Spot(T, -float(design.cone.offset)), "throat"), Named(Spot(TIP), "tip"))
    detail = Detail("tip", Spot(TIP), CLOSER * tip)

    def frames(history: Any) -> Float[np.ndarray, "steps frames 3"]:
        poses = with_tip(history, front)
        if bending is not None:
            order = Coordinates(TIP, tuple(bending.modes.size if body == P else 0 for body in range(TIP)))
            poses = with_stations(poses, history, order, bending, P)
        for part in parts:
            poses = part.with_frames(poses, history)
        return poses

    return Drawing(shapes, flanks(design), names, detail, frames)


def _drawn(design: Design, first: int) -> list[DrawnPart]:
    """Return the parts of a design in its drawing. ``first``: number of the first frame that is a part's own."""
    drawn = list[DrawnPart]()
    for part in parts_of(design):
        drawn.append(part.drawn(design, first + sum(it.frames for it in drawn)))
    return drawn


def with_tip(history: Any, front: float) -> Float[np.ndarray, "steps frames 3"]:
    """Return the bodies' frames and the tip's, ``front`` [m] before the probe's centre of mass and as far off its axis
    as the probe is bent."""
    frames = np.asarray(history.position)
    x, y, angle = np.moveaxis(frames[:, P], -1, 0)
    off = np.asarray(history.others.get("bending", 0.0 * x))
    cos, sin = np.cos(angle), np.sin(angle)
    tip = np.stack([x + front * cos - off * sin, y + front * sin + off * cos, angle], axis=-1)
    return np.concatenate([frames, tip[:, None]], axis=1)


def active(design: Design) -> Outline:
    """Return the active vehicle, a uniform box of its mass and inertia (assumed) whose front is at the hinge."""
    reach = float(design.active.hinge_offset)
    corners, broken = _vehicle(design, reach, float(design.active.inertia / design.active.mass), 0.0)
    return Outline(S, corners, part=f"active vehicle{broken}")


def passive(design: Design) -> tuple[Outline, ...]:
    """Return the passive vehicle, a uniform box of its mass and inertia (assumed) whose front is the throat plane, with
    the cone's two flanks before it, and the capture plane (M65)."""
    cone = design.cone
    reach, throat = float(cone.offset), float(cone.throat_radius)
    far, wide = mouth(design)
    corners, broken = _vehicle(design, reach, float(design.passive.inertia / design.passive.mass), 1.5 * wide)
    corners = -corners  # its front faces backwards
    hole = -reach + 0.6 * float(np.max(corners[:, 0]) + reach)  # x where the throat's hole ends
    vehicle = np.concatenate([corners, [[-reach, -throat], [hole, -throat], [hole, throat], [-reach, throat]]])
    wedge = np.array([[-reach, throat], [far, wide], [-reach, wide]])
    plane = -reach - float(design.probe.tip_radius) * math.sin(float(cone.half_angle))
    return (
        Outline(T, vehicle, part=f"passive vehicle{broken}"),
        Outline(T, wedge, part="cone"),
        Outline(T, wedge * [1.0, -1.0]),
        Outline(T, np.array([[plane, -1.3 * wide], [plane, 1.3 * wide]]), False, "capture plane", dashed=True),
    )


def mouth(design: Design) -> tuple[float, float]:
    """Return where the upper flank ends, in the axes of the passive vehicle [m]."""
    cone = design.cone
    angle, length = float(cone.half_angle), float(cone.length)
    return -float(cone.offset) - length * math.cos(angle), float(cone.throat_radius) + length * math.sin(angle)


def flanks(design: Design) -> tuple[Touch, ...]:
    """Return where the forces of the lower and the upper flank act on the tip (M30, M31)."""
    cone = design.cone
    cos, sin = math.cos(float(cone.half_angle)), math.sin(float(cone.half_angle))
    start = -float(cone.offset), float(cone.throat_radius)
    return tuple(
        Touch(
            ball=Spot(TIP),
            carrier=Spot(T),
            shape=Segment(start[0], -side * start[1], -cos, -side * sin, float(cone.length)),
            side=float(side),
            radius=float(design.probe.tip_radius),
        )
        for side in SIDE
    )


def _vehicle(design: Design, reach: float, square: float, least: float) -> tuple[np.ndarray, str]:
    """Return the corners of a uniform box of half the length ``reach`` [m] and the radius of gyration √``square``,
    ``least`` [m] half as high at least, with its front at x = ``reach``; and what the legend adds: a box too large
    beside the mechanism is broken off along zigzag lines."""
    wide, cylinder = mouth(design)[1], ROOMY * float(design.buffer.cylinder_length)
    longest = max(LARGEST * wide, cylinder)
    # Of a uniform box I/m = (l² + h²)/12; half its height is a third of half its length at least.
    half_height = math.sqrt(max(3.0 * square - reach**2, reach**2 / 9.0))
    whole = max(2.0 * reach, min(cylinder, longest)), max(half_height, least)
    length, tall = min(whole[0], longest), min(whole[1], LARGEST * wide)
    corners = np.array([[reach, -tall], [reach - length, -tall], [reach - length, tall], [reach, tall]])
    if (length, tall) == whole:
        return corners, ""
    tooth = TOOTH * LARGEST * wide
    cut = whole[1] > tall, whole[0] > length, whole[1] > tall
    edges = [_edge(corners[k], corners[k + 1], tooth if cut[k] else 0.0) for k in range(3)]
    return np.concatenate([*edges, corners[3:]]), ", broken off"


def _edge(start: np.ndarray, end: np.ndarray, tooth: float) -> np.ndarray:
    """Return the points of an edge without its last one: the first alone, or a zigzag of ``tooth`` [m] to either
    side."""
    if tooth == 0.0:
        return start[None]
    along = (end - start) / float(np.hypot(*(end - start)))
    number = np.arange(2 * TEETH)
    swing = np.where(number == 0, 0.0, np.where(number % 2, tooth, -tooth))
    return start + np.outer(number / (2 * TEETH), end - start) + np.outer(swing, [-along[1], along[0]])
