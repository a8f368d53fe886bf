"""The global search: which segments are near a node (M139)."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

Candidates = Int[Array, "pairs some"]


def candidates(slaves: np.ndarray, ends: np.ndarray, positions: Float[Array, "nodes 2"], some: int = 4) -> Candidates:
    """Return the ``some`` segments whose middles are nearest to each slave: nothing further away can hold its foot as
    long as it moves by less than a segment's length.

    All pairs are looked at. Of 200 nodes and 200 segments that takes as long as two steps of their elements, and it is
    done once in many steps; sorted buckets would win from some 1000 on.
    """
    middles = 0.5 * (positions[ends[:, 0]] + positions[ends[:, 1]])
    off = positions[slaves][:, None] - middles[None]
    some = min(some, len(ends))
    return jax.lax.top_k(-jnp.sum(jax.lax.stop_gradient(off) ** 2, axis=-1), some)[1]
