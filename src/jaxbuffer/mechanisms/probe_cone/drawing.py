"""What the capture mechanism looks like. Lengths are the design's; what it leaves open is said below."""

import math
from typing import Any

import numpy as np
from jaxtyping import Float

from ...contact import Segment
from ..drawing import (
    Band,
    Coil,
    Detail,
    Disc,
    Drawing,
    Named,
    Outline,
    Rod,
    Spot,
    Spring,
    Touch,
    box,
    stations,
    with_stations,
)
from .assembly import SIDE, B, P, S, T, probe_masses
from .design import Design

TIP = 4  # the frame behind those of the bodies: the tip's, off the probe's axis where the probe bends
ROD_WIDTH, CYLINDER_WIDTH = 0.8, 2.6  # of the tip's radius; assumed
CLOSER = 3.0  # half of the detail's width, in radii of the tip


def drawing(design: Design, bodies: tuple[str, ...] = ()) -> Drawing:
    """Both vehicles, hinge, buffer, probe and cone, in the design's lengths."""
    masses = probe_masses(design)
    front, rear = float(masses.front), float(masses.rear)
    tip, half = float(design.probe.tip_radius), float(design.buffer.cylinder_length) / 2.0
    tall, hinge = 0.5 * CYLINDER_WIDTH * tip, Spot(B, half)
    stop = [] if design.buffer.stop_stiffness is None else [_stop(design, half, tall)]
    wide, bending = ROD_WIDTH * tip, masses.bending
    rod = Rod(Spot(P, -rear), Spot(TIP), wide, "probe")
    bent = Band(stations(TIP + 1), wide, "probe", clamped=True)
    shapes = (
        Outline(S, active(design), part="active vehicle"),
        *passive(design),
        Outline(B, box(-half, half, -tall, tall), part="cylinder"),
        *stop,
        Spring(Spot(B, -half), Spot(P, -rear), 1.4 * tall, "axial spring and damper"),
        Coil(hinge, 1.5 * tall, "hinge with torsional spring and damper"),
        rod if bending is None else bent,
        Disc(Spot(TIP), tip),
    )
    names = (Named(hinge, "hinge"), Named(Spot(T, -float(design.cone.offset)), "throat"), Named(Spot(TIP), "tip"))
    detail = Detail("tip", Spot(TIP), CLOSER * tip)

    def frames(history: Any) -> Float[np.ndarray, "steps frames 3"]:
        found = with_tip(history, front)
        return found if bending is None else with_stations(found, history, TIP, bending, P)

    return Drawing(shapes, flanks(design), names, detail, frames)


def with_tip(history: Any, front: float) -> Float[np.ndarray, "steps frames 3"]:
    """The bodies' frames and the tip's, ``front`` [m] before the probe's centre of mass and as far off its axis as the
    probe is bent."""
    frames = np.asarray(history.position)
    x, y, angle = np.moveaxis(frames[:, P], -1, 0)
    off = np.asarray(history.others.get("bending", 0.0 * x))
    cos, sin = np.cos(angle), np.sin(angle)
    tip = np.stack([x + front * cos - off * sin, y + front * sin + off * cos, angle], axis=-1)
    return np.concatenate([frames, tip[:, None]], axis=1)


def active(design: Design) -> np.ndarray:
    """The active vehicle's corners: a uniform box of its mass and inertia, whose front is at the hinge; assumed."""
    reach = float(design.active.hinge_offset)
    tall = _half_height(float(design.active.inertia / design.active.mass), reach)
    return box(-reach, reach, -tall, tall)


def passive(design: Design) -> tuple[Outline, ...]:
    """The passive vehicle, a uniform box of its mass and inertia (assumed) whose front is the throat plane, with the
    cone's two flanks before it, and the capture plane (M65)."""
    cone = design.cone
    reach, throat = float(cone.offset), float(cone.throat_radius)
    tall = max(_half_height(float(design.passive.inertia / design.passive.mass), reach), 1.5 * mouth(design)[1])
    hole = 0.2 * reach  # x where the throat's hole ends
    outer = [[-reach, -tall], [reach, -tall], [reach, tall], [-reach, tall]]
    vehicle = np.array([*outer, [-reach, throat], [hole, throat], [hole, -throat], [-reach, -throat]])
    far, wide = mouth(design)
    wedge = np.array([[-reach, throat], [far, wide], [-reach, wide]])
    plane = -reach - float(design.probe.tip_radius) * math.sin(float(cone.half_angle))
    return (
        Outline(T, vehicle, part="passive vehicle"),
        Outline(T, wedge, part="cone"),
        Outline(T, wedge * [1.0, -1.0]),
        Outline(T, np.array([[plane, -1.3 * wide], [plane, 1.3 * wide]]), False, "capture plane", dashed=True),
    )


def mouth(design: Design) -> tuple[float, float]:
    """Where the upper flank ends, in the axes of the passive vehicle [m]."""
    cone = design.cone
    angle, length = float(cone.half_angle), float(cone.length)
    return -float(cone.offset) - length * math.cos(angle), float(cone.throat_radius) + length * math.sin(angle)


def flanks(design: Design) -> tuple[Touch, ...]:
    """Where the forces of the lower and the upper flank act on the tip (M30, M31)."""
    cone = design.cone
    cos, sin = math.cos(float(cone.half_angle)), math.sin(float(cone.half_angle))
    start = -float(cone.offset), float(cone.throat_radius)
    return tuple(
        Touch(
            Spot(TIP), Spot(T), Segment(start[0], -side * start[1], -cos, -side * sin, float(cone.length)), float(side)
        )
        for side in SIDE
    )


def _stop(design: Design, half: float, tall: float) -> Outline:
    """Where the rear end of the rod meets the end stop (M28)."""
    place = half - float(design.buffer.end)
    return Outline(B, np.array([[place, -tall], [place, tall]]), filled=False, part="end stop")


def _half_height(square: float, reach: float) -> float:
    """Half the height [m] of a uniform box with the radius of gyration √``square`` and half the length ``reach``, a
    third of that at least: I/m = (l² + h²)/12."""
    return math.sqrt(max(3.0 * square - reach**2, reach**2 / 9.0))
