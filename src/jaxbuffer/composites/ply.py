"""One ply: its stiffness in its own axes and turned."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked


class Ply(NamedTuple):
    """A ply in plane stress.

    - ``along``, ``across``: Young's moduli E1 along the fibres and E2 across them [Pa].
    - ``shear``: G12 [Pa].
    - ``poisson``: ν12 [-].
    - ``thickness``: [m].
    """

    along: Scalar
    across: Scalar
    shear: Scalar
    poisson: Scalar
    thickness: Scalar

    def stiffness(self, angle: Scalar = 0.0) -> Float[Array, "3 3"]:
        """Return Q̄ [Pa]: stress from strain (εx, εy, γxy) in axes from which the fibres are turned by ``angle`` [°]
        (M156)."""
        other = self.poisson * self.across / self.along  # ν21
        factor = 1.0 / (1.0 - self.poisson * other)
        q11, q12, q22 = factor * self.along, factor * self.poisson * self.across, factor * self.across
        own = stacked([q11, q12, 0.0, q12, q22, 0.0, 0.0, 0.0, self.shear]).reshape(3, 3)
        # The same matrix turns strains there and stresses back, since their product, work, does not change.
        turn = in_ply_axes(angle)
        return turn.T @ own @ turn


def in_ply_axes(angle: Scalar) -> Float[Array, "3 3"]:
    """Return the matrix that turns strains (εx, εy, γxy) into the axes of a ply whose fibres are at ``angle`` [°]; its
    transpose turns the ply's stresses (σ1, σ2, τ12) back."""
    radians = jnp.deg2rad(jnp.asarray(angle, float))
    c, s = jnp.cos(radians), jnp.sin(radians)
    return stacked([c * c, s * s, c * s, s * s, c * c, -c * s, -2.0 * c * s, 2.0 * c * s, c * c - s * s]).reshape(3, 3)
