"""Damping factor and delivered restitution of K δⁿ (1 + d δ̇/δ̇⁻): one exact relation, solved either way.

The relation is M46, solved in the form M47, which has no trivial root d = 0 and no cancellation.
"""

import functools

import jax
import jax.numpy as jnp
from jax import lax

from ..._types import Scalar

SERIES_BELOW = 0.05
INLINED = functools.partial(jax.jit, inline=True)  # called by itself it is compiled once, not at every call
TERMS = 14  # of the series: its first neglected term is below 0.05^14 / 16


def psi(x: Scalar) -> Scalar:
    """Return (ln(1 + x) - x)/x² for x > -1 (M47)."""
    x = jnp.asarray(x, float)
    small = jnp.abs(x) < SERIES_BELOW
    # Each branch gets an argument that it can take: NaN of one that is not taken would reach the derivative.
    far = jnp.where(small, 1.0, x)
    near = jnp.where(small, x, 0.0)
    series = jnp.zeros_like(near)
    for k in reversed(range(TERMS)):
        # Horner's rule, from the last term.
        series = (-1.0) ** (k + 1) / (k + 2) + near * series
    return jnp.where(small, series, (jnp.log1p(far) - far) / (far * far))


def _imbalance(d: Scalar, e: Scalar) -> Scalar:
    # 1 - d e may round to zero where e is small: the limit is -∞, on the right side.
    return psi(d) - e * e * psi(-jnp.minimum(d * e, 1.0 - 1e-16))


def _root(function, low: Scalar, high: Scalar) -> Scalar:
    """Return where an increasing function crosses zero, by bisection to the last digit."""

    def halve(_, bracket):
        low, high = bracket
        middle = 0.5 * (low + high)
        below = function(middle) < 0.0
        return jnp.where(below, middle, low), jnp.where(below, high, middle)

    low, high = lax.fori_loop(0, 62, halve, (jnp.asarray(low, float), jnp.asarray(high, float)))
    return 0.5 * (low + high)


# Bisection has no derivative: the rules of this module take it from the relation that is solved (M47).
@jax.custom_jvp
@INLINED
def damping_delivering(restitution: Scalar) -> Scalar:
    """Return the factor d [-] with which two free bodies part at ``restitution`` times their approach speed, for values
    in (0, 1]."""
    e = jnp.asarray(restitution, float)
    # The relation's imbalance is least at d = 1/e - 1 and infinite at 1/e: the root lies between.
    return jnp.where(e < 1.0, _root(lambda d: _imbalance(d, e), 1.0 / e - 1.0, 1.0 / e), 0.0)


@damping_delivering.defjvp
def _damping_jvp(primals: tuple, tangents: tuple) -> tuple:
    (e,), (move,) = primals, tangents
    d = damping_delivering(e)
    return d, _slope(d, e)[0] * move


@jax.custom_jvp
@INLINED
def restitution_delivered(factor: Scalar) -> Scalar:
    """Return the restitution e [-] at which two free bodies part when the law's ``factor`` is d ≥ 0 [-]."""
    d = jnp.asarray(factor, float)
    return _root(lambda e: _imbalance(d, e), jnp.zeros_like(d), 1.0 / jnp.maximum(d, 1.0))


@restitution_delivered.defjvp
def _restitution_jvp(primals: tuple, tangents: tuple) -> tuple:
    (d,), (move,) = primals, tangents
    e = restitution_delivered(d)
    return e, _slope(d, e)[1] * move


def _slope(d: Scalar, e: Scalar) -> tuple[Scalar, Scalar]:
    """Return dd/de and de/dd along the relation (M47); the limit of dd/de at d = 0 is -3/2."""
    d, e = jnp.asarray(d, float), jnp.asarray(e, float)
    # Near d = 0 numerator and denominator vanish together: the limit takes their place.
    small = d < 1e-7
    below = jnp.where(small, 1.0, (1.0 + e) * (e - 1.0 + d * e))
    slope = jnp.where(small, -1.5, -d * e * (1.0 + d) / below)
    return slope, 1.0 / slope
