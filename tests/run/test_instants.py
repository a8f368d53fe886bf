"""A run's history between its steps: the polynomials, the blocks, straight lines, and a bar that swings."""

from types import SimpleNamespace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jaxbuffer as jb
from jaxbuffer.hybrid.hermite import quintic
from jaxbuffer.mechanisms.bar_drop import BAR_DROP
from jaxbuffer.run.history import history_at
from jaxbuffer.run.instants import BLOCK, _blocks, _instants, _straight, at_times
from made_up import END, made_up_capture

START, LENGTH = 0.7, 0.3  # s


@eqx.filter_jit
def bar_at_start(parameters):
    """The first state, which contacts are closed, and how many coordinates there are."""
    system = BAR_DROP.system(*parameters)
    at, closed = system.first_evaluation()
    return at.state, closed, system.coordinates


@eqx.filter_jit
def rate_of_bar(parameters, state, closed):
    return BAR_DROP.system(*parameters).derivative(0.0, state, closed)


@pytest.mark.parametrize("share", [0.0, 0.15, 0.5, 0.8, 1.0])
def test_a_quintic_is_met_everywhere(share):
    polynomial = np.polynomial.Polynomial([2.0, -1.0, 3.0, 0.5, -4.0, 1.5])
    ends = [[jnp.array([float(polynomial.deriv(k)(time)) if k else float(polynomial(time))]) for k in range(3)]
            for time in (START, START + LENGTH)]  # fmt: skip
    value, rate = quintic(*ends, jnp.asarray(LENGTH), jnp.asarray(share))
    np.testing.assert_allclose(value, polynomial(START + share * LENGTH), rtol=1e-12)
    np.testing.assert_allclose(rate, polynomial.deriv()(START + share * LENGTH), rtol=1e-11)


def test_straight_lines():
    """Of numbers and of rows of them."""
    first, after, share = np.array([0, 1]), np.array([1, 2]), np.array([0.25, 0.5])
    np.testing.assert_allclose(_straight(np.array([1.0, 3.0, 7.0]), first, after, share), [1.5, 5.0])
    rows = np.array([[[0.0, 1.0]], [[4.0, 1.0]], [[6.0, -1.0]]])
    np.testing.assert_allclose(_straight(rows, first, after, share), [[[1.0, 1.0]], [[5.0, 0.0]]])


@pytest.mark.parametrize("count", [1, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK])
def test_blocks_of_one_size_hold_every_row_in_order(count):
    numbers = np.arange(count)
    blocks = [block for (block,) in _blocks((numbers,), count)]
    assert len(blocks) == -(-count // BLOCK)
    assert {block.size for block in blocks} == {BLOCK}
    joined = np.concatenate(blocks)
    np.testing.assert_array_equal(joined[:count], numbers)
    assert np.all(joined[count:] == count - 1)


def test_a_history_without_states_is_followed_in_straight_lines():
    run = made_up_capture()
    time = np.asarray(run.history.time)
    wanted = np.array([-1.0, 0.0, 0.3 * time[1], 0.25 * time[7] + 0.75 * time[8], END, END + 1.0])
    found = at_times(run, wanted)
    held = np.clip(wanted, 0.0, END)
    np.testing.assert_allclose(found.time, held, atol=1e-15)
    np.testing.assert_allclose(found.stroke, 0.0075 * held / END, atol=1e-15)
    np.testing.assert_allclose(found.energy.lost["friction"], 0.2 * held / END, atol=1e-15)
    np.testing.assert_allclose(found.contact_force[:, 1], np.interp(held, time, run.history.contact_force[:, 1]))


def test_at_the_one_step_of_a_run_that_ends_at_once():
    run = made_up_capture()
    first = jax.tree.map(lambda values: values[:1], run.history)
    found = at_times(SimpleNamespace(history=first), np.array([0.0, 1.0]))
    np.testing.assert_array_equal(found.time, [0.0, 0.0])


@pytest.mark.slow
def test_between_the_steps_of_a_swinging_bar():
    """Positions by a quintic, speeds by a cubic: errors go at least with the sixth and the fourth power
    of a step."""
    parameters = (jb.BarDrop(), jb.BarDropScenario(height=0.194), jnp.asarray(20.0))
    system = BAR_DROP.system(*parameters)
    posture, closed = system.first_evaluation()
    n, rate = system.coordinates, jax.jit(lambda time, state: system.derivative(time, state, closed))
    exact = solve_ivp(rate, (0.0, 0.2), posture.state, "DOP853", rtol=1e-12, atol=1e-14, dense_output=True).sol
    errors, start = [], 0.04
    for length in (0.16, 0.08):
        times = start + length * np.array([0.0, 0.2, 0.5, 0.7, 1.0])
        ends = exact(start), exact(start + length)
        each = [np.broadcast_to(x, (times.size, *np.shape(x))) for x in (closed, *ends)]
        found = _instants(BAR_DROP, parameters, 0.0 * times + start, 0.0 * times + start + length, times, *each)
        there = exact(times).T
        off = np.abs(np.asarray(found.state) - there)
        errors.append([np.max(off[:, :n]), np.max(off[:, n : 2 * n])])
        np.testing.assert_allclose(found.time, times)
        np.testing.assert_allclose(off[[0, -1]], 0.0, atol=1e-9)
        seen = history_at(system, jnp.asarray(times[2]), closed, found.state[2])
        np.testing.assert_allclose(found.gap[2], seen.gap, atol=1e-12)
    assert np.all(np.log2(np.divide(*errors)) > [5.5, 3.5])


@pytest.mark.parametrize("length", [1e-14, 1e-12, 1e-9, 1e-6])
def test_between_steps_that_are_as_short_as_a_rounding_of_time(length):
    """A bar swings about a pin; a step that ends at a maximum may be that short, and positions are rounded."""
    parameters = (jb.BarDrop(), jb.BarDropScenario(height=0.194), jnp.asarray(20.0))
    start, closed, n = bar_at_start(parameters)
    state, x = np.array(start), np.array([0.0, 0.3, 0.7, 1.0])
    state[n : 2 * n] = 1.0  # m/s, rad/s
    rate = np.asarray(rate_of_bar(parameters, state, closed))
    end = state + length * rate
    each = [np.broadcast_to(it, (x.size, *np.shape(it))) for it in (closed, state, end)]
    found = _instants(BAR_DROP, parameters, 0.0 * x, 0.0 * x + length, length * x, *each)
    expected = state[n : 2 * n] + length * x[:, None] * rate[n : 2 * n]
    np.testing.assert_allclose(np.asarray(found.state)[:, n : 2 * n], expected, rtol=1e-6)
