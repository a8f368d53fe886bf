"""Guards that jump at one instant: a gap and the run's end, as where a ball is pushed through a flank."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.hybrid import ExplicitRungeKutta, HybridSystem, Linearisation, Options, StepTolerance, solve

DURATION = 0.1  # s
EDGE = 1e-3  # m, where both guards jump
STIFFNESS = 1e6  # N/m over kg: behind the edge the ball is thrown back at once


class BehindAnEdge(HybridSystem):
    """A ball that comes behind an edge, where its gap falls from 1 m to -0.5 m and then grows; 0.4 m
    deep the run ends."""

    speed: jax.Array

    @property
    def coordinates(self):
        return 1

    def start(self):
        return jnp.stack([jnp.zeros(()), self.speed]), jnp.zeros(1)

    def gaps(self, state):
        return jnp.where(state[:1] > EDGE, -0.4 - 0.1 * EDGE / state[:1], 1.0)

    def terminals(self, state):
        return -self.gaps(state) - 0.4

    def touchdown(self, state, approach_acceleration, contact):
        return state

    def derivative(self, time, state, active):
        return jnp.stack([state[1], -active[0] * STIFFNESS * jnp.maximum(-self.gaps(state)[0], 0.0)])

    def observables(self, state, rate, active):
        return jnp.zeros(0)

    def rate_observables(self):
        return ()

    def scales(self):
        return jnp.ones(2)

    def impact_step(self, state):
        return jnp.asarray(1e-4)

    def linearisation(self, time, state, active):
        return Linearisation.none(1, 1)


@pytest.fixture(scope="module", params=[1e-6, 1e-9])
def passing(request):
    """A run past the edge, compiled, by tolerance."""
    options = Options(ExplicitRungeKutta(), StepTolerance(request.param, request.param), max_events=16, max_steps=2000)
    return jax.jit(lambda speed: solve(BehindAnEdge, (speed,), DURATION, options))


@pytest.mark.parametrize("speed", np.linspace(0.3, 2.9, 14))
def test_the_run_ends_where_both_jump(speed, passing):
    """The contact closes at the same instant, and the end's guard falls after it: the run's end must not be passed
    over, nor looked for without end."""
    run = passing(jnp.asarray(speed))
    assert int(run.status) == 0
    assert int(run.attempts) < 80  # two searches of two dozen tries, and some steps
    # A jump has no slope to be located by: of a step as long as the run two dozen bisections leave a millionth.
    np.testing.assert_allclose(run.log.time[int(run.log.count) - 1], EDGE / speed, atol=1e-6 * DURATION)
