"""The probe-cone mechanism assembled from bodies, joints, elements and a ball on flanks.

Four bodies in the paper's order (M4): active vehicle S, cylinder B, probe P (with the tip on its end), passive vehicle
T.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._types import Scalar, stacked
from ...contact import BallPair, Hole, KelvinVoigt, RegularisedCoulomb, Segment, contact_law, socket_stiffness
from ...contact.laws import DampedHertz
from ...elements import (
    BallContact,
    Buffer,
    BufferForce,
    Element,
    EndStop,
    Latch,
    Oscillators,
    Pin,
    RubberBlock,
    SpringDamper,
    Thrust,
)
from ...elements.element import ROUNDED_LENGTH
from ...multibody import (
    AxialSpringDamper,
    Body,
    FlexibleBody,
    Kinematics,
    Point,
    Prismatic,
    Revolute,
    System,
    TorsionalSpringDamper,
)
from ...multibody.flexible import FlexibleBar, Marker
from ...plane import Vector
from ..assembled import Assembled, Shown
from ..layout import EvaluatedState
from ..system import slowest_touchdown
from .bending import Bending, bending_probe, modal_scales
from .buffer import Buffer as BufferPart
from .design import Design, Scenario
from .throat import Throat

S, B, P, T = range(4)  # bodies, in the order of the coordinates
LOWER, UPPER = 0, 1  # flanks
FLANKS = 2
CONTACTS = ("lower", "upper")  # their names
# Energies, stored and lost, that every capture lists, whatever it has.
LISTED = (("kinetic", "spring", "contact", "stop"), ("stop_damper", "hinge_play", "bending"))
SIDE = np.array([1.0, -1.0])  # σ: +1 lower, -1 upper flank
# With latches there are long implicit steps, and Newton's method does not know of Baumgarte's terms: with the full gain
# it fails at steps that accuracy would allow.
GAIN_WITH_LATCH = 0.5
ROUNDED_ACCELERATION = 1e-12  # m/s²: what rounding of positions of a metre makes of it by the constraints' correction


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
        """Return the tip's centre, on the probe."""
        return (self.front, 0.0) if self.bending is None else self.bending.end

    def guided(self, x: Scalar) -> Point:
        """Return a point of the probe's axis that does not bend, ``x`` [m] before its centre of mass."""
        return (x, 0.0) if self.bending is None else Marker.on_frame(x, 0.0, self.bending.modes.size)


def probe_masses(design: Design) -> Masses:
    """Return rod and tip as one body; a free tip's spin inertia is left out of it (M6)."""
    probe = design.probe
    mass = probe.rod_mass + probe.tip_mass
    shift = probe.tip_mass * (probe.length / 2) / mass
    rear, front = probe.length / 2 + shift, probe.length / 2 - shift
    tip = probe.tip_inertia
    inertia = probe.rod_mass * (probe.length**2 / 12 + shift**2) + probe.tip_mass * front**2
    return Masses(mass, inertia if probe.free_tip else inertia + tip, rear, front, tip, bending_probe(probe))


class Parts(NamedTuple):
    """What a mechanism was assembled from: ``design``, ``scenario``, and the ``probe`` with its tip."""

    design: Design
    scenario: Scenario
    probe: Masses


def assemble(design: Design, scenario: Scenario, stabilisation: Scalar = 20.0) -> Assembled:
    """Return a design in a scenario as a mechanism that is ready to be stepped through time.

    This is the one place that asks which parts a design has.

    **Arguments:** ``design``; ``scenario``; ``stabilisation``: Baumgarte's gain [1/s].
    """
    probe, speed, mass = probe_masses(design), scenario.approach_speed, design.active.mass
    latched, smooth, bending = design.latch.has("stiffness"), design.contact.memory == "smooth", probe.bending
    system = assemble_system(design, probe, GAIN_WITH_LATCH * stabilisation if latched else stabilisation)
    q, v = start_motion(design, scenario, probe)
    tip = tip_in_cone(design, scenario, probe)
    touching, memory = first_contact(tip, scenario, system.kinematics(q, v))
    # Positions are compared with the penetration of a typical impact, velocities with the approach speed.
    length = 1e-3
    bent, bending_rate = ([], []) if bending is None else modal_scales(bending, speed)
    return Assembled(
        system=system,
        q=q,
        v=v,
        contacts=(tip,),
        elements=elements_of(design, scenario, probe),
        closed=touching,
        first_memory=memory,
        quiet=design.latch.quiet if latched else None,
        # Angles are compared at an arm of 0.1 m.
        size=(
            stacked([length, length, length / 0.1] * 4 + bent),
            stacked([speed, speed, speed / 0.1] * 4 + bending_rate),
        ),
        speed=speed,
        energy_size=0.5 * mass * speed**2,
        momentum_size=mass * speed,
        memory_time=design.contact.memory_time if smooth else None,
        shown=shown_of(design, scenario),
        recorded=RECORDED if design.buffer.has("stop_stiffness") else (*RECORDED, NO_STOP),
        parts=Parts(design, scenario, probe),
        stored_in="spring",
        lost_in=None if bending is None else "bending",
        listed=LISTED,
        rings=bending is not None,
    )


def elements_of(design: Design, scenario: Scenario, probe: Masses) -> tuple[Element, ...]:
    """Return the elements of a design in a scenario, in the order in which its energies are listed."""
    buffer, latch, hinge, shock = design.buffer, design.latch, design.hinge, design.shock
    # Both stops measure their stroke by the buffer's own spring, so that all three agree on it.
    axial = axial_force(buffer, probe)
    throat = Throat(
        design=design,
        scenario=scenario,
        tip_point=probe.tip_centre,
        tip_body=P,
        cone_body=T,
        captures=not latch.has("stiffness"),
    )
    torsional = TorsionalSpringDamper(S, B, stiffness=buffer.k_T, damping=buffer.c_T)
    elements: list[Element] = [
        throat,
        Buffer(axial, buffer.longest_stroke),
        SpringDamper(torsional, lost_in="torsional_damper", name="hinge spring"),
    ]
    if buffer.has("stop_stiffness"):
        law = KelvinVoigt(buffer.stop_stiffness, buffer.stop_damping)
        if buffer.has("stop_thickness"):
            law = RubberBlock(law.linear_stiffness, law.damping, buffer.stop_thickness)
        elements.append(EndStop(axial, law, buffer.end))
    if design.probe.has("bending_stiffness"):
        elements.append(Bending())
    if hinge.has("play"):
        elements.append(pin_in_bush(design))
    if buffer.has("rebound_stiffness"):
        law = KelvinVoigt(buffer.rebound_stiffness, buffer.rebound_damping)
        elements.append(EndStop(axial, law, buffer.rebound_gap, rebound=True, watched=False, name="rebound"))
    if latch.has("stiffness"):
        elements.append(latches(design, probe, throat.plane))
    if scenario.has("thrust"):
        elements.append(Thrust(S, scenario.thrust, scenario.thrust_time))
    if shock.frequencies:
        carriers = {"active": S, "passive": T}
        names = tuple(shock.frequencies)
        bodies = tuple(carriers[name.partition("_")[0]] for name in names)
        elements.append(Oscillators(bodies, tuple(shock.frequencies.values()), names, shock.damping))
    return tuple(elements)


def assemble_system(design: Design, probe: Masses, stabilisation: Scalar) -> System:
    """Return bodies and joints of the mechanism (M15).

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
        # With play the contact of the pin holds the hinge, in place of the joint (M109).
        joints=(guide,) if design.hinge.has("play") else (hinge, guide),
        stabilisation=stabilisation,
    )


def axial_force(buffer: BufferPart, probe: Masses) -> AxialSpringDamper:
    """Return the buffer's axial force: the paper's linear spring and damper, or a real buffer's (M23, M171 to M173)."""
    linear: dict[str, Any] = {
        "first": B,
        "second": P,
        "first_point": (-buffer.cylinder_length / 2, 0.0),
        "second_point": probe.guided(-probe.rear),
        # They are None where a measured curve stands for them.
        "stiffness": 0.0 if buffer.k_A is None else buffer.k_A,
        "damping": 0.0 if buffer.c_A is None else buffer.c_A,
        "free_length": buffer.free_length,
        "guide": (1.0, 0.0),
        "published_damping": buffer.damping == "published",
    }
    more = (buffer.spring_curve, buffer.damper_curve, buffer.preload, buffer.c_A2, buffer.rebound_factor)
    if all(part is None for part in (*more, buffer.friction)):
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


def tip_on_flanks(design: Design) -> BallPair:
    """Return the tip against both flanks, in the axes of T (M30)."""
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


def tip_in_cone(design: Design, scenario: Scenario, probe: Masses) -> BallContact:
    """Return the contact of the tip with both flanks (M29, M30)."""
    contact = design.contact
    return BallContact(
        P,
        T,
        tip_on_flanks(design),
        point=probe.tip_centre,
        names=CONTACTS,
        spin_inertia=probe.tip_inertia if design.probe.free_tip else None,
        onset_length=contact.onset_length if contact.memory == "smooth" else None,
        fixed_foot=scenario.contact_distance if contact.arms == "published" else None,
    )


def first_contact(tip: BallContact, scenario: Scenario, kin: Kinematics) -> tuple[Array, Array]:
    """Return which flanks are touched at t = 0, and the contacts' memory there [m/s]."""
    slowest = slowest_touchdown(scenario.approach_speed)
    if scenario.start == "free":  # nothing touches, and the memory is at its floor (M170)
        return jnp.zeros(FLANKS), jnp.full(FLANKS, slowest)
    approach = tip.evaluate(kin).approach.approach_speed
    touching = jnp.where((jnp.arange(FLANKS) == LOWER) & (approach > 0.0), 1.0, 0.0)
    return touching, jnp.maximum(approach, slowest)


def pin_in_bush(design: Design) -> Pin:
    """Return the hinge's pin, on the active vehicle, in a bush with play on the cylinder (M109)."""
    hinge = design.hinge
    # Pin and bush have no friction (M109): the slip speed means nothing.
    pair = BallPair(
        hinge.pin_radius, Hole(0.0, 0.0, hinge.bush_radius), jnp.ones(1), pin_law(design), RegularisedCoulomb(0.0, 1.0)
    )
    pin, bush = (design.active.hinge_offset, 0.0), (design.buffer.cylinder_length / 2, 0.0)
    return Pin(BallContact(S, B, pair, pin, bush))


def pin_law(design: Design) -> DampedHertz:
    """Return the law of the pin's contact: a ball in a socket."""
    hinge = design.hinge
    modulus, ratio = hinge.young_modulus, hinge.poisson_ratio
    stiffness = socket_stiffness(hinge.pin_radius, hinge.bush_radius, modulus, ratio, modulus, ratio)
    return DampedHertz(stiffness, hinge.damping)


def latches(design: Design, probe: Masses, plane: Scalar) -> Latch:
    """Return the latches of the cone, which hold the tip's centre. ``plane``: where it is captured, along the axis of T
    [m]."""
    latch = design.latch
    return Latch(
        first=P,
        second=T,
        point=probe.tip_centre,
        plane=plane,
        seat=(plane + latch.depth, 0.0),
        stiffness=latch.stiffness,
        damping=latch.damping,
        turn_stiffness=latch.turn_stiffness,
        turn_damping=latch.turn_damping,
        preload=latch.preload,
        preload_length=latch.preload_length,
        closing_time=latch.closing_time,
        strength=latch.strength,
    )


# --- what is watched --------------------------------------------------------------------------------------------------


def hinge_force(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return the size of the force that accelerates the active vehicle [N] (M68)."""
    # The vehicle's acceleration tells the force also where the hinge has play, and so no multipliers (M68).
    return _size_of(rate[mechanism.coordinates : mechanism.coordinates + 2] * mechanism.parts.design.active.mass)


def passive_force(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return the size of the force on the passive vehicle [N]."""
    first = mechanism.coordinates + 3 * T
    return _size_of(rate[first : first + 2] * mechanism.parts.design.passive.mass)


def _size_of(force: Float[Array, " 2"]) -> Scalar:
    """Return a force's size, with a derivative also where it is zero."""
    return jnp.sqrt(force[0] ** 2 + force[1] ** 2 + 1e-24)


def hinge_angle(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return the cylinder's angle against the active vehicle [rad]."""
    return at.kin.frame(B).angle - at.kin.frame(S).angle


def bending_of_tip(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return how far the tip is bent off the probe's axis [m], 0 if it does not bend."""
    bending = mechanism.parts.probe.bending
    return jnp.zeros(()) if bending is None else bending.end.displacement(at.kin.modal(P)[0]).y


def _rounded_force(vehicle: str) -> Callable[[Assembled], Scalar]:
    """Return what of the force on a vehicle is rounding, in the spring's force and by the constraints' correction."""

    def of(mechanism: Assembled) -> Scalar:
        mass = getattr(mechanism.parts.design, vehicle).mass
        return ROUNDED_LENGTH * mechanism.element("buffer").stiffness_at_rest + ROUNDED_ACCELERATION * mass

    return of


def _rounded_length(mechanism: Assembled) -> Scalar:
    return ROUNDED_LENGTH


HINGE_FORCE = Shown("hinge_force", hinge_force, of_rate=True, negligible=_rounded_force("active"))
PASSIVE_FORCE = Shown("passive_force", passive_force, of_rate=True, negligible=_rounded_force("passive"))
HINGE_ANGLE = Shown("hinge_angle", lambda *at: jnp.abs(hinge_angle(*at)), negligible=_rounded_length)
BENDING = Shown("bending", lambda *at: jnp.abs(bending_of_tip(*at)), negligible=_rounded_length)
# Of a history; those of which the largest size is watched have their sign there.
RECORDED = (
    Shown("tip_spin", lambda mechanism, at, rate: at.contacts[0].spin),
    Shown("hinge_angle", hinge_angle),
    Shown("bending", bending_of_tip),
)
NO_STOP = Shown("stop_force", lambda mechanism, at, rate: jnp.zeros(()))  # a history has that force in any case


def shown_of(design: Design, scenario: Scenario) -> tuple[Shown, ...]:
    """Return what is watched beside the elements' own observables."""
    bending = (BENDING,) if design.probe.has("bending_stiffness") else ()
    # Without a latch, and from the touch, nothing but the tip acts on the passive vehicle.
    acted_on = design.latch.has("stiffness") or scenario.start == "free"
    return (HINGE_FORCE, HINGE_ANGLE, *bending, *((PASSIVE_FORCE,) if acted_on else ()))


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
    probe, cylinder, active = _behind(design, masses, tip.x)
    q = stacked([active, tip.y, 0.0, cylinder, tip.y, 0.0, probe, tip.y, 0.0, *passive])
    return q, stacked([scenario.approach_speed, 0.0, 0.0] * 3 + passive_rate)


def _tip_at_start(design: Design, scenario: Scenario) -> Vector:
    """Return the tip's centre at t = 0 in the axes of T: at the lower flank (M62), or anywhere before the mouth
    (M170)."""
    angle, cone, radius = design.cone.half_angle, design.cone, design.probe.tip_radius
    cos, sin = jnp.cos(angle), jnp.sin(angle)
    if scenario.start == "free":
        return Vector(-cone.offset - cone.length * cos - radius - scenario.standoff, scenario.offset)
    return Vector(
        -cone.offset - scenario.contact_distance * cos - radius * sin,
        -cone.throat_radius - scenario.contact_distance * sin + radius * cos,
    )


def _behind(design: Design, masses: Masses, tip: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Return where the centres of mass of probe, cylinder and active vehicle are along their axis [m], the ``tip``
    being there and the spring at its free length."""
    probe = tip - masses.front
    cylinder = probe - masses.rear - design.buffer.free_length + design.buffer.cylinder_length / 2
    return probe, cylinder, cylinder + design.buffer.cylinder_length / 2 - design.active.hinge_offset


def _turned(design: Design, scenario: Scenario, masses: Masses, tip: Vector) -> tuple[list[Scalar], list[Scalar]]:
    """Return positions and velocities of S, B and P at a free start: they lie along an axis through the tip and turn
    about the centre of mass of S as one body (M170)."""
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
