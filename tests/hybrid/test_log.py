"""The log of events: order, and what it still knows of events that found no room; stored steps."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.hybrid import Kind, Log, Steps

ROWS = np.zeros((2, 3))  # a state of three numbers and one tangent
CONTACTS, OBSERVABLES = 2, 3  # the first two observables are the contacts' forces


@functools.partial(jax.jit, static_argnums=0)
def empty(room):
    return Log.empty(room, jnp.asarray(ROWS), CONTACTS, OBSERVABLES)


@jax.jit
def appended(log, when, kind, which, time, values, touching):
    active = jnp.array([1.0, 0.0])
    rows = ROWS + time
    return log.append(when, kind, which, time, values, 2.0 * time, active, rows, -rows, touching)


def filled(entries, room):
    """A log with entries (kind, which, time, values), between which there is contact from a touchdown to a release."""
    log, touching = empty(room), False
    for kind, which, time, values in entries:
        log = appended(log, True, int(kind), which, time, np.asarray(values, float), touching)
        touching = {Kind.TOUCHDOWN: True, Kind.RELEASE: False}.get(kind, touching)
    return jax.tree.map(np.asarray, log)


IMPACT = [
    (Kind.TOUCHDOWN, 0, 1.0, (0.0, 0.0, 1.0)),
    (Kind.PEAK, 0, 2.0, (5.0, 0.0, 2.0)),
    (Kind.RELEASE, 0, 3.0, (0.0, 0.0, 3.0)),
    (Kind.END, 0, 4.0, (0.0, 0.0, 4.0)),
]


def test_events_stand_in_order():
    log = filled(IMPACT, 6)
    assert int(log.count) == 4
    assert not log.overflown
    np.testing.assert_array_equal(log.kind[:5], [Kind.TOUCHDOWN, Kind.PEAK, Kind.RELEASE, Kind.END, Kind.NONE])
    np.testing.assert_array_equal(log.time[:4], [1.0, 2.0, 3.0, 4.0])
    np.testing.assert_array_equal(log.guard_rate[:4], [2.0, 4.0, 6.0, 8.0])
    np.testing.assert_array_equal(log.values[1], [5.0, 0.0, 2.0])
    np.testing.assert_array_equal(log.rows[2], ROWS + 3.0)
    np.testing.assert_array_equal(log.rates[2], -ROWS - 3.0)
    assert float(log.latest) == 4.0


def test_where_nothing_happens_nothing_is_written():
    """Every iteration writes: into the spare slot at the end, if there is no event."""
    before = filled(IMPACT, 6)
    after = jax.tree.map(np.asarray, appended(before, False, int(Kind.PEAK), 1, 9.0, np.full(OBSERVABLES, 9.0), True))
    assert int(after.kind[-1]) == Kind.NONE
    spare = after.kind.shape[0] - 1
    for old, new in zip(jax.tree.leaves(before), jax.tree.leaves(after), strict=True):
        np.testing.assert_array_equal(old[:spare] if np.ndim(old) else old, new[:spare] if np.ndim(new) else new)


LATER = [
    (Kind.TOUCHDOWN, 1, 10.0, (0.0, 1.0, 0.0)),
    (Kind.PEAK, 1, 11.0, (0.0, 8.0, 0.0)),
    (Kind.PEAK, 2, 11.5, (0.0, 7.0, 30.0)),
    (Kind.PEAK, 1, 12.0, (99.0, 6.0, 0.0)),
    (Kind.RELEASE, 1, 13.0, (0.0, 0.0, 0.0)),
    (Kind.TOUCHDOWN, 1, 20.0, (0.0, 0.5, 0.0)),
    (Kind.TOUCHDOWN, 0, 21.0, (0.0, 0.0, 0.0)),
    (Kind.END, 3, 22.5, (0.0, 0.0, 0.0)),
]


@pytest.fixture(scope="module")
def overflown():
    """Room for the first impact's three events; eight find none."""
    return filled(IMPACT[:3] + LATER, 3)


def test_later_touchdowns_are_counted(overflown):
    assert overflown.overflown
    np.testing.assert_array_equal(overflown.missed, [1, 2])


def test_later_maxima_are_known_where_they_are_highest(overflown):
    """Of each observable at an event of its own: 99 of the first was seen at another's maximum."""
    np.testing.assert_array_equal(overflown.missed_values, [0.0, 8.0, 30.0])
    room = overflown.room
    assert room == 3
    np.testing.assert_array_equal(overflown.time[room + 1 : room + 3], [11.0, 11.5])
    np.testing.assert_array_equal(overflown.kind[room : room + 3], [Kind.NONE, Kind.PEAK, Kind.PEAK])
    np.testing.assert_array_equal(overflown.rows[room + 1], ROWS + 11.0)


def test_a_later_maximum_may_be_negative():
    """An observable below zero has a largest value too."""
    later = [(Kind.PEAK, 2, 11.0, (0.0, 0.0, -3.0)), (Kind.PEAK, 2, 12.0, (0.0, 0.0, -2.0))]
    log = filled(IMPACT[:3] + later, 3)
    assert float(log.missed_values[2]) == -2.0
    assert (int(log.kind[log.room + 2]), float(log.time[log.room + 2])) == (Kind.PEAK, 12.0)


def test_what_never_came_holds_nothing(overflown):
    """Of a full log the slot of an observable without a later maximum counts for none: zero is no value of it."""
    room = overflown.room
    np.testing.assert_array_equal(overflown.used, [True] * 3 + [False, True, True, True, False])
    assert not np.asarray(filled(IMPACT[:2], 3).used)[2:].any() and room == 3


def test_later_contact_time_adds_up(overflown):
    """From 10 to 13 s and from 20 to 22.5 s."""
    assert float(overflown.missed_time) == pytest.approx(5.5, rel=1e-15)


def test_the_end_has_its_place(overflown):
    """And what was there before stays."""
    end = overflown.room + OBSERVABLES
    assert (int(overflown.kind[end]), int(overflown.which[end]), float(overflown.time[end])) == (Kind.END, 3, 22.5)
    assert float(overflown.latest) == 22.5
    np.testing.assert_array_equal(overflown.time[:3], [1.0, 2.0, 3.0])


def test_a_maximum_across_the_limit():
    """Contact that began in the last entry with room counts from there."""
    log = filled([IMPACT[0], (Kind.PEAK, 0, 1.5, (5.0, 0.0, 0.0)), (Kind.RELEASE, 0, 4.0, (0.0, 0.0, 0.0))], 1)
    assert float(log.missed_time) == pytest.approx(3.0, rel=1e-15)
    np.testing.assert_array_equal(log.missed, [0, 0])


@functools.partial(jax.jit, static_argnums=0)
def no_steps(room):
    return Steps.empty(room, jnp.asarray(ROWS), CONTACTS)


@jax.jit
def stored_step(steps, when, time):
    return steps.append(when, time, jnp.zeros(CONTACTS), ROWS + time)


def test_steps_are_stored_while_there_is_room():
    """All are counted; without room nothing is stored."""
    stored, none = no_steps(2), no_steps(0)
    for time, when in ((1.0, True), (2.0, False), (3.0, True), (4.0, True)):
        stored, none = stored_step(stored, when, time), stored_step(none, when, time)
    assert int(stored.count) == int(none.count) == 3
    np.testing.assert_array_equal(np.asarray(stored.time)[:2], [1.0, 3.0])
    np.testing.assert_array_equal(np.asarray(stored.rows)[1], ROWS + 3.0)
    assert none.time.shape == (0,)
