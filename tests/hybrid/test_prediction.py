"""The prediction of touchdowns and releases, on gaps whose motion is a parabola."""

import jax
import numpy as np
import pytest

from hybrid.ball import guards
from jaxbuffer.hybrid.events import prediction

SPEED, FALL = 0.1, 500.0  # m/s away from the surface, m/s² back to it
OPEN, CLOSED = np.zeros(1), np.ones(1)
next_touchdown, next_release = jax.jit(prediction.next_touchdown), jax.jit(prediction.next_release)


def thrown(gap, time):
    """A ball thrown up from ``gap`` [m]."""
    return guards(contact=(gap + SPEED * time - 0.5 * FALL * time**2, SPEED - FALL * time, -FALL))


@pytest.mark.parametrize(("gap", "time"), [(1e-6, 0.0), (1e-6, 1e-4), (1e-6, 3e-4), (0.0, 0.0), (-1e-6, 0.0)])
def test_a_touchdown_is_predicted(gap, time):
    """Of a parabola exactly, on its way up and on its way down; from a release that ended short of zero too."""
    predicted = next_touchdown(thrown(gap, time), OPEN)
    np.testing.assert_allclose(time + predicted, (SPEED + np.sqrt(SPEED**2 + 2.0 * FALL * gap)) / FALL, rtol=1e-12)


def test_however_slowly_it_turns_back():
    """0.1 m/s upwards and 1e-3 m/s² back: on the surface again after 200 s."""
    slow = guards(contact=(0.0, 0.1, -1e-3))
    np.testing.assert_allclose(float(next_touchdown(slow, OPEN)), 200.0, rtol=1e-12)


@pytest.mark.parametrize(
    ("rate", "acceleration", "active"),
    [(SPEED, FALL, OPEN), (SPEED, 0.0, OPEN), (-SPEED, FALL, OPEN), (-SPEED, 0.0, CLOSED)],
)
def test_no_touchdown_is_predicted(rate, acceleration, active):
    """Of a ball that leaves, one that turns back before the surface, and one that touches it already."""
    assert float(next_touchdown(guards(contact=(0.1, rate, acceleration)), active)) == np.inf


def test_a_release_is_predicted():
    """Of a tip that is slowed down exactly; of one that is pushed away as if it were not."""
    time = (SPEED - np.sqrt(SPEED**2 - 2.0 * FALL * 1e-6)) / FALL
    contact, predicted = next_release(thrown(-1e-6, 0.0), CLOSED)
    assert int(contact) == 0
    np.testing.assert_allclose(float(predicted), time, rtol=1e-12)
    for before in (1e-4, 1e-6):
        pushed = guards(contact=(-SPEED * before, SPEED, FALL))
        np.testing.assert_allclose(float(next_release(pushed, CLOSED)[1]), before, rtol=1e-12)


@pytest.mark.parametrize(
    ("gap", "rate", "active"),
    [(-1e-6, -SPEED, CLOSED), (-0.1, SPEED, CLOSED), (-1e-6, SPEED, OPEN), (1e-6, SPEED, CLOSED)],
)
def test_no_release_is_predicted(gap, rate, active):
    """Of a tip that goes deeper, one that turns back before it is out, of a contact open already, of one left."""
    assert float(next_release(guards(contact=(gap, rate, -FALL)), active)[1]) == np.inf


def test_the_first_of_several():
    """Two open contacts, two closed ones; without any of a kind, none."""
    gap, rate, none = np.array([2e-3, 1e-3, -2e-3, -1e-3]), np.array([-1.0, -1.0, 1.0, 1.0]), np.zeros(4)
    several = guards()._replace(gap=gap, gap_rate=rate, gap_acceleration=none)
    active = np.array([0.0, 0.0, 1.0, 1.0])
    np.testing.assert_allclose(float(next_touchdown(several, active)), 1e-3, rtol=1e-12)
    contact, time = next_release(several, active)
    assert int(contact) == 3
    np.testing.assert_allclose(float(time), 1e-3, rtol=1e-12)
    nothing = guards()._replace(gap=none[:0], gap_rate=none[:0], gap_acceleration=none[:0])
    assert float(next_touchdown(nothing, none[:0])) == np.inf
    assert (int(next_release(nothing, none[:0])[0]), float(next_release(nothing, none[:0])[1])) == (-1, np.inf)
