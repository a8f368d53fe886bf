"""The bar dropped on a plate, assembled from bodies, joints, a ball on the plate, and sensors; either may bend."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..._types import Scalar, stacked
from ...contact import BallPair, RegularisedCoulomb, Segment, contact_law
from ...elements import BallContact, Element, Sensor, deepest
from ...multibody import GROUND, AppliedForce, Body, FlexibleBody, Joint, Kinematics, Point, Revolute, System, Weld
from ...multibody.flexible import Marker
from ..assembled import Assembled
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
    bending: list[Element] = []
    if bar.modes:
        bent = bar.bent
        bodies, hinge, end = [FlexibleBody(bent.modes)], bent.start, bent.end
        bending.append(Sensor(bar_deflection, bar.middle_off_ends, name="bar_deflection"))
    joints: list[Joint] = [Revolute(GROUND, BAR, second_point=hinge)]
    if design.plate.modes:
        plate = design.plate.bent
        bodies.append(FlexibleBody(plate.modes))
        # The plate's axes are held, and its modes alone move it.
        joints.append(Weld(GROUND, PLATE, top, Marker.on_frame(0.0, 0.0, plate.modes.size)))
        carrier, middle = PLATE, plate.middle
        bending.append(Sensor(plate_deflection, plate.middle, name="plate_deflection"))
    sine = scenario.height / bar.length
    cosine = jnp.sqrt(1.0 - jnp.asarray(sine) ** 2)
    # The hinge is the origin, and the bar leans up from it so that its ball end is at the height.
    places = [half * cosine, half * sine, jnp.arctan2(sine, cosine), *([*top, 0.0] if design.plate.modes else [])]
    modes = sum(body.size for body in bodies if isinstance(body, FlexibleBody))
    q = stacked([*places, *[0.0] * modes])
    weight = AppliedForce(BAR, (0.0, -mass * scenario.gravity), bodies[BAR].centre_of_mass)
    time = design.impact.memory_time
    ball = BallContact(BAR, carrier, ball_on_plate(design), end, middle, memory_time=time, name="plate")
    return Assembled(
        System(tuple(bodies), tuple(joints), (weight,), stabilisation),
        q=q,
        v=jnp.zeros(len(q)),
        elements=(ball, Sensor(deepest, (ball,), least=0.0, name="penetration"), *bending),
        # speed of the bar's middle when it is level
        size=(1e-3, jnp.sqrt(1.5 * scenario.gravity * scenario.height)),
        # The bar's middle falls by half of the height.
        energy_size=0.5 * mass * scenario.gravity * scenario.height,
    )


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


def plate_deflection(kin: Kinematics, middle: Marker) -> Scalar:
    """Return how far the plate is bent downwards under the ball [m], at its ``middle``."""
    return kin.frame(PLATE).origin.y - kin.point(PLATE, middle).place.y


def bar_deflection(kin: Kinematics, weights: Float[np.ndarray, " modes"]) -> Scalar:
    """Return how far the bar's middle is from the straight line between its ends [m], to either side. ``weights``: of
    its modes, see `Bar.middle_off_ends`."""
    return jnp.abs(jnp.sum(weights * kin.modal(BAR)[0]))
