"""The graph of a linear map: its scalars as vertices, and coefficients on the edges between them."""

import dataclasses
import itertools
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array

Coefficient = Any  # a Python number, a traced scalar, or a `Mask`


@dataclasses.dataclass(frozen=True)
class Mask:
    """A coefficient of one where a condition holds: what it switches off may be infinite."""

    condition: Array


class Vertex:
    """One scalar of the map, with the coefficients of its sources; numbered as they are made, so sources come first."""

    __slots__ = ("number", "sources")
    numbers = itertools.count()

    def __init__(self, *sources: tuple["Vertex", Coefficient]) -> None:
        self.number = next(self.numbers)
        self.sources: dict[Vertex, Coefficient] = {}
        for source, coefficient in sources:
            before = self.sources.get(source)
            self.sources[source] = coefficient if before is None else _number(before) + _number(coefficient)


def _number(coefficient: Coefficient) -> Any:
    """Return the coefficient as something to calculate with."""
    return jnp.where(coefficient.condition, 1.0, 0.0) if isinstance(coefficient, Mask) else coefficient


def scaled(coefficient: Coefficient, vector: Array) -> Array:
    """Multiply a vector by a coefficient."""
    if isinstance(coefficient, Mask):
        return jnp.where(coefficient.condition, vector, 0.0)
    if isinstance(coefficient, float) and abs(coefficient) == 1.0:
        return vector if coefficient == 1.0 else -vector
    return coefficient * vector
