"""How a four-node element maps its square of ξ and η onto the plane (M130)."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

SIGNS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])  # ξ, η of the corners
POINTS = SIGNS / np.sqrt(3.0)  # ξ, η of the integration points
SHAPES = 0.25 * (1.0 + SIGNS[:, 0] * POINTS[:, :1]) * (1.0 + SIGNS[:, 1] * POINTS[:, 1:])  # N (points, corners)
SLOPES = (
    0.25
    * np.stack(  # ∂N/∂(ξ, η) (points, corners, 2)
        [SIGNS[:, 0] * (1.0 + SIGNS[:, 1] * POINTS[:, 1:]), SIGNS[:, 1] * (1.0 + SIGNS[:, 0] * POINTS[:, :1])], axis=-1
    )
)


class Mapping(NamedTuple):
    """The map at the integration points.

    - ``weight``: (elements, 4) area of each point [m²].
    - ``inverse``: (elements, 4, 2, 2) ∂(ξ, η)/∂X [1/m].
    - ``gradient``: (elements, 4, 4, 2) ∂N/∂X of the corners' shape functions [1/m].
    """

    weight: Float[Array, "elements 4"]
    inverse: Float[Array, "elements 4 2 2"]
    gradient: Float[Array, "elements 4 4 2"]

    @staticmethod
    def of(corners: Float[Array, "elements 4 2"]) -> "Mapping":
        """From the corners' positions [m], counter-clockwise."""
        jacobian = jnp.einsum("pck,eci->epik", SLOPES, corners)  # ∂X/∂(ξ, η)
        a, b, c, d = jacobian[..., 0, 0], jacobian[..., 0, 1], jacobian[..., 1, 0], jacobian[..., 1, 1]
        weight = a * d - b * c
        adjugate = jnp.stack([jnp.stack([d, -b], axis=-1), jnp.stack([-c, a], axis=-1)], axis=-2)
        inverse = adjugate / weight[..., None, None]
        return Mapping(weight, inverse, jnp.einsum("pck,epki->epci", SLOPES, inverse))
