"""Vectors of space, of scalars: cheaper in compiled loops than small arrays."""

from typing import NamedTuple

from .._types import Scalar
from ..basis import is_zero


class Vector(NamedTuple):
    """A vector of three scalars; what is Python's 0 costs nothing in a compiled program.

    - ``x``, ``y``, ``z``: components; (x, y) alone lies in the plane z = 0.
    """

    x: Scalar
    y: Scalar
    z: Scalar = 0.0

    def __add__(self, other: "Vector") -> "Vector":  # type: ignore[override]
        return Vector(*(plus(a, b) for a, b in zip(self, other, strict=True)))

    def __sub__(self, other: "Vector") -> "Vector":
        return self + -other

    def __neg__(self) -> "Vector":
        return Vector(*(a if is_zero(a) else -a for a in self))

    def __mul__(self, factor: Scalar) -> "Vector":  # type: ignore[override]
        return Vector(*(times(a, factor) for a in self))

    def dot(self, other: "Vector") -> Scalar:
        """Return the scalar product with ``other``."""
        return plus(plus(times(self.x, other.x), times(self.y, other.y)), times(self.z, other.z))

    def cross(self, other: "Vector") -> "Vector":
        """Return the vector product with ``other`` (M207)."""
        return Vector(
            less(times(self.y, other.z), times(self.z, other.y)),
            less(times(self.z, other.x), times(self.x, other.z)),
            less(times(self.x, other.y), times(self.y, other.x)),
        )


def plus(a: Scalar, b: Scalar) -> Scalar:
    """Return a + b."""
    return b if is_zero(a) else a if is_zero(b) else a + b


def less(a: Scalar, b: Scalar) -> Scalar:
    """Return a - b."""
    return a if is_zero(b) else -b if is_zero(a) else a - b


def times(a: Scalar, b: Scalar) -> Scalar:
    """Return a b."""
    if is_zero(a) or is_zero(b):
        return 0.0
    one = [isinstance(factor, float) and factor == 1.0 for factor in (a, b)]
    return b if one[0] else a if one[1] else a * b
