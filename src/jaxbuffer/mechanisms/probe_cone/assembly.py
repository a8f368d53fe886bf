"""The probe-cone mechanism assembled from bodies, joints, elements and a ball on flanks."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..._types import Scalar, stacked
from ...basis import AnyBasis
from ...contact import BallPair, Hole, KelvinVoigt, RegularisedCoulomb, Segment, contact_law, socket_stiffness
from ...contact.laws import DampedHertz
from ...elements import (
    AttitudeControl,
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
from ...multibody import AxialSpringDamper, ForceElement, TorsionalSpringDamper
from ...plane import PLANE
from ..assembled import Assembled
from .bending import Bending, modal_scales
from .bodies import TIP, B, Masses, P, S, T, assemble_system, probe_masses
from .buffer import ProbeBuffer
from .design import Design, DockingDesign, Meeting, Scenario
from .observables import NO_STOP, RECORDED, shown_of
from .start import start_motion
from .throat import Throat

LOWER, UPPER = 0, 1  # flanks
CONTACTS = ("lower", "upper")  # their names
# Energies, stored and lost, that every capture lists, whatever it has.
LISTED = (("kinetic", "spring", "contact", "stop"), ("stop_damper", "hinge_play", "bending"))
SIDE = np.array([1.0, -1.0])  # σ: +1 lower, -1 upper flank
UPPER_SIDE = -1.0
# With latches there are long implicit steps, and Newton's method does not know of Baumgarte's terms: with the full gain
# it fails at steps that accuracy would allow.
GAIN_WITH_LATCH = 0.5


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
    latched, bending = design.latch.has("stiffness"), probe.bending
    system = assemble_system(design, probe, GAIN_WITH_LATCH * stabilisation if latched else stabilisation)
    q, v = start_motion(design, scenario, probe)
    tip = tip_in_cone(design, scenario, probe, tip_on_flanks(design))
    # Positions are compared with the penetration of a typical impact, velocities with the approach speed.
    length = 1e-3
    bent, bending_rate = ([], []) if bending is None else modal_scales(bending, speed)
    return Assembled(
        system=system,
        q=q,
        v=v,
        elements=(tip, *elements_of(design, scenario, probe, tip)),
        rest_threshold=design.latch.quiet if latched else None,
        # Angles are compared at an arm of 0.1 m.
        size=(
            stacked([length, length, length / 0.1] * 4 + bent),
            stacked([speed, speed, speed / 0.1] * 4 + bending_rate),
        ),
        speed=speed,
        energy_size=0.5 * mass * speed**2,
        momentum_size=mass * speed,
        shown=shown_of(design, scenario),
        recorded=RECORDED if design.buffer.has("stop_stiffness") else (*RECORDED, NO_STOP),
        parts=Parts(design, scenario, probe),
        stored_in="spring",
        lost_in=None if bending is None else "bending",
        listed=LISTED,
        impulsive_reactions=bending is not None,
    )


def elements_of(design: Design, scenario: Scenario, probe: Masses, tip: BallContact) -> tuple[Element, ...]:
    """Return the elements of a design in a scenario, in the order in which its energies are listed."""
    torsional = TorsionalSpringDamper(S, B, stiffness=design.buffer.k_T, damping=design.buffer.c_T)
    planar: list[Element] = [Bending()] if design.probe.has("bending_stiffness") else []
    planar += [pin_in_bush(design)] if design.hinge.has("play") else []
    return shared_elements(design, scenario, probe, tip, torsional, planar)


def shared_elements(
    design: DockingDesign[Any],
    scenario: Meeting,
    probe: Masses,
    tip: BallContact,
    hinge: ForceElement,
    planar: Sequence[Element] = (),
    basis: AnyBasis = PLANE,
) -> tuple[Element, ...]:
    """Return the elements of a design in the plane or in space. ``hinge``: its springs; ``planar``: others of the
    plane alone."""
    buffer, latch, shock, control = design.buffer, design.latch, design.shock, design.control
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
    elements: list[Element] = [
        throat,
        Buffer(axial, buffer.longest_stroke),
        SpringDamper(hinge, lost_in="torsional_damper", name="hinge spring"),
    ]
    if buffer.has("stop_stiffness"):
        law = KelvinVoigt(buffer.stop_stiffness, buffer.stop_damping)
        if buffer.has("stop_thickness"):
            law = RubberBlock(law.linear_stiffness, law.damping, buffer.stop_thickness)
        elements.append(EndStop(axial, law, buffer.end))
    elements += planar
    if buffer.has("rebound_stiffness"):
        law = KelvinVoigt(buffer.rebound_stiffness, buffer.rebound_damping)
        elements.append(EndStop(axial, law, buffer.rebound_gap, rebound=True, watched=False, name="rebound"))
    if latch.has("stiffness"):
        elements.append(latches(design, probe, throat.plane))
    if scenario.has("thrust"):
        elements.append(Thrust(S, scenario.thrust, scenario.thrust_time))
    # A start in contact has no control that ends there.
    if control.has("stiffness") and not (control.until == "contact" and scenario.start == "contact"):
        latch_element = next((it for it in elements if isinstance(it, Latch)), None)
        until = {"contact": tip, "latch": latch_element, "end": None}[control.until]
        elements.append(AttitudeControl(S, control.stiffness, control.damping, control.limit, until, basis))
    if shock.frequencies:
        carriers = {"active": S, "passive": T}
        names = tuple(shock.frequencies)
        bodies = tuple(carriers[name.partition("_")[0]] for name in names)
        elements.append(Oscillators(bodies, tuple(shock.frequencies.values()), names, shock.damping))
    return tuple(elements)


def axial_force(buffer: ProbeBuffer, probe: Masses) -> AxialSpringDamper:
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


def tip_on_flanks(design: DockingDesign[Any], side: Array | float = SIDE) -> BallPair:
    """Return the tip against both flanks, or that of one ``side``, in the axes of T (M30)."""
    angle, side = design.cone.half_angle, jnp.asarray(side)
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


def tip_in_cone(
    design: DockingDesign[Any], scenario: Any, probe: Masses, pair: BallPair, names: tuple[str, ...] = CONTACTS
) -> BallContact:
    """Return the contact of the tip with both flanks, or with the cone (M29, M30)."""
    contact, smooth = design.contact, design.contact.memory == "smooth"
    return BallContact(
        P,
        T,
        pair,
        point=probe.tip_centre,
        names=names,
        spin_inertia=probe.tip_inertia if design.probe.free_tip else None,
        onset_length=contact.onset_length if smooth else None,
        fixed_foot=scenario.contact_distance if contact.arms == "published" else None,
        memory_time=contact.memory_time if smooth else None,
        first_contact=nothing_touches if scenario.start == "free" else tip_touches,
        name=TIP,
    )


def tip_touches(approach: Array, slowest: Scalar) -> tuple[Array, Array]:
    """Return which flanks the tip touches at t = 0 where it starts on the cone, and the contacts' memory [m/s]."""
    # The start lies on the lower flank alone (M64); a tip that moves off it does not touch it either.
    touching = jnp.where((jnp.arange(approach.size) == LOWER) & (approach > 0.0), 1.0, 0.0)
    # Damping is divided by the memory, which therefore has a least value (M36).
    return touching, jnp.maximum(approach, slowest)


def nothing_touches(approach: Array, slowest: Scalar) -> tuple[Array, Array]:
    """Return that no flank is touched at a free start, where the memory is at its floor (M170)."""
    return jnp.zeros(approach.size), jnp.full(approach.size, slowest)


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


def latches(design: DockingDesign[Any], probe: Masses, plane: Scalar) -> Latch:
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
