"""What a design and its approach rule out or leave open, before anything is computed."""

import math
from collections.abc import Iterator

import numpy as np

from ..view import Caution
from .design import Design, Scenario
from .parts import parts_of


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
    x, aside = scenario.approach.flight(design, scenario, mouth - radius - float(scenario.standoff))
    past = np.flatnonzero(x > mouth)
    # A tip that does not get to the mouth in that time does not miss it for certain.
    if not past.size:
        return
    before = slice(0, int(past[0]) + 1)
    off = np.interp(mouth, x[before][-2:], aside[before][-2:])
    # A tip that passes the mouth outside the rim may have touched the rim on its way.
    nearest = np.min(np.hypot(x[before] - mouth, aside[before] - rim))
    if off > rim and nearest > radius:
        passed = f"the tip passes its mouth {1e3 * off:.4g} mm off the axis, beyond the rim at {1e3 * rim:.4g} mm"
        offsets = (f"scenario.{name} is {1e3 * float(getattr(scenario, name)):.4g} mm" for name in scenario.offsets)
        given = " and ".join(offsets)
        yield Caution(f"the approach misses the cone: {passed}; {given}", "approach", excess=off - rim)
