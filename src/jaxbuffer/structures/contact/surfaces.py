"""Surfaces that nodes touch, and the pairs of a node and its foot on one (M139)."""

from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..._types import Scalar
from ..incidence import added_at

TERRITORY = 0.05  # of a segment's length by which it goes on beyond either end for the foot of a node
DEEPEST = 0.5  # of a segment's length: a node further behind it is on another side of the body


class Pairs(NamedTuple):
    """Nodes and their feet.

    - ``gap``: (pairs,) distance from the surface, negative behind it [m].
    - ``normal``: (pairs, 2) from the surface to the node [-].
    - ``nodes``: (pairs, 2) the surface's nodes beside the foot.
    - ``weights``: (pairs, 2) φ, how much of the foot moves with each [-].
    - ``present``: (pairs,) whether there is a foot.
    """

    gap: Float[Array, " pairs"]
    normal: Float[Array, "pairs 2"]
    nodes: Int[Array, "pairs 2"]
    weights: Float[Array, "pairs 2"]
    present: Bool[Array, " pairs"]

    def along(self, slaves: np.ndarray, vectors: Float[Array, "nodes 2"], direction: Float[Array, "pairs 2"]) -> Array:
        """Return by how much the nodes' ``vectors`` part node and foot of each pair (pairs,) along a ``direction``."""
        foot = jnp.sum(self.weights[..., None] * vectors[self.nodes], axis=1)
        return jnp.sum((vectors[slaves] - foot) * direction, axis=1)


class RigidPlane(eqx.Module):
    """A rigid plane through a node, which may have a mass and move.

    - ``node``: its number.
    - ``normal``: (2,) to the side where others are [-].
    """

    node: int = eqx.field(static=True)
    normal: tuple[Scalar, Scalar]

    def pairs(self, slaves: np.ndarray, positions: Float[Array, "nodes 2"], near: Any = None) -> Pairs:
        """Pair all ``slaves`` with their feet."""
        count = len(slaves)
        normal = jnp.broadcast_to(jnp.asarray([self.normal]), (count, 2))
        gap = jnp.sum((positions[slaves] - positions[self.node][None]) * normal, axis=1)
        nodes, weights = jnp.full((count, 2), self.node), jnp.broadcast_to(jnp.asarray([[1.0, 0.0]]), (count, 2))
        return Pairs(gap, normal, nodes, weights, jnp.ones(count, bool))

    def on_nodes(self, slaves: np.ndarray, force: Float[Array, "pairs 2"], nodes: int) -> Float[Array, "nodes 2"]:
        """Return the (nodes, 2) forces on the slaves and, against them, on the plane's node."""
        # By a mask, since XLA writes a scatter as a loop over its numbers (see `Incidence`).
        against = jnp.where(jnp.arange(nodes)[:, None] == self.node, jnp.sum(force, axis=0)[None], 0.0)
        return added_at(slaves, force, nodes) - against


class Segments(eqx.Module):
    """A chain of straight segments between nodes; the body is on the left of each.

    - ``ends``: (segments, 2) the nodes.
    """

    ends: np.ndarray

    def pairs(self, slaves: np.ndarray, positions: Float[Array, "nodes 2"], near: Any) -> Pairs:
        """Pair each slave with its foot on the nearest of the segments ``near`` it (pairs, some): see `candidates`."""
        ends = jnp.asarray(self.ends)[near]
        start, along = positions[ends[..., 0]], positions[ends[..., 1]] - positions[ends[..., 0]]
        squared = jnp.sum(along * along, axis=-1)
        off = positions[jnp.asarray(slaves)][:, None] - start
        share = jnp.sum(off * along, axis=-1) / squared
        on = jnp.clip(share, 0.0, 1.0)
        length = jnp.sqrt(squared)
        normal = jnp.stack([along[..., 1], -along[..., 0]], axis=-1) / length[..., None]
        gap = jnp.sum(off * normal, axis=-1)
        beside = (share - on) * length
        # A foot a little beyond an end still counts, so that none is lost between two segments.
        fits = (jnp.abs(share - on) <= TERRITORY) & (gap > -DEEPEST * length)
        distance = jnp.where(fits, jnp.hypot(jnp.where(fits, gap, 1.0), beside), jnp.inf)
        best = jnp.argmin(distance, axis=1)
        pick = lambda x: jnp.take_along_axis(x, best.reshape(-1, *[1] * (x.ndim - 1)), axis=1)[:, 0]  # noqa: E731
        weight = pick(on)
        return Pairs(
            pick(gap), pick(normal), pick(ends), jnp.stack([1.0 - weight, weight], axis=1), jnp.any(fits, axis=1)
        )


Surface = RigidPlane | Segments
