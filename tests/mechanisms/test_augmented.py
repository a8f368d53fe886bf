"""The mechanism assembled from parts against the paper's equations written out: the 16 × 16 augmented system."""

import equinox as eqx
import numpy as np
import pytest
from numpy.testing import assert_allclose

from mechanisms.states import PLACES, TIPS, mechanism, pressed
from verification.exact_model import ExactModel

each_place = pytest.mark.parametrize("place", PLACES)
each_tip = pytest.mark.parametrize("tip", TIPS)
each_seed = pytest.mark.parametrize("seed", range(3))


def both(tip, place, seed):
    """The mechanism with its derivative, and the paper's equations at the same state, off the constraints."""
    assembled = mechanism(TIPS[tip], stabilisation=0.0)
    state, active = pressed(assembled, place, seed, consistent=False)
    exact = ExactModel(assembled.parts.design, assembled.parts.scenario)
    y = np.asarray(state)
    q, v, memory = y[:12], y[12 : 24 + assembled.spins], y[-2:]
    return assembled, state, active, exact, (q, v, memory)


@eqx.filter_jit  # once for all states and places of a mechanism
def motion(assembled, state, active):
    """Multipliers, rate of the state and forces of the contacts."""
    at = assembled.evaluate(state)
    rate = assembled.derivative(0.0, state, active)
    multipliers = assembled.forces(at, active).motion.multipliers
    return multipliers, rate, assembled.contact_forces(at, active)[0]


@eqx.filter_jit
def constraints(assembled, state):
    """Φ, Φ_q and γ of eq. 7."""
    return assembled.system.constraints(assembled.kinematics(state))[:3]


@eqx.filter_jit
def observables(assembled, state, active):
    return assembled.observables(state, assembled.derivative(0.0, state, active), active)


@eqx.filter_jit
def started(assembled):
    """The state at the start, and the speeds of approach that the contacts remember there."""
    state, _ = assembled.start()
    return state, assembled.memory(state)


def close(actual, expected, relative):
    assert_allclose(actual, expected, rtol=relative, atol=relative * np.max(np.abs(expected)))


@pytest.mark.quick
@each_place
@each_tip
@each_seed
def test_accelerations_and_multipliers(place, tip, seed):
    """The depth, some µm, is a difference of lengths: rounding of those is 1e-11 of it (measured: 9e-12)."""
    assembled, state, active, exact, at = both(tip, place, seed)
    acceleration, multipliers, touches = exact.motion(*at)
    assert max(touch.normal_force for touch in touches) > 10.0
    ours, rate, _ = motion(assembled, state, active)
    close(ours, multipliers, 5e-11)
    close(rate[12 : 24 + assembled.spins], acceleration, 5e-11)
    assert_allclose(rate[:12], at[1][:12], atol=0.0)


@each_place
@each_tip
def test_constraints(place, tip):
    assembled, state, _, exact, (q, v, _) = both(tip, place, 5)
    for ours, written in zip(constraints(assembled, state), exact.constraints(q, v), strict=True):
        assert_allclose(ours, written, atol=1e-15)


@pytest.mark.quick
@each_place
@each_tip
@each_seed
def test_contact_forces(place, tip, seed):
    assembled, state, active, exact, at = both(tip, place, seed)
    _, _, forces = motion(assembled, state, active)
    touches = exact.touches(*at)
    close(forces.normal, [touch.normal_force for touch in touches], 5e-11)
    close(forces.friction, [touch.friction_force for touch in touches], 5e-11)


@pytest.mark.quick
@each_place
@each_tip
@each_seed
def test_rates_of_the_losses(place, tip, seed):
    """c_A L̇², c_T (θ̇_B - θ̇_S)², (F_n - K δ^{3/2}) δ̇, -F_t v_t."""
    assembled, state, active, exact, (q, v, memory) = both(tip, place, seed)
    *_, rate = exact.buffer(q, v)
    touch = max(exact.touches(q, v, memory), key=lambda touch: touch.depth)
    design = assembled.parts.design
    expected = {
        "axial_damper": design.buffer.c_A * rate**2,
        "torsional_damper": design.buffer.c_T * (v[5] - v[2]) ** 2,
        "hysteresis": (touch.normal_force - exact.stiffness * touch.depth**1.5) * touch.rate,
        "friction": -touch.friction_force * touch.slip,
    }
    losses = assembled.part(np.asarray(motion(assembled, state, active)[1]), "lost")
    assert_allclose(losses, [expected[name] for name in assembled.loss_names], rtol=1e-9)
    assert min(expected.values()) > 0.0


@each_place
@each_tip
def test_observables(place, tip):
    assembled, state, active, exact, (q, v, memory) = both(tip, place, 7)
    seen = np.asarray(observables(assembled, state, active))
    names = ("lower", "upper", "hinge_force", "buffer_force", "stroke", "hinge_angle", "extension")
    expected = exact.quantities(np.concatenate([q, v]), memory)
    assert_allclose([seen[assembled.observed.index(name)] for name in names], expected, rtol=1e-9)


@each_tip
def test_start(tip):
    assembled = mechanism(TIPS[tip])
    state, memory = map(np.asarray, started(assembled))
    q, v, speed = ExactModel(assembled.parts.design, assembled.parts.scenario).start()
    assert_allclose(state[: 24 + assembled.spins], np.concatenate([q, v]), atol=1e-16)
    assert_allclose(memory[0], speed, rtol=1e-14)
