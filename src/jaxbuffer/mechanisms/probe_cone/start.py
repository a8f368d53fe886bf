"""The start of a run: positions and velocities at t = 0."""

from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar, stacked
from ...plane import Vector
from .bodies import Masses
from .design import Design, DockingDesign, Scenario


def start_motion(
    design: Design, scenario: Scenario, masses: Masses
) -> tuple[Float[Array, " coordinates"], Float[Array, " coordinates"]]:
    """Return positions and velocities at t = 0 (M62, M63, M170).

    **Arguments:** ``design``; ``scenario``; ``masses``: of the probe. **Returns:** q [m, m, rad, …] and q̇, 12 entries
    each and one for each mode of a probe that bends.
    """
    local = _tip_at_start(design, scenario)
    turn_cos, turn_sin = jnp.cos(scenario.misalignment), jnp.sin(scenario.misalignment)
    tip = Vector(turn_cos * local.x - turn_sin * local.y, turn_sin * local.x + turn_cos * local.y)
    modes = 0 if masses.bending is None else masses.bending.modes.size
    # The modal coordinates follow those of all bodies; the probe starts straight.
    passive = [0.0, 0.0, scenario.misalignment, *[0.0] * modes]
    passive_rate = [0.0, 0.0, scenario.passive_rate, *[0.0] * modes]
    if scenario.start == "free":
        placed, moving = _turned(design, scenario, masses, tip)
        return stacked([*placed, *passive]), stacked([*moving, *passive_rate])
    probe, cylinder, active = behind_tip(design, masses, tip.x)
    q = stacked([active, tip.y, 0.0, cylinder, tip.y, 0.0, probe, tip.y, 0.0, *passive])
    return q, stacked([scenario.approach_speed, 0.0, 0.0] * 3 + passive_rate)


def _tip_at_start(design: Design, scenario: Scenario) -> Vector:
    """Return the tip's centre at t = 0 in the axes of T: at the lower flank (M62), or anywhere before the mouth
    (M170)."""
    if scenario.start == "free":
        return Vector(before_mouth(design, scenario.standoff), scenario.offset)
    return on_lower_flank(design, scenario.contact_distance)


def before_mouth(design: DockingDesign[Any], standoff: Scalar) -> Scalar:
    """Return where along the axis of T the tip's centre is, ``standoff`` [m] before it could touch the mouth (M170)."""
    cone = design.cone
    return -cone.offset - cone.length * jnp.cos(cone.half_angle) - design.probe.tip_radius - standoff


def on_lower_flank(design: DockingDesign[Any], distance: Scalar) -> Vector:
    """Return the tip's centre in the axes of T where it touches the lower flank at a slant ``distance`` [m] (M62)."""
    angle, cone, radius = design.cone.half_angle, design.cone, design.probe.tip_radius
    cos, sin = jnp.cos(angle), jnp.sin(angle)
    return Vector(
        -cone.offset - distance * cos - radius * sin,
        -cone.throat_radius - distance * sin + radius * cos,
    )


def behind_tip(design: DockingDesign[Any], masses: Masses, tip: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Return where the centres of mass of probe, cylinder and active vehicle are along their axis [m], the ``tip``
    being there and the spring at its free length."""
    probe = tip - masses.front
    cylinder = probe - masses.rear - design.buffer.free_length + design.buffer.cylinder_length / 2
    return probe, cylinder, cylinder + design.buffer.cylinder_length / 2 - design.active.hinge_offset


def _turned(design: Design, scenario: Scenario, masses: Masses, tip: Vector) -> tuple[list[Scalar], list[Scalar]]:
    """Return positions and velocities of S, B and P at a free start: they lie along an axis through the tip and turn
    about the centre of mass of S as one body (M170)."""
    cos, sin = jnp.cos(scenario.active_angle), jnp.sin(scenario.active_angle)
    probe, cylinder, active = behind_tip(design, masses, 0.0)
    placed: list[Scalar] = []
    moving: list[Scalar] = []
    for behind in (active, cylinder, probe):
        placed += [tip.x + behind * cos, tip.y + behind * sin, scenario.active_angle]
        arm = behind - active
        moving += [
            scenario.approach_speed - scenario.active_rate * arm * sin,
            scenario.lateral_speed + scenario.active_rate * arm * cos,
            scenario.active_rate,
        ]
    return placed, moving
