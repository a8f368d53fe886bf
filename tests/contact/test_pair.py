"""A pair's forces on its two bodies: equal, opposite, on one line, and balanced in energy."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from jaxbuffer.contact import BallPair, LankaraniNikravesh, RegularisedCoulomb, Segment
from jaxbuffer.plane import Frame, Vector

RADIUS, EDGE, LENGTH = 0.015, (-0.1, 0.015), 0.07
SIDE = np.array([1.0, -1.0])
TOUCHDOWN = jnp.array([0.1, 0.1])
PAIR = BallPair(
    radius=RADIUS,
    shape=Segment(EDGE[0], -SIDE * EDGE[1], -np.sqrt(0.5), -SIDE * np.sqrt(0.5), LENGTH),
    side=SIDE,
    law=LankaraniNikravesh(6e9, 0.7),
    friction=RegularisedCoulomb(0.4, 1e-3),
)


def pressed(seed):
    """Pose (ball x, y; carrier x, y, angle) with one flank or rim pressed in by up to 20 µm, and random rates."""
    rng = np.random.default_rng(seed)
    side = rng.choice([-1.0, 1.0])
    place, angle = rng.choice(["flank", "throat", "mouth"]), rng.uniform(-0.4, 0.4)
    along, inward = np.sqrt(0.5) * np.array([-1.0, -side]), np.sqrt(0.5) * np.array([-1.0, side])
    slant = {"flank": rng.uniform(0.0, LENGTH), "throat": 0.0, "mouth": LENGTH}[place]
    lean = {"flank": 0.0, "throat": -rng.uniform(0.1, 1.0), "mouth": rng.uniform(0.1, 1.0)}[place]
    away = np.cos(lean) * inward + np.sin(lean) * along
    local = np.array([EDGE[0], -side * EDGE[1]]) + slant * along + (RADIUS - rng.uniform(0, 2e-5)) * away
    origin = rng.normal(size=2)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    rates = rng.normal(size=6) * [0.02, 0.02, 0.3, 0.02, 0.02, 0.05]
    return np.array([*(origin + turn @ local), *origin, angle]), rates


def bodies(pose, rates):
    x, y, cone_x, cone_y, angle = pose
    u, v, spin, cone_u, cone_v, cone_spin = rates
    ball = Frame(Vector(x, y), 0.0, 1.0, 0.0, Vector(u, v), spin)
    cos, sin = jnp.cos(angle), jnp.sin(angle)
    return ball, Frame(Vector(cone_x, cone_y), angle, cos, sin, Vector(cone_u, cone_v), cone_spin)


@jax.jit
def closed(pose, rates):
    a = PAIR.approach(*bodies(pose, rates))
    normal = PAIR.normal_force(a, TOUCHDOWN)
    friction = PAIR.friction_force(a, normal)
    vector = jnp.stack(a.normal * normal + a.tangent * friction)
    return a, normal, friction, vector, PAIR.hysteresis_power(a, normal)


def forces(pose, rates):
    """Approach, F_n, F_t, the force vectors on the ball and the power lost in hysteresis, an entry a flank."""
    return jax.tree.map(np.asarray, closed(pose, rates))


each_seed = pytest.mark.parametrize("seed", range(12))


@each_seed
def test_exactly_one_flank_pushes(seed):
    _, normal, friction, *_ = forces(*pressed(seed))
    assert np.count_nonzero(normal > 0.0) == 1
    assert np.all(normal >= 0.0)
    assert np.all(np.abs(friction) <= 0.4 * normal)


@each_seed
def test_both_bodies_are_pushed_at_one_point(seed):
    """The foot seen from the ball's centre is the foot seen from the carrier: action and reaction share a line, so the
    moments about any point cancel."""
    pose, rates = pressed(seed)
    a, _, _, vector, _ = forces(pose, rates)
    on_ball = pose[:2, None] - a.distance * np.stack(a.normal)
    on_cone = pose[2:4, None] + np.stack(a.foot)
    assert_allclose(on_ball, on_cone, atol=1e-15)
    for point in ([0.0, 0.0], [3.0, -2.0]):
        arms = on_ball - np.array(point)[:, None], on_cone - np.array(point)[:, None]
        moments = [arm[0] * vector[1] - arm[1] * vector[0] for arm in arms]
        assert_allclose(moments[0] - moments[1], 0.0, atol=1e-15 * max(1.0, np.max(np.abs(vector))) * 10)


@jax.jit
def storing_power(pose, rates):
    """The rate of the stored energy."""
    stored = lambda pose: PAIR.stored_energy(PAIR.approach(*bodies(pose, rates)))  # noqa: E731
    u, v, _, *cone_rates = rates
    return jax.jvp(stored, (pose,), (jnp.stack([u, v, *cone_rates]),))[1]


@each_seed
def test_power_is_stored_or_lost_and_friction_only_loses(seed):
    """Work rate of the forces on both bodies = -d(stored)/dt - hysteresis - friction heat."""
    pose, rates = pressed(seed)
    a, normal, friction, (force_x, force_y), lost = forces(pose, rates)
    u, v, spin, cone_u, cone_v, cone_spin = rates
    to_foot = -a.distance * np.stack(a.normal)
    ball_power = force_x * u + force_y * v + (to_foot[0] * force_y - to_foot[1] * force_x) * spin
    cone_power = -force_x * cone_u - force_y * cone_v - (a.foot.x * force_y - a.foot.y * force_x) * cone_spin

    storing = np.asarray(storing_power(pose, rates))
    heat = -friction * a.slip
    assert np.all(heat >= 0.0)
    assert_allclose(ball_power + cone_power, -storing - lost - heat, atol=1e-13 * np.max(normal))


@each_seed
def test_hysteresis_takes_while_closing_and_while_opening(seed):
    """(F_n - K δ^{3/2}) δ̇ = χ̂ K δ^{3/2} δ̇²/δ̇⁻ is never negative."""
    pose, rates = pressed(seed)
    for sign in (1.0, -1.0):
        *_, lost = forces(pose, sign * rates)
        assert np.sum(lost) > 0.0
