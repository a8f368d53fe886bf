"""Logarithmic strain in the plane (M132)."""

import jax.numpy as jnp
from jaxtyping import Array, Float

SMALL = 1e-3  # the square of the argument below which a series is exact to rounding


def logarithmic(c11: Array, c22: Array, c12: Array) -> Float[Array, "*batch 3"]:
    """Return ½ ln C as (ε11, ε22, γ12), from C = FᵀF, in closed form and smooth where the principal stretches are
    equal.

    **Example:** a stretch to twice the length.

    >>> strain = logarithmic(jnp.array(4.0), jnp.array(1.0), jnp.array(0.0))
    >>> f"{float(strain[0]):.6f}, that is ln 2; {float(strain[1]):.1f}"
    '0.693147, that is ln 2; 0.0'
    """
    mean, half = 0.5 * (c11 + c22), 0.5 * (c11 - c22)
    squared = (half * half + c12 * c12) / (mean * mean)
    # For small strains 1 - s² loses the digits of s², which `log1p` keeps.
    isotropic = jnp.log(mean) + 0.5 * jnp.log1p(-squared)  # ½ ln det C
    turned = _artanh_over_argument(squared) / mean
    return 0.5 * jnp.stack([isotropic + turned * half, isotropic - turned * half, 2.0 * turned * c12], axis=-1)


def _artanh_over_argument(squared: Array) -> Array:
    """Return artanh(x)/x from x²."""
    series = 1.0 + squared * (1.0 / 3.0 + squared * (1.0 / 5.0 + squared * (1.0 / 7.0 + squared / 9.0)))
    # Each branch gets an argument that it can take: NaN of one that is not taken would reach the derivative.
    x = jnp.sqrt(jnp.where(squared < SMALL, 0.25, squared))
    return jnp.where(squared < SMALL, series, jnp.arctanh(x) / x)
