"""Quaternions and frames of space, against SciPy's rotations and differences."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jaxbuffer.space import SPACE, Quaternion, Vector

each_seed = pytest.mark.parametrize("seed", range(4))
ANGLES = [0.0, 1e-300, 1e-12, 1e-6, 0.0316, 0.0632, 0.0633, 0.0640, 1.0, 2.0, 3.0, 3.1415]


def random_quaternion(rng, size=1.0):
    """Of any rotation, and of a size of its own."""
    return size * Rotation.random(rng=rng).as_quat(scalar_first=True)


def scipy_rotation(quaternion):
    return Rotation.from_quat(np.asarray(quaternion, float), scalar_first=True)


def matrix(axes):
    return np.array([list(axis) for axis in axes]).T


@each_seed
@pytest.mark.parametrize("size", [1.0, 0.3, 7.0])
def test_the_axes_are_the_columns_of_the_rotation_matrix_whatever_the_size(seed, size):
    q = random_quaternion(np.random.default_rng(seed), size)
    np.testing.assert_allclose(matrix(Quaternion(*q).axes()), scipy_rotation(q).as_matrix(), atol=1e-15)


@each_seed
def test_a_product_is_one_rotation_after_the_other(seed):
    rng = np.random.default_rng(seed)
    a, b = random_quaternion(rng), random_quaternion(rng)
    product = Quaternion(*a).after(Quaternion(*b))
    np.testing.assert_allclose(
        scipy_rotation(product).as_matrix(), (scipy_rotation(a) * scipy_rotation(b)).as_matrix(), atol=1e-15
    )
    back = matrix(Quaternion(*a).inverse().axes())
    np.testing.assert_allclose(back, scipy_rotation(a).inv().as_matrix(), atol=1e-15)


@each_seed
@pytest.mark.parametrize("angle", ANGLES)
def test_the_rotation_vector_and_back(seed, angle):
    """Both signs of a quaternion are one rotation; near zero and near half a turn no digit is lost."""
    axis = np.random.default_rng(seed).normal(size=3)
    turn = angle * axis / np.linalg.norm(axis)
    q = Quaternion.of_rotation_vector(Vector(*turn))
    np.testing.assert_allclose(q, Rotation.from_rotvec(turn).as_quat(scalar_first=True), rtol=1e-15, atol=1e-16)
    for sign in (1.0, -1.0, 0.2, -5.0):
        there = Quaternion(*(sign * part for part in q)).rotation_vector()
        np.testing.assert_allclose(there, turn, rtol=2e-15, atol=0.0)


@pytest.mark.parametrize("angle", ANGLES[2:])
def test_the_rotation_vector_is_that_of_scipy(angle):
    q = Rotation.from_rotvec(angle * np.array([0.6, 0.0, -0.8])).as_quat(scalar_first=True)
    np.testing.assert_allclose(Quaternion(*q).rotation_vector(), scipy_rotation(q).as_rotvec(), rtol=1e-14)


@jax.jit
def through_a_quaternion(turn):
    """Derivatives of a rotation vector by the one whose quaternion it is of, forwards and in reverse."""
    through = lambda turn: jnp.stack(Quaternion.of_rotation_vector(Vector(*turn)).rotation_vector())  # noqa: E731
    return jax.jacfwd(through)(turn), jax.jacrev(through)(turn)


@pytest.mark.parametrize("angle", [0.0, 1e-6, 0.0632, 0.0633, 1.0, 3.0])
def test_the_rotation_vector_has_derivatives_everywhere(angle):
    """∂(rotation vector)/∂(rotation vector) through a quaternion is the identity, at zero as well."""
    forwards, reverse = through_a_quaternion(angle * np.array([0.36, 0.48, -0.8]))
    np.testing.assert_allclose(forwards, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(reverse, np.eye(3), atol=1e-14)


def random_state(seed, bodies=2):
    """Positions with quaternions of sizes of their own, velocities."""
    rng = np.random.default_rng(seed)
    q = np.concatenate([np.concatenate([rng.normal(size=3), random_quaternion(rng, 1.3)]) for _ in range(bodies)])
    return q, rng.normal(size=6 * bodies)


@jax.jit
def frames(q, v):
    """Of two bodies."""
    return SPACE.frames(q, v, 2)


@jax.jit
def position_rate(q, v):
    return SPACE.position_rate(q, 2).of(v)


@jax.jit
def velocity(q, rate):
    return SPACE.position_rate(q, 2).velocity(rate)


relative_rotation = jax.jit(SPACE.relative_rotation)


@jax.jit
def pose_rates(q, v):
    """Origins and axes of two bodies' frames, and their rates along q̇ = N(q) v."""

    def poses(q):
        return [jnp.stack([jnp.stack(part) for part in (f.origin, *f.axes)]) for f in SPACE.frames(q, v, 2)]

    return jax.jvp(poses, (q,), (SPACE.position_rate(q, 2).of(v),))


@each_seed
def test_the_position_rate_turns_the_frames_with_their_spins(seed):
    """Along q̇ = N(q) v the origins move with the velocities, and each axis with ω × axis."""
    q, v = random_state(seed)
    for body, (pose, moved) in enumerate(zip(*pose_rates(q, v), strict=True)):
        mine, axes = v[6 * body : 6 * body + 6], np.asarray(pose)[1:]
        expected = [mine[:3], *(np.cross(mine[3:], axis) for axis in axes)]
        np.testing.assert_allclose(moved, expected, atol=1e-14)
    # the quaternion's size stays
    assert abs(2.0 * q[3:7] @ np.asarray(position_rate(q, v))[3:7]) < 1e-14


@each_seed
def test_the_velocity_of_a_position_rate(seed):
    """``velocity`` is the inverse of ``of``, column by column, and does not see what changes a size."""
    q, v = random_state(seed)
    rest = np.random.default_rng(seed).normal(size=(14, 3))
    columns = np.concatenate([np.stack([v, 2.0 * v, -v], axis=1), rest])
    rate = np.asarray(position_rate(q, columns))
    np.testing.assert_allclose(rate[:14, 1], 2.0 * np.asarray(position_rate(q, v)), rtol=1e-15)
    np.testing.assert_allclose(velocity(q, rate), columns, rtol=1e-13, atol=1e-14)
    grown = np.zeros(14)
    grown[3:7] = q[3:7]
    np.testing.assert_allclose(velocity(q, grown), 0.0, atol=1e-15)


@each_seed
def test_frames_turn_and_unturn(seed):
    q, v = random_state(seed)
    frame = jax.tree.map(np.asarray, frames(q, v)[1])
    rotation, arm = scipy_rotation(q[10:14]), Vector(0.3, -0.7, 0.2)
    np.testing.assert_allclose(frame.turn(arm), rotation.apply(list(arm)), atol=1e-15)
    np.testing.assert_allclose(frame.unturn(arm), rotation.inv().apply(list(arm)), atol=1e-15)
    spin = np.asarray(v[9:12])
    np.testing.assert_allclose(frame.velocity_at(arm), v[6:9] + np.cross(spin, list(arm)), atol=1e-14)
    np.testing.assert_allclose(frame.centripetal(arm), np.cross(spin, np.cross(spin, list(arm))), atol=1e-14)


@each_seed
def test_the_relative_rotation_takes_one_frame_to_the_other(seed):
    q, v = random_state(seed)
    first, second = frames(q, v)
    turn = Rotation.from_rotvec(relative_rotation(first, second))
    np.testing.assert_allclose(turn.as_matrix() @ matrix(first.axes), matrix(second.axes), atol=1e-14)
    np.testing.assert_allclose(relative_rotation(SPACE.ground(), first), scipy_rotation(q[3:7]).as_rotvec())


@jax.jit
def turn_and_half_square_rate(q, v):
    """The rotation between two bodies, and the rate of half its square."""

    def squared(q):
        turn = SPACE.relative_rotation(*SPACE.frames(q, v, 2))
        return 0.5 * turn.dot(turn), turn

    rate = SPACE.position_rate(q, 2).of(v)
    _, gained, turn = jax.jvp(squared, (q,), (rate,), has_aux=True)
    return turn, gained


@each_seed
def test_moments_of_the_rotation_vector_are_those_of_its_potential(seed):
    """k φ does the work that ½ k |φ|² loses, at any relative rotation: φ is along its own axis."""
    q, v = random_state(seed)
    turn, gained = turn_and_half_square_rate(q, v)
    power = np.asarray(turn) @ (v[9:12] - v[3:6])
    np.testing.assert_allclose(gained, power, rtol=1e-12)


@jax.jit
def inertial(q, v, moments):
    """Inertia, spin momentum and gyroscopic moment of one body."""
    (frame,) = SPACE.frames(q, v, 1)
    functions = SPACE.inertia_block, SPACE.spin_momentum, SPACE.gyroscopic_moment
    return [function(frame, moments) for function in functions]


@each_seed
def test_inertia_and_gyroscopic_moment(seed):
    """R I Rᵀ, R I Rᵀ ω and -ω × R I Rᵀ ω."""
    q, v = random_state(seed, 1)
    moments = (0.7, 1.9, 2.3)
    block, momentum, gyroscopic = inertial(q, v, moments)
    turn, spin = scipy_rotation(q[3:7]).as_matrix(), v[3:6]
    inertia = turn @ np.diag(moments) @ turn.T
    for i, row in enumerate(block):
        np.testing.assert_allclose(row, inertia[i, : i + 1], atol=1e-14)
    np.testing.assert_allclose(momentum, inertia @ spin, atol=1e-14)
    np.testing.assert_allclose(gyroscopic, -np.cross(spin, inertia @ spin), atol=1e-13)
