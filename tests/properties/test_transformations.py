"""JAX's transformations change how a capture is computed and not what comes out."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxbuffer import Scenario, replace, simulate, table2
from mechanisms.states import PLACES, mechanism, pressed

few = settings(max_examples=15, deadline=None, derandomize=True)
TOPIC = "JAX's transformations"
MECHANISMS = {free: mechanism(free) for free in (False, True)}


@jax.jit
def compiled(assembled, state, active):
    return assembled.derivative(jnp.zeros(()), state, active)


@few
@given(st.booleans(), st.sampled_from(PLACES), st.integers(0, 10_000))
def test_compiled_derivative_is_the_eager_one(evidence, free, place, seed):
    """To the rounding of the penetration, 1e-16 m of some µm."""
    assembled = MECHANISMS[free]
    state, active = pressed(assembled, place, seed)
    eager = np.asarray(assembled.derivative(jnp.zeros(()), state, active))
    off = np.max(np.abs(compiled(assembled, state, active) - eager)) / np.max(np.abs(eager))
    evidence(TOPIC, "jit is eager: the state's derivative", off, 1e-9, "eager evaluation")


@settings(few, max_examples=4)
@given(st.booleans(), st.integers(0, 10_000))
def test_batched_derivative_is_the_loop(evidence, free, seed):
    assembled = MECHANISMS[free]
    states, active = zip(*(pressed(assembled, place, seed) for place in PLACES), strict=True)
    batch = jax.vmap(lambda y, a: assembled.derivative(jnp.zeros(()), y, a))(jnp.stack(states), jnp.stack(active))
    for k, (state, closed) in enumerate(zip(states, active, strict=True)):
        alone = np.asarray(assembled.derivative(jnp.zeros(()), state, closed))
        off = np.max(np.abs(batch[k] - alone)) / np.max(np.abs(alone))
        evidence(TOPIC, "vmap is the loop: the state's derivative", off, 1e-9, "the loop")


# At the default tolerance a rounding that turns a step down moves the result by that tolerance, 1e-6.
TIGHT = 1e-9
SPEEDS, ANGLES = (0.1, 0.2, 0.27), (0.0, 0.05, -0.03)


@pytest.fixture(scope="module")
def one_by_one():
    scenarios = [Scenario(approach_speed=v, misalignment=a) for v, a in zip(SPEEDS, ANGLES, strict=True)]
    captures = [simulate(table2(), scenario, rtol=TIGHT) for scenario in scenarios]
    assert len({int(capture.impact_count) for capture in captures}) == 3
    return captures


def assert_equal_captures(evidence, claim, batch, captures):
    """Outcome and counts equal, numbers within what rounding grows to over some ten impacts (measured 5e-8)."""
    for k, capture in enumerate(captures):
        assert int(batch.code[k]) == int(capture.outcome)
        assert int(batch.impact_count[k]) == int(capture.impact_count)
        assert int(batch.peak_flank[k]) == int(capture.peak_flank)
        for name in ("peak_force", "end_time", "stroke", "hinge_angle"):
            off = abs(float(getattr(batch, name)[k]) / float(getattr(capture, name)) - 1.0)
            evidence(TOPIC, claim, off, 1e-6, "captures one by one", detail=name)


@pytest.mark.slow
def test_captures_batched_over_scenarios_are_the_loop(evidence, one_by_one):
    batch = jax.vmap(lambda v, a: simulate(table2(), Scenario(approach_speed=v, misalignment=a), rtol=TIGHT))(
        jnp.array(SPEEDS), jnp.array(ANGLES)
    )
    assert_equal_captures(evidence, "vmap over scenarios is the loop: whole captures", batch, one_by_one)


@pytest.mark.slow
def test_captures_batched_over_designs_are_the_loop(evidence):
    stiffness = (300.0, 500.0, 1200.0)
    batch = jax.vmap(lambda k: simulate(replace(table2(), {"buffer.k_A": k}), rtol=TIGHT))(jnp.array(stiffness))
    alone = [simulate(replace(table2(), {"buffer.k_A": k}), rtol=TIGHT) for k in stiffness]
    assert_equal_captures(evidence, "vmap over designs is the loop: whole captures", batch, alone)


@pytest.mark.slow
def test_a_capture_inside_an_outer_jit_is_the_same(evidence):
    inside = jax.jit(lambda k: simulate(replace(table2(), {"buffer.k_A": k}), rtol=TIGHT))(800.0)
    outside = simulate(replace(table2(), {"buffer.k_A": 800.0}), rtol=TIGHT)
    batch = jax.tree.map(lambda leaf: jnp.asarray(leaf)[None], inside)
    assert_equal_captures(evidence, "a capture inside an outer jit is the same", batch, [outside])
