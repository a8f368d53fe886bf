"""Choosing between trees of arrays."""

from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

T = TypeVar("T")


def where(condition: Bool[Array, ""], new: T, old: T) -> T:
    """Apply `jax.numpy.where` to every leaf."""
    return jax.tree.map(lambda a, b: jnp.where(condition, a, b), new, old)
