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
from ..assembled import Assembled, BallContact, Shown
from ..layout import EvaluatedState
from .design import Rod, Slider, SliderCrank, SliderCrankScenario
from .pins import Pin
from .shapes import PlanarBody

CRANK, ROD, SLIDER = range(3)
SQUARE = 4  # sides of a bush by components


def slider_crank(design: SliderCrank, scenario: SliderCrankScenario, stabilisation: Scalar = 20.0) -> Assembled:
    """Return the mechanism at its start (docs/slider_crank.md). The shaft is the origin, the slider's line the
    x-axis."""
    crank, rod, slider = design.crank, design.rod, design.slider
    off = crank.unbalance / crank.mass
    link, rear, front = rod_body(rod)
    block, guide, seat = slider_body(slider)
    # A body's inertia is about its centre of mass: from that about the shaft Steiner's share is taken off.
    bodies = (Body(crank.mass, crank.inertia - crank.unbalance * off), link, block)
    joints: list[Joint] = [Revolute(GROUND, CRANK, second_point=(-off, 0.0)), guide]
    contacts: list[BallContact] = []
    for pin, body, point, end in (
        (design.piston_pin, SLIDER, seat, front),
        (design.crank_pin, CRANK, (crank.length - off, 0.0), rear),
    ):
        if pin.joint == "pinned":
            joints.append(Revolute(body, ROD, first_point=point, second_point=end))
        elif pin.by_components:
            sides = (in_contact(pin, flank, -1.0) for flank in flanks(pin.bush_radius))
            contacts += [BallContact(ROD, body, side, end, point) for side in sides]
        else:
            hole = Hole(0.0, 0.0, pin.bush_radius)
            contacts.append(BallContact(body, ROD, in_contact(pin, hole, 1.0), point, end))
    weights = [
        AppliedForce(k, (0.0, -body.mass * scenario.gravity), body.centre_of_mass) for k, body in enumerate(bodies)
    ]
    drives, motors, torques = driven(design, scenario)
    q, v = ideal_motion(design, scenario)
    turning = design.drive.kind == "torque"
    # A motor may bring the crank from rest to its no-load speed.
    fastest = jnp.maximum(jnp.abs(scenario.crank_speed), design.drive.no_load_speed if turning else 0.0)
    speed = crank.length * fastest
    return Assembled(
        System(bodies, (*joints, *drives), (*weights, *motors), stabilisation),
        q=q,
        v=v,
        contacts=tuple(contacts),
        size=(1e-4, speed),
        shown=(*torques, Shown("slider_acceleration", slider_acceleration, of_rate=True), *deformations(design)),
        recorded=eccentricities(design),
        memory_time=design.piston_pin.memory_time,
        parts=bending_rod(rod) if rod.modes else None,
        energy_size=0.5 * block.mass * speed**2 + (0.5 * crank.inertia * fastest**2 if turning else 0.0),
    )


def rod_body(rod: Rod) -> tuple[Body, Point, Point]:
    """Return the rod, and where its pins are: the crank's and the piston's."""
    if not rod.modes:
        return rod.body, *rod.ends
    bent = bending_rod(rod)
    first, second = (bent.first, bent.second) if isinstance(bent, PlanarBody) else (bent.start, bent.end)
    return FlexibleBody(bent.modes), first, second


def bending_rod(rod: Rod) -> FlexibleBar | PlanarBody:
    """Return the rod in modes of a free bar or shape, whose axes keep its centre of mass and angular momentum."""
    if rod.shape is not None:
        return rod.form
    return free_bar(rod.bar, rod.modes - 2, damping_ratio=rod.damping_ratio)


def slider_body(slider: Slider) -> tuple[Body, Prismatic, Point]:
    """Return the slider, the guide that keeps its pin on the x-axis, and where the pin is."""
    if slider.shape is None:
        return slider.body, Prismatic(GROUND, SLIDER), (0.0, 0.0)
    guide, seat = slider.places
    # The guide's line is moved by as much as the pin lies beside the guide, so that the pin is on the x-axis.
    line = (0.0, guide[1] - seat[1])
    if not slider.modes:
        return slider.body, Prismatic(GROUND, SLIDER, line, guide), seat
    form = slider.form
    return FlexibleBody(form.modes), Prismatic(GROUND, SLIDER, line, form.first), form.second


def driven(
    design: SliderCrank, scenario: SliderCrankScenario
) -> tuple[tuple[Joint, ...], tuple[ForceElement, ...], tuple[Shown, Shown]]:
    """Return what turns the crank: a joint that keeps its speed, or a motor's torque; and its torque as observables."""
    drive = design.drive
    if drive.kind == "speed":
        joint = DrivenAngle(GROUND, CRANK, ConstantSpeed(scenario.crank_angle, scenario.crank_speed))
        return (joint,), (), torques(driven_torque, of_rate=True)
    # M_0 (1 - ω/ω_0) is a constant torque and a damper of M_0/ω_0.
    damping = drive.torque / drive.no_load_speed
    motor = (AppliedTorque(CRANK, drive.torque), TorsionalSpringDamper(GROUND, CRANK, 0.0, damping))
    return (), motor, torques(motor_torque, of_rate=False)


def torques(of: Callable[[Assembled, EvaluatedState, Array], Scalar], of_rate: bool) -> tuple[Shown, Shown]:
    """Return the drive's torque, and its negative, whose largest value is the least torque's."""
    return Shown("drive_torque", of, of_rate), Shown("braking_torque", lambda *at: -of(*at), of_rate)


def in_contact(pin: Pin, shape: Shape, side: float) -> BallPair:
    """Return a pin against its bush; ``side``: see `BallPair`."""
    return BallPair(
        radius=pin.radius,
        shape=shape,
        side=side * jnp.ones(()),
        law=pin.contact_law,
        friction=RegularisedCoulomb(pin.friction, pin.slip_speed),
    )


def flanks(half: Scalar) -> tuple[Segment, ...]:
    """Return a square hole about its body's origin, ``half`` [m] its half-width, seen from inside: right, left, above,
    below.

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
    """Return positions and velocities of the mechanism without play, in closed form."""
    crank, rod = design.crank, design.rod
    off = crank.unbalance / crank.mass
    theta, omega = jnp.asarray(scenario.crank_angle), scenario.crank_speed
    cos, sin = jnp.cos(theta), jnp.sin(theta)
    # The rod leans so that the piston pin is on the x-axis.
    sine = -crank.length * sin / rod.length
    cosine = jnp.sqrt(1.0 - sine * sine)
    angle, spin = jnp.arcsin(sine), -crank.length * omega * cos / (rod.length * cosine)
    (rear, below), _ = rod.ends
    along = -rear
    pin_x, pin_y = crank.length * cos, crank.length * sin
    slider_speed = -pin_y * omega - rod.length * sine * spin
    q = [off * cos, off * sin, theta, pin_x + along * cosine, pin_y + along * sine, angle]
    v = [-off * sin * omega, off * cos * omega, omega]
    v += [-pin_y * omega - along * sine * spin, pin_x * omega + along * cosine * spin, spin]
    straight = [0.0] * (rod.modes + design.slider.modes)
    if rod.shape is not None:  # its centre of mass may lie beside the line through its pins
        q[3:5] = [q[3] + below * sine, q[4] - below * cosine]
        v[3:5] = [v[3] + below * cosine * spin, v[4] + below * sine * spin]
    _, (seat_x, seat_y) = design.slider.places
    return (
        stacked([*q, pin_x + rod.length * cosine - seat_x, 0.0 - seat_y, 0.0, *straight]),
        stacked([*v, slider_speed, 0.0, 0.0, *straight]),
    )


def driven_torque(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return the torque that keeps the crank's speed steady [N m]: the drive's power over the speed."""
    return mechanism.drive_power(rate) / at.kin.v[3 * CRANK + 2]


def motor_torque(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return the torque of a motor whose torque falls with its speed [N m]."""
    # The motor's two elements stand behind the weights.
    constant, damper = mechanism.system.forces[-2:]
    assert isinstance(constant, AppliedTorque) and isinstance(damper, TorsionalSpringDamper)
    return constant.torque + damper.torque(at.kin)


def deformations(design: SliderCrank) -> tuple[Shown, ...]:
    """Return the contacts' depth, where their damper makes the peak force, which then says little of how deep they
    went; and deflection and stress of a rod that bends."""
    depths = (Shown("penetration", depth, least=0.0),) if design.piston_pin.by_components else ()
    bending = (Shown("rod_deflection", rod_deflection), Shown("rod_stress", rod_stress)) if design.rod.modes else ()
    pushed = (Shown("slider_deflection", slider_deflection(design.slider)),) if design.slider.modes else ()
    return (*depths, *bending, *pushed)


def depth(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return the depth of the contact that is deepest [m], negative where none touches."""
    return -jnp.min(mechanism.gaps_at(at)[0])


def slider_acceleration(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return the size of the slider's acceleration [m/s²]."""
    return jnp.abs(rate[mechanism.coordinates + 3 * SLIDER])


def eccentricities(design: SliderCrank) -> tuple[Shown, ...]:
    """Return, of each pin with play, the centre relative to the bush's, along the slider's line and across it [m]."""
    shown, contact = [], 0
    for pin in (design.piston_pin, design.crank_pin):
        if pin.joint == "clearance":
            # by components, the rod's end is the ball and the pin's body carries the shape
            sign = -1.0 if pin.by_components else 1.0
            shown += [Shown(f"{pin.section}_{axis}", eccentricity(contact, sign, axis)) for axis in ("x", "y")]
            contact += SQUARE if pin.by_components else 1
    return tuple(shown)


def eccentricity(contact: int, sign: float, axis: str) -> Callable[[Assembled, EvaluatedState, Array], Scalar]:
    """Return one component of a pin's eccentricity, from one of its contacts; ``sign``: -1 where the ball stands for
    the bush."""

    def of(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
        return sign * getattr(at.contacts[contact].centre.place - at.contacts[contact].origin.place, axis)

    return of


def rod_deflection(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return how far the rod's middle is off the line through its ends [m]."""
    if isinstance(mechanism.parts, PlanarBody):
        return jnp.abs(jnp.sum(mechanism.parts.deflection * at.kin.modal(ROD)[0]))
    ends_and_middle = deflection(mechanism.parts, at.kin.modal(ROD)[0], (0.0, 0.5, 1.0))[:, 1]
    return jnp.abs(ends_and_middle[1] - 0.5 * (ends_and_middle[0] + ends_and_middle[2]))


def rod_stress(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return the size of the stress along the rod on the surface of its middle [Pa]: that of bending, of a shape the
    whole."""
    if isinstance(mechanism.parts, PlanarBody):
        upper, lower = (jnp.abs(jnp.sum(row * at.kin.modal(ROD)[0])) for row in mechanism.parts.stress)
        return jnp.maximum(upper, lower)
    bar = mechanism.parts.bar
    edge = jnp.sqrt(3.0 * bar.second_moment / bar.area)  # half the depth of a rectangle
    return jnp.abs(stress(mechanism.parts, at.kin.modal(ROD)[0], (0.5,), edge)[0])


def slider_deflection(slider: Slider) -> Callable[[Assembled, EvaluatedState, Array], Scalar]:
    """Return how far the piston pin is pushed along the slider's line, against the slider's guide [m]."""
    form = slider.form

    def of(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
        guide, seat = (at.kin.point(SLIDER, marker).place for marker in (form.first, form.second))
        return jnp.abs(seat.x - guide.x - (form.second.x - form.first.x))

    return of
