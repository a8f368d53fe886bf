"""The probe-cone mechanism assembled from bodies, joints, elements and a ball on flanks."""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..._types import Scalar, stacked
from ...contact import BallPair, RegularisedCoulomb, Segment, Shape, contact_law
from ...elements import BallContact, Buffer, BufferForce, Element, SpringDamper
from ...multibody import AxialSpringDamper, ForceElement, TorsionalSpringDamper
from ..assembled import Assembled
from .bodies import TIP, B, Masses, P, S, T, assemble_system, probe_masses
from .design import Design, DockingDesign, Scenario
from .observables import observables_of, recorded_of
from .parts import ProbeBuffer, holder_of, parts_of
from .parts.bending import modal_scales
from .parts.part import Joined
from .start import start_motion
from .throat import Throat

LOWER, UPPER = 0, 1  # flanks
CONTACTS = ("lower", "upper")  # their names
# Energies, stored and lost, that every capture lists, whatever it has.
LISTED = (("kinetic", "spring", "contact", "stop"), ("stop_damper", "hinge_play", "bending"))
SIDE = np.array([1.0, -1.0])  # σ: +1 lower, -1 upper flank
UPPER_SIDE = -1.0
# Where the tip is held there are long implicit steps, and Newton's method does not know of Baumgarte's terms: with the
# full gain it fails at steps that accuracy would allow.
GAIN_WHERE_HELD = 0.5


class Parts(NamedTuple):
    """What a mechanism was assembled from: ``design``, ``scenario``, and the ``probe`` with its tip."""

    design: DockingDesign[Any]
    scenario: Any
    probe: Masses


def assemble(design: Design, scenario: Scenario, stabilisation: Scalar = 20.0) -> Assembled:
    """Return a design in a scenario as a mechanism that is ready to be stepped through time.

    **Arguments:** ``design``; ``scenario``; ``stabilisation``: Baumgarte's gain [1/s].
    """
    probe, speed, mass = probe_masses(design), scenario.approach_speed, design.active.mass
    holder, bending = holder_of(design), probe.bending
    system = assemble_system(design, probe, stabilisation if holder is None else GAIN_WHERE_HELD * stabilisation)
    q, v = start_motion(design, scenario, probe)
    tip = tip_in_cone(design, scenario, probe, tip_on_flanks(design))
    hinge = TorsionalSpringDamper(S, B, stiffness=design.buffer.k_T, damping=design.buffer.c_T)
    # Positions are compared with the penetration of a typical impact, velocities with the approach speed.
    length = 1e-3
    bent, bending_rate = ([], []) if bending is None else modal_scales(bending, speed)
    return Assembled(
        system=system,
        q=q,
        v=v,
        elements=(tip, *elements_of(design, scenario, probe, tip, hinge)),
        rest_threshold=None if holder is None else holder.rest_threshold(design),
        # Angles are compared at an arm of 0.1 m.
        size=(
            stacked([length, length, length / 0.1] * 4 + bent),
            stacked([speed, speed, speed / 0.1] * 4 + bending_rate),
        ),
        speed=speed,
        energy_size=0.5 * mass * speed**2,
        momentum_size=mass * speed,
        shown=observables_of(design, scenario),
        recorded=recorded_of(design),
        parts=Parts(design, scenario, probe),
        stored_in="spring",
        lost_in=None if bending is None else "bending",
        listed=LISTED,
        impulsive_reactions=bending is not None,
    )


def elements_of(
    design: DockingDesign[Any], scenario: Any, probe: Masses, tip: BallContact, hinge: ForceElement
) -> tuple[Element, ...]:
    """Return the elements of a design in a scenario, of the plane or of space, in the order in which its energies are
    listed. ``tip``: its contact with the cone; ``hinge``: the springs of the hinge."""
    buffer, holder = design.buffer, holder_of(design)
    throat = Throat(
        design=design,
        scenario=scenario,
        tip_point=probe.tip_centre,
        tip_body=P,
        cone_body=T,
        holder=None if holder is None else holder.name,
    )
    joined = Joined(design, scenario, probe.tip_centre, axial_force(buffer, probe), throat, tip)
    return (
        throat,
        Buffer(joined.axial, buffer.longest_stroke),
        SpringDamper(hinge, lost_in="torsional_damper", name="hinge spring"),
        *(element for part in parts_of(design, scenario) for element in part.elements(joined)),
    )


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


def tip_on_flanks(design: DockingDesign[Any]) -> BallPair:
    """Return the tip against both flanks, in the axes of T (M30)."""
    return tip_against(design, flank(design, jnp.asarray(SIDE)), jnp.asarray(SIDE))


def flank(design: DockingDesign[Any], side: Any) -> Segment:
    """Return both flanks, or that of one ``side``, in the axes of T (M30)."""
    angle = design.cone.half_angle
    return Segment(
        start_x=-design.cone.offset,
        start_y=-side * design.cone.throat_radius,
        direction_x=-jnp.cos(angle),
        direction_y=-side * jnp.sin(angle),
        length=design.cone.length,
    )


def tip_against(design: DockingDesign[Any], shape: Shape, side: Any) -> BallPair:
    """Return the tip against a shape, with the design's law and friction."""
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
        shape=shape,
        side=side,
        law=contact_law(contact.law, numbers),
        friction=RegularisedCoulomb(contact.friction, contact.slip_speed),
    )


def tip_in_cone(
    design: DockingDesign[Any], scenario: Any, probe: Masses, pair: BallPair, names: tuple[str, ...] = CONTACTS
) -> BallContact:
    """Return the contact of the tip with both flanks, or with the cone in space (M29, M30)."""
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
