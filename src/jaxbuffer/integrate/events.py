"""Where within a step a guard crosses zero: touchdowns, releases, the end of the run, and maxima.

Guards are signed so that each crossing of interest goes from negative to positive. A first guess comes from the cubic
Hermite polynomial through both ends of the step; the loop then lands a real step on it and corrects.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from ..mechanisms.hybrid import HybridSystem

NEARLY = 0.999  # of the best so far: what the cubic's error might hide
NEAR_BEST = 0.8  # of the best so far: from here on an observable of the state's rate is followed closely


class Guards(NamedTuple):
    """Guards and observables at one instant, with their time derivatives (of gaps the second one too), and what the
    motion does not change with its rounding."""

    gap: Float[Array, " contacts"]
    gap_rate: Float[Array, " contacts"]
    gap_bend: Float[Array, " contacts"]
    terminal: Float[Array, " terminals"]
    terminal_rate: Float[Array, " terminals"]
    value: Float[Array, " observables"]
    slope: Float[Array, " observables"]
    invariant: Float[Array, ""]
    rounding: Float[Array, ""]


class Signed(NamedTuple):
    """All guards, negative before their event, with the derivatives that are known (0 for those of maxima, and for
    second ones of the end's)."""

    value: Float[Array, " guards"]
    rate: Float[Array, " guards"]
    bend: Float[Array, " guards"]


def signed(guards: Guards, active: Float[Array, " contacts"]) -> Signed:
    """The guards of contacts, of the run's end and of maxima, in this order."""
    sign, none = jnp.where(active > 0.5, 1.0, -1.0), jnp.zeros_like(guards.slope)
    value = jnp.concatenate([sign * guards.gap, guards.terminal, -guards.slope])
    rate = jnp.concatenate([sign * guards.gap_rate, guards.terminal_rate, none])
    bend = jnp.concatenate([sign * guards.gap_bend, jnp.zeros_like(guards.terminal), none])
    return Signed(value, rate, bend)


def nearly_best(system: HybridSystem, state: Array, rate: Array, active: Array, best: Array) -> Bool[Array, ""]:
    """Whether an observable of the state's rate comes near its best so far: its own rate takes the state's second
    derivative, which costs two right-hand sides."""
    value = system.observables(state, rate, active)
    # one by one, so that what the others take is not evaluated
    near = [value[k] > NEAR_BEST * best[k] for k, of_rate in enumerate(system.rate_observables()) if of_rate]
    return jnp.any(jnp.stack(near))


def observe(system: HybridSystem, state: Array, rate: Array, second: Array, active: Array) -> Guards:
    """Guards and observables with their rates, from the state and its derivatives. Where the second one is not known
    (zeros: see `nearly_best`), observables of the state's rate count as rising, slowly."""
    look = lambda y, r: system.watched(y, r, active)  # noqa: E731
    seen, moves = jax.jvp(look, (state, rate), (rate, second))
    of_rate = jnp.asarray(system.rate_observables(), bool)
    slope = jnp.where(of_rate & ~jnp.any(second != 0.0), 1e-300, moves.value)
    return Guards(
        seen.gap, seen.gap_rate, moves.gap_rate, seen.terminal, moves.terminal, seen.value, slope, *seen.invariant
    )


def next_touchdown(guards: Guards, active: Float[Array, " contacts"]) -> Float[Array, ""]:
    """Until an open contact closes, if all go on with the acceleration they have [s]; infinite if none does."""
    at = _until_zero(guards.gap, guards.gap_rate, guards.gap_bend)
    return jnp.min(jnp.where(active < 0.5, at, jnp.inf), initial=jnp.inf)


def next_release(guards: Guards, active: Float[Array, " contacts"]) -> tuple[Int[Array, ""], Float[Array, ""]]:
    """Which closed contact opens first, and in what time [s] if its gap goes on growing as it does, or more slowly by
    the acceleration it has; infinite if none does."""
    at = _until_zero(-guards.gap, -guards.gap_rate, jnp.maximum(-guards.gap_bend, 0.0))
    at = jnp.where(active > 0.5, at, jnp.inf)
    which = jnp.argmin(at) if at.shape[0] else jnp.asarray(-1)
    return which, jnp.min(at, initial=jnp.inf)


def _until_zero(distance: Array, rate: Array, bend: Array) -> Float[Array, " contacts"]:
    """Until the parabola through a positive distance reaches zero [s]; infinite if it does not."""
    square = rate * rate - 2.0 * bend * distance
    root = jnp.sqrt(jnp.maximum(square, 0.0))
    closing = 2.0 * distance / jnp.maximum(root - rate, 1e-300)
    turning = (rate + root) / jnp.where(bend < 0.0, -bend, 1.0)
    at = jnp.where(rate < 0.0, closing, jnp.where(bend < 0.0, turning, jnp.inf))
    return jnp.where((square > 0.0) & (distance > 0.0), at, jnp.inf)


class Crossing(NamedTuple):
    """The first crossing in a step: which guard (-1: none), where [s from the step's start], the bracket's far end,
    whether the step holds no other."""

    which: Int[Array, ""]
    at: Float[Array, ""]
    far: Float[Array, ""]
    alone: Bool[Array, ""]


def _hermite(start: Array, end: Array, rate_start: Array, rate_end: Array, x: Array) -> Float[Array, " n"]:
    """The cubic through both ends with both rates (per step), at the fraction x of the step."""
    jump = end - start
    c2, c3 = 3.0 * jump - 2.0 * rate_start - rate_end, rate_start + rate_end - 2.0 * jump
    return start + x * (rate_start + x * (c2 + x * c3))


def _stationary(start: Array, end: Array, rate_start: Array, rate_end: Array) -> Float[Array, " n"]:
    """Where in (0, 1] the Hermite cubic's derivative falls through zero: it is negative at the end, and at the start
    where the cubic rises only in between."""
    jump = end - start
    a = 3.0 * (rate_start + rate_end - 2.0 * jump)
    b = 2.0 * (3.0 * jump - 2.0 * rate_start - rate_end)
    c = rate_start
    root = jnp.sqrt(jnp.maximum(b * b - 4.0 * a * c, 0.0))
    q = -0.5 * (b + jnp.where(b >= 0.0, root, -root))
    first = c / jnp.where(q == 0.0, 1.0, q)
    second = q / jnp.where(a == 0.0, 1e-300, a)
    inside = (first >= 0.0) & (first <= 1.0) & (q != 0.0) & (c > 0.0)
    return jnp.clip(jnp.where(inside, first, second), 0.0, 1.0)


def _root(before: Signed, after: Signed, step: Array, far: Array, bent: Array) -> Float[Array, " n"]:
    """Root in (0, far] of the polynomials through both ends that are negative at 0 and positive at ``far``, by Newton's
    method kept in its bracket: of degree five where second derivatives are known (``bent``), else three."""
    z0, m0, m1 = before.value, before.rate * step, after.rate * step
    jump = after.value - z0
    b0 = jnp.where(bent, before.bend * step**2, 6.0 * jump - 4.0 * m0 - 2.0 * m1)
    b1 = jnp.where(bent, after.bend * step**2, 2.0 * m0 + 4.0 * m1 - 6.0 * jump)
    c2, j, k, n = 0.5 * b0, jump - m0 - 0.5 * b0, m1 - m0 - b0, 0.5 * (b1 - b0)
    c3, c4, c5 = 10.0 * j - 4.0 * k + n, -15.0 * j + 7.0 * k - 2.0 * n, 6.0 * j - 3.0 * k + n
    low, high = jnp.zeros_like(far), far
    x = jnp.clip(-z0 / jnp.where(jump == 0.0, 1.0, jump), 0.0, 1.0) * far
    for _ in range(7):
        z = z0 + x * (m0 + x * (c2 + x * (c3 + x * (c4 + x * c5))))
        slope = m0 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + 5.0 * x * c5)))
        low, high = jnp.where(z < 0.0, x, low), jnp.where(z < 0.0, high, x)
        newton = x - z / jnp.where(slope == 0.0, 1.0, slope)
        x = jnp.where((newton >= low) & (newton <= high), newton, 0.5 * (low + high))
    return x


def first_crossing(
    before: Guards,
    after: Guards,
    step: Float[Array, ""],
    active: Float[Array, " contacts"],
    best: Float[Array, " observables"],
    ignored: Int[Array, ""],
    maxima: Bool[Array, ""],
) -> Crossing:
    """The earliest event in a step; most steps hold none, and are not searched.

    **Arguments:** guards at both ends of the step; ``step`` [s]; ``active``: which contacts are closed; ``best``: only
    maxima that (nearly) exceed it matter; ``ignored``: a guard left out (-1 for none); ``maxima``: whether to look for
    maxima at all.
    """
    start, end = signed(before, active), signed(after, active)
    rises = slice(0, before.gap.shape[0] + before.terminal.shape[0])
    dipping = (start.rate > 0.0) & (end.rate < 0.0)
    worth = jnp.concatenate([((end.value > 0.0) | dipping)[rises], _turned(before, after)])
    none = Crossing(jnp.asarray(-1), step, step, jnp.asarray(False))
    search = lambda: _first_crossing(before, after, step, active, best, ignored, maxima)  # noqa: E731
    return lax.cond(jnp.any(worth), search, lambda: none)


def _turned(before: Guards, after: Guards) -> Bool[Array, " observables"]:
    """Whether an observable has a maximum in a step: it rises first, or has risen though it fell first."""
    return ((before.slope > 0.0) | (after.value > before.value)) & (after.slope <= 0.0)


def _first_crossing(
    before: Guards, after: Guards, step: Array, active: Array, best: Array, ignored: Array, maxima: Array
) -> Crossing:
    contacts, terminals = before.gap.shape[0], before.terminal.shape[0]
    rises = slice(0, contacts + terminals)
    start, end = (Signed(*(part[rises] for part in signed(guards, active))) for guards in (before, after))
    # A guard left on zero or a little past it by the landing on its last event, and on its way back, has not crossed.
    start = start._replace(value=jnp.where((start.value >= 0.0) & (start.rate < 0.0), -1e-300, start.value))
    z0, z1, m0, m1 = start.value, end.value, start.rate * step, end.rate * step

    # A contact may touch and leave, or leave and touch, within one step: its guard has a maximum above zero inside.
    hump = _stationary(z0, z1, m0, m1)
    top = _hermite(z0, z1, m0, m1, hump)
    contact = jnp.arange(contacts + terminals) < contacts
    open_contact = jnp.concatenate([active < 0.5, jnp.zeros(terminals, bool)])
    dips = contact & (z0 < 0.0) & (z1 <= 0.0) & (m0 > 0.0) & (m1 < 0.0) & (top > 0.0)
    far = jnp.where(dips, hump, 1.0)
    root = _root(start, end, step, far, contact)
    # A guard already past zero at the start (by the tolerance of an earlier landing) acts at once if it stays there.
    root = jnp.where(z0 > 0.0, jnp.where(open_contact, 0.0, 1.0), root)
    crossed = (z1 > 0.0) | dips

    rise, fall = before.slope * step, after.slope * step
    peak = _stationary(before.value, after.value, rise, fall)
    height = _hermite(before.value, after.value, rise, fall, peak)
    peaked = _turned(before, after) & (jnp.maximum(height, after.value) > NEARLY * best) & maxima

    where = jnp.concatenate([jnp.where(crossed, root, jnp.inf), jnp.where(peaked, peak, jnp.inf)])
    where = jnp.where(jnp.arange(where.shape[0]) == ignored, jnp.inf, where)
    which = jnp.argmin(where)
    fraction = where[which]
    reach = jnp.concatenate([far, jnp.ones_like(peak)])[which]
    found = jnp.isfinite(fraction)
    alone = jnp.sum(jnp.isfinite(where)) == 1
    return Crossing(jnp.where(found, which, -1), jnp.where(found, fraction, 1.0) * step, reach * step, alone)
