"""Types shared by every room."""

from jaxtyping import Array, Bool, Float, Int

Scalar = Float[Array, ""] | float
"""A real number: a Python float at construction, a 0-d array (or tracer) inside compiled code."""

BoolScalar = Bool[Array, ""] | bool
IntScalar = Int[Array, ""] | int
