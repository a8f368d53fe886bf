"""The equations of motion know no preferred place, direction, side or speed of reference."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from mechanisms.states import PLACES, mechanism, pressed

few = settings(max_examples=15, deadline=None, derandomize=True)
angles = st.floats(-np.pi, np.pi)
lengths = st.floats(-3.0, 3.0)
speeds = st.floats(-2.0, 2.0)
places = st.sampled_from(PLACES)
seeds = st.integers(0, 10_000)
tips = st.booleans()

VECTORS = np.arange(8).reshape(4, 2) + np.arange(4)[:, None]  # where (x, y) of the four bodies are in q
TURNS = np.arange(2, 12, 3)
LOSSES = ("axial_damper", "torsional_damper", "hysteresis", "friction")


@functools.cache
def compiled(free):
    """Accelerations with the tip's, rates of the losses, and contact forces, of a state and its closed contacts."""
    assembled = mechanism(free)

    @jax.jit
    def evaluated(state, active):
        rate = assembled.derivative(0.0, state, active)
        forces = assembled.contact_forces(assembled.evaluate(state), active)[0]
        lost = dict(zip(assembled.loss_names, assembled.part(rate, "lost"), strict=True))
        losses = jnp.stack([lost[name] for name in LOSSES])
        return rate[12 : 24 + assembled.spins], losses, forces.normal, forces.friction

    return evaluated


def evaluate(free, state, active):
    return [np.array(each) for each in compiled(free)(state, active)]


def assert_same(seen, expected, relative):
    for ours, theirs in zip(seen, map(np.asarray, expected), strict=True):
        assert_allclose(ours, theirs, rtol=relative, atol=relative * max(np.max(np.abs(theirs)), 1e-3))


@pytest.mark.quick
@few
@given(tips, places, seeds)
def test_mirror_image_swaps_the_flanks(free, place, seed):
    assembled = mechanism(free)
    state, active = pressed(assembled, place, seed)
    mirrored = np.array(state)
    odd = [k + offset for offset in (0, 12) for body in range(4) for k in (3 * body + 1, 3 * body + 2)]
    mirrored[odd + [24] * free] *= -1.0
    mirrored[-2:] = mirrored[:-3:-1]
    acceleration, losses, normal, friction = evaluate(free, state, active)
    flipped = acceleration.copy()
    flipped[[k for k in odd if k < 12] + [12] * free] *= -1.0
    seen = evaluate(free, jnp.asarray(mirrored), active[::-1])
    assert_same(seen, (flipped, losses, normal[::-1], friction[::-1]), 1e-14)
    assert float(jnp.max(normal)) > 1.0


@few
@given(tips, places, seeds, angles, lengths, lengths)
def test_frame_may_be_turned_and_moved(free, place, seed, angle, x, y):
    """To the rounding of the penetration, some 1e-15 m of some µm when positions are metres."""
    assembled = mechanism(free)
    state, active = pressed(assembled, place, seed)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def turned(values):
        values = np.array(values)
        values[VECTORS] = values[VECTORS] @ turn.T
        return values

    moved = np.array(state)
    moved[:12], moved[12:24] = turned(moved[:12]), turned(moved[12:24])
    moved[VECTORS] += [x, y]
    moved[TURNS] += angle
    acceleration, *rest = evaluate(free, state, active)
    seen = evaluate(free, jnp.asarray(moved), active)
    assert_same(seen, (turned(acceleration), *rest), 2e-9)


@pytest.mark.quick
@few
@given(tips, places, seeds, speeds, speeds)
def test_frame_may_travel(free, place, seed, u, v):
    """Galilean invariance: a common velocity changes no force (the paper's published damping has it too)."""
    assembled = mechanism(free)
    state, active = pressed(assembled, place, seed)
    boosted = np.array(state)
    boosted[12 + VECTORS] += [u, v]
    seen = evaluate(free, jnp.asarray(boosted), active)
    assert_same(seen, evaluate(free, state, active), 1e-11)


@few
@given(places, seeds, st.floats(0.3, 3.0))
def test_stopped_motion_has_no_loss_and_scaled_motion_scales_the_dampers(place, seed, factor):
    """Damper powers go as the square of the velocities, whatever the state."""
    assembled = mechanism(False)
    state, active = pressed(assembled, place, seed)

    def damped(scale):
        moving = jnp.concatenate([state[:12], scale * state[12:24], state[24:]])
        return evaluate(False, moving, active)[1]

    assert_allclose(damped(0.0), 0.0, atol=0.0)
    assert_allclose(damped(factor)[:2], factor**2 * damped(1.0)[:2], rtol=1e-12)
