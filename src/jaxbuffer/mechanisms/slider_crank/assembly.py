"""The slider-crank assembled from bodies, joints and elements: the one place that asks which parts a design has."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar, stacked
from ...contact import BallPair, Hole, RegularisedCoulomb, Segment, Shape
from ...elements import BallContact, Drive, Element, Motor
from ...multibody import (
    GROUND,
    AppliedForce,
    Body,
    ConstantSpeed,
    DrivenAngle,
    FlexibleBody,
    Joint,
    Point,
    Prismatic,
    Revolute,
    System,
)
from ..assembled import Assembled
from .design import Rod, Slider, SliderCrank, SliderCrankScenario
from .pins import PinInBush
from .sensors import CRANK, ROD, SLIDER, eccentricity, sensors
from .shapes import PlanarBody


def slider_crank(design: SliderCrank, scenario: SliderCrankScenario, stabilisation: Scalar = 20.0) -> Assembled:
    """Return the mechanism at its start (docs/slider_crank.md). The shaft is the origin, the slider's line the
    x-axis."""
    crank = design.crank
    off = crank.unbalance / crank.mass
    link, rear, front = rod_body(design.rod)
    block, guide, seat = slider_body(design.slider)
    # A body's inertia is about its centre of mass: from that about the shaft Steiner's share is taken off.
    bodies = (Body(crank.mass, crank.inertia - crank.unbalance * off), link, block)
    weights = tuple(
        AppliedForce(k, (0.0, -body.mass * scenario.gravity), body.centre_of_mass) for k, body in enumerate(bodies)
    )
    joints: list[Joint] = [Revolute(GROUND, CRANK, second_point=(-off, 0.0)), guide]
    contacts: list[BallContact] = []
    recorded: list[Element] = []
    for pin, body, point, end in (
        (design.piston_pin, SLIDER, seat, front),
        (design.crank_pin, CRANK, (crank.length - off, 0.0), rear),
    ):
        if pin.joint == "pinned":
            joints.append(Revolute(body, ROD, first_point=point, second_point=end))
        else:
            contacts += pin_in_bush(pin, body, point, end, design.piston_pin.memory_time)
            recorded += eccentricity(pin, contacts[-1])
    q, v = ideal_motion(design, scenario)
    turning = design.drive.kind == "torque"
    # A motor may bring the crank from rest to its no-load speed.
    fastest = jnp.maximum(jnp.abs(scenario.crank_speed), design.drive.no_load_speed if turning else 0.0)
    speed = crank.length * fastest
    return Assembled(
        System(bodies, tuple(joints), weights, stabilisation),
        q=q,
        v=v,
        elements=(*contacts, drive(design, scenario), *sensors(design, tuple(contacts)), *recorded),
        size=(1e-4, speed),
        energy_size=0.5 * block.mass * speed**2 + (0.5 * crank.inertia * fastest**2 if turning else 0.0),
    )


def drive(design: SliderCrank, scenario: SliderCrankScenario) -> Element:
    """Return what turns the crank: a drive that keeps its speed, or a motor."""
    motor = design.drive
    if motor.kind == "speed":
        return Drive(DrivenAngle(GROUND, CRANK, ConstantSpeed(scenario.crank_angle, scenario.crank_speed)))
    return Motor(CRANK, motor.torque, motor.no_load_speed, scenario.crank_angle, lost_in="dampers")


def pin_in_bush(pin: PinInBush, body: int, point: Point, end: Point, memory_time: Scalar | None) -> list[BallContact]:
    """Return the contact of a pin with play: round, the ball on ``body`` at ``point`` in the bush at the rod's ``end``,
    or by components, the rod's end between the four sides of a square on the body."""
    # A square hole has the slider's directions, and so is on the slider; the round bush is on the rod.
    if pin.by_components:
        return [
            BallContact(ROD, body, in_contact(pin, side, -1.0), end, point, memory_time=memory_time, name=name)
            for name, side in zip(pin.contacts, flanks(pin.bush_radius), strict=True)
        ]
    hole, (name,) = Hole(0.0, 0.0, pin.bush_radius), pin.contacts
    return [BallContact(body, ROD, in_contact(pin, hole, 1.0), point, end, memory_time=memory_time, name=name)]


def rod_body(rod: Rod) -> tuple[Body, Point, Point]:
    """Return the rod, and where its pins are: the crank's and the piston's."""
    if not rod.modes:
        return rod.body, *rod.ends
    bent = rod.bent
    first, second = (bent.first, bent.second) if isinstance(bent, PlanarBody) else (bent.start, bent.end)
    return FlexibleBody(bent.modes), first, second


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


def in_contact(pin: PinInBush, shape: Shape, side: float) -> BallPair:
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
    # The rod is longer than the crank (`check_fit`), so that this is above zero, and the rod never stands across.
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
