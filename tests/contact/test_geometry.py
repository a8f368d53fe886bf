"""Foot, gap and normal of a ball in a cone: cases worked by hand, mirror symmetry, speeds against derivatives."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from jaxbuffer.contact import BallPair, LankaraniNikravesh, RegularisedCoulomb, Segment
from jaxbuffer.plane import Frame, Vector

RADIUS, LENGTH = 0.02, 0.1
EDGE = (-0.3, 0.04)  # the throat edge: x, and distance from the axis
COS, SIN = 0.8, 0.6  # of the cone's half angle
SIDE = np.array([1.0, -1.0])  # lower flank, upper flank

CONE = BallPair(
    radius=RADIUS,
    shape=Segment(EDGE[0], -SIDE * EDGE[1], -COS, -SIDE * SIN, LENGTH),
    side=SIDE,
    law=LankaraniNikravesh(1e9, 0.9),
    friction=RegularisedCoulomb(0.3, 1e-3),
)

# In the cone's axes: where the centre is, and foot, normal, distance of the lower flank, worked by hand.
THROAT, MOUTH = np.array([-0.3, -0.04]), np.array([-0.38, -0.1])
ALONG, INWARD = np.array([-COS, -SIN]), np.array([-SIN, COS])
LOWER_CASES = {
    "half way, touching": (THROAT + 0.05 * ALONG + 0.02 * INWARD, (-0.34, -0.07), (-0.6, 0.8), 0.02),
    "a quarter, apart": (THROAT + 0.025 * ALONG + 0.05 * INWARD, (-0.32, -0.055), (-0.6, 0.8), 0.05),
    "half way, pressed in": (THROAT + 0.05 * ALONG + 0.019 * INWARD, (-0.34, -0.07), (-0.6, 0.8), 0.019),
    "half way, carried through": (THROAT + 0.05 * ALONG - 0.009 * INWARD, (-0.34, -0.07), (-0.6, 0.8), -0.009),
    "half way, pressed on the back": (THROAT + 0.05 * ALONG - 0.019 * INWARD, (-0.34, -0.07), (0.6, -0.8), 0.019),
    "half way, behind": (THROAT + 0.05 * ALONG - 0.03 * INWARD, (-0.34, -0.07), (0.6, -0.8), 0.03),
    "throat rim, across": (np.array([-0.3, -0.01]), (-0.3, -0.04), (0.0, 1.0), 0.03),
    "throat rim, aslant": (np.array([-0.27, 0.0]), (-0.3, -0.04), (0.6, 0.8), 0.05),
    "throat rim, along the flank": (np.array([-0.22, 0.02]), (-0.3, -0.04), (0.8, 0.6), 0.1),
    "mouth rim, from ahead": (np.array([-0.43, -0.1]), (-0.38, -0.1), (-1.0, 0.0), 0.05),
    "mouth rim, from outside": (np.array([-0.41, -0.14]), (-0.38, -0.1), (-0.6, -0.8), 0.05),
}


def frame(x, y, angle, u, v, spin):
    return Frame(Vector(x, y), angle, jnp.cos(angle), jnp.sin(angle), Vector(u, v), spin)


def motion(x=0.0, y=0.0, angle=0.0, u=0.0, v=0.0, spin=0.0):
    """Of a ball or of its carrier."""
    return np.array([x, y, angle, u, v, spin])


@jax.jit
def on_both_flanks(ball, carrier):
    return CONE.approach(frame(*ball), frame(*carrier))


def approach(ball, carrier):
    return jax.tree.map(np.asarray, on_both_flanks(ball, carrier))


@pytest.mark.parametrize("case", LOWER_CASES)
@pytest.mark.parametrize("flank", [0, 1])
def test_worked_cases_on_both_flanks(case, flank):
    """The upper flank sees the mirror image of the lower flank's case."""
    centre, foot, normal, distance = LOWER_CASES[case]
    mirror = np.array([1.0, SIDE[flank]])
    a = approach(motion(*(centre * mirror)), motion())
    assert_allclose([a.foot.x[flank], a.foot.y[flank]], foot * mirror, atol=1e-15)
    assert_allclose([a.normal.x[flank], a.normal.y[flank]], normal * mirror, atol=1e-14)
    assert_allclose(a.distance[flank], distance, atol=1e-15)
    assert_allclose(a.gap[flank], distance - RADIUS, atol=1e-15)


def test_tangents_point_along_the_flanks_towards_the_throat():
    a = approach(motion(-0.36, 0.0), motion())
    assert_allclose(a.tangent, [[COS, COS], [SIN, -SIN]], atol=1e-14)


def test_gap_and_normal_are_continuous_across_the_rims():
    """A hundredth of a micrometre to either side of the rims' normals, before the flank and behind it."""
    for rim, front in itertools.product((THROAT, MOUTH), (1.0, -1.0)):
        for step in (-1e-8, 1e-8):
            a = approach(motion(*(rim + front * 0.03 * INWARD + step * ALONG)), motion())
            assert_allclose(a.gap[0], 0.01, atol=1e-14)
            assert_allclose([a.normal.x[0], a.normal.y[0]], front * INWARD, atol=4e-7)
            assert_allclose([a.foot.x[0], a.foot.y[0]], rim, atol=1.1e-8)


def test_geometry_turns_and_shifts_with_its_body():
    """The carrier at (2, -1) turned by 0.7 rad: gaps and speeds are as before, directions turn."""
    angle, origin, centre = 0.7, np.array([2.0, -1.0]), np.array([-0.35, -0.03])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    plain = approach(motion(*centre), motion())
    turned = approach(motion(*(origin + turn @ centre)), motion(*origin, angle))
    assert_allclose(turned.gap, plain.gap, atol=1e-15)
    for name in ("normal", "tangent", "foot"):
        assert_allclose(np.stack(getattr(turned, name)), turn @ np.stack(getattr(plain, name)), atol=1e-14)


def random_motion(seed):
    """Ball and carrier in general motion, the tip somewhere about the cone (rims included)."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(-0.5, 0.5)
    centre = np.array([rng.uniform(-0.45, -0.25), rng.uniform(-0.15, 0.15)])
    ball = motion(*centre, 0.0, *rng.normal(size=3))
    return ball, motion(*(0.01 * rng.normal(size=2)), angle, *rng.normal(size=3))


@pytest.mark.parametrize("seed", range(8))
def test_mirror_image_swaps_the_flanks(seed):
    ball, cone = random_motion(seed)
    a = approach(ball, cone)
    mirror = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
    b = approach(mirror * ball, mirror * cone)
    for name in ("gap", "approach_speed", "slip", "distance"):
        assert_allclose(getattr(b, name), getattr(a, name)[::-1], atol=1e-14, err_msg=name)
    for name in ("normal", "tangent", "foot"):
        x, y = getattr(a, name)
        assert_allclose(getattr(b, name), [x[::-1], -y[::-1]], atol=1e-14, err_msg=name)


@jax.jit
def gap_rate(ball, cone):
    """By poses that move with the velocities."""
    gap = lambda *poses: CONE.approach(*(frame(*pose, 0.0, 0.0, 0.0) for pose in poses)).gap  # noqa: E731
    return jax.jvp(gap, (ball[:3], cone[:3]), (ball[3:], cone[3:]))[1]


@pytest.mark.parametrize("seed", range(8))
def test_the_gap_closes_at_the_approach_speed(seed):
    """d gap/dt by automatic differentiation of the positions alone, spins included through the poses."""
    ball, cone = random_motion(seed)
    assert_allclose(approach(ball, cone).approach_speed, -np.asarray(gap_rate(ball, cone)), rtol=1e-13, atol=1e-14)


def test_random_motions_reach_flanks_and_rims():
    """The two tests above see all three kinds of foot."""
    slants = []
    for seed in range(8):
        ball, cone = random_motion(seed)
        off_x, off_y = frame(*cone).unturn(approach(ball, cone).foot)
        slants.append(np.hypot(off_x - EDGE[0], off_y + SIDE * EDGE[1]))
    ends = np.isclose(slants, 0.0, atol=1e-12), np.isclose(slants, LENGTH, rtol=1e-12)
    assert np.any(ends[0])
    assert np.any(ends[1])
    assert not np.all(ends[0] | ends[1])


def test_a_rolling_ball_does_not_slip():
    """On the lower flank towards the throat at v the ball turns clockwise by v/R; the other way it slips by 2 v."""
    centre, speed = THROAT + 0.05 * ALONG + RADIUS * INWARD, 0.3
    for spin, slip in ((-speed / RADIUS, 0.0), (0.0, speed), (speed / RADIUS, 2 * speed)):
        a = approach(motion(*centre, 0.0, speed * COS, speed * SIN, spin), motion())
        assert_allclose(a.slip[0], slip, atol=1e-15)
        assert_allclose(a.approach_speed[0], 0.0, atol=1e-15)


def test_speeds_are_those_of_the_material_points_at_the_foot():
    """A carrier spinning under a still ball: its point at the foot (x, y) moves at ω (-y, x)."""
    centre, spin = THROAT + 0.05 * ALONG + RADIUS * INWARD, 0.4
    a = approach(motion(*centre), motion(spin=spin))
    velocity = spin * np.array([0.07, -0.34])  # the foot is at (-0.34, -0.07)
    assert_allclose(a.approach_speed[0], velocity @ INWARD, rtol=1e-13)
    assert_allclose(a.slip[0], velocity @ ALONG, rtol=1e-13)
