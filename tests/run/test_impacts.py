"""Impacts, time in contact and moving events read off logs written by hand."""

from functools import partial
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.hybrid import Kind, Log
from jaxbuffer.mechanisms.run import Maxima
from jaxbuffer.run.impacts import contact_time, impacts
from jaxbuffer.run.moving import carried, moving_events, shifted
from jaxbuffer.run.read_off import _peak_impact
from jaxbuffer.run.survey import Survey

CONTACTS, OBSERVABLES = 2, 3  # forces of both contacts, and something else
T, R, P, END = Kind.TOUCHDOWN, Kind.RELEASE, Kind.PEAK, Kind.END

# kind, contact or observable, time, forces of both contacts, closed contacts afterwards
EVENTS = [
    (T, 0, 1.0, (0.0, 0.0), (1, 0)),
    (P, 0, 1.5, (9.0, 0.0), (1, 0)),
    (T, 1, 1.6, (4.0, 0.0), (1, 1)),
    (P, 1, 1.8, (2.0, 7.0), (1, 1)),
    (R, 0, 2.0, (0.0, 3.0), (0, 1)),
    (R, 1, 2.5, (0.0, 0.0), (0, 0)),
    (T, 0, 4.0, (0.0, 0.0), (1, 0)),
    (P, 0, 4.5, (6.0, 0.0), (1, 0)),
    (END, 0, 4.75, (5.0, 0.0), (1, 0)),
]


append = jax.jit(Log.append)
empty = jax.jit(Log.empty, static_argnums=(0, 2, 3))


def logged(events, room):
    log = empty(room, np.zeros((1, 4)), CONTACTS, OBSERVABLES)
    before = (0, 0)
    for kind, which, time, force, active in events:
        values, rows = np.array([*force, time]), np.array([[time, 10.0 * time, 0.0, 0.0]])
        now = np.array(active, float)
        log = append(log, True, int(kind), which, time, values, 2.0, now, rows, np.ones((1, 4)), any(before))
        before = active
    return log


def system(contacts=CONTACTS):
    """One whose approach speeds at touchdown are the first two numbers of the state."""
    return SimpleNamespace(impact_contacts=contacts, memory=lambda state: state[:2])


def surveyed(log, contacts=CONTACTS):
    slots = log.kind.shape[0]
    return Survey(jnp.zeros((slots, CONTACTS)), log.values[:, :contacts], jnp.zeros(slots))


@partial(jax.jit, static_argnums=1)  # once for all logs of one length
def compiled(log, contacts):
    return impacts(system(contacts), log, surveyed(log, contacts))


def impacts_in(log, contacts=CONTACTS):
    return jax.tree.map(np.asarray, compiled(log, contacts))


@partial(jax.jit, static_argnums=1)
def time_in_contact(log, contacts=CONTACTS):
    return contact_time(system(contacts), log)


@jax.jit
def peak_impact(log, top):
    return _peak_impact(log, top, impacts(system(), log, surveyed(log)))


@jax.jit
def stretched(log):
    """The change of the time in contact as all times of a log are stretched."""
    at = lambda time: time_in_contact(Log(**(vars(log) | {"time": time})))  # noqa: E731
    return jax.jvp(at, (log.time,), (log.time,))[1]


def highest(time, contact):
    return Maxima(np.asarray(9.0), np.asarray(time), np.asarray(contact), {})


@pytest.mark.parametrize("room", [9, 20])
def test_every_impact_with_its_peak_and_its_release(room):
    found = impacts_in(logged(EVENTS, room))
    assert int(found.count) == 3
    np.testing.assert_array_equal(found.time[:3], [1.0, 1.6, 4.0])
    np.testing.assert_array_equal(found.contact[:3], [0, 1, 0])
    np.testing.assert_array_equal(found.approach_speed[:3], [1.0, 16.0, 4.0])
    np.testing.assert_array_equal(found.peak_force[:3], [9.0, 7.0, 6.0])
    np.testing.assert_array_equal(found.release_time[:3], [2.0, 2.5, np.nan])
    np.testing.assert_array_equal(found.contact[3:], -1)
    for part in (found.time, found.approach_speed, found.peak_force, found.release_time):
        np.testing.assert_array_equal(part[3:], 0.0)


def test_only_contacts_that_have_impacts_count():
    found = impacts_in(logged(EVENTS, 20), 1)
    assert int(found.count) == 2
    np.testing.assert_array_equal(found.peak_force[:2], [9.0, 6.0])


def test_a_force_below_zero_is_none():
    """A peak's polished value may be a rounding below."""
    log = logged([(T, 0, 1.0, (-1e-12, 0.0), (1, 0)), (R, 0, 2.0, (-1e-12, 0.0), (0, 0))], 9)
    assert impacts_in(log).peak_force[0] == 0.0


def test_without_contacts_there_are_no_impacts():
    log = logged([(END, 0, 1.0, (0.0, 0.0), (0, 0))], 3)
    found = impacts_in(log, 0)
    assert int(found.count) == 0
    slots = log.kind.shape[0]
    np.testing.assert_array_equal(found.contact, np.full(slots, -1))
    for part in (found.time, found.approach_speed, found.peak_force, found.release_time):
        np.testing.assert_array_equal(part, np.zeros(slots))


def test_in_a_log_that_is_full_the_impacts_in_it_are_listed():
    """Room for six events: the last touchdown is counted, not listed."""
    log = logged(EVENTS, 6)
    found = impacts_in(log)
    assert int(found.count) == 2
    np.testing.assert_array_equal(found.release_time[:2], [2.0, 2.5])
    assert np.sum(log.missed) == 1


@pytest.mark.parametrize("room", [4, 6, 7, 9, 20])
def test_time_in_contact(room):
    """From 1 to 2.5 and from 4 to 4.75, whatever found room; its derivative is unknown where something did not."""
    log = logged(EVENTS, room)
    np.testing.assert_allclose(time_in_contact(log), 2.25, rtol=1e-14)
    np.testing.assert_allclose(stretched(log), 2.25 if room >= len(EVENTS) else np.nan, rtol=1e-14)


def test_time_in_contact_of_the_first_contact_alone():
    np.testing.assert_allclose(time_in_contact(logged(EVENTS, 20), 1), 1.75, rtol=1e-14)


def test_time_in_contact_of_a_run_without_an_event():
    assert float(time_in_contact(logged([], 5))) == 0.0


@pytest.mark.parametrize(("contact", "time", "expected"),
                         [(0, 1.5, 0), (1, 1.8, 1), (0, 4.5, 2), (0, 1.0, 0), (1, 1.5, -1), (0, 0.5, -1)])  # fmt: skip
def test_the_impact_of_the_peak(contact, time, expected):
    """The contact's last touchdown before it."""
    assert int(peak_impact(logged(EVENTS, 20), highest(time, contact))) == expected


@pytest.mark.slow
@pytest.mark.parametrize(("room", "time", "expected"), [(6, 2.5, 0), (6, 2.6, -1), (8, 4.5, 2)])
def test_beyond_a_full_log_the_impact_of_the_peak_is_unknown(room, time, expected):
    """It may be another one's than the last that is listed."""
    assert int(peak_impact(logged(EVENTS, room), highest(time, 0))) == expected


def test_an_event_moves_by_its_guard_over_the_guards_rate():
    moved = jax.jvp(shifted, (1.0, 0.0, 4.0), (0.5, 2.0, 7.0))
    np.testing.assert_allclose(moved, (1.0, 0.5 - 2.0 / 4.0 + 0.0))
    value, move = jax.jvp(carried, (jnp.array([1.0, 2.0]), jnp.array([3.0, -1.0]), jnp.asarray(9.0)),
                          (jnp.array([0.1, 0.2]), jnp.array([5.0, 5.0]), jnp.asarray(2.0)))  # fmt: skip
    np.testing.assert_allclose(value, [1.0, 2.0])
    np.testing.assert_allclose(move, [6.1, -1.8])


def test_touchdowns_and_releases_move_with_the_gap():
    """A gap that grows by p: touchdowns, where minus the gap rises at 2, come p/2 later; releases p/2 earlier; maxima
    and a touchdown at the start stay."""
    log = logged([(T, 1, 0.0, (0.0, 0.0), (0, 1)), *EVENTS], 20)

    @jax.jit
    def times(p, log):
        gap = p * jnp.array([[1.0, 10.0]]) * jnp.ones((log.kind.shape[0], 1))
        return moving_events(log, surveyed(log)._replace(gap=gap)).time

    time, move = jax.jvp(lambda p: times(p, log), (0.0,), (1.0,))
    np.testing.assert_array_equal(time, log.time)
    of_contact = {0: 0.5, 1: 5.0}
    expected = [0.0, *({T: of_contact[w], R: -of_contact[w]}.get(k, 0.0) for k, w, *_ in EVENTS)]
    np.testing.assert_allclose(move[: len(expected)], expected, atol=1e-15)
