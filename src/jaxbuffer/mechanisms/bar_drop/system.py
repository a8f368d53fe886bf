"""The bar dropped on a plate, assembled: one body on a hinge, its weight, and a ball against a flat plate."""

import jax.numpy as jnp

from ..._types import Scalar, stacked
from ...contact import BallOnSegments, RegularisedCoulomb, Segment, contact_law
from ...multibody import GROUND, AppliedForce, Body, Revolute, System
from ..assembled import Assembled, BallContact, Posture
from .design import BarDrop, BarDropScenario


def depth(mechanism: Assembled, at: Posture) -> Scalar:
    """How deep the ball is in the plate [m], negative above it."""
    return -at.approach[0].gap[0]


def bar_drop(design: BarDrop, scenario: BarDropScenario, stabilisation: Scalar = 20.0) -> Assembled:
    """The mechanism at rest with its ball end at the scenario's height (docs/bar_drop.md).

    The hinge is the origin and the plate's top lies one ball radius below it, so that the bar is level at contact.
    """
    bar, half = design.bar, design.bar.length / 2.0
    mass = bar.mass
    system = System(
        bodies=(Body(mass, mass * bar.length**2 / 12.0),),
        joints=(Revolute(GROUND, 0, second_point=(-half, 0.0)),),
        forces=(AppliedForce(0, (0.0, -mass * scenario.gravity)),),
        stabilisation=stabilisation,
    )
    sine = scenario.height / bar.length
    cosine = jnp.sqrt(1.0 - jnp.asarray(sine) ** 2)
    drop = jnp.sqrt(1.5 * scenario.gravity * scenario.height)  # speed of the bar's middle when it is level [m/s]
    return Assembled(
        system,
        q=stacked([half * cosine, half * sine, jnp.arctan2(sine, cosine)]),
        v=jnp.zeros(3),
        contacts=(BallContact(0, GROUND, plate(design), point=(half, 0.0)),),
        size=(1e-3, drop),
        shown=(("penetration", depth),),
        energy_size=0.5 * mass * scenario.gravity * scenario.height,
    )


def plate(design: BarDrop) -> BallOnSegments:
    """The ball against the flat plate, long enough to both sides of the hinge."""
    radius, impact = design.bar.ball_radius, design.impact
    numbers = {
        "stiffness": impact.stiffness,
        "restitution": impact.restitution,
        "linear_stiffness": impact.linear_stiffness,
        "damping": impact.damping,
        "exponent": impact.exponent,
        "ramp_depth": impact.ramp_depth,
    }
    return BallOnSegments(
        radius=radius,
        segments=Segment(-2.0 * design.bar.length, -radius, 1.0, 0.0, 4.0 * design.bar.length),
        side=-jnp.ones(()),
        law=contact_law(impact.law, numbers),
        friction=RegularisedCoulomb(impact.friction, impact.slip_speed),
    )
