"""How the vehicles of some scenarios meet, in the few numbers that parts are sized by."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ....errors import InputError
from ..parts.vehicles import reduced_mass


class Encounter(NamedTuple):
    """The numbers that a latch and a buffer are sized by, the worst of some scenarios.

    - ``mass``: μ, the reduced mass [kg].
    - ``slowest``, ``fastest``: speeds of approach [m/s].
    - ``miss``: the tip's largest distance from the axis where it crosses the capture plane [m].
    - ``angle``: the probe's largest angle against the axis there [rad].
    - ``approach``: the longest time until the tip is at the capture plane, unless it bounces [s].
    - ``turn_inertia``: that a turn of the vehicles about the tip meets [kg m²].
    """

    mass: float
    slowest: float
    fastest: float
    miss: float
    angle: float
    approach: float
    turn_inertia: float


def encounter(design: Any, scenarios: Sequence[Any]) -> Encounter:
    """Return how a design's vehicles meet in some scenarios. **Raises:** `InputError` where there are none."""
    if not scenarios:
        raise InputError("scenarios is empty; sizing needs at least one")
    speeds = [float(np.linalg.norm(it.approach.speeds)) for it in scenarios]
    misses, angles, times = zip(
        *(_crossing(design, it, speed) for it, speed in zip(scenarios, speeds, strict=True)), strict=True
    )
    return Encounter(
        mass=float(reduced_mass(design)),
        slowest=min(speeds),
        fastest=max(speeds),
        miss=max(misses),
        angle=max(angles),
        approach=max(times),
        turn_inertia=turn_inertia(design),
    )


def play(design: Any) -> float:
    """Return how far off the axis the ball's centre can be where it crosses the capture plane [m]: R_c - R cos β."""
    cone, radius = design.cone, float(design.probe.tip_radius)
    return max(float(cone.throat_radius) - radius * math.cos(float(cone.half_angle)), 0.0)


def _crossing(design: Any, scenario: Any, speed: float) -> tuple[float, float, float]:
    """Return the miss [m] and the angle [rad] with which a tip crosses the capture plane at most, and when [s]."""
    cone, radius, approach = design.cone, float(design.probe.tip_radius), scenario.approach
    beta, room = float(cone.half_angle), play(design)
    depth = float(cone.length) * math.cos(beta)
    if scenario.start == "free":
        standoff = float(scenario.standoff)
        x, aside = approach.flight(design, scenario, -float(cone.offset) - depth - radius - standoff)
        before = aside[x < -float(cone.offset) - radius * math.sin(beta)]
        way, off = standoff + depth, float(np.max(before, initial=0.0))
    else:
        distance = float(scenario.contact_distance)
        way, off = distance * math.cos(beta), room + distance * math.sin(beta)
    # Who flies that far off the axis touches no flank on the way; others slide down it, to its end at most.
    miss = min(off, room)
    # Where the vehicles do not give way, the flank turns the probe about its hinge.
    slid = math.asin(min((off - miss) / hinge_to_tip(design), 1.0))
    turned = float(np.linalg.norm(approach.active_spin - approach.passive_spin)) * way / speed
    return miss, approach.angle + turned + slid, way / speed


def hinge_to_tip(design: Any) -> float:
    """Return the distance of the tip's centre from the hinge at the spring's free length [m]."""
    buffer = design.buffer
    return float(design.probe.length) + float(buffer.free_length) - float(buffer.cylinder_length)


def turn_inertia(design: Any) -> float:
    """Return the inertia that the angle between two vehicles meets which are pinned at the tip [kg m²] (M185).

    With arms a and b from their centres of mass to the pin and no angular momentum, A θ̇₁ + B θ̇₂ = 0 with A = I₁ + μ a
    (a + b) and B = I₂ + μ b (a + b); the kinetic energy is then half of this times the square of θ̇₁ - θ̇₂.
    """
    mass, first, second = (float(it) for it in (reduced_mass(design), design.active.inertia, design.passive.inertia))
    a = float(design.active.hinge_offset) + hinge_to_tip(design)
    b = float(design.cone.offset) + float(design.probe.tip_radius) * math.sin(float(design.cone.half_angle))
    of_first, of_second = first + mass * a * (a + b), second + mass * b * (a + b)
    both = first * of_second**2 + second * of_first**2 + mass * (a * second - b * first) ** 2
    return both / (of_first + of_second) ** 2
