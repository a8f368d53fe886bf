"""Hertz's pressure between a ball and a plane, and the one at which the softer side begins to yield."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar

PLANE = jnp.pi**3 / 6.0


def hertz_pressure(force: Scalar, radius: Scalar, young: Scalar, poisson: Scalar) -> Float[Array, "..."]:
    """Largest pressure [Pa] under a ball of ``radius`` [m] pressed with ``force`` [N] on a plane of its own material.

    p_0³ = 6 F E*²/(π³ R²), E* = E/(2 (1 - ν²)) (Johnson, Contact Mechanics 1985, eq. 4.24), with Young's modulus [Pa]
    and Poisson's ratio [-] of both.
    """
    modulus = young / (2.0 * (1.0 - poisson**2))
    return jnp.cbrt(jnp.asarray(force) * modulus**2 / (PLANE * radius**2))


def yield_pressure(stress: Scalar, poisson: Scalar) -> Float[Array, "..."]:
    """The largest Hertz pressure [Pa] at which the material below the surface begins to yield (von Mises).

    1.295 exp(0.736 ν) times the yield ``stress`` [Pa] (Jackson & Green 2005); 1.61 for ν = 0.3.
    """
    return 1.295 * jnp.exp(0.736 * jnp.asarray(poisson)) * stress
