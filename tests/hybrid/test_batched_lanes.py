"""`vmap` on an accelerator steps all runs of a batch together; asked for on a CPU, each lane is the run alone."""

import importlib

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from hybrid.test_diffeqsolve import STIFFNESS, Ball, expected
from jaxbuffer.hybrid import ExplicitRungeKutta, Options, Status, StepTolerance, solve

LOCATED = Options(solver=ExplicitRungeKutta(), tolerance=StepTolerance(1e-10, 1e-10), max_events=8)
# The third and the last two rise a few percent through the end and fall again, within one step of free flight: its
# rounding decides whether one of the guard's signs is seen, so that the end must be found without it.
HEIGHTS = np.array([0.05, np.nan, 0.04, 0.055, 0.0365, 0.038])


@pytest.fixture
def together(monkeypatch):
    """Counts how often the batched branch was chosen."""
    asked = []
    module = importlib.import_module("jaxbuffer.hybrid.lanes")
    monkeypatch.setattr(module, "in_turn", lambda: asked.append(True) and False)
    return asked


def ball(height):
    """Status, times of the events [s], largest force [N]."""
    log = (result := solve(Ball, (height, jnp.asarray(STIFFNESS)), jnp.asarray(1.0), LOCATED)).log
    return result.status, log.time[:4], log.values[1, 0]


def test_lanes_are_the_runs_alone_and_one_fails_alone(together):
    """Events, end, largest force and its derivative of balls that bounce once, against closed forms."""

    def both(height):
        slope = jax.jacfwd(lambda height: ball(height)[2])(height)
        return *ball(height), slope

    status, times, force, slope = map(np.asarray, jax.jit(jax.vmap(both))(HEIGHTS))
    force_by_height = jax.jit(jax.jacfwd(lambda height: expected(height, STIFFNESS)[1]))
    assert together
    assert status.tolist() == [0, int(Status.NOT_FINITE), 0, 0, 0, 0]
    for lane in (0, 2, 3, 4, 5):
        exact, peak = expected(HEIGHTS[lane], STIFFNESS)
        np.testing.assert_allclose(times[lane], exact, rtol=1e-8)
        np.testing.assert_allclose(force[lane], peak, rtol=1e-8)
        np.testing.assert_allclose(slope[lane], force_by_height(HEIGHTS[lane]), rtol=1e-6)
