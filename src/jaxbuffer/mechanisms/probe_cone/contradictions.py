"""What a design and its approach rule out or leave open, before anything is computed."""

import math
from collections.abc import Iterator

import numpy as np

from ..view import Caution
from .design import Design, Scenario
from .parts import parts_of

INSTANTS = 4001  # of a flight, between which the tip moves by far less than its radius
FURTHER = 4.0  # times the way to the throat that a flight is followed


def contradictions(design: Design, scenario: Scenario) -> list[Caution]:
    """Return a caution for a ball that does not pass the throat, an approach that misses the cone, and what the parts
    of the design rule out."""
    of_parts = (it for part in parts_of(design, scenario) for it in part.contradictions(design, scenario))
    return [*_ball_in_throat(design), *_miss(design, scenario), *of_parts]


def _ball_in_throat(design: Design) -> Iterator[Caution]:
    """Yield what a ball that is larger than the throat cannot do (M65)."""
    reach = design.cone.reach(design.probe.tip_radius)
    if reach == math.inf:
        return
    radius, throat = float(design.probe.tip_radius), float(design.cone.throat_radius)
    sizes = f"probe.tip_radius {1e3 * radius:.4g} mm is above cone.throat_radius {1e3 * throat:.4g} mm"
    if reach < 0.0:
        wedged = f"the ball wedges in the cone {-1e3 * reach:.3g} mm before the capture plane and cannot reach it"
        yield Caution(f"{sizes}: {wedged}", "throat", excess=-reach)
        return
    at_rest = f"it comes to rest on the throat's edge, at most {1e3 * reach:.3g} mm behind the capture plane"
    # The less it gets behind the capture plane the worse, and worse still where it does not reach it.
    line = f"{sizes}: the ball does not pass the throat; {at_rest}, where the model counts it as captured"
    yield Caution(line, "throat", excess=-reach)


def _miss(design: Design, scenario: Scenario) -> Iterator[Caution]:
    """Yield a caution if the tip of a free start flies past the cone, by the straight flight and steady turning of both
    sides."""
    if scenario.start != "free" or (scenario.has("thrust") and float(scenario.thrust) < 0.0):
        return
    cone, radius = design.cone, float(design.probe.tip_radius)
    length, angle = float(cone.length), float(cone.half_angle)
    mouth = -float(cone.offset) - length * np.cos(angle)
    rim = float(cone.throat_radius) + length * np.sin(angle)
    x, y = _flight(design, scenario, mouth - radius - float(scenario.standoff))
    past = np.flatnonzero(x > mouth)
    # A tip that does not get to the mouth in that time does not miss it for certain.
    if not past.size:
        return
    before = slice(0, int(past[0]) + 1)
    off = np.interp(mouth, x[before][-2:], y[before][-2:])
    # A tip that passes the mouth outside the rim may have touched the rim on its way.
    nearest = np.min(np.hypot(x[before] - mouth, np.abs(y[before]) - rim))
    if abs(off) > rim and nearest > radius:
        passed = f"the tip passes its mouth {1e3 * abs(off):.4g} mm off the axis, beyond the rim at {1e3 * rim:.4g} mm"
        given = f"scenario.offset is {1e3 * float(scenario.offset):.4g} mm"
        yield Caution(f"the approach misses the cone: {passed}; {given}", "approach", excess=abs(off) - rim)


def _flight(design: Design, scenario: Scenario, start: float) -> tuple[np.ndarray, np.ndarray]:
    """Return where the tip's centre is in the axes of the passive vehicle [m] while nothing touches, at instants from 0
    on.

    ``start``: its x at t = 0 in those axes [m] (M170).
    """
    speed, lateral = float(scenario.approach_speed), float(scenario.lateral_speed)
    time = np.linspace(0.0, FURTHER * abs(start) / speed, INSTANTS)
    turn, tilt = float(scenario.misalignment), float(scenario.active_angle)
    offset = float(scenario.offset)
    first = start * np.cos(turn) - offset * np.sin(turn), start * np.sin(turn) + offset * np.cos(turn)
    # The active vehicle turns about its centre of mass, which is this far behind the tip at the spring's free length.
    behind = float(design.active.hinge_offset) + float(design.buffer.free_length) + float(design.probe.length)
    pushed = np.zeros_like(time)
    if scenario.has("thrust"):
        for_time, push = float(scenario.thrust_time), float(scenario.thrust) / float(design.active.mass)
        pushing = np.minimum(time, for_time)
        # ½ a t² while it pushes, and from then on at the speed a τ that it has given: one formula for both.
        pushed = push * pushing * (time - 0.5 * pushing)
    axis = tilt + float(scenario.active_rate) * time
    x = first[0] + speed * time + pushed * np.cos(tilt) + behind * (np.cos(axis) - np.cos(tilt))
    y = first[1] + lateral * time + pushed * np.sin(tilt) + behind * (np.sin(axis) - np.sin(tilt))
    seen = turn + float(scenario.passive_rate) * time
    return x * np.cos(seen) + y * np.sin(seen), -x * np.sin(seen) + y * np.cos(seen)
