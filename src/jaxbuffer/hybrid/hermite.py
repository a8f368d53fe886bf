"""Hermite's polynomials between the two ends of a step: cubics from values and rates, quintics from second derivatives
too."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from .system import HybridSystem, State

ROUNDED = 1e-6  # of a step

Values = Float[Array, " *values"]


def cubic(start: Values, end: Values, rate_start: Values, rate_end: Values, x: Values | Scalar) -> Values:
    """Return the cubic through both ends with both rates (per step) at the fraction x of the step."""
    jump = end - start
    c2, c3 = 3.0 * jump - 2.0 * rate_start - rate_end, rate_start + rate_end - 2.0 * jump
    return start + x * (rate_start + x * (c2 + x * c3))


def maximum_of_cubic(start: Values, end: Values, rate_start: Values, rate_end: Values) -> Values:
    """Return where in (0, 1] the cubic has its maximum: its derivative is negative at the end, and at the start where
    the cubic rises only in between."""
    jump = end - start
    a = 3.0 * (rate_start + rate_end - 2.0 * jump)
    b = 2.0 * (3.0 * jump - 2.0 * rate_start - rate_end)
    c = rate_start
    # The stable form of both roots: q never subtracts numbers of like size.
    root = jnp.sqrt(jnp.maximum(b * b - 4.0 * a * c, 0.0))
    q = -0.5 * (b + jnp.where(b >= 0.0, root, -root))
    first = c / jnp.where(q == 0.0, 1.0, q)
    second = q / jnp.where(a == 0.0, 1e-300, a)
    # of a maximum at the very end rounding may put the root just beyond: the other one is then far from any maximum
    inside = (first >= 0.0) & (first <= 1.0 + ROUNDED) & (q != 0.0) & (c > 0.0)
    return jnp.clip(jnp.where(inside, first, second), 0.0, 1.0)


def quintic(
    start: tuple[Values, Values, Values], end: tuple[Values, Values, Values], step: Scalar, x: Scalar
) -> tuple[Values, Values]:
    """Return value and rate, at the fraction x of a ``step`` [s], of the polynomial that has at both ends the values,
    rates [1/s] and second derivatives [1/s²] given."""
    y0, f0, g0 = start[0], step * start[1], 0.5 * step**2 * start[2]
    y1, f1, g1 = end[0], step * end[1], 0.5 * step**2 * end[2]
    # what the quadratic from the start lacks at the end: value, first and half the second derivative
    a, b, c = y1 - y0 - f0 - g0, f1 - f0 - 2.0 * g0, g1 - g0
    c3, c4, c5 = 10.0 * a - 4.0 * b + c, -15.0 * a + 7.0 * b - 2.0 * c, 6.0 * a - 3.0 * b + c
    value = y0 + x * (f0 + x * (g0 + x * (c3 + x * (c4 + x * c5))))
    rate = f0 + x * (2.0 * g0 + x * (3.0 * c3 + x * (4.0 * c4 + x * (5.0 * c5))))
    return value, rate / step


def state_within(
    system: HybridSystem, start: tuple[State, State], end: tuple[State, State], step: Scalar, x: Scalar
) -> State:
    """Return the state at the fraction x of a ``step`` [s], from the state and its rate at both ends.

    Of the coordinates the second derivatives are known too: they are quintic, the velocities are those with which the
    quintics move. All else is cubic.
    """
    (y0, f0), (y1, f1), n = start, end, system.coordinates
    after = n + system.velocities
    rest = cubic(y0[after:], y1[after:], step * f0[after:], step * f1[after:], x)
    first, last = ((y[:n], f[:n], system.position_acceleration(y, f)) for y, f in (start, end))
    q, rate = quintic(first, last, step, x)
    return jnp.concatenate([q, system.position_rate(q).velocity(rate), rest])
