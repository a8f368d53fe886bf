"""How time passes within a step: the substitution t = t(x), with x from 0 to 1 over the step."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float


class TimeTransform(NamedTuple):
    """The time since the step's start as a quadratic function of x: start·x + growth·x²/2.

    Just after a touchdown and just before a release the force goes with the 3/2 power of time, and its sensitivity with
    the square root. In the square root of the time from the event both are smooth, and a method keeps its order.

    ``start`` [s]: dt/dx at the step's start; ``growth`` [s]: d²t/dx².
    """

    start: Float[Array, ""]
    growth: Float[Array, ""]

    @staticmethod
    def uniform(length: Float[Array, ""]) -> "TimeTransform":
        """Let time pass evenly in a step of a ``length`` [s]."""
        return TimeTransform(length, jnp.zeros(()))

    @staticmethod
    def after_touchdown(elapsed: Float[Array, ""], length: Float[Array, ""]) -> "TimeTransform":
        """Let the step, which starts ``elapsed`` [s] after a touchdown, be even in the square root of the time from
        there."""
        before, after = jnp.sqrt(elapsed), jnp.sqrt(elapsed + length)
        root = length / jnp.maximum(before + after, 1e-150)
        return TimeTransform(2.0 * before * root, 2.0 * root * root)

    @staticmethod
    def onto_release(length: Float[Array, ""]) -> "TimeTransform":
        """Let the step, which ends on a release, be even in the square root of the time until there."""
        return TimeTransform(2.0 * length, -2.0 * length)

    @property
    def length(self) -> Float[Array, ""]:
        """Return the length of the whole step [s]."""
        return self.start + 0.5 * self.growth

    def derivative(self, x: np.ndarray | Array) -> Float[Array, " nodes"]:
        """Return dt/dx [s] at the fractions ``x`` of the step."""
        return self.start + self.growth * x

    def elapsed(self, x: np.ndarray | Array) -> Float[Array, " nodes"]:
        """Return the time since the step's start [s] at the fractions ``x`` of the step."""
        return (self.start + 0.5 * self.growth * x) * x
