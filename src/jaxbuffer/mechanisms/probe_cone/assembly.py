"""The probe-cone mechanism assembled from bodies, joints, spring-dampers and a ball-on-flanks contact.

Four bodies in the paper's order (M4): active vehicle S, cylinder B, probe P (with the tip on its end), passive vehicle
T.
"""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._types import Scalar, stacked
from ...contact import BallPair, KelvinVoigt, RegularisedCoulomb, Segment, contact_law
from ...multibody import (
    AxialSpringDamper,
    Body,
    FlexibleBody,
    Point,
    Prismatic,
    Revolute,
    System,
    TorsionalSpringDamper,
)
from ...multibody.flexible import FlexibleBar, Marker
from ...plane import Vector
from .bending import bending_probe
from .buffer import Buffer
from .buffer_force import BufferForce, is_plain
from .design import Design, Scenario

S, B, P, T = range(4)  # bodies, in the order of the coordinates
LOWER, UPPER = 0, 1  # flanks
FLANKS = 2
SIDE = np.array([1.0, -1.0])  # σ: +1 lower, -1 upper flank


class Masses(NamedTuple):
    """The probe with its tip (M6).

    - ``mass``: m_P [kg].
    - ``inertia``: I_P about the centre of mass [kg m²].
    - ``rear``, ``front``: l_r and l_t, from the centre of mass to the rear end and to the tip's centre [m].
    - ``tip_inertia``: I_t of the tip about its centre [kg m²]; a welded tip's is part of ``inertia`` too.
    - ``bending``: of a probe that bends, the modes of its rod with the tip, clamped at the rear end.
    """

    mass: Scalar
    inertia: Scalar
    rear: Scalar
    front: Scalar
    tip_inertia: Scalar
    bending: FlexibleBar | None

    @property
    def tip_centre(self) -> Point:
        """The tip's centre, on the probe."""
        return (self.front, 0.0) if self.bending is None else self.bending.end

    def guided(self, x: Scalar) -> Point:
        """A point of the probe's axis that does not bend, ``x`` [m] before its centre of mass."""
        return (x, 0.0) if self.bending is None else Marker.on_frame(x, 0.0, self.bending.modes.size)


def probe_masses(design: Design) -> Masses:
    """Rod and tip as one body; a free tip's spin inertia is left out of it (M6)."""
    probe = design.probe
    mass = probe.rod_mass + probe.tip_mass
    shift = probe.tip_mass * (probe.length / 2) / mass
    rear, front = probe.length / 2 + shift, probe.length / 2 - shift
    tip = probe.tip_inertia
    inertia = probe.rod_mass * (probe.length**2 / 12 + shift**2) + probe.tip_mass * front**2
    return Masses(mass, inertia if probe.free_tip else inertia + tip, rear, front, tip, bending_probe(probe))


def assemble_system(design: Design, probe: Masses, stabilisation: Scalar) -> System:
    """Bodies, joints and buffer of the mechanism (M15, M23, M26).

    **Arguments:** ``design``; ``probe``: masses and lengths of the probe; ``stabilisation``: Baumgarte's gain [1/s].
    """
    half = design.buffer.cylinder_length / 2
    cylinder = Body(design.buffer.cylinder_mass, design.buffer.cylinder_mass * design.buffer.cylinder_length**2 / 12)
    hinge = Revolute(S, B, first_point=(design.active.hinge_offset, 0.0), second_point=(half, 0.0))
    guide = Prismatic(B, P, second_point=probe.guided(0.0))
    return System(
        bodies=(
            Body(design.active.mass, design.active.inertia),
            cylinder,
            Body(probe.mass, probe.inertia) if probe.bending is None else FlexibleBody(probe.bending.modes),
            Body(design.passive.mass, design.passive.inertia),
        ),
        joints=(guide,) if design.hinge.play is not None else (hinge, guide),
        forces=(
            axial_element(design.buffer, probe),
            TorsionalSpringDamper(S, B, stiffness=design.buffer.k_T, damping=design.buffer.c_T),
        ),
        stabilisation=stabilisation,
    )


def axial_element(buffer: Buffer, probe: Masses) -> AxialSpringDamper:
    """The buffer's axial element: the paper's linear spring and damper, or a real buffer's (M23, M171 to M173)."""
    linear: dict[str, Any] = {
        "first": B,
        "second": P,
        "first_point": (-buffer.cylinder_length / 2, 0.0),
        "second_point": probe.guided(-probe.rear),
        "stiffness": 0.0 if buffer.k_A is None else buffer.k_A,
        "damping": 0.0 if buffer.c_A is None else buffer.c_A,
        "free_length": buffer.free_length,
        "guide": (1.0, 0.0),
        "published_damping": buffer.damping == "published",
    }
    if is_plain(buffer):
        return AxialSpringDamper(**linear)
    return BufferForce(
        **linear,
        spring_curve=None if buffer.spring_curve is None else buffer.spring_curve.cubic(),
        damper_curve=None if buffer.damper_curve is None else buffer.damper_curve.cubic(),
        preload=buffer.preload,
        preload_length=buffer.preload_length,
        quadratic=buffer.c_A2,
        rebound_factor=buffer.rebound_factor,
        friction=buffer.friction,
        friction_speed=buffer.friction_speed,
    )


def assemble_contact(design: Design) -> BallPair:
    """The tip against both flanks, in the axes of T (M30)."""
    angle, side = design.cone.half_angle, jnp.asarray(SIDE)
    flanks = Segment(
        start_x=-design.cone.offset,
        start_y=-side * design.cone.throat_radius,
        direction_x=-jnp.cos(angle),
        direction_y=-side * jnp.sin(angle),
        length=design.cone.length,
    )
    contact = design.contact
    numbers = {
        "stiffness": design.contact_stiffness,
        "restitution": contact.restitution,
        "linear_stiffness": contact.linear_stiffness,
        "damping": contact.damping,
        "exponent": contact.exponent,
        "ramp_depth": contact.ramp_depth,
    }
    return BallPair(
        radius=design.probe.tip_radius,
        shape=flanks,
        side=side,
        law=contact_law(contact.law, numbers),
        friction=RegularisedCoulomb(contact.friction, contact.slip_speed),
    )


def rebound_stop(design: Design) -> KelvinVoigt | None:
    """The law of the stop that holds the probe near its free length (M174); None without one."""
    stiffness = design.buffer.rebound_stiffness
    return None if stiffness is None else KelvinVoigt(stiffness, design.buffer.rebound_damping)


def end_stop(design: Design) -> KelvinVoigt | None:
    """The law of the buffer's end stop (M28), which acts while the stroke exceeds s_m; None without a stop."""
    stiffness = design.buffer.stop_stiffness
    return None if stiffness is None else KelvinVoigt(stiffness, design.buffer.stop_damping)


def start_motion(
    design: Design, scenario: Scenario, masses: Masses
) -> tuple[Float[Array, " coordinates"], Float[Array, " coordinates"]]:
    """Positions and velocities at t = 0 (M62, M63, M170).

    **Arguments:** ``design``; ``scenario``; ``masses``: of the probe. **Returns:** q [m, m, rad, …] and q̇, 12 entries
    each and one for each mode of a probe that bends.
    """
    local = _tip_at_start(design, scenario)
    turn_cos, turn_sin = jnp.cos(scenario.misalignment), jnp.sin(scenario.misalignment)
    tip = Vector(turn_cos * local.x - turn_sin * local.y, turn_sin * local.x + turn_cos * local.y)
    modes = 0 if masses.bending is None else masses.bending.modes.size
    passive = [0.0, 0.0, scenario.misalignment, *[0.0] * modes]
    passive_rate = [0.0, 0.0, scenario.passive_rate, *[0.0] * modes]
    if scenario.start == "free":
        placed, moving = _turned(design, scenario, masses, tip)
        return stacked([*placed, *passive]), stacked([*moving, *passive_rate])
    probe, cylinder, active = _behind(design, masses, tip.x)
    q = stacked([active, tip.y, 0.0, cylinder, tip.y, 0.0, probe, tip.y, 0.0, *passive])
    return q, stacked([scenario.approach_speed, 0.0, 0.0] * 3 + passive_rate)


def _tip_at_start(design: Design, scenario: Scenario) -> Vector:
    """The tip's centre at t = 0 in the axes of T: at the lower flank (M62), or anywhere before the mouth (M170)."""
    angle, cone, radius = design.cone.half_angle, design.cone, design.probe.tip_radius
    cos, sin = jnp.cos(angle), jnp.sin(angle)
    if scenario.start == "free":
        return Vector(-cone.offset - cone.length * cos - radius - scenario.standoff, scenario.offset)
    return Vector(
        -cone.offset - scenario.contact_distance * cos - radius * sin,
        -cone.throat_radius - scenario.contact_distance * sin + radius * cos,
    )


def _behind(design: Design, masses: Masses, tip: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Where the centres of mass of probe, cylinder and active vehicle are along their axis, the ``tip`` being there and
    the spring at its free length [m]."""
    probe = tip - masses.front
    cylinder = probe - masses.rear - design.buffer.free_length + design.buffer.cylinder_length / 2
    return probe, cylinder, cylinder + design.buffer.cylinder_length / 2 - design.active.hinge_offset


def _turned(design: Design, scenario: Scenario, masses: Masses, tip: Vector) -> tuple[list[Scalar], list[Scalar]]:
    """Positions and velocities of S, B and P at a free start: they lie along an axis through the tip and turn about the
    centre of mass of S as one body (M170)."""
    cos, sin = jnp.cos(scenario.active_angle), jnp.sin(scenario.active_angle)
    probe, cylinder, active = _behind(design, masses, 0.0)
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
