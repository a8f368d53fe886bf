"""The search for events within a step, on guards whose motion is a polynomial: the one through both ends is exact."""

import jax
import numpy as np
import pytest

from jaxbuffer.hybrid.events.crossing import first_crossing, unlocated_maximum
from jaxbuffer.hybrid.events.guards import RISING, Extremes, Guards

STEP, SPEED, FALL = 1e-3, 0.1, 500.0  # s, m/s away from the surface, m/s² back to it
NONE, OPEN, CLOSED = np.zeros(0), np.zeros(1), np.ones(1)
crossing = jax.jit(first_crossing)


def seen(contacts=(), ends=(), observed=()):
    """Gaps with rate and acceleration, guards of the end with their rates, observables with theirs."""

    def columns(rows, n):
        return np.array(rows, float).reshape(-1, n).T

    return Guards(
        *columns(contacts, 3), *columns(ends, 2), *columns(observed, 2), np.zeros((0, 1)), np.zeros(()), np.zeros(())
    )


def searched(before, after, active=NONE, least=NONE, ignored=-1, maxima=True, step=STEP):
    given = np.asarray(step), active, least, np.asarray(ignored), np.full(before.value.shape, maxima)
    return crossing(before, after, *given)


def thrown(gap, time):
    """A ball that leaves a surface, thrown up from ``gap`` [m]."""
    return seen(contacts=[(gap + SPEED * time - 0.5 * FALL * time**2, SPEED - FALL * time, -FALL)])


def polynomial(coefficients, time):
    """Value, rate and acceleration."""
    p = np.polynomial.Polynomial(coefficients)
    return p(time), p.deriv()(time), p.deriv(2)(time)


@pytest.mark.parametrize("left", [0.0, -1e-15, 1e-15])
def test_a_release_is_not_a_touchdown(left):
    """The step onto a release leaves the gap at zero, or on either side of it: the touchdown is the next one."""
    found = searched(thrown(left, 0.0), thrown(left, STEP), OPEN)
    assert int(found.guard) == 0
    np.testing.assert_allclose(float(found.at), 2.0 * SPEED / FALL, rtol=1e-9)


def test_a_step_too_short_to_leave_by_is_no_touchdown():
    """Left below the surface by more than the next short step rises: still on its way out at the end of it."""
    assert int(searched(thrown(-1e-12, 0.0), thrown(-1e-12, 5e-12), OPEN, step=5e-12).guard) == -1


def test_a_contact_that_came_back_and_leaves_again_has_touched():
    """Left a little below the surface; at the step's end deeper below it, after a flight, and on its way out."""
    before, after = thrown(-1e-12, 0.0), seen(contacts=[(-2e-8, 1e-3, 20.0)])
    found = searched(before, after, OPEN)
    assert int(found.guard) == 0
    assert 0.0 < float(found.at) < STEP


@pytest.mark.parametrize("left", [0.0, -1e-15])
def test_a_contact_missed_by_rounding_acts_at_once(left):
    """On the surface or a little beyond it and going on."""
    before = thrown(left, 0.0)._replace(gap_rate=np.array([-SPEED]))
    after = thrown(left, STEP)._replace(gap_rate=np.array([-SPEED - FALL * STEP]))
    found = searched(before, after, OPEN)
    assert (int(found.guard), float(found.at)) == (0, 0.0)


@pytest.mark.parametrize(("active", "sign"), [(OPEN, 1.0), (CLOSED, -1.0)])
def test_touching_and_leaving_within_one_step(active, sign):
    """A contact open at both ends of the step, its gap a parabola below zero between 0.3 and 0.6 of it; and a closed
    one that leaves and touches. The first of the two crossings is found, bracketed by where the guard is highest."""
    depth = [sign * 1e-6 * c for c in (0.3 * 0.6, -(0.3 + 0.6) / STEP, 1.0 / STEP**2)]
    before, after = (seen(contacts=[polynomial(depth, time)]) for time in (0.0, STEP))
    found = searched(before, after, active)
    assert int(found.guard) == 0
    np.testing.assert_allclose([found.at, found.far], [0.3 * STEP, 0.45 * STEP], rtol=1e-9)
    assert bool(found.alone)


def test_coming_near_is_not_touching():
    """The same parabola, its lowest point a little above zero."""
    near = [1e-6 * c for c in (0.45**2 + 0.001, -0.9 / STEP, 1.0 / STEP**2)]
    before, after = (seen(contacts=[polynomial(near, time)]) for time in (0.0, STEP))
    found = searched(before, after, OPEN)
    assert (int(found.guard), bool(found.exists), float(found.at)) == (-1, False, STEP)


def test_the_end_of_the_run():
    """A cubic guard without a known second derivative; falling through zero is no end."""
    cubic = np.polynomial.Polynomial.fromroots([0.4 * STEP, -STEP, -2.0 * STEP]) * 1e9
    rows = [[(cubic(time), cubic.deriv()(time))] for time in (0.0, STEP)]
    found = searched(seen(ends=rows[0]), seen(ends=rows[1]))
    assert int(found.guard) == 0
    np.testing.assert_allclose(float(found.at), 0.4 * STEP, rtol=1e-9)
    assert not searched(seen(ends=rows[1]), seen(ends=rows[0])).exists


def test_a_maximum_inside():
    """Of a cubic exactly; not where it stays below the least that matters, where maxima are not looked for, where it is
    ignored, nor where its rate is not known at the end."""
    cubic = np.polynomial.Polynomial([1.0, 3.0, 1.0, -4.0])
    slope = cubic.deriv()
    rows = [[(cubic(x), slope(x) / STEP)] for x in (0.0, 1.0)]
    before, after = (seen(observed=row) for row in rows)
    found = searched(before, after, least=np.array([1.0]))
    assert int(found.guard) == 0
    np.testing.assert_allclose(float(found.at), max(slope.roots()) * STEP, rtol=1e-12)
    assert float(found.far) == STEP
    highest = cubic(max(slope.roots()))
    assert searched(before, after, least=np.array([highest])).exists
    assert not searched(before, after, least=np.array([1.01 * highest])).exists
    assert not searched(before, after, least=np.array([1.0]), maxima=False).exists
    assert not searched(before, after, least=np.array([1.0]), ignored=0).exists
    unknown = after._replace(value_rate=np.array([RISING]))
    assert not searched(before, unknown, least=np.array([1.0])).exists


def test_a_maximum_between_two_falling_ends_is_seen():
    """After a maximum that was located, an observable may fall and rise to a higher one within a step."""
    cubic = np.polynomial.Polynomial([0.0, -1.0, 8.0, -6.5])
    slope = cubic.deriv()
    assert slope(0.0) < 0.0
    assert slope(1.0) < 0.0
    assert cubic(1.0) > cubic(0.0)
    before, after = (seen(observed=[(cubic(x), slope(x) / STEP)]) for x in (0.0, 1.0))
    found = searched(before, after, least=np.array([cubic(0.0)]))
    assert int(found.guard) == 0
    np.testing.assert_allclose(float(found.at), max(slope.roots()) * STEP, rtol=1e-9)


def test_a_maximum_of_what_rises_again_is_seen():
    """Between two rising ends of which the second is lower: the cubic's maximum exactly, and its steepest fall beyond.
    Of rates that are not known nothing follows."""
    cubic = np.polynomial.Polynomial([1.0, 1.1, -2.9, 1.7])
    slope = cubic.deriv()
    assert slope(0.0) > 0.0 and slope(1.0) > 0.0 and cubic(1.0) < cubic(0.0)
    before, after = (seen(observed=[(cubic(x), slope(x) / STEP)]) for x in (0.0, 1.0))
    found = searched(before, after, least=np.array([1.0]))
    assert int(found.guard) == 0
    steepest = float(slope.deriv().roots()[0])
    np.testing.assert_allclose(float(found.at), min(slope.roots()) * STEP, rtol=1e-12)
    np.testing.assert_allclose(float(found.far), steepest * STEP, rtol=1e-12)
    np.testing.assert_allclose(float(found.far_value), -slope(steepest) / STEP, rtol=1e-12)
    unknown = [ends._replace(value_rate=np.array([RISING])) for ends in (before, after)]
    assert not searched(*unknown, least=np.array([0.0])).exists


def test_the_earliest_of_several():
    """A touchdown at 0.7 of the step, the end at 0.5, a maximum at 0.2; each is found once the earlier ones are not."""
    top = 0.2 * STEP

    def at(time):
        return seen(
            [(0.7 * STEP - time, -1.0, 0.0)], [(time - 0.5 * STEP, 1.0)], [(1.0 - (time - top) ** 2, 2 * (top - time))]
        )

    least = np.zeros(1)
    first = searched(at(0.0), at(STEP), OPEN, least)
    assert (int(first.guard), bool(first.alone)) == (2, False)
    np.testing.assert_allclose(float(first.at), top, rtol=1e-6)
    second = searched(at(0.0), at(STEP), OPEN, least, ignored=2)
    assert int(second.guard) == 1
    np.testing.assert_allclose(float(second.at), 0.5 * STEP, rtol=1e-9)
    third = searched(at(0.0), at(0.4 * STEP), OPEN, least, step=0.4 * STEP)
    assert (int(third.guard), bool(third.alone)) == (2, True)


def test_of_two_at_once_the_first_guard():
    """Contacts come before the end, and those of lower number first; the other one is then found on arrival."""
    before, after = (seen([(gap, -1.0, 0.0)] * 2, [(-gap, 1.0)]) for gap in (0.5 * STEP, -0.5 * STEP))
    found = searched(before, after, np.zeros(2))
    assert (int(found.guard), bool(found.alone)) == (0, False)
    np.testing.assert_allclose(float(found.at), 0.5 * STEP, rtol=1e-12)
    assert int(searched(before, after, np.zeros(2), ignored=0).guard) == 1


def test_a_located_maximum_counts_as_falling():
    """Whatever the rate that the step onto it has left; other observables keep theirs."""
    left = seen(observed=[(1.0, 1e-9), (1.0, 2.0)])
    fallen = jax.jit(Guards.falling)(left, np.array([True, False]))
    np.testing.assert_array_equal(fallen.value_rate, [0.0, 2.0])
    after = seen(observed=[(0.9, -1.0), (1.2, 3.0)])
    least = np.array([0.5, 0.5])
    assert int(searched(left, after, least=least).guard) == 0
    assert not searched(fallen, after, least=least).exists


@jax.jit
def tenth_below_largest(values):
    """Of the extent: before any of the ``values`` of an observable, and after them."""
    extremes = before = Extremes.none(1)
    for value in values:
        extremes = extremes.including(value)
    return before.below_largest(0.1), extremes.below_largest(0.1)


@pytest.mark.parametrize(("datum", "extent"), [(0.0, 4.0), (-7.0, 4.0), (1e6, 4.0), (4.5, 0.5)])
def test_near_the_largest_value_is_a_matter_of_the_extent(datum, extent):
    """Of values from 1 to 5 that is the range, wherever zero is, unless the largest one is smaller; before any,
    everything is near."""
    before, near = tenth_below_largest(np.array([[5.0 - datum], [1.0 - datum]]))
    np.testing.assert_allclose(near, [5.0 - 0.1 * extent - datum], rtol=1e-15, atol=1e-9)
    assert float(before[0]) == -np.inf


@pytest.mark.parametrize("datum", [0.0, 9.0, 1e6])
def test_an_accepted_step_above_the_log_is_a_maximum_where_it_falls(datum):
    """Not where it goes on rising, nor where the log holds as much."""
    extremes = Extremes(np.array([5.0, 5.0, 5.0]) - datum, np.array([1.0, 1.0, 1.0]) - datum)
    start, end = np.array([5.0, 5.0, 5.0]) - datum, np.array([4.0, 6.0, 4.0]) - datum
    found = jax.jit(unlocated_maximum)(start, end, np.array([4.99, 3.0, 5.0]) - datum, extremes)
    np.testing.assert_array_equal(found, [True, False, False])


@pytest.mark.parametrize(
    ("peak", "below", "share", "rate"),
    [
        (0.09191669334453416, 0.00658206208988635, 0.9999374882125882, -1e-18),
        (3403.1262565205284, 0.005269666677814153, 0.9530703270102384, -1e-18),
        (1.2636588638879704e-05, 4.391623899990015e-05, 0.835000596031934, 0.0),
    ],
)
def test_a_maximum_at_the_very_end_is_found_there(peak, below, share, rate):
    """Two maxima at the same time: the step ends on one, so the other's rate there is rounding. The root of the cubic's
    derivative may then lie just beyond the end; the other root is at the beginning or before it."""
    start, rise = peak * (1.0 - below), 2.0 * below * peak * share / STEP
    before, after = seen(observed=[(start, rise)]), seen(observed=[(peak, rate * peak / STEP)])
    found = searched(before, after, least=np.zeros(1))
    assert int(found.guard) == 0
    np.testing.assert_allclose(float(found.at), STEP, rtol=1e-5)


def test_a_maximum_at_the_start_but_for_rounding():
    """Its rate is 4e-23 there: looked for in a step from whose end a change of that rate can be seen."""
    bend = -500.0
    before, after = seen(observed=[(1.0, 4e-23)]), seen(observed=[(1.0 + 0.5 * bend * STEP**2, bend * STEP)])
    found = searched(before, after, least=np.ones(1))
    assert int(found.guard) == 0
    assert 1e-7 * STEP < float(found.at) < 1e-5 * STEP
