"""Sensitivities as extra rows of the state: row 0 is y, row i is ∂y/∂p_i times a scale, all under one error control.

AD through an adaptive loop bounds the error of the state only; carrying S = ∂y/∂p as state bounds its error too
(docs/numerics.md). Every function of (parameters, state) is lifted to rows by one push-forward a row.
"""

from collections.abc import Callable
from typing import Generic, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

Rows = Float[Array, "rows state"]
P = TypeVar("P")


class Lanes(eqx.Module, Generic[P]):
    """The primal parameters and, stacked along a leading axis, one direction for each sensitivity row.

    ``directions`` has the structure of ``primal`` with a leading axis on each array; None for no sensitivities.
    """

    primal: P
    directions: P | None = None

    @property
    def count(self) -> int:
        """Number of sensitivity rows."""
        leaves = jax.tree.leaves(self.directions)
        return leaves[0].shape[0] if leaves else 0

    def start(self, function: Callable[[P], Float[Array, " state"]]) -> Rows:
        """Rows of a function of the parameters alone."""
        value = function(self.primal)[None]
        if not self.count:
            return value
        push = jax.vmap(lambda direction: jax.jvp(function, (self.primal,), (direction,))[1])
        return jnp.concatenate([value, push(self.directions)])

    def lift(self, function: Callable[[P, Array], Float[Array, " out"]]) -> Callable[[Rows], Float[Array, "rows out"]]:
        """Turn f(parameters, state) into its action on rows."""

        def lifted(rows: Rows) -> Float[Array, "rows out"]:
            if not self.count:
                return function(self.primal, rows[0])[None]
            value, push = jax.linearize(function, self.primal, rows[0])
            return jnp.concatenate([value[None], jax.vmap(push)(self.directions, rows[1:])])

        return lifted
