"""Largest values against closed forms: whatever their sign, wherever zero is, and where a quantity jumps."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.hybrid import Diffrax, ExplicitRungeKutta, HybridSystem, Linearisation, Options, StepTolerance, solve

GRAVITY, SPEED, DURATION = 9.81, 4.0, 0.7  # m/s², m/s, s
RANGE = SPEED**2 / (2.0 * GRAVITY)  # m, from the start to the highest point
HIGHEST = SPEED / GRAVITY  # s


class Motion(HybridSystem):
    """One coordinate, no contact, an end that never comes; nothing stiff."""

    @property
    def coordinates(self):
        return 1

    def gaps(self, state):
        return jnp.zeros(0)

    def terminals(self, state):
        return -jnp.ones(1)

    def touchdown(self, state, approach_acceleration, contact):
        return state

    def touching(self, active):
        return jnp.asarray(False)

    def scales(self):
        return jnp.ones(2)

    def impact_step(self, state):
        return jnp.asarray(1e-3)

    def linearisation(self, time, state, active):
        return Linearisation.none(1, 1)


class Thrown(Motion):
    """A ball thrown upwards; observed are its height over a datum, the height's negative, and both as if they depended
    on the rate."""

    datum: jax.Array

    def start(self):
        return jnp.array([0.0, SPEED]), jnp.zeros(0)

    def derivative(self, time, state, active):
        return jnp.stack([state[1], -GRAVITY * jnp.ones(())])

    def observables(self, state, rate, active):
        height = state[0] - self.datum
        return jnp.stack([height, -state[0] - self.datum, height + 0.0 * rate[1]])

    def rate_observables(self):
        return (False, False, True)


def largest(system, result):
    """The largest value of each observable at the start and in the log."""
    state, active = system.start()
    start = system.observables(state, system.derivative(0.0, state, active), active)
    return np.max([start, *np.asarray(result.log.values)[: int(result.log.count)]], axis=0)


@pytest.fixture(scope="module", params=[ExplicitRungeKutta(), Diffrax()], ids=["loop", "diffrax"])
def thrown(request):
    """A throw over a datum, compiled."""
    options = Options(request.param, StepTolerance(1e-9, 1e-9), max_events=16)
    return jax.jit(lambda datum: solve(Thrown, (datum,), DURATION, options))


@pytest.mark.parametrize("datum", [0.0, 0.9, -0.9, RANGE, 1e6 * RANGE, -1e6 * RANGE])
def test_a_maximum_is_one_whatever_its_sign(datum, thrown):
    """The ball's highest point is found below its datum as above it, and over a datum a million ranges away."""
    heights = largest(Thrown(datum), thrown(jnp.asarray(datum)))
    rounding = 4e-16 * abs(datum)
    np.testing.assert_allclose(heights[[0, 2]], RANGE - datum, atol=1e-8 * RANGE + rounding, rtol=0.0)
    lowest = max(0.0, -(SPEED * DURATION - 0.5 * GRAVITY * DURATION**2))
    np.testing.assert_allclose(heights[1], lowest - datum, atol=1e-7 * RANGE + rounding, rtol=0.0)


BRAKE, RUB, SLIP_SPEED = 20.0, 15.0, 1e-5  # m/s², m/s², m/s


class Reversing(Motion):
    """A block braked with growing force and rubbed by friction, which reverses with its motion: the size of its
    acceleration, (BRAKE + RUB)(1 + t) before, drops to (BRAKE - RUB)(1 + t) within some µs."""

    speed: jax.Array

    def start(self):
        return jnp.stack([jnp.zeros(()), self.speed]), jnp.zeros(0)

    def derivative(self, time, state, active):
        force = BRAKE + RUB * jnp.tanh(state[1] / SLIP_SPEED)
        return jnp.stack([state[1], -force * (1.0 + time)])

    def observables(self, state, rate, active):
        return jnp.abs(rate[1:])

    def rate_observables(self):
        return (True,)


def test_a_maximum_where_friction_reverses():
    """The acceleration is largest where the block turns round, and falls to a seventh of that within one step.

    Its speed is v - (BRAKE + RUB)(t + t²/2), so that 1 + t = √(1 + 2 v/(BRAKE + RUB)) there.
    """
    options = Options(ExplicitRungeKutta(), StepTolerance(1e-6, 1e-6), max_events=16)
    run = jax.jit(lambda speed: solve(Reversing, (speed,), 0.2, options))
    for speed in np.linspace(1.0, 3.0, 9):
        expected = (BRAKE + RUB) * np.sqrt(1.0 + 2.0 * speed / (BRAKE + RUB))
        assert largest(Reversing(jnp.asarray(speed)), run(jnp.asarray(speed)))[0] == pytest.approx(
            expected, rel=1e-4
        ), speed
