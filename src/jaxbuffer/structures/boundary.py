"""How much of a boundary belongs to each of its nodes, and what it encloses."""

import jax.numpy as jnp
from jaxtyping import Array, Float


def boundary_areas(path: Float[Array, "nodes 2"]) -> Float[Array, "nodes 2"]:
    """Return area times outward normal of each node of a boundary that is followed with the inside on its left [m², a
    metre deep]: half of either side's."""
    along = path[1:] - path[:-1]
    normal = 0.5 * jnp.stack([along[:, 1], -along[:, 0]], axis=1)
    return jnp.zeros_like(path).at[:-1].add(normal).at[1:].add(normal)


def enclosed(path: Float[Array, "nodes 2"]) -> Float[Array, ""]:
    """Return the area inside a boundary as of `boundary_areas` that is closed, or has both ends at one height; or that
    begins and ends level on the vertical axis, which then bounds it too [m²]."""
    # Trapezoids between the path and the vertical axis add up to what is enclosed.
    x, y = path[:, 0], path[:, 1]
    return 0.5 * jnp.sum((x[1:] + x[:-1]) * (y[1:] - y[:-1]))
