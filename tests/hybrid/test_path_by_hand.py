"""The path of a solve by diffrax between its points, and where its events begin, on points written by hand."""

import jax
import jax.numpy as jnp
import numpy as np

from hybrid.ball import Ball
from jaxbuffer.hybrid import Kind, Status
from jaxbuffer.hybrid.locate_events import Path, locate_events

TIMES = np.array([0.0, 0.1, 0.3])  # s


def thrown(time):
    """A ball under gravity alone, from 1 m upwards at 2 m/s, and a number that goes with the fifth power of time."""
    return np.stack([1.0 + 2.0 * time - 5.0 * time**2, 2.0 - 10.0 * time, time**5], axis=-1)


def path(states):
    """The saved points of `thrown` with their rates and second derivatives, the states replaced by others."""
    still = 0.0 * TIMES
    rate = np.stack([2.0 - 10.0 * TIMES, still - 10.0, 5.0 * TIMES**4], axis=-1)
    second = np.stack([still - 10.0, still, 20.0 * TIMES**3], axis=-1)
    unused = np.full((1, 3), np.inf)
    points = (np.concatenate([x, unused]) for x in (states, rate, second))
    return jax.tree.map(jnp.asarray, Path(np.append(TIMES, np.inf), *points, np.asarray(2)))


def test_a_polynomial_of_the_fifth_order_is_followed_exactly():
    found, at = path(thrown(TIMES)), jax.jit(Path.at)
    for time in (0.0, 0.04, 0.1, 0.22, 0.3):
        np.testing.assert_allclose(at(found, np.asarray(time)), thrown(np.array(time)), atol=1e-14)


def test_a_start_in_contact_is_the_first_event():
    states = thrown(TIMES)
    states[0] = -0.01, -1.0, 0.5
    status = np.asarray(int(Status.TIMEOUT))
    find = jax.jit(lambda path, active, status: locate_events(Ball(1e4), path, active, 4, status)[0])
    log = jax.tree.map(np.asarray, find(path(states), np.ones(1), status))
    assert (int(log.kind[0]), float(log.time[0])) == (Kind.TOUCHDOWN, 0.0)
    np.testing.assert_array_equal(log.rows[0, 0], states[0])
    np.testing.assert_allclose(log.values[0], [100.0, 90.0], rtol=1e-14)
