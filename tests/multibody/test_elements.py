"""Force elements: loads follow from energies, power balances, and internal forces conserve momentum."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.multibody import (
    GROUND,
    AppliedForce,
    AppliedTorque,
    AxialSpringDamper,
    Body,
    Kinematics,
    System,
    TorsionalSpringDamper,
)

ENDS = {"both bodies": (0, 1), "swapped": (1, 0), "ground first": (GROUND, 1), "ground second": (0, GROUND)}


def axial(i, j, damping=0.0, published=False):
    return AxialSpringDamper(i, j, (0.2, -0.3), (-0.1, 0.4), 170.0, damping, 0.6, published_damping=published)


def torsional(i, j, damping=0.0):
    return TorsionalSpringDamper(i, j, 23.0, damping, angle=0.7)


INTERNAL = {"axial": axial, "torsional": torsional}
APPLIED = {"force": AppliedForce(1, (3.0, -5.0), (0.3, 0.2)), "torque": AppliedTorque(0, -1.7)}

each_internal = pytest.mark.parametrize("kind", INTERNAL)
each_ends = pytest.mark.parametrize("ends", ENDS)


def random_motion(seed=0):
    rng = np.random.default_rng(seed)
    return jnp.asarray(rng.normal(size=6)), jnp.asarray(rng.normal(size=6))


def force_of(element, q, v):
    """Generalised force of a single element on two bodies."""
    return System((Body(1.0, 1.0), Body(1.0, 1.0)), (), (element,)).generalised_force(Kinematics(q, v))


def energy_of(element, q):
    return element.energy(Kinematics(q, jnp.zeros_like(q)))


@each_internal
@each_ends
def test_conservative_loads_are_minus_the_energy_gradient(kind, ends):
    q, v = random_motion()
    element = INTERNAL[kind](*ENDS[ends])
    expected = -jax.grad(lambda q: energy_of(element, q))(q)
    np.testing.assert_allclose(force_of(element, q, v), expected, rtol=1e-13, atol=1e-12)


@pytest.mark.parametrize("kind", APPLIED)
def test_applied_loads_are_minus_the_energy_gradient(kind):
    q, v = random_motion()
    expected = -jax.grad(lambda q: energy_of(APPLIED[kind], q))(q)
    np.testing.assert_allclose(force_of(APPLIED[kind], q, v), expected, rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize("published", [False, True])
@each_ends
def test_axial_power_is_what_the_store_loses_and_the_damper_takes(ends, published):
    q, v = random_motion(1)
    element = axial(*ENDS[ends], damping=8.0, published=published)
    assert_balanced(element, q, v)


@each_ends
def test_torsional_power_is_what_the_store_loses_and_the_damper_takes(ends):
    q, v = random_motion(2)
    assert_balanced(torsional(*ENDS[ends], damping=1.9), q, v)


def assert_balanced(element, q, v):
    power = jnp.sum(force_of(element, q, v) * v)
    stored = jax.jvp(lambda q: energy_of(element, q), (q,), (v,))[1]
    lost = element.dissipation(Kinematics(q, v))
    assert float(lost) > 0.1
    np.testing.assert_allclose(power, -stored - lost, rtol=1e-12)


@each_internal
def test_internal_loads_conserve_linear_and_angular_momentum(kind):
    q, v = random_motion(3)
    # Forces of some 200 N with arms of some 1 m: a few roundings.
    force, moment = total(INTERNAL[kind](0, 1, 5.0), q, v)
    np.testing.assert_allclose(force, 0.0, atol=1e-12)
    np.testing.assert_allclose(moment, 0.0, atol=1e-12)


def test_published_damping_turns_the_pair():
    """The paper's Rayleigh function pulls along Ḋ, not D. A couple c D × Ḋ is left, so angular momentum is lost."""
    q, v = random_motion(4)
    element = axial(0, 1, damping=5.0, published=True)
    force, moment = total(element, q, v)
    state = element.state(Kinematics(q, v))
    couple = -5.0 * (state.along * state.length).cross(state.separation_rate)
    np.testing.assert_allclose(force, 0.0, atol=1e-13)
    np.testing.assert_allclose(moment, couple, rtol=1e-12)
    assert abs(float(moment)) > 0.5


def total(element, q, v):
    """Sum of forces, and of moments about the inertial origin."""
    force = np.asarray(force_of(element, q, v)).reshape(2, 3)
    x, y = np.asarray(q)[0::3], np.asarray(q)[1::3]
    return force[:, :2].sum(0), np.sum(x * force[:, 1] - y * force[:, 0] + force[:, 2])


def test_axial_tension_of_a_stretched_and_stretching_spring():
    """Bodies at rest angle 5 m apart with points at their centres, parting at 2 m/s: f = 10·(5 - 3) + 4·2."""
    element = AxialSpringDamper(0, 1, (0.0, 0.0), (0.0, 0.0), 10.0, 4.0, 3.0)
    q, v = jnp.array([0.0, 0.0, 0.3, 3.0, 4.0, -0.2]), jnp.array([0.0, 0.0, 7.0, 1.2, 1.6, 9.0])
    np.testing.assert_allclose(element.tension(Kinematics(q, v)), 28.0, rtol=1e-15)
    np.testing.assert_allclose(force_of(element, q, v), [16.8, 22.4, 0.0, -16.8, -22.4, 0.0], rtol=1e-14, atol=1e-14)


def test_torsional_torque_restores_and_resists():
    """-k (θ_j - θ_i - angle) - c (θ̇_j - θ̇_i) = -2·(0.9 - 0.2 - 0.1) - 0.5·(3 - 1)."""
    element = TorsionalSpringDamper(0, 1, 2.0, 0.5, angle=0.1)
    q, v = jnp.array([0.0, 0.0, 0.2, 0.0, 0.0, 0.9]), jnp.array([0.0, 0.0, 1.0, 0.0, 0.0, 3.0])
    np.testing.assert_allclose(force_of(element, q, v), [0, 0, 2.2, 0, 0, -2.2], rtol=1e-15)
