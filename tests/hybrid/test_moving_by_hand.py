"""Derivatives of a log's entries, of a ball in a floor of springs, by hand."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from hybrid.ball import Ball
from jaxbuffer.hybrid import Kind, Log
from jaxbuffer.hybrid.event_times import moving

STIFFNESS, DEPTH, SPEED = 1e4, 2e-3, 0.3


@jax.jit
def logged():
    """A start in contact, a release that rises at `SPEED`, and the time's end, each in the same state."""
    row = jnp.array([[-DEPTH, SPEED, 0.0]])
    log = Log.empty(4, row, 1, 2)
    for kind, which, time, active in (
        (Kind.TOUCHDOWN, 0, 0.0, 1.0),
        (Kind.RELEASE, 0, 0.5, 0.0),
        (Kind.END, -1, 1.0, 1.0),
    ):
        event = (jnp.asarray(x) for x in (True, int(kind), which, time))
        values = jnp.array([STIFFNESS * DEPTH * active, 0.0])
        rates = jnp.array([[SPEED, STIFFNESS * DEPTH * active - 10.0, 0.0]])
        log = log.append(*event, values, jnp.asarray(SPEED), jnp.array([active]), row, rates, jnp.asarray(True))
    return log


@eqx.filter_jit
def moved(log, ball, rises):
    """The log and its derivative by the stiffness, a unit of which raises the rows by ``rises``."""

    def of(stiffness):
        rows = log.rows + (stiffness - STIFFNESS) * rises
        return moving(dataclasses.replace(log, rows=rows), (stiffness,), ball)

    return jax.jvp(of, (jnp.asarray(STIFFNESS),), (jnp.ones(()),))


def rising(log):
    """By 1 in height."""
    rises = np.zeros(log.rows.shape)
    rises[..., 0] = 1.0
    return rises


def jumping_ball(stiffness):
    return Ball(stiffness, True)


def test_starts_and_ends_by_time_stay_and_a_release_moves():
    """By the stiffness, where the height rises by 1 a unit of it at fixed times: a release comes 1/v earlier, and what
    is read there changes by its rate times that; the rate at a start in contact, logged as zero, by nothing."""
    log = logged()
    found, move = jax.tree.map(np.asarray, moved(log, Ball, rising(log)))
    np.testing.assert_array_equal(found.time, log.time)
    np.testing.assert_allclose(move.time[:3], [0.0, -1.0 / SPEED, 0.0], rtol=1e-14)
    at_rest, pushed = [1.0, 0.0, 0.0], [0.0, DEPTH - STIFFNESS, 0.0]
    np.testing.assert_allclose(move.rows[:3, 0], [at_rest, [0.0, 10.0 / SPEED, 0.0], at_rest], atol=1e-14)
    np.testing.assert_allclose(move.rates[:3, 0], [[0.0] * 3, [10.0 / SPEED, 0.0, 0.0], pushed], atol=1e-12)
    force = DEPTH - STIFFNESS
    np.testing.assert_allclose(move.values[:3], [[force, force], [0.0, 0.0], [force, force]], rtol=1e-12)
    np.testing.assert_array_equal(move.time[3:], 0.0)
    assert np.all(np.isnan(move.guard_rate[:3]))
    assert float(move.latest) == float(move.missed_time) == 0.0


def test_where_forces_jump_the_rate_is_that_before_the_event():
    """Of a release: with the contact still closed."""
    log = logged()
    move = moved(log, jumping_ball, rising(log))[1].rates
    np.testing.assert_allclose(np.asarray(move)[1, 0], [10.0 / SPEED, DEPTH, 0.0], rtol=1e-9)


def test_a_maximum_moves_by_its_slope_over_the_guards_rate():
    """The force's slope is -k v: minus that rises by v a unit of stiffness, so that the maximum comes v/v earlier."""
    log = logged()
    kind, time = np.array(log.kind), np.array(log.time)
    kind[0], time[0] = Kind.PEAK, 0.1
    log = dataclasses.replace(log, kind=jnp.asarray(kind), time=jnp.asarray(time))
    move = moved(log, Ball, np.zeros(log.rows.shape))[1].time
    np.testing.assert_allclose(np.asarray(move)[0], -1.0, rtol=1e-12)
