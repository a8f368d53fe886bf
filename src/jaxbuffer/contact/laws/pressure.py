"""Hertz's pressure between a ball and a plane, and the one at which the softer side begins to yield."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar

PLANE = jnp.pi**3 / 6.0


def hertz_pressure(force: Scalar, radius: Scalar, modulus: Scalar) -> Float[Array, "..."]:
    """Return the largest pressure under a ball that is pressed on a plane [Pa] (M55).

    **Arguments:**

    - ``force``: F_n [N].
    - ``radius``: of the ball [m].
    - ``modulus``: E* of both bodies [Pa], see `contact_modulus`.
    """
    return jnp.cbrt(jnp.asarray(force) * modulus**2 / (PLANE * radius**2))


def yield_pressure(stress: Scalar, poisson: Scalar) -> Float[Array, "..."]:
    """Return the largest pressure [Pa] at which the material below the surface begins to yield (M56); 1.61 ``stress``
    for ν = 0.3.

    **Arguments:** ``stress``: yield stress [Pa]; ``poisson``: Poisson's ratio [-].
    """
    return 1.295 * jnp.exp(0.736 * jnp.asarray(poisson)) * stress
