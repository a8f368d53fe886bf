"""How time passes in a step."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float


class Stride(NamedTuple):
    """A step's length [s] and how time passes in it: start·x + growth·x²/2 at the fraction x of the way.

    Just after a touchdown and just before a release the force goes with the 3/2 power of time, and its sensitivity with
    the square root: in the square root of the time from the event both are smooth, and a method keeps its order.
    """

    start: Float[Array, ""]
    growth: Float[Array, ""]

    @staticmethod
    def even(length: Float[Array, ""]) -> "Stride":
        """A step in which time passes evenly."""
        return Stride(length, jnp.zeros(()))

    @staticmethod
    def after(elapsed: Float[Array, ""], length: Float[Array, ""]) -> "Stride":
        """A step that starts ``elapsed`` [s] after a touchdown: even in the root of the time from there."""
        before, after = jnp.sqrt(elapsed), jnp.sqrt(elapsed + length)
        root = length / jnp.maximum(before + after, 1e-150)
        return Stride(2.0 * before * root, 2.0 * root * root)

    @staticmethod
    def onto(length: Float[Array, ""]) -> "Stride":
        """A step that ends on a release."""
        return Stride(2.0 * length, -2.0 * length)

    @property
    def length(self) -> Float[Array, ""]:
        """The whole step [s]."""
        return self.start + 0.5 * self.growth

    def pace(self, x: np.ndarray | Array) -> Float[Array, " nodes"]:
        """Time per fraction of the way [s]."""
        return self.start + self.growth * x

    def passed(self, x: np.ndarray | Array) -> Float[Array, " nodes"]:
        """Time since the step's start [s]."""
        return (self.start + 0.5 * self.growth * x) * x
