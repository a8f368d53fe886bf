"""The graph of a linear map: its scalars as vertices, and coefficients on the edges between them."""

import dataclasses
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array

Coefficient = Any  # a Python number, a traced scalar, or a `Mask`


@dataclasses.dataclass(frozen=True)
class Mask:
    """A coefficient of one where a condition holds: what it switches off may be infinite."""

    condition: Array


class Vertex:
    """One scalar of the map, with the coefficients of its sources and the set of its users."""

    __slots__ = ("sources", "users")

    def __init__(self, *sources: tuple["Vertex", Coefficient]) -> None:
        self.sources: dict[Vertex, Coefficient] = {}
        self.users: dict[Vertex, None] = {}  # a set in the order of insertion: programs must not depend on hashes
        for source, coefficient in sources:
            self.add(source, coefficient)

    def add(self, source: "Vertex", coefficient: Coefficient) -> None:
        """One more edge from ``source``, or more on the one there is."""
        before = self.sources.get(source)
        self.sources[source] = coefficient if before is None else number(before) + number(coefficient)
        source.users[self] = None

    def eliminate(self) -> None:
        """Connect users and sources past this vertex."""
        for user in self.users:
            onwards = user.sources.pop(self)
            for source, coefficient in self.sources.items():
                user.add(source, product(onwards, coefficient))
        for source in self.sources:
            del source.users[self]

    @property
    def gain(self) -> int:
        """How many edges fewer there are without it, at least."""
        return len(self.sources) + len(self.users) - len(self.sources) * len(self.users)


def number(coefficient: Coefficient) -> Any:
    """The coefficient as something to calculate with."""
    return jnp.where(coefficient.condition, 1.0, 0.0) if isinstance(coefficient, Mask) else coefficient


def product(a: Coefficient, b: Coefficient) -> Coefficient:
    """The coefficient of two edges in a row."""
    if isinstance(a, Mask) and isinstance(b, Mask):
        return Mask(a.condition & b.condition)
    if isinstance(a, float) or isinstance(b, float):
        known, other = (a, b) if isinstance(a, float) else (b, a)
        if abs(known) == 1.0:
            return other if known == 1.0 else -number(other)
    if isinstance(a, Mask) or isinstance(b, Mask):
        return scaled(a, b) if isinstance(a, Mask) else scaled(b, a)
    return a * b


def scaled(coefficient: Coefficient, lane: Array) -> Array:
    """A lane, or a scalar, times a coefficient."""
    if isinstance(coefficient, Mask):
        return jnp.where(coefficient.condition, lane, 0.0)
    if isinstance(coefficient, float) and abs(coefficient) == 1.0:
        return lane if coefficient == 1.0 else -lane
    return coefficient * lane
