"""A contact that closes so slowly that rounding alone moves its gap across the tolerance of events."""

import jax
import jax.numpy as jnp
import pytest

from hybrid.test_diffeqsolve import Ball
from jaxbuffer.hybrid import ExplicitRungeKutta, Kind, Options, Status, StepTolerance, solve

FAR = 1000.0  # m, from the origin to the floor: what a double keeps of a height there is 1e-13 m
SLOW, HIGH = 1e-6, 1e-7  # m/s, m
CLOSELY = Options(
    solver=ExplicitRungeKutta(), tolerance=StepTolerance(1e-9, 1e-9), event_time=1e-12, max_events=8, max_steps=2000
)


class BallFarAway(Ball):
    """A ball that drifts through a floor far from the origin; what is asked is whether the touchdown is found.

    Its ``height`` is less than a double resolves there, and is added to the gap, so that no state has a gap of zero.
    """

    def start(self):
        return jnp.stack([jnp.asarray(FAR + HIGH), jnp.asarray(-SLOW)]), jnp.zeros(1)

    def derivative(self, time, state, active):
        return jnp.stack([state[1], jnp.zeros(())])

    def gaps(self, state):
        return state[:1] - FAR + self.height

    def terminals(self, state):
        return -jnp.ones(1)

    def observables(self, state, rate, active):
        return jnp.zeros(1)


run = jax.jit(lambda height: solve(BallFarAway, (height, jnp.asarray(1.0)), jnp.asarray(0.2), CLOSELY))


@pytest.mark.parametrize("height", [1e-14, 3e-14, 5e-14, 8e-14])
def test_a_touchdown_is_found_where_rounding_hides_its_time(height):
    """After HIGH / SLOW, as closely as rounding of 1e-13 m allows at that speed, and in few steps."""
    result = run(jnp.asarray(height))
    assert int(result.status) == int(Status.TIMEOUT)
    assert int(result.attempts) < 200
    assert int(result.log.kind[0]) == int(Kind.TOUCHDOWN)
    assert abs(float(result.log.time[0]) - HIGH / SLOW) < 3e-13 / SLOW
