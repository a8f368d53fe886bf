"""JAX's transformations change how a capture is computed and not what comes out."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxbuffer import Outcome, Scenario, replace, simulate, table2
from mechanisms.states import PLACES, mechanism, pressed

few = settings(max_examples=15, deadline=None, derandomize=True)
TOPIC = "JAX's transformations"


@jax.jit
def compiled(assembled, state, active):
    return assembled.derivative(jnp.zeros(()), state, active)


@pytest.mark.quick
@few
@given(st.booleans(), st.sampled_from(PLACES), st.integers(0, 10_000))
def test_compiled_derivative_is_the_eager_one(evidence, free, place, seed):
    """To the rounding of the penetration, 1e-16 m of some µm."""
    assembled = mechanism(free)
    state, active = pressed(assembled, place, seed)
    eager = np.asarray(assembled.derivative(jnp.zeros(()), state, active))
    off = np.max(np.abs(compiled(assembled, state, active) - eager)) / np.max(np.abs(eager))
    evidence(TOPIC, "jit is eager: the state's derivative", off, 1e-9, "eager evaluation")


@settings(few, max_examples=4)
@given(st.booleans(), st.integers(0, 10_000))
def test_batched_derivative_is_the_loop(evidence, free, seed):
    assembled = mechanism(free)
    states, active = zip(*(pressed(assembled, place, seed) for place in PLACES), strict=True)
    batch = jax.vmap(lambda y, a: assembled.derivative(jnp.zeros(()), y, a))(jnp.stack(states), jnp.stack(active))
    for k, (state, closed) in enumerate(zip(states, active, strict=True)):
        alone = np.asarray(assembled.derivative(jnp.zeros(()), state, closed))
        off = np.max(np.abs(batch[k] - alone)) / np.max(np.abs(alone))
        evidence(TOPIC, "vmap is the loop: the state's derivative", off, 1e-9, "the loop")


# Two programs round differently, which an adaptive step size amplifies up to its tolerance.
TIGHT = 1e-10
SCENARIOS = [(500.0, 0.1, 0.0), (500.0, 0.2, 0.05), (500.0, 0.27, -0.03)]  # N/m, m/s, rad
DESIGNS = [(300.0, 0.1, 0.0), SCENARIOS[0], (1200.0, 0.1, 0.0)]
FAILED = (np.nan, 0.1, 0.0)
LANES = [*SCENARIOS, DESIGNS[0], DESIGNS[2], (800.0, 0.2, 0.05), FAILED, (500.0, 0.15, -0.02)]
NUMBERS = ("peak_force", "peak_time", "peak_hinge_force", "stroke", "hinge_angle", "end_time", "contact_time")
COUNTS = ("code", "peak_flank", "peak_impact", "impact_count")


def simulated(stiffness, speed, misalignment):
    scenario = Scenario(approach_speed=speed, misalignment=misalignment)
    return simulate(replace(table2(), {"buffer.k_A": stiffness}), scenario, rtol=TIGHT)


@pytest.fixture(scope="module")
def batch():
    """All lanes by one program: each one's capture."""
    found = jax.vmap(simulated)(*map(jnp.array, zip(*LANES, strict=True)))
    return {lane: jax.tree.map(lambda leaf, k=k: np.asarray(leaf)[k], found) for k, lane in enumerate(LANES)}


def assert_equal_captures(evidence, claim, found, lane):
    """Outcome and counts equal, numbers within what rounding grows to over some ten impacts (measured 5e-8)."""
    alone = simulated(*lane)
    for name in COUNTS:
        assert int(getattr(found, name)) == int(getattr(alone, name)), name
    for name in ("peak_force", "end_time", "stroke", "hinge_angle"):
        off = abs(float(getattr(found, name)) / float(getattr(alone, name)) - 1.0)
        evidence(TOPIC, claim, off, 1e-6, "captures one by one", detail=name)


@pytest.mark.long
def test_captures_batched_over_scenarios_are_the_loop(evidence, batch):
    assert len({int(batch[lane].impact_count) for lane in SCENARIOS}) == 3
    for lane in SCENARIOS:
        assert_equal_captures(evidence, "vmap over scenarios is the loop: whole captures", batch[lane], lane)


@pytest.mark.slow
def test_captures_batched_over_designs_are_the_loop(evidence, batch):
    for lane in DESIGNS:
        assert_equal_captures(evidence, "vmap over designs is the loop: whole captures", batch[lane], lane)


def test_lanes_over_designs_and_scenarios_are_those_of_a_loop(batch):
    """Whatever one of them comes to."""
    failed = batch[FAILED]
    assert Outcome(int(failed.code)) == Outcome.failed_input
    assert all(np.isnan(getattr(failed, name)) for name in NUMBERS), "a failed lane says nothing"
    for lane in (lane for lane in LANES if lane is not FAILED):
        found, alone = batch[lane], simulated(*lane)
        for name in COUNTS:
            assert int(getattr(found, name)) == int(getattr(alone, name)), name
        for name in NUMBERS:
            np.testing.assert_allclose(getattr(found, name), getattr(alone, name), rtol=1e-8, err_msg=name)
        impacts = found.impacts.peak_force, alone.impacts.peak_force
        np.testing.assert_allclose(*impacts, rtol=1e-8, atol=1e-8 * float(alone.peak_force))


@pytest.mark.long
def test_a_capture_inside_an_outer_jit_is_the_same(evidence):
    lane = (800.0, 0.1, 0.0)
    assert_equal_captures(evidence, "a capture inside an outer jit is the same", jax.jit(simulated)(*lane), lane)
