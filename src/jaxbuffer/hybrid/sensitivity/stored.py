"""Values that are evaluated once and stored, however many users they have."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Float, Int


class Store(NamedTuple):
    """Has XLA store a vector rather than evaluate it anew in every operation that uses it.

    XLA does that with cheap operations: sums, products, and all else but divisions, roots and reductions. So a vector
    is reduced: the bitwise *and* of it and itself, which XLA cannot know to be so, as ``zeros`` (whole numbers) are
    joined to its bits before. A division by one does the same and takes four times as long.
    """

    zeros: Int[Array, "2"]

    @staticmethod
    def of(example: Float[Array, "..."]) -> "Store":
        """Make the zeros from any two numbers of an array, which must hold two or more."""
        nothing = 0.0 * jnp.ravel(example)[:2]  # either zero, or NaN
        return Store(_bits(nothing / (1.0 + nothing)) & 1)  # a division, so that it is stored itself

    def __call__(self, vector: Float[Array, " n"]) -> Float[Array, " n"]:
        """Return the same vector, stored."""
        twice = _bits(vector)[None, :] | self.zeros[:, None]
        same = lax.reduce(twice, np.array(-1, twice.dtype), lax.bitwise_and, (0,))
        return lax.bitcast_convert_type(same, vector.dtype)


def _bits(values: Float[Array, "..."]) -> Int[Array, "..."]:
    """Read numbers as whole numbers of the same bits."""
    return lax.bitcast_convert_type(values, f"int{8 * values.dtype.itemsize}")
