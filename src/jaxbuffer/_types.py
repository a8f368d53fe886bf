"""Types shared by every room."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

if TYPE_CHECKING:  # an int is a float there, and NumPy's arrays are not told apart from JAX's
    Scalar = Float[Array, ""] | float
else:
    Scalar = Float[Array | np.ndarray, ""] | float | int
"""A real number: Python's or NumPy's at construction, a 0-d array (or tracer) inside compiled code."""

Values = Float[Array, "*batch"]
"""One number, or an array of them treated together (a cone's flanks)."""


def stacked(values: Sequence[Scalar]) -> Float[Array, " n"]:
    """Scalars, Python's or traced, as one array."""
    return jnp.stack([jnp.asarray(value, float) for value in values])
