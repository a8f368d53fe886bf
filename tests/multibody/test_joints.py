"""Every joint's Φ against geometry, its Φ_q and γ against automatic differentiation of Φ alone."""

import equinox as eqx
import jax
import numpy as np
import pytest

from jaxbuffer.multibody import GROUND, Body, FixedAngle, Kinematics, PointOnLine, Prismatic, Revolute, System, Weld

A, B = (0.31, -0.12), (-0.45, 0.27)
NORMAL = (np.sin(0.7), np.cos(0.7))
JOINTS = {
    "revolute": lambda i, j: Revolute(i, j, A, B),
    "fixed angle": lambda i, j: FixedAngle(i, j, 0.4),
    "point on line": lambda i, j: PointOnLine(i, j, A, B, NORMAL),
    "prismatic": lambda i, j: Prismatic(i, j, A, B, NORMAL, 0.4),
    "weld": lambda i, j: Weld(i, j, A, B, 0.4),
}
BODIES = {"both bodies": (0, 1), "swapped": (1, 0), "ground first": (GROUND, 1), "ground second": (0, GROUND)}

each_joint = pytest.mark.parametrize("joint", JOINTS)
each_pair = pytest.mark.parametrize("pair", BODIES)
each_seed = pytest.mark.parametrize("seed", range(3))


def random_system(joint, pair, seed):
    rng = np.random.default_rng(seed)
    system = System((Body(1.0, 0.1), Body(2.0, 0.3)), (JOINTS[joint](*BODIES[pair]),))
    return system, rng.normal(size=6), rng.normal(size=6)


@eqx.filter_jit  # once for all seeds of a system
def rows(system, q, v):
    """The rows of the constraints, Φ_q by automatic differentiation, and γ = -(Φ_q q̇)_q q̇ from two push-forwards."""

    def phi(q):
        return system.constraints(Kinematics(q, v)).phi

    def rate(q):
        return jax.jvp(phi, (q,), (v,))[1]

    return system.constraints(Kinematics(q, v)), jax.jacfwd(phi)(q), -jax.jvp(rate, (q,), (v,))[1]


def pose(q, body):
    """Origin and rotation matrix of a body."""
    x, y, angle = (0.0, 0.0, 0.0) if body == GROUND else q[3 * body : 3 * body + 3]
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return np.array([x, y]), turn, angle


@each_joint
@each_pair
@each_seed
def test_constraint_is_the_stated_geometry(joint, pair, seed):
    system, q, v = random_system(joint, pair, seed)
    (origin_i, turn_i, angle_i), (origin_j, turn_j, angle_j) = (pose(q, body) for body in BODIES[pair])
    apart = origin_i + turn_i @ A - origin_j - turn_j @ B
    angle = angle_i - angle_j - 0.4
    across = -(turn_i @ NORMAL) @ apart
    expected = {
        "revolute": apart,
        "fixed angle": [angle],
        "point on line": [across],
        "prismatic": [angle, across],
        "weld": [*apart, angle],
    }[joint]
    found, _, _ = rows(system, q, v)
    np.testing.assert_allclose(found.phi, expected, atol=1e-14)


@each_joint
@each_pair
@each_seed
def test_jacobian_is_the_derivative_of_the_constraint(joint, pair, seed):
    found, expected, _ = rows(*random_system(joint, pair, seed))
    np.testing.assert_allclose(found.jacobian, expected, atol=1e-14)


@each_joint
@each_pair
@each_seed
def test_gamma_is_the_velocity_part_of_the_second_derivative(joint, pair, seed):
    found, _, expected = rows(*random_system(joint, pair, seed))
    np.testing.assert_allclose(found.gamma, expected, atol=1e-13)


@each_joint
def test_swapping_the_ground_and_a_body_leaves_reactions_on_the_body_alone(joint):
    found, _, _ = rows(*random_system(joint, "ground first", 0))
    jacobian = np.asarray(found.jacobian)
    assert np.all(jacobian[:, :3] == 0.0)
    assert np.any(jacobian[:, 3:] != 0.0)


@pytest.mark.parametrize("kind", [Revolute, FixedAngle, PointOnLine, Prismatic, Weld])
def test_points_left_out_are_the_origins_of_the_bodies(kind):
    joint = kind(0, 1)
    assert (joint.first_point, joint.second_point) == ((0.0, 0.0), (0.0, 0.0))


def closed_form(joint, q, v):
    """Φ, the Jacobian by both bodies and γ of a joint between bodies 0 and 1, as M10 to M14 write them."""
    (r_i, r_j), (angle_i, angle_j) = (q[0:2], q[3:5]), (q[2], q[5])
    (u_i, u_j), (spin_i, spin_j) = (v[0:2], v[3:5]), (v[2], v[5])
    turn = lambda angle: np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])  # noqa: E731
    across = lambda a: np.array([-a[1], a[0]])  # noqa: E731
    a, b, nu = turn(angle_i) @ A, turn(angle_j) @ B, turn(angle_i) @ NORMAL
    pin = (
        r_i + a - r_j - b,
        [[1.0, 0.0, -a[1], -1.0, 0.0, b[1]], [0.0, 1.0, a[0], 0.0, -1.0, -b[0]]],
        spin_i**2 * a - spin_j**2 * b,
    )
    angle = ([angle_i - angle_j - 0.4], [[0.0, 0.0, 1.0, 0.0, 0.0, -1.0]], [0.0])
    p, rate = r_j + b - r_i, u_j + spin_j * across(b) - u_i
    line = (
        [nu @ (p - a)],
        [[-nu[0], -nu[1], across(nu) @ p, nu[0], nu[1], nu @ across(b)]],
        [spin_i**2 * (nu @ p) - 2.0 * spin_i * (across(nu) @ rate) + spin_j**2 * (nu @ b)],
    )
    parts = {
        "revolute": (pin,),
        "fixed angle": (angle,),
        "point on line": (line,),
        "prismatic": (angle, line),
        "weld": (pin, angle),
    }[joint]
    return [np.concatenate(part) for part in zip(*parts, strict=True)]


@each_joint
@each_seed
def test_rows_of_primitives_are_the_closed_forms(joint, seed):
    """In the plane lists of primitives give M10 to M14."""
    system, q, v = random_system(joint, "both bodies", seed)
    found, _, _ = rows(system, q, v)
    phi, jacobian, gamma = closed_form(joint, q, v)
    np.testing.assert_allclose(found.phi, phi, atol=1e-15)
    np.testing.assert_allclose(found.jacobian, jacobian, atol=1e-15)
    np.testing.assert_allclose(found.gamma, gamma, rtol=1e-14, atol=1e-14)
