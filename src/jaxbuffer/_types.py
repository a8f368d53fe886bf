"""Types shared by every room."""

from collections.abc import Sequence

import jax.numpy as jnp
from jaxtyping import Array, Float

Scalar = Float[Array, ""] | float
"""A real number: a Python float at construction, a 0-d array (or tracer) inside compiled code."""

Values = Float[Array, "*batch"]
"""One number, or an array of them treated together (a cone's flanks)."""


def stacked(values: Sequence[Scalar]) -> Float[Array, " n"]:
    """Scalars, Python's or traced, as one array."""
    return jnp.stack([jnp.asarray(value, float) for value in values])
