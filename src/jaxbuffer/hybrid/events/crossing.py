"""The search for the first event within a step: where a guard crosses zero, from polynomials through both ends.

It gives a first guess only; the loop then takes steps that end ever closer to the event (see `bracketing`).
"""

from typing import NamedTuple

import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from ..hermite import ROUNDED, cubic, maximum_of_cubic
from .guards import RISING, Extremes, Guards, SignedGuards, signed

NEARLY = 0.001  # of its extent: a maximum so little below the largest value may be higher than the cubic says
UNLOCATED = 1e-6  # of its extent: by how much an observable at an accepted step exceeds the log to be logged there
NOT_YET = -1e-300  # the value of a guard that counts as still before its event: the search needs a negative one


class Crossing(NamedTuple):
    """The first crossing in a step.

    ``guard`` (-1: none is crossed); ``at``: time from the step's start [s]; ``far`` [s]: a time at which the guard is
    beyond its zero, and ``far_value``: its value there, as far as it is known; ``alone``: whether the step holds no
    other.
    """

    guard: Int[Array, ""]
    at: Float[Array, ""]
    far: Float[Array, ""]
    far_value: Float[Array, ""]
    alone: Bool[Array, ""]

    @property
    def exists(self) -> Bool[Array, ""]:
        """Return whether there is a crossing."""
        return self.guard >= 0


def first_crossing(
    before: Guards,
    after: Guards,
    step: Float[Array, ""],
    active: Float[Array, " contacts"],
    least: Float[Array, " observables"],
    ignored: Int[Array, ""],
    maxima: Bool[Array, " observables"],
) -> Crossing:
    """Return the earliest event in a step; most steps hold none and are not searched.

    **Arguments:** guards ``before`` and ``after`` the ``step`` [s]; ``active``: which contacts are closed;
    ``least``: the value of each observable that a maximum must exceed to matter; ``ignored``: a guard left out (-1:
    none); ``maxima``: the observables whose maxima to look for.
    """
    start, end = signed(before, active), signed(after, active)
    crossing = slice(0, before.gap.shape[0] + before.terminal.shape[0])
    # A guard below zero at both ends may have been above it in between only if it turned.
    dipping = (start.rate > 0.0) & (end.rate < 0.0)
    possible = jnp.concatenate([((end.value > 0.0) | dipping)[crossing], _has_maximum(before, after)])
    none = Crossing(jnp.asarray(-1), step, step, jnp.zeros(()), jnp.asarray(False))
    # Most steps hold no event: `cond` spares them the search, unless lanes are stepped together.
    search = lambda: _first_crossing(before, after, step, active, least, ignored, maxima)  # noqa: E731
    return lax.cond(jnp.any(possible), search, lambda: none)


def _first_crossing(
    before: Guards, after: Guards, step: Array, active: Array, least: Array, ignored: Array, maxima: Array
) -> Crossing:
    root, far = _roots(before, after, step, active)
    peak, beyond_peak, value_there = _maxima(before, after, step, least)
    peak = jnp.where(maxima, peak, jnp.inf)
    fractions = jnp.concatenate([root, peak])
    fractions = jnp.where(jnp.arange(fractions.shape[0]) == ignored, jnp.inf, fractions)
    guard = jnp.argmin(fractions)
    fraction = fractions[guard]
    reach = jnp.concatenate([far, beyond_peak])[guard]
    far_value = jnp.concatenate([signed(after, active).value[: far.shape[0]], value_there])[guard]
    exists = jnp.isfinite(fraction)
    alone = jnp.sum(jnp.isfinite(fractions)) == 1
    guard, at = jnp.where(exists, guard, -1), jnp.where(exists, fraction, 1.0) * step
    return Crossing(guard, at, reach * step, far_value, alone)


def _roots(before: Guards, after: Guards, step: Array, active: Array) -> tuple[Array, Array]:
    """Return, for each guard of a contact or of the run's end, the fraction of the step at which it rises through zero
    (infinite if it does not), and a fraction at which it is above zero.

    Three cases take care. A guard left at zero or a little above it by the step that ended on its last event, and on
    its way back down, has not crossed, though a short step may end before it is below zero; one that is higher at the
    step's end has been below zero and has come back. One that is above zero at
    the start and stays there has crossed already (it was missed by the tolerance of an earlier location): an open
    contact then closes at once. And a contact may touch and leave, or leave and touch, within one step: its guard is
    negative at both ends and has a maximum above zero inside.
    """
    contacts, terminals = before.gap.shape[0], before.terminal.shape[0]
    these = slice(0, contacts + terminals)
    start, end = (SignedGuards(*(part[these] for part in signed(guards, active))) for guards in (before, after))
    leaving = (start.value >= 0.0) & (start.rate < 0.0)
    still_leaving = leaving & (end.rate < 0.0) & (end.value <= start.value)
    start = start._replace(value=jnp.where(leaving, NOT_YET, start.value))
    z0, z1, m0, m1 = start.value, end.value, start.rate * step, end.rate * step
    maximum = maximum_of_cubic(z0, z1, m0, m1)
    highest = cubic(z0, z1, m0, m1, maximum)
    contact = jnp.arange(contacts + terminals) < contacts
    open_contact = jnp.concatenate([active < 0.5, jnp.zeros(terminals, bool)])
    dips = contact & (z0 < 0.0) & (z1 <= 0.0) & (m0 > 0.0) & (m1 < 0.0) & (highest > 0.0)
    far = jnp.where(dips, maximum, 1.0)
    root = _polynomial_root(start, end, step, far, contact)
    root = jnp.where(z0 > 0.0, jnp.where(open_contact, 0.0, 1.0), root)
    return jnp.where((z1 > 0.0) & ~still_leaving | dips, root, jnp.inf), far


def _maxima(before: Guards, after: Guards, step: Array, least: Array) -> tuple[Array, Array, Array]:
    """Return the fraction of the step at which each observable has a maximum that matters (infinite if it has none), a
    fraction at which it falls after that, and the value of its guard there.

    Of a maximum that is at the step's start but for rounding, the fraction is `ROUNDED`: from a shorter step nothing
    could be seen of how the rate changes. An observable that rises again at the step's end falls most steeply at its
    cubic's turning point.
    """
    rise, fall = before.value_rate * step, after.value_rate * step
    peak = maximum_of_cubic(before.value, after.value, rise, fall)
    height = cubic(before.value, after.value, rise, fall, peak)
    matters = _has_maximum(before, after) & (jnp.maximum(height, after.value) >= least)
    jump, again = after.value - before.value, fall > 0.0
    steepest = (jump - (2.0 * rise + fall) / 3.0) / jnp.where(again, 2.0 * jump - rise - fall, 1.0)
    slope = rise + steepest * (3.0 * jump - 2.0 * rise - fall)
    far = jnp.where(again, steepest, 1.0)
    far_value = jnp.where(again, -slope / step, -after.value_rate)
    return jnp.where(matters, jnp.maximum(peak, ROUNDED), jnp.inf), far, far_value


def _has_maximum(before: Guards, after: Guards) -> Bool[Array, " observables"]:
    """Return whether each observable has a maximum in a step.

    It has one where it falls at the end and rises at the start or is higher at the end; and where it rises at both
    ends, as far as the rates are known, but is lower at the end.
    """
    rises, falls = before.value_rate > 0.0, after.value_rate <= 0.0
    known = (before.value_rate > RISING) & (after.value_rate > RISING)
    return (rises | (after.value > before.value)) & falls | known & (after.value < before.value)


def unlocated_maximum(
    start: Float[Array, " observables"],
    end: Float[Array, " observables"],
    logged: Float[Array, " observables"],
    extremes: Extremes,
) -> Bool[Array, " observables"]:
    """Return which observables are larger at a step's start than anywhere in the log so far, and fall from there to its
    end.

    Such a maximum was not located, because the observable jumps within a step, as a reaction does where friction
    reverses, or because the search for it was given up. The accepted steps' largest value then stands for it.
    """
    return (start > logged + UNLOCATED * extremes.extent) & (end < start)


def _polynomial_root(
    before: SignedGuards, after: SignedGuards, step: Array, far: Array, quintic: Array
) -> Float[Array, " n"]:
    """Return the root in (0, far] of each polynomial through both ends that is negative at 0 and positive at ``far``.
    The degree is five where second derivatives are known (``quintic``), else three; Newton's method is kept in its
    bracket."""
    z0, m0, m1 = before.value, before.rate * step, after.rate * step
    jump = after.value - z0
    b0 = jnp.where(quintic, before.acceleration * step**2, 6.0 * jump - 4.0 * m0 - 2.0 * m1)
    b1 = jnp.where(quintic, after.acceleration * step**2, 2.0 * m0 + 4.0 * m1 - 6.0 * jump)
    c2, j, k, n = 0.5 * b0, jump - m0 - 0.5 * b0, m1 - m0 - b0, 0.5 * (b1 - b0)
    c3, c4, c5 = 10.0 * j - 4.0 * k + n, -15.0 * j + 7.0 * k - 2.0 * n, 6.0 * j - 3.0 * k + n

    def nearer(_: Array, bracket: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        low, x, high = bracket
        z = z0 + x * (m0 + x * (c2 + x * (c3 + x * (c4 + x * c5))))
        slope = m0 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + 5.0 * x * c5)))
        low, high = jnp.where(z < 0.0, x, low), jnp.where(z < 0.0, high, x)
        newton = x - z / jnp.where(slope == 0.0, 1.0, slope)
        return low, jnp.where((newton >= low) & (newton <= high), newton, 0.5 * (low + high)), high

    straight = jnp.clip(-z0 / jnp.where(jump == 0.0, 1.0, jump), 0.0, 1.0) * far
    # So many iterations, whatever they reach: this is a first guess, from which `bracketing` goes on.
    return lax.fori_loop(0, 7, nearer, (jnp.zeros_like(far), straight, far))[1]
