"""Shortening a step until it ends on an event, by Newton's method kept inside a bracket."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .events import Crossing, Signed

MAX_TRIES = 12  # for a maximum, which may be one of rounding only
SHARPER = 0.01  # a maximum may be much narrower than an impact
PATIENT = 2  # tries by Newton's method alone
FAR = 4.0  # times as far as a release is foreseen: where it is looked for
MOST_TRIES = 2 * MAX_TRIES  # for a guard with a rate, so that a maximum given up never costs a touchdown


class Landing(NamedTuple):
    """A step on its way onto a guard's zero.

    ``target``: the guard (-1: no landing under way); ``aim``: the length to try [s]; ``low``, ``high``: bracket [s]
    with the guard's values there; ``tries`` so far; ``aside``: it only looks at a maximum within a step that stands;
    ``there``: the last try ended on the event, and is taken again with sensitivities.
    """

    target: Int[Array, ""]
    aim: Float[Array, ""]
    low: Float[Array, ""]
    high: Float[Array, ""]
    low_value: Float[Array, ""]
    high_value: Float[Array, ""]
    tries: Int[Array, ""]
    aside: Bool[Array, ""]
    there: Bool[Array, ""]

    @staticmethod
    def none() -> "Landing":
        """No landing under way."""
        zero, no = jnp.zeros(()), jnp.asarray(False)
        return Landing(jnp.asarray(-1), zero, zero, zero, zero, zero, jnp.asarray(0), no, no)

    @staticmethod
    def begin(
        crossing: Crossing,
        before: Float[Array, " guards"],
        after: Float[Array, " guards"],
        tries: Int[Array, ""],
        aside: Bool[Array, ""],
    ) -> "Landing":
        """Aim at a crossing found in a step, given the signed guards at its ends and the tries spent on others."""
        which, zero, no = crossing.which, jnp.zeros(()), jnp.asarray(False)
        return Landing(which, crossing.at, zero, crossing.far, before[which], after[which], tries, aside, no)

    @staticmethod
    def toward(contact: Int[Array, ""], time: Float[Array, ""], gaps: Float[Array, " contacts"]) -> "Landing":
        """Aim at the release of a closed contact as foreseen [s], given the gaps now."""
        zero, no = jnp.zeros(()), jnp.asarray(False)
        low = jnp.sum(jnp.where(jnp.arange(gaps.shape[0]) == contact, gaps, 0.0))
        return Landing(contact, time, zero, FAR * time, low, (1.0 - FAR) * low, jnp.asarray(0), no, no)

    @property
    def under_way(self) -> Bool[Array, ""]:
        """Whether a step is being shortened."""
        return self.target >= 0


class Verdict(NamedTuple):
    """``settled``: the landing is over; ``there``: the step ends on the event; ``happened``: it does, or just beyond,
    rather than beside one that is not there; ``offset``: time from the step's end to the event itself [s]; ``rate``:
    the guard's; ``next``: what to try if not.
    """

    settled: Bool[Array, ""]
    there: Bool[Array, ""]
    happened: Bool[Array, ""]
    offset: Float[Array, ""]
    rate: Float[Array, ""]
    next: Landing


def judge(
    landing: Landing,
    step: Float[Array, ""],
    guards: Signed,
    rated: int,
    tolerance: Float[Array, ""] | float,
    shortfall: Float[Array, ""] | float,
) -> Verdict:
    """How far a landing is off.

    **Arguments:** ``guards`` at the step's end; the first ``rated`` have exact rates, the others get theirs from the
    parabola through both ends of the bracket and this point; ``tolerance`` [s];
    ``shortfall``: by how much an observable may be below its maximum where the step ends.
    """
    z = guards.value[landing.target]
    to_low = (z - landing.low_value) / (step - landing.low)
    to_high = (landing.high_value - z) / (landing.high - step)
    across = (landing.high_value - landing.low_value) / (landing.high - landing.low)
    rate = jnp.where(landing.target < rated, guards.rate[landing.target], to_low + to_high - across)
    rising = (rate > 0.0) & jnp.isfinite(rate)
    rate = jnp.where(rising, rate, 1.0)
    straight = -z / rate
    bent = jnp.sqrt(jnp.maximum(1.0 + 2.0 * guards.bend[landing.target] * straight / rate, 0.0))
    offset = jnp.where(rising, straight * 2.0 / (1.0 + bent), jnp.inf)
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
    close = (jnp.abs(offset) <= tolerance) | maximum & (0.5 * jnp.abs(z * offset) <= shortfall)
    there = close | landing.there & rising
    patience = jnp.where(landing.target < rated, MOST_TRIES, MAX_TRIES)
    settled = there | (high - low <= tolerance) | (landing.tries >= patience) | (step == 0.0)
    return Verdict(
        settled=settled,
        there=there,
        happened=settled & (there | ~under),
        offset=jnp.where(there, offset, 0.0),
        rate=rate,
        next=landing._replace(
            aim=proposal, low=low, high=high, low_value=low_value, high_value=high_value, tries=landing.tries + 1
        ),
    )
