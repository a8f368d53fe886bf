"""A ball on one body against a plane on another: geometry and loads by hand."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.contact import BallPair, RegularisedCoulomb, Segment
from jaxbuffer.contact.laws import Hertz
from jaxbuffer.elements import BallContact, ContactForces
from jaxbuffer.multibody import GROUND, Kinematics

RADIUS = 0.1
PLANE = Segment(-5.0, 0.0, 1.0, 0.0, 10.0)  # along the x-axis of its body
TURN = 0.4
Q = jnp.array([1.0, 2.0, 0.3, -0.5, 0.2, TURN])
V = jnp.array([0.1, -0.2, 0.7, 0.05, 0.3, -0.6])


def contact(carrier, **points):
    return BallContact(0, carrier, BallPair(RADIUS, PLANE, -1.0, Hertz(1.0), RegularisedCoulomb(0.0, 1.0)), **points)


def place(k, point):
    cos, sin = np.cos(Q[3 * k + 2]), np.sin(Q[3 * k + 2])
    return np.array([Q[3 * k] + cos * point[0] - sin * point[1], Q[3 * k + 1] + sin * point[0] + cos * point[1]])


@pytest.mark.quick
@pytest.mark.parametrize("points", [{}, {"point": (0.2, -0.1)}, {"carrier_point": (0.3, 0.4)}])
def test_the_gap_is_the_height_above_the_plane(points):
    """Points are the bodies' origins unless they are given."""
    approach, centre, origin, *_ = contact(1, **points).evaluate(Kinematics(Q, V))
    ball, base = place(0, points.get("point", (0.0, 0.0))), place(1, points.get("carrier_point", (0.0, 0.0)))
    normal = np.array([-np.sin(TURN), np.cos(TURN)])
    np.testing.assert_allclose(centre.place, ball, rtol=1e-14)
    np.testing.assert_allclose(origin.place, base, rtol=1e-14)
    np.testing.assert_allclose(approach.gap, [normal @ (ball - base) - RADIUS], rtol=1e-13)
    np.testing.assert_allclose([approach.normal.x[0], approach.normal.y[0]], normal, rtol=1e-13)


def test_on_the_ground_it_is_the_height():
    approach = contact(GROUND).evaluate(Kinematics(Q, V)).approach
    np.testing.assert_allclose(approach.gap, [2.0 - RADIUS], rtol=1e-14)


@pytest.mark.quick
@pytest.mark.parametrize(("normal", "friction"), [(3.0, 0.0), (0.0, 2.0), (3.0, 2.0)])
def test_loads_at_the_foot_balance(normal, friction):
    """Equal and opposite, with the same moment about the origin; a normal force has none about the ball's centre."""
    made = contact(1, point=(0.2, -0.1), carrier_point=(0.3, 0.4))
    kin = Kinematics(Q, V)
    at = made.evaluate(kin)
    approach = at.approach
    on_ball, on_carrier = made.loads_of(at, ContactForces(jnp.array([normal]), jnp.array([friction])))
    np.testing.assert_allclose(np.add(on_ball.force, on_carrier.force), 0.0, atol=1e-15)
    assert np.hypot(*on_ball.force) == pytest.approx(np.hypot(normal, friction))
    across = [-np.sin(TURN), np.cos(TURN)]
    assert np.dot(on_ball.force, across) == pytest.approx(normal)

    def about_origin(load, k):
        (x, y), (fx, fy) = Q[3 * k : 3 * k + 2], load.force
        return load.moment + x * fy - y * fx

    assert float(about_origin(on_ball, 0)) == pytest.approx(-float(about_origin(on_carrier, 1)))
    arm = place(0, (0.2, -0.1)) - np.asarray(Q[:2])
    own = float(on_ball.moment) - (arm[0] * on_ball.force[1] - arm[1] * on_ball.force[0])
    height = float(approach.gap[0]) + RADIUS  # of the foot below the centre
    assert abs(own) == pytest.approx(height * friction, abs=1e-14)
