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


def signed(
    guards: Guards, active: Float[Array, " contacts"]
) -> tuple[Float[Array, " guards"], Float[Array, " guards"]]:
    """All guards, negative before their event, and the rates of those that have one (0 for maxima)."""
    sign = jnp.where(active > 0.5, 1.0, -1.0)
    value = jnp.concatenate([sign * guards.gap, guards.terminal, -guards.slope])
    rate = jnp.concatenate([sign * guards.gap_rate, guards.terminal_rate, jnp.zeros_like(guards.slope)])
    return value, rate


def observe(system: HybridSystem, time: Array, state: Array, rate: Array, active: Array, best: Array) -> Guards:
    """Guards and observables with their rates.

    Observables of the state's rate need its second derivative, which costs as much as two right-hand sides: only where
    such an observable comes near its best so far. Elsewhere it counts as rising, slowly.
    """
    n = system.coordinates
    acceleration = jnp.zeros_like(rate).at[:n].set(rate[n : 2 * n])
    approach = lambda y, r: jax.jvp(system.gaps, (y,), (r,))  # noqa: E731
    (gap, gap_rate), (_, gap_bend) = jax.jvp(approach, (state, rate), (rate, acceleration))
    terminal, terminal_rate = jax.jvp(system.terminals, (state,), (rate,))
    of_rate = jnp.asarray(system.rate_observables(), bool)
    near = of_rate & (system.observables(state, rate, active) > NEAR_BEST * best)
    second = lax.cond(
        jnp.any(near),
        lambda: jax.jvp(lambda y: system.derivative(time, y, active), (state,), (rate,))[1],
        lambda: jnp.zeros_like(state),
    )
    value, slope = jax.jvp(lambda y, r: system.observables(y, r, active), (state, rate), (rate, second))
    slope = jnp.where(of_rate & ~near, 1e-300, slope)
    return Guards(gap, gap_rate, gap_bend, terminal, terminal_rate, value, slope, *system.invariant(state, active))


def next_touchdown(guards: Guards, active: Float[Array, " contacts"]) -> Float[Array, ""]:
    """Until an open contact closes, if all go on with the acceleration they have [s]; infinite if none does."""
    gap, rate, bend = guards.gap, guards.gap_rate, guards.gap_bend
    square = rate * rate - 2.0 * bend * gap
    root = jnp.sqrt(jnp.maximum(square, 0.0))
    closing = 2.0 * gap / jnp.maximum(root - rate, 1e-300)
    turning = (rate + root) / jnp.where(bend < 0.0, -bend, 1.0)
    at = jnp.where(rate < 0.0, closing, jnp.where(bend < 0.0, turning, jnp.inf))
    return jnp.min(jnp.where((active < 0.5) & (square > 0.0) & (gap > 0.0), at, jnp.inf), initial=jnp.inf)


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
    """Where in (0, 1] the Hermite cubic's derivative falls (or rises) through zero, its ends being of opposite sign."""
    jump = end - start
    a = 3.0 * (rate_start + rate_end - 2.0 * jump)
    b = 2.0 * (3.0 * jump - 2.0 * rate_start - rate_end)
    c = rate_start
    root = jnp.sqrt(jnp.maximum(b * b - 4.0 * a * c, 0.0))
    q = -0.5 * (b + jnp.where(b >= 0.0, root, -root))
    first = c / jnp.where(q == 0.0, 1.0, q)
    second = q / jnp.where(a == 0.0, 1e-300, a)
    inside = (first >= 0.0) & (first <= 1.0) & (q != 0.0)
    return jnp.clip(jnp.where(inside, first, second), 0.0, 1.0)


def _cubic_root(z0: Array, z1: Array, m0: Array, m1: Array, far: Array) -> Float[Array, " n"]:
    """Root of Hermite cubics in (0, far] that are negative at 0 and positive at ``far``: Newton kept in its bracket."""
    jump = z1 - z0
    c2, c3 = 3.0 * jump - 2.0 * m0 - m1, m0 + m1 - 2.0 * jump
    low, high = jnp.zeros_like(far), far
    x = jnp.clip(-z0 / jnp.where(jump == 0.0, 1.0, jump), 0.0, 1.0) * far
    for _ in range(7):
        z = z0 + x * (m0 + x * (c2 + x * c3))
        slope = m0 + x * (2.0 * c2 + 3.0 * x * c3)
        low, high = jnp.where(z < 0.0, x, low), jnp.where(z < 0.0, high, x)
        newton = x - z / jnp.where(slope == 0.0, 1.0, slope)
        x = jnp.where((newton > low) & (newton < high), newton, 0.5 * (low + high))
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
    z1, rate1 = signed(after, active)
    rises = slice(0, before.gap.shape[0] + before.terminal.shape[0])
    turned = (before.slope > 0.0) & (after.slope <= 0.0)
    dipping = (signed(before, active)[1] > 0.0) & (rate1 < 0.0)
    worth = jnp.concatenate([(z1 > 0.0)[rises] | dipping[rises], turned])
    none = Crossing(jnp.asarray(-1), step, step, jnp.asarray(False))
    search = lambda: _first_crossing(before, after, step, active, best, ignored, maxima)  # noqa: E731
    return lax.cond(jnp.any(worth), search, lambda: none)


def _first_crossing(
    before: Guards, after: Guards, step: Array, active: Array, best: Array, ignored: Array, maxima: Array
) -> Crossing:
    contacts, terminals = before.gap.shape[0], before.terminal.shape[0]
    z0, rate0 = signed(before, active)
    z1, rate1 = signed(after, active)
    m0, m1 = rate0 * step, rate1 * step
    rises = slice(0, contacts + terminals)
    # A guard left on zero or a little past it by the landing on its last event, and on its way back, has not crossed.
    z0 = jnp.where((z0 >= 0.0) & (m0 < 0.0), -1e-300, z0)

    # A contact may touch and leave, or leave and touch, within one step: its guard has a maximum above zero inside.
    hump = _stationary(z0[rises], z1[rises], m0[rises], m1[rises])
    top = _hermite(z0[rises], z1[rises], m0[rises], m1[rises], hump)
    open_contact = jnp.concatenate([active < 0.5, jnp.zeros(terminals, bool)])
    contact = jnp.arange(contacts + terminals) < contacts
    dips = contact & (z0[rises] < 0.0) & (z1[rises] <= 0.0) & (m0[rises] > 0.0) & (m1[rises] < 0.0) & (top > 0.0)
    far = jnp.where(dips, hump, 1.0)
    root = _cubic_root(z0[rises], z1[rises], m0[rises], m1[rises], far)
    # A guard already past zero at the start (by the tolerance of an earlier landing) acts at once if it stays there.
    root = jnp.where(z0[rises] > 0.0, jnp.where(open_contact, 0.0, 1.0), root)
    crossed = (z1[rises] > 0.0) | dips

    rise, fall = before.slope * step, after.slope * step
    peak = _stationary(before.value, after.value, rise, fall)
    height = _hermite(before.value, after.value, rise, fall, peak)
    peaked = (before.slope > 0.0) & (after.slope <= 0.0) & (jnp.maximum(height, after.value) > NEARLY * best) & maxima

    where = jnp.concatenate([jnp.where(crossed, root, jnp.inf), jnp.where(peaked, peak, jnp.inf)])
    where = jnp.where(jnp.arange(where.shape[0]) == ignored, jnp.inf, where)
    which = jnp.argmin(where)
    fraction = where[which]
    reach = jnp.concatenate([far, jnp.ones_like(peak)])[which]
    found = jnp.isfinite(fraction)
    alone = jnp.sum(jnp.isfinite(where)) == 1
    return Crossing(jnp.where(found, which, -1), jnp.where(found, fraction, 1.0) * step, reach * step, alone)
