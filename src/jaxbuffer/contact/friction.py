"""Tangential contact forces."""

import equinox as eqx
import jax.numpy as jnp

from .._types import Scalar, Values


class RegularisedCoulomb(eqx.Module):
    """Coulomb's friction, regularised by a slip speed (M59).

    - ``coefficient``: μ ≥ 0 [-].
    - ``slip_speed``: v_s > 0 [m/s]; its limit 0 is Coulomb's law.
    """

    coefficient: Scalar
    slip_speed: Scalar

    def force(self, normal_force: Values, slip: Values) -> Values:
        """Return the friction force along the tangent [N], in the shape of its arguments (M59).

        **Arguments:**

        - ``normal_force``: F_n [N].
        - ``slip``: v_t along the tangent [m/s].
        """
        return -self.coefficient * normal_force * jnp.tanh(slip / self.slip_speed)
