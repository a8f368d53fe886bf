"""The slider-crank, assembled: crank, rod and slider, their joints, and a contact for each pin with play."""

from collections.abc import Callable

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar, stacked
from ...contact import BallPair, Hole, RegularisedCoulomb, Segment, Shape
from ...multibody import (
    GROUND,
    AppliedForce,
    AppliedTorque,
    Body,
    ConstantSpeed,
    DrivenAngle,
    FlexibleBody,
    ForceElement,
    Joint,
    Point,
    Prismatic,
    Revolute,
    System,
    TorsionalSpringDamper,
)
from ...multibody.flexible import FlexibleBar, deflection, free_bar, stress
from ..assembled import Assembled, BallContact, Posture, Shown
from .design import SliderCrank, SliderCrankScenario
from .pins import Pin

CRANK, ROD, SLIDER = range(3)
SQUARE = 4  # sides of a bush by components


def slider_crank(design: SliderCrank, scenario: SliderCrankScenario, stabilisation: Scalar = 20.0) -> Assembled:
    """The mechanism at its start (docs/slider_crank.md). The shaft is the origin, the slider's line the x-axis."""
    crank, rod, slider = design.crank, design.rod, design.slider
    off = crank.unbalance / crank.mass
    bent = bending_rod(design) if rod.modes else None
    bodies = (
        Body(crank.mass, crank.inertia - crank.unbalance * off),
        rod.body if bent is None else FlexibleBody(bent.modes),
        Body(slider.mass, 1.0),
    )
    front: Point = ((1.0 - rod.centre) * rod.length, 0.0)
    rear: Point = (-rod.centre * rod.length, 0.0)
    if bent is not None:
        front, rear = bent.end, bent.start
    joints: list[Joint] = [Revolute(GROUND, CRANK, second_point=(-off, 0.0)), Prismatic(GROUND, SLIDER)]
    contacts: list[BallContact] = []
    for pin, body, point, end in (
        (design.piston_pin, SLIDER, (0.0, 0.0), front),
        (design.crank_pin, CRANK, (crank.length - off, 0.0), rear),
    ):
        if pin.joint == "pinned":
            joints.append(Revolute(body, ROD, first_point=point, second_point=end))
        elif pin.by_components:
            contacts += [BallContact(ROD, body, in_contact(pin, flank, -1.0), end) for flank in flanks(pin.bush_radius)]
        else:
            hole = Hole(0.0, 0.0, pin.bush_radius)
            contacts.append(BallContact(body, ROD, in_contact(pin, hole, 1.0), point, end))
    weights = [
        AppliedForce(k, (0.0, -body.mass * scenario.gravity), body.centre_of_mass) for k, body in enumerate(bodies)
    ]
    drives, motors, torques = driven(design, scenario)
    q, v = ideal_motion(design, scenario)
    turning = design.drive.kind == "torque"
    fastest = jnp.maximum(jnp.abs(scenario.crank_speed), design.drive.no_load_speed if turning else 0.0)
    speed = crank.length * fastest
    return Assembled(
        System(bodies, (*joints, *drives), (*weights, *motors), stabilisation),
        q=q,
        v=v,
        contacts=tuple(contacts),
        size=(1e-4, speed),
        shown=(*torques, Shown("slider_acceleration", slider_acceleration, of_rate=True), *seen(design)),
        recorded=eccentricities(design),
        parts=bent,
        energy_size=0.5 * slider.mass * speed**2 + (0.5 * crank.inertia * fastest**2 if turning else 0.0),
    )


def bending_rod(design: SliderCrank) -> FlexibleBar:
    """The rod in modes of a free bar, whose axes keep its centre of mass and angular momentum."""
    rod = design.rod
    return free_bar(rod.bar, rod.modes - 2, damping_ratio=rod.damping_ratio)


def driven(
    design: SliderCrank, scenario: SliderCrankScenario
) -> tuple[tuple[Joint, ...], tuple[ForceElement, ...], tuple[Shown, Shown]]:
    """What turns the crank: a joint that keeps its speed, or a motor's torque; and its torque as observables."""
    drive = design.drive
    if drive.kind == "speed":
        joint = DrivenAngle(GROUND, CRANK, ConstantSpeed(scenario.crank_angle, scenario.crank_speed))
        return (joint,), (), torques(driven_torque, of_rate=True)
    damping = drive.torque / drive.no_load_speed
    motor = (AppliedTorque(CRANK, drive.torque), TorsionalSpringDamper(GROUND, CRANK, 0.0, damping))
    return (), motor, torques(motor_torque, of_rate=False)


def torques(of: Callable[[Assembled, Posture, Array], Scalar], of_rate: bool) -> tuple[Shown, Shown]:
    """The drive's torque, and its negative, whose largest value is the least torque's."""
    return Shown("drive_torque", of, of_rate), Shown("braking_torque", lambda *at: -of(*at), of_rate)


def in_contact(pin: Pin, shape: Shape, side: float) -> BallPair:
    """A pin against its bush; ``side``: see `BallPair`."""
    return BallPair(
        radius=pin.radius,
        shape=shape,
        side=side * jnp.ones(()),
        law=pin.contact_law,
        friction=RegularisedCoulomb(pin.friction, pin.slip_speed),
    )


def flanks(half: Scalar) -> tuple[Segment, ...]:
    """A square hole about its body's origin, ``half`` [m] its half-width, seen from inside: right, left, above, below.

    Each is long enough for a pin that is deep in its neighbours.
    """
    far, long = 2.0 * half, 4.0 * half
    return (
        Segment(half, -far, 0.0, 1.0, long),
        Segment(-half, far, 0.0, -1.0, long),
        Segment(far, half, -1.0, 0.0, long),
        Segment(-far, -half, 1.0, 0.0, long),
    )


def ideal_motion(
    design: SliderCrank, scenario: SliderCrankScenario
) -> tuple[Float[Array, " coordinates"], Float[Array, " coordinates"]]:
    """Positions and velocities of the mechanism without play, in closed form."""
    crank, rod = design.crank, design.rod
    off = crank.unbalance / crank.mass
    theta, omega = jnp.asarray(scenario.crank_angle), scenario.crank_speed
    cos, sin = jnp.cos(theta), jnp.sin(theta)
    sine = -crank.length * sin / rod.length
    cosine = jnp.sqrt(1.0 - sine * sine)
    angle, spin = jnp.arcsin(sine), -crank.length * omega * cos / (rod.length * cosine)
    along = rod.centre * rod.length
    pin_x, pin_y = crank.length * cos, crank.length * sin
    slider_speed = -pin_y * omega - rod.length * sine * spin
    q = [off * cos, off * sin, theta, pin_x + along * cosine, pin_y + along * sine, angle]
    v = [-off * sin * omega, off * cos * omega, omega]
    v += [-pin_y * omega - along * sine * spin, pin_x * omega + along * cosine * spin, spin]
    straight = [0.0] * rod.modes
    return (
        stacked([*q, pin_x + rod.length * cosine, 0.0, 0.0, *straight]),
        stacked([*v, slider_speed, 0.0, 0.0, *straight]),
    )


def driven_torque(mechanism: Assembled, at: Posture, rate: Array) -> Scalar:
    """What keeps the crank's speed steady [N m]: the drive's power over the speed."""
    return rate[mechanism.drive_work] / at.kin.v[3 * CRANK + 2]


def motor_torque(mechanism: Assembled, at: Posture, rate: Array) -> Scalar:
    """Of a motor whose torque falls with its speed [N m]."""
    constant, damper = mechanism.system.forces[-2:]
    assert isinstance(constant, AppliedTorque) and isinstance(damper, TorsionalSpringDamper)
    return constant.torque + damper.torque(at.kin)


def seen(design: SliderCrank) -> tuple[Shown, ...]:
    """The contacts' depth, where their damper makes the peak force, which then says little of how deep they went;
    deflection and stress of a rod that bends."""
    depths = (Shown("penetration", depth),) if design.piston_pin.by_components else ()
    bending = (Shown("rod_deflection", rod_deflection), Shown("rod_stress", rod_stress)) if design.rod.modes else ()
    return (*depths, *bending)


def depth(mechanism: Assembled, at: Posture, rate: Array) -> Scalar:
    """Of the contact that is deepest [m], negative where none touches."""
    return -jnp.min(mechanism.gaps_at(at)[0])


def slider_acceleration(mechanism: Assembled, at: Posture, rate: Array) -> Scalar:
    """Its size [m/s²]."""
    return jnp.abs(rate[mechanism.coordinates + 3 * SLIDER])


def eccentricities(design: SliderCrank) -> tuple[Shown, ...]:
    """Of each pin with play the centre relative to the bush's, along the slider's line and across it [m]."""
    found, contact = [], 0
    for pin in (design.piston_pin, design.crank_pin):
        if pin.joint == "clearance":
            # by components, the rod's end is the ball and the pin's body carries the shape
            sign = -1.0 if pin.by_components else 1.0
            found += [Shown(f"{pin.section}_{axis}", eccentricity(contact, sign, axis)) for axis in ("x", "y")]
            contact += SQUARE if pin.by_components else 1
    return tuple(found)


def eccentricity(contact: int, sign: float, axis: str) -> Callable[[Assembled, Posture, Array], Scalar]:
    """One component of it, from a contact of the pin's; ``sign``: -1 where the ball stands for the bush."""

    def of(mechanism: Assembled, at: Posture, rate: Array) -> Scalar:
        return sign * getattr(at.centre[contact].place - at.origin[contact].place, axis)

    return of


def rod_deflection(mechanism: Assembled, at: Posture, rate: Array) -> Scalar:
    """How far the rod's middle is off the line through its ends [m]."""
    ends_and_middle = deflection(mechanism.parts, at.kin.modal(ROD)[0], (0.0, 0.5, 1.0))[:, 1]
    return jnp.abs(ends_and_middle[1] - 0.5 * (ends_and_middle[0] + ends_and_middle[2]))


def rod_stress(mechanism: Assembled, at: Posture, rate: Array) -> Scalar:
    """Bending stress on the surface of the rod's middle [Pa], its size."""
    bar = mechanism.parts.bar
    edge = jnp.sqrt(3.0 * bar.second_moment / bar.area)  # half the depth of a rectangle
    return jnp.abs(stress(mechanism.parts, at.kin.modal(ROD)[0], (0.5,), edge)[0])
