"""Locating a guard's zero: how many steps it takes, by which rule the next is chosen, and what ends it."""

import jax
import numpy as np
import pytest

from jaxbuffer.hybrid.events.bracketing import MAX_TRIES, MAX_TRIES_MAXIMUM, Bracket, refine
from jaxbuffer.hybrid.events.crossing import Crossing
from jaxbuffer.hybrid.events.guards import SignedGuards

LENGTH, CLOSE = 1e-2, 1e-9  # s
GUARD, MAXIMUM = 0, 1


around, around_release = jax.jit(Bracket.around), jax.jit(Bracket.around_release)


@jax.jit
def shown(bracket, step, guards, shortfall, linear_time, rounding=0.0):
    return refine(bracket, step, guards, 1, CLOSE, shortfall, linear_time, rounding)


def begun(guard, first, value):
    """The bracket of an event found in a step, from both ends' values of the guard."""
    before, after = (np.array([value(x)] * 2) for x in (0.0, LENGTH))
    crossing = Crossing(np.asarray(guard), np.asarray(first), np.asarray(LENGTH), after[guard], np.asarray(True))
    return around(crossing, before, np.asarray(0))


def refined(bracket, value, rate, acceleration=0.0, shortfall=0.0, step=None, linear_time=LENGTH, rounding=0.0):
    """What a step of the bracket's length shows."""
    both = lambda number: np.array([number] * 2)  # noqa: E731
    guards = SignedGuards(both(value), both(rate), both(acceleration))
    step = bracket.step if step is None else np.asarray(step)
    return shown(bracket, step, guards, np.asarray(shortfall), np.asarray(linear_time), np.asarray(rounding))


def located(guard, first, value, rate, acceleration=lambda x: 0.0, shortfall=0.0):
    """The lengths tried, and what the last showed, where a step's length gives the guard this value and rate."""
    bracket, tried = begun(guard, first, value), []
    while True:
        x = float(bracket.step)
        tried.append(x)
        found = refined(bracket, value(x), rate(x) * (guard == GUARD), acceleration(x) * (guard == GUARD), shortfall)
        if found.finished:
            return tried, found
        bracket = found.bracket


def test_newtons_method_first():
    """Two tries by the guard's rate; the step's length becomes an end of the bracket."""
    bracket = begun(GUARD, 0.5 * LENGTH, lambda x: x - 0.3 * LENGTH)
    found = refined(bracket, value=2e-3, rate=2.0)
    assert not found.finished
    np.testing.assert_allclose(float(found.bracket.step), 0.5 * LENGTH - 1e-3, rtol=1e-12)
    np.testing.assert_allclose([found.bracket.low, found.bracket.high], [0.0, 0.5 * LENGTH])
    np.testing.assert_allclose([found.bracket.low_value, found.bracket.high_value], [-0.3 * LENGTH, 2e-3])
    assert int(found.bracket.tries) == 1


@pytest.mark.parametrize(("tries", "by"), [(1, "newton"), (2, "secant"), (3, "newton"), (4, "secant"), (5, "secant")])
def test_the_secant_takes_two_tries_of_three(tries, by):
    """From the third try on; of the bracket with this step as an end."""
    bracket = begun(GUARD, 0.5 * LENGTH, lambda x: x - 0.3 * LENGTH)._replace(tries=np.asarray(tries))
    found = refined(bracket, value=1e-3, rate=2.0)
    newton = 0.5 * LENGTH - 1e-3 / 2.0
    secant = 0.5 * LENGTH * 0.3 * LENGTH / (0.3 * LENGTH + 1e-3)
    np.testing.assert_allclose(float(found.bracket.step), {"newton": newton, "secant": secant}[by], rtol=1e-12)


@pytest.mark.parametrize(("value", "rate"), [(1e-3, 1e-3), (1e-3, -1.0), (-1e-3, np.nan)])
def test_the_middle_where_newtons_method_leaves_the_bracket(value, rate):
    """By far, the wrong way, or nowhere."""
    found = refined(begun(GUARD, 0.5 * LENGTH, lambda x: x - 0.3 * LENGTH), value, rate)
    np.testing.assert_allclose(float(found.bracket.step), LENGTH * (0.25 if value > 0.0 else 0.75), rtol=1e-12)


@pytest.mark.parametrize("rate", [-0.5, -1e-9, 0.0])
def test_where_a_guard_falls_there_is_no_event(rate):
    """However near its zero: it rises through the event that is sought."""
    found = refined(begun(GUARD, 0.5 * LENGTH, lambda x: x - 0.3 * LENGTH), value=1e-30, rate=rate)
    assert not found.converged
    assert not found.finished


def test_a_misleading_rate_does_not_hold_a_location_up():
    """An implicit step's error changes with its length too: the guard then goes on three times as fast as its rate at
    the step's end says, so that Newton's method overshoots threefold and bisection alone would take 23 tries."""
    zero, slope = 0.37 * LENGTH, 1e-3
    tried, found = located(GUARD, 0.3 * LENGTH, lambda x: 3.0 * slope * (x - zero), lambda x: slope)
    assert len(tried) <= 5
    assert bool(found.occurred)
    np.testing.assert_allclose(tried[-1], zero, atol=CLOSE)


@pytest.mark.parametrize("shortfall", [1e-3, 1e-6])
def test_a_maximum_is_as_close_as_its_height_needs(shortfall):
    """1 - ½ k (t - zero)²: where it may fall short by s, time may be off by √(2 s/k); the rest is stepped over. Its
    rate's rate k comes from the parabola through bracket and step."""
    zero, curvature = 0.37 * LENGTH, 1e6
    tried, found = located(MAXIMUM, 0.36 * LENGTH, lambda x: curvature * (x - zero), lambda x: 0.0, shortfall=shortfall)
    off = zero - tried[-1]
    assert abs(off) <= np.sqrt(2.0 * shortfall / curvature)
    np.testing.assert_allclose(float(found.offset), off, atol=1e-12)
    np.testing.assert_allclose(float(found.guard_rate), curvature, rtol=1e-9)
    assert len(tried) == (1 if 0.5 * curvature * (0.01 * LENGTH) ** 2 <= shortfall else 2)


@pytest.mark.parametrize(("linear_time", "near"), [(0.05 * LENGTH, False), (0.2 * LENGTH, True)])
def test_a_flat_maximum_is_moved_onto_no_farther_than_the_state_can_be(linear_time, near):
    """A tenth of the step behind its end, where any height will do: moved farther, what else is logged would be off."""
    bracket = begun(MAXIMUM, 0.5 * LENGTH, lambda x: x - 0.4 * LENGTH)
    found = refined(bracket, value=0.1 * LENGTH, rate=0.0, shortfall=1.0, linear_time=linear_time)
    assert found.converged
    np.testing.assert_allclose(float(found.offset), -0.1 * LENGTH * near, rtol=1e-12)


def test_a_guard_that_bends_is_met_at_once():
    """A parabola's second derivative is known: from a first guess that is off by a quarter, the next try ends on it."""
    speed, bend = 0.1, 30.0
    zero = 0.4 * LENGTH
    value = lambda x: speed * (x - zero) + 0.5 * bend * (x - zero) ** 2  # noqa: E731
    tried, found = located(GUARD, 0.3 * LENGTH, value, lambda x: speed + bend * (x - zero), lambda x: bend)
    assert len(tried) == 2
    np.testing.assert_allclose(tried[-1], zero, rtol=1e-12)
    assert float(found.offset) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(("guard", "patience"), [(GUARD, MAX_TRIES), (MAXIMUM, MAX_TRIES_MAXIMUM)])
@pytest.mark.parametrize("value", [-1e-3, 1e-3])
def test_patience_ends(guard, patience, value):
    """After so many tries, an event counts where the step ends beyond it, not where it ends before."""
    bracket = begun(guard, 0.5 * LENGTH, lambda x: x - 0.3 * LENGTH)
    one_left = refined(bracket._replace(tries=np.asarray(patience - 1)), value, 1.0)
    none_left = refined(bracket._replace(tries=np.asarray(patience)), value, 1.0)
    assert not one_left.finished
    assert none_left.finished
    assert not none_left.converged
    assert bool(none_left.occurred) == (value > 0.0)
    assert float(none_left.offset) == 0.0


def test_a_bracket_closed_up_is_as_near_as_it_gets():
    """Narrower than the tolerance, though the guard's value still jumps across it."""
    narrow = begun(GUARD, 0.5 * LENGTH, lambda x: x - 0.3 * LENGTH)
    narrow = narrow._replace(low=np.asarray(0.5 * LENGTH - 0.5 * CLOSE))
    found = refined(narrow, value=1e-3, rate=1.0)
    assert found.finished
    assert found.occurred
    assert not found.converged


def test_an_event_at_the_start_ends_at_once():
    """A contact missed by an earlier location's tolerance closes in a step of length zero."""
    bracket = begun(GUARD, 0.0, lambda x: 1e-12 + x)
    found = refined(bracket, value=1e-3, rate=1.0)
    assert found.finished
    assert found.occurred


def test_a_step_retaken_on_its_event_ends_on_it():
    """With tangents a step ends up to its error beside the same without: further off than was asked, maybe."""
    bracket = around_release(np.asarray(GUARD), np.asarray(LENGTH), np.array([-1e-4]))
    first = refined(bracket, value=1e-2 * CLOSE, rate=1e-3)
    retaken = refined(bracket._replace(converged=np.asarray(True)), value=1e-2 * CLOSE, rate=1e-3)
    assert not first.finished
    assert retaken.finished
    assert retaken.occurred
    np.testing.assert_allclose(float(retaken.offset), -10.0 * CLOSE, rtol=1e-12)


@pytest.mark.parametrize(("value", "known"), [(-3e-17, True), (3e-17, True), (-1e-15, False)])
def test_no_step_ends_nearer_than_rounding_lets_it(value, known):
    """A gap of a rounding error, at 1e-8 m/s, is three tolerances before its event, whichever step is tried."""
    bracket = begun(GUARD, 0.5 * LENGTH, lambda x: 1e-8 * (x - 0.5 * LENGTH))
    found = refined(bracket, value=value, rate=1e-8, rounding=1e-16)
    assert abs(value / 1e-8) > CLOSE
    assert bool(found.finished) == bool(found.occurred) == known
    assert float(found.offset) == 0.0, "where rounding puts it says no time"
