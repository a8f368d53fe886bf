"""Tangential contact forces."""

import equinox as eqx
import jax.numpy as jnp

from .._types import Scalar, Values


class RegularisedCoulomb(eqx.Module):
    """F_t = -μ F_n tanh(v_t / v_s).

    **Arguments:** ``coefficient`` μ ≥ 0 [-]; ``slip_speed`` v_s > 0 [m/s], whose limit 0 is Coulomb's law.
    """

    coefficient: Scalar
    slip_speed: Scalar

    def force(self, normal_force: Values, slip: Values) -> Values:
        """F_t [N], against the slip v_t [m/s]."""
        return -self.coefficient * normal_force * jnp.tanh(slip / self.slip_speed)
