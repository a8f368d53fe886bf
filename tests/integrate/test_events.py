"""The search for events within a step, on guards whose motion is a parabola: the cubic through both ends is exact."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.integrate.events import Guards, first_crossing, next_release, next_touchdown

STEP, SPEED, FALL = 1e-3, 0.1, 500.0  # s, m/s away from the surface, m/s² back to it
NONE, OPEN = jnp.zeros(0), jnp.zeros(1)


def thrown(gap, time):
    """A ball that leaves a surface, thrown up from ``gap`` [m]."""
    height = gap + SPEED * time - 0.5 * FALL * time**2
    rate, bend = jnp.array([SPEED - FALL * time]), jnp.array([-FALL])
    return Guards(jnp.array([height]), rate, bend, NONE, NONE, NONE, NONE, jnp.zeros(()), jnp.zeros(()))


@pytest.mark.parametrize("left", [0.0, -1e-15, 1e-15])
def test_a_release_is_not_a_touchdown(left):
    """The landing on a release leaves the gap at zero, or on either side of it: the touchdown is the next one."""
    found = first_crossing(
        thrown(left, 0.0), thrown(left, STEP), jnp.asarray(STEP), OPEN, NONE, jnp.asarray(-1), jnp.asarray(True)
    )
    assert int(found.which) == 0
    np.testing.assert_allclose(float(found.at), 2.0 * SPEED / FALL, rtol=1e-9)


@pytest.mark.parametrize("left", [0.0, -1e-15])
def test_a_contact_missed_by_rounding_acts_at_once(left):
    """On the surface or a little beyond it and going on."""
    before = thrown(left, 0.0)._replace(gap_rate=jnp.array([-SPEED]))
    after = thrown(left, STEP)._replace(gap_rate=jnp.array([-SPEED - FALL * STEP]))
    found = first_crossing(before, after, jnp.asarray(STEP), OPEN, NONE, jnp.asarray(-1), jnp.asarray(True))
    assert (int(found.which), float(found.at)) == (0, 0.0)


@pytest.mark.parametrize("time", [0.0, 1e-4, 3e-4])
def test_a_touchdown_is_foreseen(time):
    """Of a parabola exactly, on its way up and on its way down."""
    foreseen = next_touchdown(thrown(1e-6, time), OPEN)
    np.testing.assert_allclose(time + foreseen, (SPEED + np.sqrt(SPEED**2 + 2.0 * FALL * 1e-6)) / FALL, rtol=1e-12)


@pytest.mark.parametrize(
    ("rate", "bend", "active"), [(SPEED, FALL, 0.0), (SPEED, 0.0, 0.0), (-SPEED, FALL, 0.0), (-SPEED, 0.0, 1.0)]
)
def test_no_touchdown_is_foreseen(rate, bend, active):
    """Of a ball that leaves, one that turns back before the surface, and one that touches it already."""
    guards = thrown(0.1, 0.0)._replace(gap_rate=jnp.array([rate]), gap_bend=jnp.array([bend]))
    assert float(next_touchdown(guards, jnp.array([active]))) == np.inf


@pytest.mark.parametrize("before", [1e-4, 1e-6])
def test_a_release_is_foreseen(before):
    """Of a tip that is slowed down exactly; of one that is pushed away as if it were not."""
    slowed = thrown(-1e-6, 0.0)
    time = (SPEED - np.sqrt(SPEED**2 - 2.0 * FALL * 1e-6)) / FALL
    which, foreseen = next_release(slowed, jnp.ones(1))
    assert int(which) == 0
    np.testing.assert_allclose(float(foreseen), time, rtol=1e-12)
    pushed = slowed._replace(gap=jnp.array([-SPEED * before]), gap_bend=jnp.array([FALL]))
    np.testing.assert_allclose(float(next_release(pushed, jnp.ones(1))[1]), before, rtol=1e-12)


@pytest.mark.parametrize(
    ("gap", "rate", "active"), [(-1e-6, -SPEED, 1.0), (-0.1, SPEED, 1.0), (-1e-6, SPEED, 0.0), (1e-6, SPEED, 1.0)]
)
def test_no_release_is_foreseen(gap, rate, active):
    """Of a tip that goes deeper, one that turns back before it is out, of a contact open already, of one left."""
    guards = thrown(gap, 0.0)._replace(gap=jnp.array([gap]), gap_rate=jnp.array([rate]))
    assert float(next_release(guards, jnp.array([active]))[1]) == np.inf


def observed(value, slope):
    """Guards of one observable alone."""
    return Guards(NONE, NONE, NONE, NONE, NONE, jnp.array([value]), jnp.array([slope]), jnp.zeros(()), jnp.zeros(()))


def test_a_maximum_between_two_falling_ends_is_seen():
    """After a maximum that was landed on, an observable may fall and rise to a higher one within a step."""
    cubic = np.polynomial.Polynomial([0.0, -1.0, 8.0, -6.5])
    slope = cubic.deriv()
    assert slope(0.0) < 0.0
    assert slope(1.0) < 0.0
    assert cubic(1.0) > cubic(0.0)
    ends = [observed(cubic(x), slope(x) / STEP) for x in (0.0, 1.0)]
    best = jnp.array([cubic(0.0)])
    found = first_crossing(*ends, jnp.asarray(STEP), NONE, best, jnp.asarray(-1), jnp.asarray(True))
    assert int(found.which) == 0
    np.testing.assert_allclose(float(found.at), max(slope.roots()) * STEP, rtol=1e-9)
