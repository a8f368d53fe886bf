"""Which nodes the corners of elements are: numbers of nodes handed to elements, and forces gathered back."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int


class Incidence(NamedTuple):
    """Both ways between nodes and corners are gathers: XLA writes a scatter as a loop over its numbers.

    - ``corners``: (elements, corners) the node of each corner.
    - ``places``: (nodes, most) which corners meet in a node, counted through all elements; their number for none.
    """

    corners: Int[np.ndarray, "elements corners"]
    places: Int[np.ndarray, "nodes most"]

    @staticmethod
    def of(corners: np.ndarray, nodes: int) -> "Incidence":
        """Make both ways from the node of each corner (elements, corners) and the number of nodes."""
        corners = np.asarray(corners, int)
        meeting: list[list[int]] = [[] for _ in range(nodes)]
        for place, node in enumerate(corners.ravel()):
            meeting[node].append(place)
        most = max([1, *map(len, meeting)])
        # Filled up with the number of a zero that stands behind all corners, so that every node gathers as many.
        places = np.array([[*group, *[corners.size] * (most - len(group))] for group in meeting], int)
        return Incidence(corners, places.reshape(nodes, most))

    def to_corners(self, values: Float[Array, "nodes *rest"]) -> Float[Array, "elements corners *rest"]:
        """Return the nodes' numbers at each element's corners."""
        return values[self.corners]

    def to_nodes(self, values: Float[Array, "elements corners *rest"]) -> Float[Array, "nodes *rest"]:
        """Sum the numbers of the corners that meet in each node."""
        flat = values.reshape(-1, *values.shape[2:])
        padded = jnp.concatenate([flat, jnp.zeros((1, *flat.shape[1:]))])
        total = padded[self.places[:, 0]]
        for k in range(1, self.places.shape[1]):
            total = total + padded[self.places[:, k]]
        return total


def added_at(places: Int[Array, " values"] | np.ndarray, values: Float[Array, "values *rest"], count: int) -> Array:
    """Sum the ``values`` at each of ``count`` places, (count, …); by a gather where the places are known beforehand."""
    if isinstance(places, np.ndarray):
        return Incidence.of(places[:, None], count).to_nodes(values[:, None])
    return jnp.zeros((count, *values.shape[1:])).at[places].add(values)
