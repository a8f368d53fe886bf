"""Locating an event: steps from the same start, of lengths that converge to the event, by Newton's method kept inside
a bracket.

This is root finding in one variable, the step's length, where evaluating the function means taking a step. One trial is
made in each iteration of the loop, so the method's state, the `Bracket`, is carried from one to the next.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .crossing import Crossing
from .guards import SignedGuards

MAX_TRIES_MAXIMUM = 12  # for a maximum, which may be one of rounding only
MAX_TRIES = 2 * MAX_TRIES_MAXIMUM  # for a guard with a rate, so that a maximum given up never costs a touchdown
MAXIMUM_TOLERANCE = 0.01  # of the time tolerance: a maximum may be much narrower than an impact
NEWTON_TRIES = 2  # tries by Newton's method alone, before the secant takes part
COINCIDENT = 1e-6  # of a bracket: a point so near to one of its ends is taken for that end
RELEASE_BRACKET = 4.0  # times the predicted time to a release: how far it is looked for


class Bracket(NamedTuple):
    """The search for the step length at which a guard is zero.

    ``guard`` (-1: none is being located); ``step`` [s]: the length to try next; ``low``, ``high`` [s]: lengths at which
    the guard is below and above zero, ``low_value``, ``high_value``: its values there; ``tries`` so far;
    ``converged``: the last try, of the state alone, ended on the event and is retaken with tangents; ``clear``: at
    ``low`` no other guard of a contact or of the run's end is above zero.
    """

    guard: Int[Array, ""]
    step: Float[Array, ""]
    low: Float[Array, ""]
    high: Float[Array, ""]
    low_value: Float[Array, ""]
    high_value: Float[Array, ""]
    tries: Int[Array, ""]
    converged: Bool[Array, ""]
    clear: Bool[Array, ""]

    def is_closed(self, tolerance: Float[Array, ""] | float) -> Bool[Array, ""]:
        """Return whether its ends are no farther apart than a ``tolerance`` [s]."""
        return self.high - self.low <= tolerance

    @staticmethod
    def none() -> "Bracket":
        """Return the bracket of no event."""
        zero, none = jnp.zeros(()), jnp.asarray(-1)
        return Bracket(none, zero, zero, zero, zero, zero, jnp.asarray(0), jnp.asarray(False), jnp.asarray(True))

    @staticmethod
    def around(crossing: Crossing, before: Float[Array, " guards"], tries: Int[Array, ""]) -> "Bracket":
        """Bracket a crossing that a step holds, given the signed guards ``before`` it and the ``tries`` spent on other
        events from the same start."""
        guard, zero = crossing.guard, jnp.zeros(())
        return Bracket(
            guard,
            step=crossing.at,
            low=zero,
            high=crossing.far,
            low_value=before[guard],
            high_value=crossing.far_value,
            tries=tries,
            converged=jnp.asarray(False),
            clear=jnp.asarray(True),
        )

    @staticmethod
    def around_release(contact: Int[Array, ""], time: Float[Array, ""], gaps: Float[Array, " contacts"]) -> "Bracket":
        """Bracket the predicted release of a closed contact in a ``time`` [s], given the ``gaps`` now [m], which are
        taken to grow evenly."""
        gap = jnp.sum(jnp.where(jnp.arange(gaps.shape[0]) == contact, gaps, 0.0))
        return Bracket(
            guard=contact,
            step=time,
            low=jnp.zeros(()),
            high=RELEASE_BRACKET * time,
            low_value=gap,
            high_value=(1.0 - RELEASE_BRACKET) * gap,
            tries=jnp.asarray(0),
            converged=jnp.asarray(False),
            clear=jnp.asarray(True),
        )


class Refinement(NamedTuple):
    """What a trial step shows of the event that is being located.

    ``finished``: no further try; ``converged``: the step ends on the event; ``occurred``: it does, or a little beyond,
    and not before one that could not be found; ``offset``: time from the step's end to the event [s], zero unless
    converged, where a maximum is too far to move the state there, and where rounding hides it; ``guard_rate``: the
    guard's rate [1/s times its unit]; ``bracket``: what to try next if not finished.
    """

    finished: Bool[Array, ""]
    converged: Bool[Array, ""]
    occurred: Bool[Array, ""]
    offset: Float[Array, ""]
    guard_rate: Float[Array, ""]
    bracket: Bracket


def refine(
    bracket: Bracket,
    step: Float[Array, ""],
    guards: SignedGuards,
    rated: int,
    tolerance: Float[Array, ""] | float,
    shortfall: Float[Array, ""] | float,
    linear_time: Float[Array, ""] | float,
    rounding: Float[Array, ""] | float,
) -> Refinement:
    """Say how far the end of a step is from the event, and which length to try next.

    Newton's method leads, with the guard's second derivative where it is known. It does not get far where the guard's
    rate is not how the guard changes with the step's length: the step's own error changes with that too. So after
    `NEWTON_TRIES` tries the bracket's secant takes two tries of three. Whatever leaves the bracket is replaced by its
    middle.

    **Arguments:** ``bracket``; ``step`` tried [s]; ``guards`` at its end: the first ``rated`` have exact rates, the
    others get theirs from the parabola through both ends of the bracket and this point; ``tolerance`` [s];
    ``shortfall``: by how much an observable may be below its maximum where the step ends; ``linear_time`` [s]: over
    how long the state there can be moved along its rate; ``rounding``: what of a guard's value is rounding.
    """
    exact = bracket.guard < rated
    z = guards.value[bracket.guard]
    rate = jnp.where(exact, guards.rate[bracket.guard], _parabola_rate(bracket, step, z))
    rising = (rate > 0.0) & jnp.isfinite(rate)
    rate = jnp.where(rising, rate, 1.0)  # no division by zero where it is of no use and the offset infinite
    offset = jnp.where(rising, _newton(z, rate, guards.acceleration[bracket.guard]), jnp.inf)
    below = z < 0.0
    low, low_value = jnp.where(below, step, bracket.low), jnp.where(below, z, bracket.low_value)
    high, high_value = jnp.where(below, bracket.high, step), jnp.where(below, bracket.high_value, z)
    secant = (low * high_value - high * low_value) / (high_value - low_value)
    following = jnp.where((bracket.tries >= NEWTON_TRIES) & (bracket.tries % 3 > 0), secant, step + offset)
    following = jnp.where((following > low) & (following < high), following, 0.5 * (low + high))
    tolerance = jnp.where(exact, tolerance, MAXIMUM_TOLERANCE * tolerance)
    # Of a maximum of rounding alone the rate is nothing, and the offset anything.
    inside = exact | (jnp.abs(offset) <= high - low)
    # Farther than the state can be moved along its rate, a step's end stands for the maximum as it is.
    near = exact | (jnp.abs(offset) <= jnp.maximum(linear_time, tolerance))
    beside = ~exact & inside & (0.5 * jnp.abs(z * offset) <= shortfall)
    # A guard that is beside zero by rounding alone does not say when its event is, and no step comes nearer. Where a
    # contact closes slowly, the tolerance would ask for that.
    rounded = exact & (jnp.abs(z) <= rounding)
    close = (jnp.abs(offset) <= tolerance) | beside | rounded
    # With tangents the same step may end a little beside: it stays on its event.
    converged = close | bracket.converged & rising
    out_of_tries = bracket.tries >= jnp.where(exact, MAX_TRIES, MAX_TRIES_MAXIMUM)
    others = jnp.arange(rated) != bracket.guard
    clear = jnp.where(below, ~jnp.any(others & (guards.value[:rated] > 0.0)), bracket.clear)
    reached = bracket._replace(
        step=following,
        low=low,
        high=high,
        low_value=low_value,
        high_value=high_value,
        tries=bracket.tries + 1,
        clear=clear,
    )
    # A step of length zero is one onto a contact that closes at once.
    finished = converged | reached.is_closed(tolerance) | out_of_tries | (step == 0.0)
    return Refinement(
        finished=finished,
        converged=converged,
        occurred=finished & (converged | ~below),
        offset=jnp.where(converged & inside & near & ~rounded, offset, 0.0),
        guard_rate=rate,
        bracket=reached,
    )


def _parabola_rate(bracket: Bracket, step: Array, value: Array) -> Float[Array, ""]:
    """Return the guard's rate at a step's end, of the parabola through this point and both ends of the bracket.

    Where the point coincides with an end but for rounding, the difference between the two says nothing: the secant then
    stands for the parabola.
    """
    width = bracket.high - bracket.low
    apart = jnp.minimum(step - bracket.low, bracket.high - step) > COINCIDENT * width
    to_low = (value - bracket.low_value) / (step - bracket.low)
    to_high = (bracket.high_value - value) / (bracket.high - step)
    across = (bracket.high_value - bracket.low_value) / (bracket.high - bracket.low)
    return jnp.where(apart, to_low + to_high - across, across)


def _newton(value: Array, rate: Array, acceleration: Array) -> Float[Array, ""]:
    """Return the time to a guard's zero [s] on the parabola with its first and second derivative, which is Newton's
    method where the second is zero."""
    linear = -value / rate
    # The quadratic's root with the square root in the denominator: it does not cancel where the parabola is nearly
    # straight.
    bend = jnp.sqrt(jnp.maximum(1.0 + 2.0 * acceleration * linear / rate, 0.0))
    return linear * 2.0 / (1.0 + bend)
