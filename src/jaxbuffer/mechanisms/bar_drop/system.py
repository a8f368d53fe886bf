"""The bar dropped on a plate, assembled: a bar on a hinge, its weight, and a ball against a plate; either may bend."""

from collections.abc import Callable
from functools import cache

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..._types import Scalar, stacked
from ...contact import BallPair, RegularisedCoulomb, Segment, contact_law
from ...multibody import GROUND, AppliedForce, Body, FlexibleBody, Joint, Point, Revolute, System, Weld
from ...multibody.flexible import Bar, FlexibleBar, Marker, free_bar, plate_strip
from ..assembled import Assembled, BallContact, Shown
from ..layout import EvaluatedState
from .design import BarDrop, BarDropScenario

BAR, PLATE = range(2)


def bar_drop(design: BarDrop, scenario: BarDropScenario, stabilisation: Scalar = 20.0) -> Assembled:
    """Return the mechanism at rest with its ball end at the scenario's height (docs/bar_drop.md).

    The hinge is the origin and the plate's top lies one ball radius below it, so that the bar is level at contact.
    """
    bar, half = design.bar, design.bar.length / 2.0
    mass, top = bar.mass, (bar.length, -bar.ball_radius)  # where the ball strikes
    bodies: list[Body] = [Body(mass, mass * bar.length**2 / 12.0)]
    hinge: Point = (-half, 0.0)
    end: Point = (half, 0.0)
    carrier = GROUND
    middle: Point = top
    shown = [Shown("penetration", depth, least=0.0)]
    if bar.modes:
        bent = bending_bar(design)
        bodies, hinge, end = [FlexibleBody(bent.modes)], bent.start, bent.end
        shown.append(Shown("bar_deflection", bar_deflection(bar.modes)))
    joints: list[Joint] = [Revolute(GROUND, BAR, second_point=hinge)]
    if design.plate.modes:
        plate = bending_plate(design)
        bodies.append(FlexibleBody(plate.modes))
        # The plate's axes are held, and its modes alone move it.
        joints.append(Weld(GROUND, PLATE, top, Marker.on_frame(0.0, 0.0, plate.modes.size)))
        carrier, middle = PLATE, plate.middle
        shown.append(Shown("plate_deflection", plate_deflection))
    sine = scenario.height / bar.length
    cosine = jnp.sqrt(1.0 - jnp.asarray(sine) ** 2)
    # The hinge is the origin, and the bar leans up from it so that its ball end is at the height.
    places = [half * cosine, half * sine, jnp.arctan2(sine, cosine), *([*top, 0.0] if design.plate.modes else [])]
    modes = sum(body.size for body in bodies if isinstance(body, FlexibleBody))
    q = stacked([*places, *[0.0] * modes])
    weight = AppliedForce(BAR, (0.0, -mass * scenario.gravity), bodies[BAR].centre_of_mass)
    return Assembled(
        System(tuple(bodies), tuple(joints), (weight,), stabilisation),
        q=q,
        v=jnp.zeros(len(q)),
        contacts=(BallContact(BAR, carrier, ball_on_plate(design), end, middle),),
        # speed of the bar's middle when it is level
        size=(1e-3, jnp.sqrt(1.5 * scenario.gravity * scenario.height)),
        shown=tuple(shown),
        energy_size=0.5 * mass * scenario.gravity * scenario.height,
        memory_time=design.impact.memory_time,
    )


def bending_bar(design: BarDrop) -> FlexibleBar:
    """Return the bar in modes of a free one, whose axes keep its centre of mass and angular momentum."""
    bar = design.bar
    return free_bar(bar.rod, bar.modes - 2, damping_ratio=bar.damping_ratio)


def bending_plate(design: BarDrop) -> FlexibleBar:
    """Return the plate in those of its modes that move where it is struck."""
    plate = design.plate
    return plate_strip(plate.strip, moving_modes(design), support=plate.support, damping_ratio=plate.damping_ratio)


def moving_modes(design: BarDrop) -> tuple[int, ...]:
    """Return which of the plate's modes move its middle, counted from 1: every other one."""
    return tuple(range(1, design.plate.modes + 1, 2))


def ball_on_plate(design: BarDrop) -> BallPair:
    """Return the ball against the flat top of the plate, long enough to both sides; the axes' origin is where it
    strikes."""
    impact, length = design.impact, design.bar.length
    numbers = {
        "stiffness": impact.stiffness,
        "restitution": impact.restitution,
        "linear_stiffness": impact.linear_stiffness,
        "damping": impact.damping,
        "exponent": impact.exponent,
        "ramp_depth": impact.ramp_depth,
    }
    return BallPair(
        radius=design.bar.ball_radius,
        # The ball end swings about the hinge, one length to the left of the origin, and so stays within two lengths of
        # that.
        shape=Segment(-3.0 * length, 0.0, 1.0, 0.0, 4.0 * length),
        side=-jnp.ones(()),
        law=contact_law(impact.law, numbers),
        friction=RegularisedCoulomb(impact.friction, impact.slip_speed),
    )


def depth(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return how deep the ball is in the plate [m], negative above it."""
    return -at.contacts[0].approach.gap[0]


def plate_deflection(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return how far the plate is bent downwards under the ball [m]."""
    return at.kin.frame(PLATE).origin.y - at.contacts[0].origin.place.y


@cache
def bar_deflection(modes: int) -> Callable[..., Scalar]:
    """Return how far the bar's middle is from the straight line between its ends [m], to either side, as an observable
    of a bar in so many modes."""
    # The mode shapes of a free uniform bar do not depend on its dimensions.
    shapes = free_bar(Bar.circle(1.0, 1.0, 1.0, 1.0), modes - 2).shapes
    start, middle, end = shapes.lateral(np.array([0.0, 0.5, 1.0]), 0)
    weights = middle - 0.5 * (start + end)
    return lambda mechanism, at, rate: jnp.abs(jnp.sum(weights * at.kin.modal(BAR)[0]))
