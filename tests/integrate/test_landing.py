"""Landing on a guard's zero: how many steps it takes, and what ends it."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.integrate.events import Crossing, Signed
from jaxbuffer.integrate.landing import Landing, judge

LENGTH, CLOSE = 1e-2, 1e-9  # s
GUARD, MAXIMUM = 0, 1


def landed(target, first, guard, rate, bend=lambda x: 0.0, shortfall=0.0):
    """The lengths tried, and the verdict on the last, where a step's length gives the guard this value and rate."""
    ends = [jnp.array([guard(x)] * 2) for x in (0.0, LENGTH)]
    crossing = Crossing(jnp.asarray(target), jnp.asarray(first), jnp.asarray(LENGTH), jnp.asarray(True))
    landing, tried = Landing.begin(crossing, *ends, jnp.asarray(0), jnp.asarray(False)), []
    while True:
        tried.append(float(landing.aim))
        here = [guard(landing.aim), rate(landing.aim), bend(landing.aim)]
        at = Signed(*(jnp.array([number, here[0] * (k == 0)]) for k, number in enumerate(here)))
        verdict = judge(landing, landing.aim, at, 1, CLOSE, shortfall)
        if verdict.settled:
            return tried, verdict
        landing = verdict.next


def test_a_misleading_rate_does_not_hold_a_landing_up():
    """An implicit step's error changes with its length too: the guard then goes on three times as fast as its rate at
    the step's end says, so that Newton's method overshoots threefold and bisection alone would take 23 tries."""
    zero, slope = 0.37 * LENGTH, 1e-3
    tried, verdict = landed(GUARD, 0.3 * LENGTH, lambda x: 3.0 * slope * (x - zero), lambda x: slope)
    assert len(tried) <= 5
    assert bool(verdict.happened)
    np.testing.assert_allclose(tried[-1], zero, atol=CLOSE)


@pytest.mark.parametrize("shortfall", [1e-3, 1e-6])
def test_a_maximum_is_as_close_as_its_height_needs(shortfall):
    """1 - ½ k (t - zero)²: where it may fall short by s, time may be off by √(2 s/k); the rest is stepped over."""
    zero, curvature = 0.37 * LENGTH, 1e6
    tried, verdict = landed(
        MAXIMUM, 0.36 * LENGTH, lambda x: curvature * (x - zero), lambda x: 0.0, shortfall=shortfall
    )
    off = zero - tried[-1]
    assert abs(off) <= np.sqrt(2.0 * shortfall / curvature)
    np.testing.assert_allclose(float(verdict.offset), off, atol=1e-12)
    assert len(tried) == (1 if 0.5 * curvature * (0.01 * LENGTH) ** 2 <= shortfall else 2)


def test_a_guard_that_bends_is_met_at_once():
    """A parabola's second derivative is known: from a first guess that is off by a quarter, the next try ends on it."""
    speed, bend = 0.1, 30.0
    zero = 0.4 * LENGTH
    guard = lambda x: speed * (x - zero) + 0.5 * bend * (x - zero) ** 2  # noqa: E731
    tried, verdict = landed(GUARD, 0.3 * LENGTH, guard, lambda x: speed + bend * (x - zero), lambda x: bend)
    assert len(tried) == 2
    np.testing.assert_allclose(tried[-1], zero, rtol=1e-12)
    assert float(verdict.offset) == pytest.approx(0.0, abs=1e-15)


def test_a_step_taken_again_on_its_event_ends_on_it():
    """With sensitivities a step ends up to its error beside the same without: further off than was asked, maybe."""
    landing = Landing.toward(jnp.asarray(GUARD), jnp.asarray(LENGTH), jnp.array([-1e-4]))
    beside = Signed(jnp.array([1e-2 * CLOSE, 0.0]), jnp.array([1e-3, 0.0]), jnp.zeros(2))
    first = judge(landing, landing.aim, beside, 1, CLOSE, 0.0)
    again = judge(landing._replace(there=jnp.asarray(True)), landing.aim, beside, 1, CLOSE, 0.0)
    assert not first.settled
    assert again.settled
    assert again.happened
    np.testing.assert_allclose(float(again.offset), -10.0 * CLOSE, rtol=1e-12)
