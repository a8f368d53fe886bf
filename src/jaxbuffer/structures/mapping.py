"""How a four-node element maps its square of ξ and η onto the plane, and where it is integrated (M130)."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

SIGNS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])  # ξ, η of the corners
GAUSS = np.array([-1.0, 1.0]) / np.sqrt(3.0)  # two points from side to side, of the weight 1 each


class Rule(NamedTuple):
    """Integration points over the square, pair by pair from the side 1-2 to the side 3-4.

    - ``points``: (points, 2) ξ, η.
    - ``weights``: (points,)
    """

    points: Float[np.ndarray, "points 2"]
    weights: Float[np.ndarray, " points"]

    @staticmethod
    def of(across: int = 2) -> "Rule":
        """Make Gauss's rule with two points along ξ and, along η, two as well or more of Lobatto's, which has the first
        and the last on the element's sides."""
        at, weights = GAUSS, np.ones(2)
        if across > 2:
            legendre = np.polynomial.legendre.Legendre.basis(across - 1)
            at = np.concatenate([[-1.0], np.sort(np.real(legendre.deriv().roots())), [1.0]])
            weights = 2.0 / (across * (across - 1) * legendre(at) ** 2)
        return Rule(np.stack([np.tile(GAUSS, across), np.repeat(at, 2)], axis=1), np.repeat(weights, 2))

    @property
    def shapes(self) -> Float[np.ndarray, "points corners"]:
        """Return N of the corners."""
        return 0.25 * np.prod(1.0 + SIGNS[None] * self.points[:, None], axis=-1)

    @property
    def slopes(self) -> Float[np.ndarray, "points corners 2"]:
        """Return ∂N/∂(ξ, η)."""
        return 0.25 * SIGNS[None] * (1.0 + (SIGNS[None] * self.points[:, None])[..., ::-1])


class Mapping(NamedTuple):
    """The map at the integration points.

    - ``weight``: (elements, points) area of each point [m²].
    - ``inverse``: (elements, points, 2, 2) ∂(ξ, η)/∂X [1/m].
    - ``gradient``: (elements, points, 4, 2) ∂N/∂X of the corners' shape functions [1/m].
    """

    weight: Float[Array, "elements points"]
    inverse: Float[Array, "elements points 2 2"]
    gradient: Float[Array, "elements points 4 2"]

    @staticmethod
    def of(corners: Float[Array, "elements 4 2"], rule: Rule) -> "Mapping":
        """Map elements from the corners' positions [m], counter-clockwise."""
        slopes = rule.slopes
        jacobian = jnp.einsum("pck,eci->epik", slopes, corners)  # ∂X/∂(ξ, η)
        a, b, c, d = jacobian[..., 0, 0], jacobian[..., 0, 1], jacobian[..., 1, 0], jacobian[..., 1, 1]
        determinant = a * d - b * c
        # Written out for two by two, as all points of all elements are inverted at once.
        adjugate = jnp.stack([jnp.stack([d, -b], axis=-1), jnp.stack([-c, a], axis=-1)], axis=-2)
        inverse = adjugate / determinant[..., None, None]
        return Mapping(determinant * rule.weights[None], inverse, jnp.einsum("pck,epki->epci", slopes, inverse))
