"""The start of a run in space: positions and velocities at t = 0."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import stacked
from ...duplication import evaluated_once
from ...space import AXES, Frame, Vector
from ..probe_cone.bodies import Masses
from ..probe_cone.start import before_mouth, behind_tip, on_lower_flank
from .design import Design3D, Scenario3D

Motion = tuple[Float[Array, " coordinates"], Float[Array, " velocities"]]


def start_motion(design: Design3D, scenario: Scenario3D, masses: Masses) -> Motion:
    """Return positions and velocities at t = 0 (M222): S, B and P lie in line behind the tip along x of S, and turn
    about the centre of mass of S as one body.

    **Arguments:** ``design``; ``scenario``; ``masses``: of the probe. **Returns:** q, 28 entries, and v, 24.
    """
    free, zero = scenario.start == "free", Vector(0.0, 0.0, 0.0)
    turned, cone = evaluated_once((scenario.active_rotation, scenario.passive_rotation))
    frame = Frame(zero, turned, turned.axes(), zero, scenario.active_spin)
    tip = Frame(zero, cone, cone.axes(), zero, zero).turn(_tip_at_start(design, scenario))
    speeds = (scenario.lateral_speed_y, scenario.lateral_speed_z) if free else (0.0, 0.0)
    probe, cylinder, active = behind_tip(design, masses, 0.0)
    q, v = [], []
    for place in (active, cylinder, probe):
        moving = Vector(scenario.approach_speed, *speeds) + frame.rate_of(frame.turn(AXES[0] * (place - active)))
        q += [*(tip + frame.turn(AXES[0] * place)), *turned]
        v += [*moving, *frame.spin]
    return stacked([*q, *zero, *cone]), stacked([*v, *zero, *scenario.passive_spin])


def _tip_at_start(design: Design3D, scenario: Scenario3D) -> Vector:
    """Return the tip's centre at t = 0 in the axes of T: at the cone, or anywhere before its mouth."""
    if scenario.start == "free":
        return Vector(before_mouth(design, scenario.standoff), scenario.offset_y, scenario.offset_z)
    # Below the axis, in the plane, is where the azimuth begins.
    place, azimuth = on_lower_flank(design, scenario.contact_distance), jnp.asarray(scenario.azimuth)
    return Vector(place.x, place.y * jnp.cos(azimuth), -place.y * jnp.sin(azimuth))
