"""A ball that comes round the end of a flank bears on its back as it would on its front."""

import jax.numpy as jnp
import pytest
from numpy.testing import assert_allclose

import jaxbuffer as jb
from jaxbuffer.contact import BallPair, RegularisedCoulomb, Segment
from jaxbuffer.contact.laws import Hertz
from jaxbuffer.elements import BallContact
from jaxbuffer.fields import Part, number
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.mechanism import Defaults, Mechanism
from jaxbuffer.mechanisms.quantity import END_TIME, PEAK_FORCE, PEAK_TIME
from jaxbuffer.multibody import GROUND, Body, Revolute, System
from registration import registered

MASS, INERTIA, ROD = 0.2, 2e-5, 0.5  # kg, kg m², m: a ball on a light rod that turns about the origin
RADIUS, STIFFNESS = 0.02, 1e8  # m, N/m^1.5
BEFORE, RATE = 0.2, 3.0  # rad below the wall's line, rad/s: over the top it comes to the wall from above


class Wall(Part):
    section = "wall"
    front: float = number(1.0, "-", doc="which side of the wall is its front: 1 below, -1 above")


class Rig(Part):
    wall: Wall = Wall()


class Turning(Part):
    section = "scenario"
    rate: float = number(RATE, "rad/s")


def rig(design, scenario, stabilisation=20.0):
    """The wall begins 0.46 m to the right of the hinge, and goes on; the ball starts on the left, below its
    line. It is struck two radii from its end: farther in nothing is taken to have come round."""
    ball = BallPair(
        RADIUS, Segment(0.46, 0.0, 1.0, 0.0, 1.0), design.wall.front, Hertz(STIFFNESS), RegularisedCoulomb(0.0, 1e-3)
    )
    joint = Revolute(GROUND, 0, second_point=(ROD, 0.0))
    x, y = -ROD * jnp.cos(BEFORE), -ROD * jnp.sin(BEFORE)
    # Clockwise, so that it goes up on the left and comes down on the right.
    omega = -scenario.rate
    q = jnp.stack([x, y, jnp.asarray(BEFORE)])
    v = jnp.stack([-omega * y, omega * x, omega])
    return Assembled(
        System((Body(MASS, INERTIA),), (joint,), (), stabilisation),
        q,
        v,
        elements=(BallContact(0, GROUND, ball),),
        size=(1e-3, 1.0),
    )


@pytest.mark.quick
def test_over_the_end_onto_the_back():
    """Time of the touchdown, largest force and what is left of the energy are those of the closed form, and the same
    whichever side is called the front."""
    energy = 0.5 * (MASS * ROD**2 + INERTIA) * RATE**2
    quantities = {"peak_force": PEAK_FORCE, "peak_time": PEAK_TIME, "end_time": END_TIME}
    touchdown = (jnp.pi + BEFORE - jnp.arcsin(RADIUS / ROD)) / RATE
    with registered(Mechanism("ball_over_a_wall", Rig, Turning, quantities, rig, defaults=Defaults(duration=1.2))):
        runs = [jb.simulate(Rig(Wall(front)), Turning(), rtol=1e-9) for front in (1.0, -1.0)]
        for run in runs:
            assert run.outcome.name == "finished" and run.impact_count == 1
            assert float(run.impacts.time[0]) == pytest.approx(float(touchdown), rel=1e-9)
            assert float(run.peak_force) == pytest.approx(STIFFNESS**0.4 * (2.5 * energy) ** 0.6, rel=1e-8)
            assert abs(float(run.balance.energy)) < 1e-8
        assert_allclose(runs[0].peak_force, runs[1].peak_force, rtol=1e-13)
