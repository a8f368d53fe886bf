"""The augmented system with the blocks of flexible bodies, against NumPy's dense algebra and differences."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.multibody import GROUND, AxialSpringDamper, Body, FlexibleBody, PointOnLine, Revolute, System, Weld
from jaxbuffer.multibody.flexible import Bar, free_bar
from multibody.particles import dense_mass, random_body, random_marker

TOPIC = "Equations of flexible bodies"
A, B, C = random_marker(0, 3), random_marker(2, 2), random_marker(1, 3)


def jointed(stiffness=30.0, scale=1.0):
    """A flexible body on a pin, a rigid one on a line, a flexible one welded to that, and a spring between the ends."""
    bodies = (random_body(0, 3), Body(1.0, 0.1), random_body(2, 2))
    bodies = eqx.tree_at(lambda bodies: bodies[0].modes.mass_matrix, bodies, replace_fn=lambda mass: scale * mass)
    joints = (
        Revolute(GROUND, 0, (0.1, 0.2), A),
        PointOnLine(0, 1, C, (0.2, -0.3), (0.6, 0.8)),
        Weld(1, 2, (0.3, 0.1), B, 0.3),
    )
    return System(bodies, joints, (AxialSpringDamper(0, 2, C, B, stiffness, 0.5, 0.7),))


def bars():
    """Bars in mean axes, whose blocks are diagonal but for one row."""
    bar = free_bar(Bar.rectangle(0.5, 0.02, 0.01, 2700.0, 7e6), 2, 1)
    body = FlexibleBody(bar.modes)
    return System((body, Body(0.2, 0.01), body), (Revolute(0, 1, bar.end), Revolute(1, 2, (0.1, 0.0), bar.start)))


def free():
    return System((random_body(0, 3), Body(1.0, 0.1)))


SYSTEMS = {"jointed": jointed, "bars": bars, "free": free}


def random_motion(system, seed=1):
    rng = np.random.default_rng(seed)
    return (0.3 * rng.normal(size=system.coordinates) for _ in range(2))


@pytest.mark.quick
@pytest.mark.parametrize("name", SYSTEMS)
def test_motion_solves_the_augmented_system(name, evidence):
    system = SYSTEMS[name]()
    q, v = random_motion(system)
    kin = system.kinematics(jnp.asarray(q), jnp.asarray(v))
    mass, found = dense_mass(system, kin), system.constraints(kin)
    jacobian, alpha, rows = np.asarray(found.jacobian), system.stabilisation, len(found.phi)
    matrix = np.block([[mass, jacobian.T], [jacobian, np.zeros((rows, rows))]])
    rhs = np.asarray(found.gamma) - 2 * alpha * (jacobian @ np.asarray(v)) - alpha**2 * np.asarray(found.phi)
    expected = np.linalg.solve(matrix, np.concatenate([system.generalised_force(kin), rhs]))
    motion = system.motion(kin)
    for ours, dense in zip(motion, np.split(expected, [system.coordinates]), strict=True):
        error = np.max(np.abs(np.asarray(ours) - dense), initial=0.0) / np.max(np.abs(dense), initial=1e-300)
        bound = np.linalg.cond(matrix) * 2.3e-16
        claim = "augmented solve, of the condition number times rounding"
        evidence(TOPIC, claim, error / bound, 1.0, "numpy.linalg.solve", detail=name)


@eqx.filter_jit
def constraint_errors(system, q, v):
    """Φ, Φ̇ and Φ̈ along the motion."""
    acceleration = system.motion(system.kinematics(q, v)).acceleration

    def phi(q):
        return system.errors(system.kinematics(q, v))

    def rate(q, v):
        return jax.jvp(phi, (q,), (v,))[1]

    return phi(q), *jax.jvp(rate, (q, v), (v, acceleration))


@pytest.mark.parametrize("name", ["jointed", "bars"])
def test_constraint_errors_decay_as_baumgarte_asks(name):
    """Φ̈ + 2α Φ̇ + α² Φ = 0 along the motion."""
    system = eqx.filter_jit(SYSTEMS[name])()
    phi, first, second = map(np.asarray, constraint_errors(system, *random_motion(system, 2)))
    alpha = system.stabilisation
    left = second + 2 * alpha * first + alpha**2 * phi
    np.testing.assert_allclose(left, 0.0, atol=1e-11 * np.max(np.abs(second)))


CHANGES = ["q", "v", "stiffness", "modal mass"]


@jax.jit
def solution_and_tangent(s, change, q, v, along):
    """Accelerations and multipliers where ``change``, one for that of `CHANGES`, goes by ``s``, and their slopes."""

    def solution(s):
        of_q, of_v, of_stiffness, of_mass = s * change
        changed = jointed(30.0 + 10.0 * of_stiffness, 1.0 + of_mass)
        return jnp.concatenate(changed.motion(changed.kinematics(q + of_q * along, v + of_v * along)))

    return jax.jvp(solution, (s,), (jnp.ones(()),))


@pytest.mark.parametrize("by", CHANGES)
def test_derivatives_of_the_solution(by, evidence):
    """The small change that solves the same system against central differences of fourth order."""
    q, v = random_motion(jointed(), 3)
    along = np.random.default_rng(4).normal(size=q.size)
    change = np.array([float(by == one) for one in CHANGES])

    def solution(s):
        return np.asarray(solution_and_tangent(s, change, q, v, along)[0])

    tangent = solution_and_tangent(0.0, change, q, v, along)[1]
    h = 1e-3
    far, near = ((solution(s) - solution(-s)) / (2 * s) for s in (2 * h, h))
    differences = (4 * near - far) / 3
    error = np.max(np.abs(np.asarray(tangent) - differences)) / np.max(np.abs(differences))
    evidence(TOPIC, "derivatives of the augmented solve, relative", error, 1e-7, "central differences", detail=by)


@pytest.mark.quick
@pytest.mark.parametrize("proportional", [False, True])
def test_springs_make_the_stiffness_matrix(proportional):
    """Σ k b bᵀ = K; with a damping matrix that is a multiple of K, Σ c b bᵀ = C too."""
    body = random_body(3, 4)
    if proportional:
        body = eqx.tree_at(lambda body: body.modes.damping, body, 0.01 * body.modes.stiffness)
    system = System((Body(1.0, 0.1), body))
    springs = body.springs(1)
    along = np.stack([system.direction(spring.blocks) for spring in springs])
    assert not along[:, :6].any()
    stiffness = sum(s.stiffness * np.outer(b, b) for s, b in zip(springs, along, strict=True))
    np.testing.assert_allclose(stiffness[6:, 6:], body.modes.stiffness, rtol=1e-13, atol=1e-12)
    if proportional:
        damping = sum(s.damping * np.outer(b, b) for s, b in zip(springs, along, strict=True))
        np.testing.assert_allclose(damping[6:, 6:], body.modes.damping, rtol=1e-12, atol=1e-13)


def test_springs_of_orthogonal_modes_are_the_modes():
    bar = Bar.rectangle(0.5, 0.02, 0.01, 2700.0, 7e6)
    body = FlexibleBody(eqx.filter_jit(free_bar)(bar, 2, damping_ratio=0.02).modes)
    assert body.modes.orthogonal
    for k, spring in enumerate(body.springs(0)):
        assert spring.blocks[0][3:] == tuple(float(j == k) for j in range(4))
        assert (spring.stiffness, spring.damping) == (body.modes.stiffness[k, k], body.modes.damping[k, k])


def test_a_rigid_bodys_inverse_masses_beside_a_flexible_one():
    """1/m, 1/m and 1/J of 4 kg and 0.5 kg m²; the other's stand in for blocks and need only be numbers."""
    inverse = np.asarray(System((Body(4.0, 0.5), random_body(0, 3))).inverse_masses)
    np.testing.assert_allclose(inverse[:3], [0.25, 0.25, 2.0], rtol=1e-15)
    assert np.all(np.isfinite(inverse))


def test_the_kinetic_energy_of_a_flexible_body_that_moves_without_turning_or_bending():
    """Half its mass times 5² m²/s²."""
    body = random_body(0, 3)
    speeds = np.array([3.0, -4.0, 0.0, 0.0, 0.0, 0.0])

    @jax.jit
    def kinetic_energy(speeds):
        frame = System((body,)).kinematics(jnp.zeros(6), speeds).frame(0)
        return body.kinetic_energy(frame, jnp.zeros(3), jnp.zeros(3))

    found = kinetic_energy(speeds)
    np.testing.assert_allclose(found, 12.5 * float(body.mass), rtol=1e-14)
