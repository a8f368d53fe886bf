"""Force elements in space: power balances at random motions, momentum, and the angles of a cross."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jaxbuffer.multibody import (
    GROUND,
    AppliedForce,
    AxialSpringDamper,
    Body,
    CrossSpringDamper,
    Prismatic,
    System,
    TorsionalSpringDamper,
    Universal,
    assemble,
)
from jaxbuffer.space import SPACE
from multibody.spatial import random_positions, random_velocities

A, B = (0.2, -0.3, 0.1), (-0.1, 0.4, 0.3)
ELEMENTS = {
    "axial": lambda i, j: AxialSpringDamper(i, j, A, B, 170.0, 8.0, 0.6),
    "guided": lambda i, j: AxialSpringDamper(i, j, A, B, 170.0, 8.0, 0.6, guide=(1.0, 0.0, 0.0)),
    "torsional": lambda i, j: TorsionalSpringDamper(i, j, 23.0, 1.9),
    "cross": lambda i, j: CrossSpringDamper(i, j, 23.0, 1.9),
}
PAIR = (Body(1.0, (0.1, 0.2, 0.25)), Body(2.0, (0.3, 0.25, 0.4)))

each_element = pytest.mark.parametrize("kind", ELEMENTS)


def held(kind, ends):
    """A system of two bodies and one element; with a cross or a guide, the joint that it belongs to."""
    joints = {"cross": (Universal(*ends, A, B),), "guided": (Prismatic(*ends, A, B),)}.get(kind, ())
    return System(PAIR, joints, (ELEMENTS[kind](*ends),), basis=SPACE)


def motion_of(system, seed):
    q, v = random_positions(seed, 2), random_velocities(seed, 2)
    return assemble(system, q, v, iterations=10)


@pytest.mark.slow
@each_element
@pytest.mark.parametrize(
    "ends", [(0, 1), pytest.param((GROUND, 1), marks=pytest.mark.slow)], ids=["both bodies", "ground"]
)
def test_power_is_what_the_store_loses_and_the_damper_takes(kind, ends):
    system = held(kind, ends)
    q, v = motion_of(system, 1)
    (element,), kin = system.forces, system.kinematics(q, v)
    # all but the gyroscopic moments, which do no work
    power = sum(
        np.dot([*load.force, *load.moment], v[6 * load.body : 6 * load.body + 6])
        for load in element.loads(kin)
        if load.body != GROUND
    )
    stored = jax.jvp(lambda q: element.energy(system.kinematics(q, v)), (q,), (system.position_rate(q).of(v),))[1]
    lost = element.dissipation(kin)
    assert float(lost) > 0.01
    np.testing.assert_allclose(power, -stored - lost, rtol=1e-11)
    np.testing.assert_allclose(system.generalised_force(kin) @ v, power, rtol=1e-11)


@each_element
def test_internal_loads_conserve_linear_and_angular_momentum(kind):
    system = held(kind, (0, 1))
    q, v = motion_of(system, 2)
    kin = system.kinematics(q, v)
    loads = system.forces[0].loads(kin)
    np.testing.assert_allclose(sum(np.array(load.force) for load in loads), 0.0, atol=1e-12)
    moments = (np.array(load.moment) + np.cross(q[7 * load.body : 7 * load.body + 3], load.force) for load in loads)
    np.testing.assert_allclose(sum(moments), 0.0, atol=1e-12)


@pytest.mark.slow
@each_element
def test_directions_of_springs_are_how_their_dampers_act(kind):
    """Σ c b bᵀ v over a linear element's directions is what its damper alone exerts."""
    system = held(kind, (0, 1))
    q, v = motion_of(system, 3)
    kin, still = system.kinematics(q, v), system.kinematics(q, 0.0 * v)
    directions = jnp.stack([system.direction(spring.blocks) for spring in system.springs(kin)])
    damping = system.springs(kin)[0].damping
    free = System(PAIR, (), system.forces, basis=SPACE)
    gyroscopic = System(PAIR, basis=SPACE).generalised_force(kin)
    damper = free.generalised_force(kin) - gyroscopic - free.generalised_force(still)
    np.testing.assert_allclose(-damping * directions.T @ (directions @ v), damper, rtol=1e-10, atol=1e-12)


def test_the_angles_of_a_cross():
    """R_j = R_i R_y(α) R_z(β), with both rates; the torques are about y of the first body and z of the second."""
    alpha, beta, rates = 0.7, -1.1, (0.4, -0.6)
    first = Rotation.from_rotvec([0.3, -0.4, 0.8])
    second = first * Rotation.from_euler("YZ", [alpha, beta])
    spin = np.array([0.5, 1.5, -0.7])
    y, z = first.apply([0.0, 1.0, 0.0]), second.apply([0.0, 0.0, 1.0])
    turned = spin + rates[0] * y + rates[1] * z
    q = jnp.array([0.0, 0, 0, *first.as_quat(scalar_first=True), 0, 0, 0, *second.as_quat(scalar_first=True)])
    v = jnp.array([0.0, 0, 0, *spin, 0, 0, 0, *turned])
    element, system = CrossSpringDamper(0, 1, 23.0, 1.9), System(PAIR, basis=SPACE)
    state = element.state(system.kinematics(q, v))
    np.testing.assert_allclose(state.angles, (alpha, beta), atol=1e-14)
    np.testing.assert_allclose(state.rates, rates, atol=1e-14)
    torque = -(23.0 * alpha + 1.9 * rates[0]) * y - (23.0 * beta + 1.9 * rates[1]) * z
    np.testing.assert_allclose(element.loads(system.kinematics(q, v))[1].moment, torque, atol=1e-12)


def test_a_weight_and_its_energy():
    system = System(PAIR, (), (AppliedForce(1, (0.3, -2.0, -9.0), A),), basis=SPACE)
    q, v = random_positions(4, 2), random_velocities(4, 2)
    energy = lambda q: system.stored_energy(system.kinematics(q, v))  # noqa: E731
    lost = jax.jvp(energy, (q,), (system.position_rate(q).of(v),))[1]
    np.testing.assert_allclose(system.generalised_force(system.kinematics(q, v)) @ v, -lost, rtol=1e-12)
