"""Vectors of space, of scalars: cheaper in compiled loops than small arrays."""

from typing import NamedTuple

import jax
import jax.numpy as jnp

from ..basis import Entry, is_zero, less, plus, times


class Vector(NamedTuple):
    """A vector of three scalars; what is Python's 0 costs nothing in a compiled program.

    - ``x``, ``y``, ``z``: components; (x, y) alone lies in the plane z = 0.
    """

    x: Entry
    y: Entry
    z: Entry = 0.0

    def __add__(self, other: "Vector") -> "Vector":  # type: ignore[override]
        return Vector(*(plus(a, b) for a, b in zip(self, other, strict=True)))

    def __sub__(self, other: "Vector") -> "Vector":
        return self + -other

    def __neg__(self) -> "Vector":
        return Vector(*(a if is_zero(a) else -a for a in self))

    def __mul__(self, factor: Entry) -> "Vector":  # type: ignore[override]
        return Vector(*(times(a, factor) for a in self))

    def dot(self, other: "Vector") -> Entry:
        """Return the scalar product with ``other``."""
        return plus(plus(times(self.x, other.x), times(self.y, other.y)), times(self.z, other.z))

    def cross(self, other: "Vector") -> "Vector":
        """Return the vector product with ``other`` (M207)."""
        return Vector(
            less(times(self.y, other.z), times(self.z, other.y)),
            less(times(self.z, other.x), times(self.x, other.z)),
            less(times(self.x, other.y), times(self.y, other.x)),
        )


def normals_to(axis: tuple[Entry, ...]) -> tuple[Vector, Vector]:
    """Return two unit vectors perpendicular to a unit vector, and to each other (Duff and others 2017)."""
    x, y, z = axis
    # Plain numbers stay plain, so that their zeros cost nothing.
    sign = jnp.where(z < 0.0, -1.0, 1.0) if isinstance(z, jax.Array) else -1.0 if z < 0.0 else 1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    return Vector(1.0 + sign * x * x * a, sign * b, -sign * x), Vector(b, sign + y * y * a, -y)
