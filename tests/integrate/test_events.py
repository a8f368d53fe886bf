"""The search for events within a step, on guards whose motion is a parabola: the cubic through both ends is exact."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.integrate.events import Guards, first_crossing, next_touchdown

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
