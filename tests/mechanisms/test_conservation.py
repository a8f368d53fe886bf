"""What the equations of motion conserve at every instant, and which published simplifications break it."""

import equinox as eqx
import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

from in_short import quick
from mechanisms.states import PLACES, TIPS, mechanism, pressed

each_place = pytest.mark.parametrize("place", PLACES)
each_tip = pytest.mark.parametrize("tip", TIPS)
each_seed = pytest.mark.parametrize("seed", quick(range(3), 0))


@eqx.filter_jit  # once for all states and places of a mechanism
def rate_of(assembled, state, active):
    return assembled.derivative(0.0, state, active)


@eqx.filter_jit
def energy_flows(assembled, state, active):
    rate = assembled.derivative(0.0, state, active)
    _, flows = jax.jvp(lambda y: assembled.energy_at(assembled.evaluate(y), active), (state,), (rate,))
    return flows


@eqx.filter_jit
def damper_arm_and_rate(assembled, state):
    """D and Ḋ between the buffer's ends."""
    axial = assembled.element("buffer").force.state(assembled.kinematics(state))
    return [*(axial.along * axial.length)], [*axial.separation_rate]


@eqx.filter_jit
def looked_at(assembled, state, active):
    """Everything evaluated at a state, and the forces of the contacts."""
    at = assembled.evaluate(state)
    return at, assembled.contact_forces(at, active)[0]


def momentum_rates(assembled, state, active):
    """Rates of linear momentum [N] and of angular momentum about the origin [N m], and the largest force [N]."""
    rate = np.asarray(rate_of(assembled, state, active))
    force = np.asarray(assembled.system.masses()) * rate[12:24]
    x, y = np.asarray(state)[:12].reshape(4, 3)[:, :2].T
    angular = np.sum(x * force[1::3] - y * force[0::3] + force[2::3])
    if assembled.spins:
        angular += assembled.parts.probe.tip_inertia * rate[24]
    return np.array([force[0::3].sum(), force[1::3].sum()]), angular, np.max(np.abs(force))


def energy_rate(assembled, state, active):
    """d/dt of everything stored and everything lost [W], and the size of the flows it is made of."""
    flows = jax.tree.leaves(energy_flows(assembled, state, active))
    return float(sum(flows)), max(abs(float(flow)) for flow in flows)


@pytest.mark.quick
@each_place
@each_tip
@each_seed
def test_momentum_is_conserved(place, tip, seed):
    """Measured: 3e-16 of the largest force, and of it times a metre."""
    assembled = mechanism(TIPS[tip])
    state, active = pressed(assembled, place, seed)
    linear, angular, largest = momentum_rates(assembled, state, active)
    assert largest > 10.0
    assert_allclose(linear, 0.0, atol=2e-15 * largest)
    assert_allclose(angular, 0.0, atol=2e-15 * largest)


@pytest.mark.quick
@each_place
@each_tip
@each_seed
def test_energy_is_balanced(place, tip, seed):
    """Kinetic, spring and contact energy lose what dampers, contact and friction take. Measured: 3e-15 of the flows."""
    assembled = mechanism(TIPS[tip])
    state, active = pressed(assembled, place, seed)
    rest, flow = energy_rate(assembled, state, active)
    assert flow > 0.1
    assert abs(rest) < 2e-14 * flow


@each_tip
def test_an_open_contact_exerts_nothing(tip):
    assembled = mechanism(TIPS[tip])
    state, _ = pressed(assembled, "lower flank", 0)
    state, rate = np.asarray(state), np.asarray(rate_of(assembled, state, np.zeros(2)))
    assert_allclose(rate[9:12], state[21:24], atol=0.0)
    assert_allclose(rate[21:24], 0.0, atol=0.0)
    assert_allclose(assembled.part(rate, "lost")[:2], 0.0, atol=0.0)


@each_seed
def test_published_damping_conserves_no_angular_momentum(seed):
    """The paper's damper pulls along Ḋ, the rate of the vector between its ends, instead of along D: the two ends'
    forces are opposite but not on one line, and the couple D × c Ḋ remains. Energy is still balanced."""
    assembled = mechanism(buffer_damping="published")
    state, active = pressed(assembled, "lower flank", seed)
    # The joints hold both ends on the cylinder's axis: Ḋ leaves D as the cylinder turns.
    linear, angular, largest = momentum_rates(assembled, state, active)
    (x, y), (rate_x, rate_y) = (map(float, vector) for vector in damper_arm_and_rate(assembled, state))
    couple = 40.0 * (x * rate_y - y * rate_x)
    assert_allclose(linear, 0.0, atol=2e-15 * largest)
    assert_allclose(angular, -couple, atol=1e-13 * largest)
    assert abs(couple) > 1e-4 * largest
    rest, flow = energy_rate(assembled, state, active)
    assert abs(rest) < 2e-14 * flow


@each_seed
@pytest.mark.parametrize("place", ["lower flank", "upper flank"])
def test_published_arms_conserve_no_angular_momentum(place, seed):
    """The paper lets the force act on the cone where first contact was, and on the probe at the tip's centre without
    the friction's moment about it: action and reaction are not on one line."""
    assembled = mechanism(contact_arms="published")
    state, active = pressed(assembled, place, seed)
    linear, angular, largest = momentum_rates(assembled, state, active)
    assert_allclose(linear, 0.0, atol=2e-15 * largest)

    at, forces = jax.tree.map(np.asarray, looked_at(assembled, state, active))
    kin, ball = at.kin, at.elements[0]
    k = PLACES.index(place)
    a = ball.approach
    push = np.array(
        [
            forces.normal[k] * a.normal.x[k] + forces.friction[k] * a.tangent.x[k],
            forces.normal[k] * a.normal.y[k] + forces.friction[k] * a.tangent.y[k],
        ]
    )
    half, side = np.sqrt(0.5), 1.0 - 2.0 * k
    local = np.array([-0.096 - 0.0435 * half, -side * (0.015 + 0.0435 * half)])  # first contact, b = 0.0435 m
    cos, sin = np.cos(kin.q[11]), np.sin(kin.q[11])
    frozen = kin.q[9:11] + np.array([[cos, -sin], [sin, cos]]) @ local
    arm = np.array(ball.centre.place) - frozen
    couple = arm[0] * push[1] - arm[1] * push[0]
    assert_allclose(angular, couple, atol=1e-13 * largest)
    assert abs(couple) > 1e-4 * largest
