"""Types shared by every room."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

Scalar = Float[Array, ""] | float
"""A real number: a Python float at construction, a 0-d array (or tracer) inside compiled code."""

BoolScalar = Bool[Array, ""] | bool
IntScalar = Int[Array, ""] | int


def stacked(values: list[Scalar]) -> Float[Array, " n"]:
    """Scalars, Python's or traced, as one array."""
    return jnp.stack([jnp.asarray(value, float) for value in values])
