"""Shortening a step until it ends on an event, by Newton's method kept inside a bracket."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .events import Crossing

MAX_TRIES = 12  # for a maximum, which may be one of rounding only
SHARPER = 0.01  # a maximum may be much narrower than an impact
PATIENT = 2  # tries by Newton's method alone
MOST_TRIES = 2 * MAX_TRIES  # for a guard with a rate, so that a maximum given up never costs a touchdown


class Landing(NamedTuple):
    """A step on its way onto a guard's zero.

    ``target``: the guard (-1: no landing under way); ``aim``: the length to try [s]; ``low``, ``high``: bracket [s]
    with the guard's values there; ``tries`` so far; ``aside``: it only looks at a maximum within a step that stands.
    """

    target: Int[Array, ""]
    aim: Float[Array, ""]
    low: Float[Array, ""]
    high: Float[Array, ""]
    low_value: Float[Array, ""]
    high_value: Float[Array, ""]
    tries: Int[Array, ""]
    aside: Bool[Array, ""]

    @staticmethod
    def none() -> "Landing":
        """No landing under way."""
        zero = jnp.zeros(())
        return Landing(jnp.asarray(-1), zero, zero, zero, zero, zero, jnp.asarray(0), jnp.asarray(False))

    @staticmethod
    def begin(
        crossing: Crossing,
        before: Float[Array, " guards"],
        after: Float[Array, " guards"],
        tries: Int[Array, ""],
        aside: Bool[Array, ""],
    ) -> "Landing":
        """Aim at a crossing found in a step, given the signed guards at its ends and the tries spent on others."""
        which, zero = crossing.which, jnp.zeros(())
        return Landing(which, crossing.at, zero, crossing.far, before[which], after[which], tries, aside)

    @property
    def under_way(self) -> Bool[Array, ""]:
        """Whether a step is being shortened."""
        return self.target >= 0


class Verdict(NamedTuple):
    """``settled``: the landing is over; ``happened``: on its event rather than beside one that is not there;
    ``offset``: time from the step's end to the event itself [s]; ``rate``: the guard's; ``next``: what to try if not.
    """

    settled: Bool[Array, ""]
    happened: Bool[Array, ""]
    offset: Float[Array, ""]
    rate: Float[Array, ""]
    next: Landing


def judge(
    landing: Landing,
    step: Float[Array, ""],
    guard: Float[Array, " guards"],
    guard_rate: Float[Array, " guards"],
    rated: int,
    tolerance: Float[Array, ""] | float,
    shortfall: Float[Array, ""] | float,
) -> Verdict:
    """How far a landing is off.

    **Arguments:** ``guard``, ``guard_rate``: signed guards at the step's end; the first ``rated`` have exact rates, the
    others get theirs from the parabola through both ends of the bracket and this point; ``tolerance`` [s];
    ``shortfall``: by how much an observable may be below its maximum where the step ends.
    """
    z = guard[landing.target]
    to_low = (z - landing.low_value) / (step - landing.low)
    to_high = (landing.high_value - z) / (landing.high - step)
    across = (landing.high_value - landing.low_value) / (landing.high - landing.low)
    rate = jnp.where(landing.target < rated, guard_rate[landing.target], to_low + to_high - across)
    rising = (rate > 0.0) & jnp.isfinite(rate)
    offset = jnp.where(rising, -z / jnp.where(rising, rate, 1.0), jnp.inf)
    under = z < 0.0
    low, low_value = jnp.where(under, step, landing.low), jnp.where(under, z, landing.low_value)
    high, high_value = jnp.where(under, landing.high, step), jnp.where(under, landing.high_value, z)
    # Newton's method doesn't get far where the guard's rate isn't how it goes with the step's length: a tolerance's
    # worth of error changes with that too. Then the bracket's secant does.
    secant = (low * high_value - high * low_value) / (high_value - low_value)
    proposal = jnp.where((landing.tries >= PATIENT) & (landing.tries % 3 > 0), secant, step + offset)
    proposal = jnp.where((proposal > low) & (proposal < high), proposal, 0.5 * (low + high))
    maximum = landing.target >= rated
    tolerance = jnp.where(maximum, SHARPER * tolerance, tolerance)
    on_target = (jnp.abs(offset) <= tolerance) | maximum & (0.5 * jnp.abs(z * offset) <= shortfall)
    patience = jnp.where(landing.target < rated, MOST_TRIES, MAX_TRIES)
    settled = on_target | (high - low <= tolerance) | (landing.tries >= patience) | (step == 0.0)
    return Verdict(
        settled=settled,
        happened=settled & (on_target | ~under),
        offset=jnp.where(on_target, offset, 0.0),
        rate=jnp.where(rising, rate, 1.0),
        next=Landing(landing.target, proposal, low, high, low_value, high_value, landing.tries + 1, landing.aside),
    )
