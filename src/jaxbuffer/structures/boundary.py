"""How much of a boundary belongs to each of its nodes."""

import jax.numpy as jnp
from jaxtyping import Array, Float


def boundary_areas(path: Float[Array, "nodes 2"]) -> Float[Array, "nodes 2"]:
    """Area times outward normal of each node of a boundary that is followed with the inside on its left [m², a metre
    deep]: half of either side's."""
    along = path[1:] - path[:-1]
    normal = 0.5 * jnp.stack([along[:, 1], -along[:, 0]], axis=1)
    return jnp.zeros_like(path).at[:-1].add(normal).at[1:].add(normal)
