"""The augmented system, its small solver and consistent initialisation, against NumPy's dense algebra."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from helpers import four_bar, pendulum, phi, slider_crank
from jaxbuffer.multibody import (
    AppliedForce,
    AppliedTorque,
    Body,
    Kinematics,
    Prismatic,
    Revolute,
    System,
    assemble,
)
from jaxbuffer.plane import ldl_solve

BUILDERS = {"pendulum": lambda: pendulum(1.1, 2.0), "four-bar": four_bar, "slider-crank": slider_crank}
each_mechanism = pytest.mark.parametrize("build", BUILDERS.values(), ids=BUILDERS)


@pytest.mark.parametrize("size", [1, 2, 3, 4, 7, 10])
def test_ldl_solves_like_a_dense_solver(size):
    rng = np.random.default_rng(size)
    factor = rng.normal(size=(size, size))
    matrix, rhs = factor @ factor.T + 0.1 * np.eye(size), rng.normal(size=size)
    expected = np.linalg.solve(matrix, rhs)
    error = np.max(np.abs(ldl_solve(jnp.asarray(matrix), jnp.asarray(rhs)) - expected))
    # Both are backward stable: they may differ by the condition number times rounding (measured: below it for all).
    assert error <= np.linalg.cond(matrix) * 2.3e-16 * np.max(np.abs(expected))


def test_ldl_solves_a_badly_scaled_system():
    """Rows a million apart, as forces and moments of a stiff mechanism are; the exact solution is known."""
    scale = np.array([1e-3, 1.0, 1e3, 1e6])
    matrix = np.array([[4.0, 1.0, 0.5, 0.2], [1.0, 3.0, 0.3, 0.1], [0.5, 0.3, 2.0, 0.4], [0.2, 0.1, 0.4, 5.0]])
    exact = np.array([1.0, -2.0, 3.0, -4.0])
    solved = ldl_solve(jnp.asarray(scale[:, None] * matrix * scale), jnp.asarray(scale * (matrix @ exact)))
    np.testing.assert_allclose(solved * scale, exact, rtol=1e-14)


def dense(system, q, v):
    """Accelerations and multipliers from the whole augmented matrix."""
    masses = np.asarray(system.masses())
    constraints = system.constraints(Kinematics(q, v))
    jacobian, n = np.asarray(constraints.jacobian), len(masses)
    force = np.asarray(system.generalised_force(Kinematics(q, v)))
    rows, alpha = len(jacobian), system.stabilisation
    matrix = np.block([[np.diag(masses), jacobian.T], [jacobian, np.zeros((rows, rows))]])
    feedback = 2 * alpha * (jacobian @ np.asarray(v)) + alpha**2 * np.asarray(constraints.phi)
    solution = np.linalg.solve(matrix, np.concatenate([force, np.asarray(constraints.gamma) - feedback]))
    return solution[:n], solution[n:]


@each_mechanism
def test_motion_solves_the_augmented_system(build):
    system, q, v = build()
    rng = np.random.default_rng(5)
    q, v = q + 0.01 * rng.normal(size=q.shape), v + 0.1 * rng.normal(size=v.shape)  # off the constraints too
    motion = system.motion(Kinematics(q, v))
    acceleration, multipliers = dense(system, q, v)
    np.testing.assert_allclose(motion.acceleration, acceleration, rtol=1e-11, atol=1e-11 * np.max(np.abs(acceleration)))
    np.testing.assert_allclose(motion.multipliers, multipliers, rtol=1e-11, atol=1e-11 * np.max(np.abs(multipliers)))


@each_mechanism
def test_constraint_errors_decay_as_baumgarte_asks(build):
    """Φ̈ + 2α Φ̇ + α² Φ = 0 along the motion, with both derivatives taken by automatic differentiation."""
    system, q, v = build()
    rng = np.random.default_rng(6)
    q, v = q + 0.01 * rng.normal(size=q.shape), v + 0.1 * rng.normal(size=v.shape)
    acceleration = system.motion(Kinematics(q, v)).acceleration

    def rate(q, v):
        return jax.jvp(lambda q: phi(system, q), (q,), (v,))[1]

    first, second = jax.jvp(rate, (q, v), (v, acceleration))
    alpha = system.stabilisation
    left = second + 2 * alpha * first + alpha**2 * phi(system, q)
    np.testing.assert_allclose(left, 0.0, atol=1e-12 * float(jnp.max(jnp.abs(second))))


def test_pin_carries_weight_and_centrifugal_force():
    """Rod of mass m, length l at angle θ from hanging with rate ω: the pin pulls with
    m g cos θ + m ω² l/2 along it and m g sin θ / 4 across (uniform rod on a pin)."""
    mass, length, angle, rate, gravity = 1.3, 0.8, 0.7, 3.0, 9.81
    system, q, v = pendulum(angle, rate, mass, length)
    along = np.array([np.sin(angle), -np.cos(angle)])
    across = np.array([np.cos(angle), np.sin(angle)])
    # The rod is the joint's second body: the multipliers are the force on it.
    on_rod = np.asarray(system.motion(Kinematics(q, v)).multipliers)
    np.testing.assert_allclose(on_rod @ along, -mass * (gravity * np.cos(angle) + rate**2 * length / 2), rtol=1e-13)
    np.testing.assert_allclose(on_rod @ across, mass * gravity * np.sin(angle) / 4, rtol=1e-13)


def test_free_bodies_without_joints_follow_newton():
    system = System((Body(2.0, 0.5),))
    motion = system.motion(Kinematics(jnp.zeros(3), jnp.ones(3)))
    assert motion.multipliers.shape == (0,)
    np.testing.assert_array_equal(motion.acceleration, np.zeros(3))


def loose_chain():
    system = System(
        (Body(2.0, 0.1), Body(0.5, 0.02), Body(0.1, 0.004)),
        (Revolute(0, 1, (0.3, 0.0), (-0.2, 0.1)), Prismatic(1, 2)),
    )
    return system, jnp.array([0.0, 0.1, 0.2, 0.6, 0.0, -0.2, 0.9, 0.1, 0.1])


def test_assembly_closes_every_joint():
    system, guess = loose_chain()
    assert float(jnp.max(jnp.abs(phi(system, guess)))) > 0.05
    q, v = assemble(system, guess, jnp.arange(9.0))
    constraints = system.constraints(Kinematics(q, v))
    np.testing.assert_allclose(constraints.phi, 0.0, atol=1e-15)
    np.testing.assert_allclose(np.asarray(constraints.jacobian) @ np.asarray(v), 0.0, atol=1e-14)


def test_assembly_moves_velocities_as_an_impulse_at_the_joints_would():
    """M (v - v0) lies in the rows of Φ_q, so that no motion the joints allow is touched."""
    system, guess = loose_chain()
    before = jnp.arange(9.0)
    q, v = assemble(system, guess, before)
    jacobian = np.asarray(system.constraints(Kinematics(q, v)).jacobian)
    impulse = np.asarray(system.masses() * (v - before))
    left = impulse - jacobian.T @ np.linalg.lstsq(jacobian.T, impulse, rcond=None)[0]
    assert np.max(np.abs(impulse)) > 0.1
    np.testing.assert_allclose(left, 0.0, atol=1e-14)


def test_assembly_leaves_a_consistent_state_alone():
    system, q, v = four_bar()
    again = assemble(system, q, v)
    np.testing.assert_allclose(again[0], q, atol=1e-15)
    np.testing.assert_allclose(again[1], v, atol=1e-14)


def test_assembly_without_joints_changes_nothing():
    system, q = System((Body(1.0, 1.0),)), jnp.array([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(assemble(system, q, q)[0], q)


@pytest.mark.parametrize("which", [0, 1], ids=["mass", "inertia"])
def test_accelerations_move_with_masses(which):
    """Against central differences of the dense solution."""
    rng = np.random.default_rng(3)
    q, v = jnp.asarray(rng.normal(size=6)), jnp.asarray(rng.normal(size=6))

    def made(numbers):
        joint = Revolute(0, 1, (0.3, 0.1), (-0.2, 0.4))
        forces = AppliedForce(0, (3.0, -5.0), (0.2, 0.1)), AppliedTorque(1, 2.0)
        return System((Body(*numbers), Body(0.7, 0.2)), (joint,), forces)

    def found(numbers):
        motion = made(numbers).motion(Kinematics(q, v))
        return jnp.concatenate([motion.acceleration, motion.multipliers])

    at, step = np.array([1.3, 0.4]), 1e-5 * np.eye(2)[which]
    moves = jax.jvp(found, (tuple(jnp.asarray(at)),), (tuple(jnp.asarray(step / 1e-5)),))[1]
    there, back = (np.concatenate(dense(made(at + sign * step), q, v)) for sign in (1.0, -1.0))
    expected = (there - back) / 2e-5
    np.testing.assert_allclose(moves, expected, atol=1e-7 * np.max(np.abs(expected)))
