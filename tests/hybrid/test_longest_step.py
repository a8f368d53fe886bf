"""A step that looks for a touchdown carries no ball so far through a thin wall that it would seem to be behind it."""

import jax
import numpy as np
import pytest

from jaxbuffer.hybrid.events import prediction
from jaxbuffer.hybrid.events.guards import Guards

NOTHING = np.zeros(0)
longest_step = jax.jit(prediction.longest_step)


def guards(gap, rate, acceleration):
    one = lambda x: np.array([x])  # noqa: E731
    return Guards(
        *(one(gap), one(rate), one(acceleration), NOTHING, NOTHING, NOTHING, NOTHING),
        *(np.zeros((0, 1)), np.zeros(()), np.zeros(())),
    )


@pytest.mark.parametrize("acceleration", [0.0, 0.3, -0.3])
def test_it_ends_no_deeper_than_the_depth(acceleration):
    """From 1 m away at 2 m/s: the parabola is 0.1 m below zero, or where half as much time again leads to."""
    watched, open_ = guards(1.0, -2.0, acceleration), np.zeros(1)
    at = lambda time: 1.0 - 2.0 * time + 0.5 * acceleration * time**2  # noqa: E731
    free, deep = (float(longest_step(watched, open_, np.asarray(depth))) for depth in (np.inf, 0.1))
    touchdown = float(np.min(np.roots([0.5 * acceleration, -2.0, 1.0]).clip(0.0))) if acceleration >= 0 else free / 1.5
    np.testing.assert_allclose(free, 1.5 * touchdown, rtol=1e-12)
    assert abs(at(deep) + 0.1) < 0.01 and deep < free
    assert float(longest_step(watched, np.ones(1), np.asarray(0.1))) == np.inf, "a closed contact is not looked for"


def test_a_shallow_one_is_not_shortened():
    watched = guards(1e-3, -2.0, 0.0)
    assert float(longest_step(watched, np.zeros(1), np.asarray(0.1))) == float(
        longest_step(watched, np.zeros(1), np.asarray(np.inf))
    )
