"""Rotations of space as quaternions. None needs the size one: all that is read of one is that of its unit quaternion,
so that what integration adds to the size changes nothing.
"""

from typing import NamedTuple

import jax.numpy as jnp

from ..basis import Entry
from .vectors import Vector

# Below this t² the series of atan(t)/t and of sin(h)/h and cos(h) are exact to rounding; the closed forms divide by t.
SMALL = 1e-3


class Quaternion(NamedTuple):
    """A rotation from a body's axes into inertial ones (M208), of any size but zero.

    - ``w``: scalar part; ``x``, ``y``, ``z``: vector part.
    """

    w: Entry
    x: Entry
    y: Entry
    z: Entry

    @staticmethod
    def of_rotation_vector(turn: Vector) -> "Quaternion":
        """Return the unit quaternion of a rotation vector, axis times angle [rad] (M210)."""
        squared = 0.25 * (turn.x * turn.x + turn.y * turn.y + turn.z * turn.z)
        small = squared < SMALL
        half = jnp.sqrt(jnp.where(small, 1.0, squared))  # a root of zero has no derivative
        cos = 1 - squared / 2 * (1 - squared / 12 * (1 - squared / 30 * (1 - squared / 56)))
        cos = jnp.where(small, cos, jnp.cos(half))
        ratio = 1 - squared / 6 * (1 - squared / 20 * (1 - squared / 42 * (1 - squared / 72)))
        ratio = 0.5 * jnp.where(small, ratio, jnp.sin(half) / half)
        return Quaternion(cos, turn.x * ratio, turn.y * ratio, turn.z * ratio)

    @property
    def vector(self) -> Vector:
        """Return the vector part."""
        return Vector(self.x, self.y, self.z)

    @property
    def squared(self) -> Entry:
        """Return the square of the size."""
        return self.w * self.w + self.x * self.x + self.y * self.y + self.z * self.z

    def inverse(self) -> "Quaternion":
        """Return the rotation back, of the same size."""
        return Quaternion(self.w, -self.x, -self.y, -self.z)

    def after(self, first: "Quaternion") -> "Quaternion":
        """Return the quaternions' product: this rotation after the ``first`` one."""
        a, b = self, first
        return Quaternion(
            a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        )

    def axes(self) -> tuple[Vector, Vector, Vector]:
        """Return the body's axes in inertial ones: the columns of the rotation matrix (M208)."""
        w, x, y, z = self
        size, half = self.squared, 0.5 * self.squared
        # XLA evaluates cheap operations anew wherever they are used, but never a division: each entry is one.
        return (
            Vector((w * w + x * x - y * y - z * z) / size, (x * y + w * z) / half, (x * z - w * y) / half),
            Vector((x * y - w * z) / half, (w * w - x * x + y * y - z * z) / size, (y * z + w * x) / half),
            Vector((x * z + w * y) / half, (y * z - w * x) / half, (w * w - x * x - y * y + z * z) / size),
        )

    def rate(self, spin: Vector) -> "Quaternion":
        """Return the rate of the quaternion with an angular velocity in inertial axes [rad/s] (M209)."""
        x, y, z = 0.5 * spin.x, 0.5 * spin.y, 0.5 * spin.z
        return Quaternion(
            -x * self.x - y * self.y - z * self.z,
            x * self.w + y * self.z - z * self.y,
            y * self.w + z * self.x - x * self.z,
            z * self.w + x * self.y - y * self.x,
        )

    def spin(self, rate: "Quaternion") -> Vector:
        """Return the angular velocity of a ``rate`` [rad/s] (M209); of one that changes the size alone it is zero."""
        turned = rate.after(self.inverse()).vector
        return turned * (2.0 / self.squared)

    def rotation_vector(self) -> Vector:
        """Return axis times angle, of the rotation by less than half a turn [rad] (M210). At half a turn it jumps."""
        # q and -q are one rotation: the one with a positive scalar part turns by less than half a turn.
        sign = jnp.where(jnp.asarray(self.w) < 0.0, -1.0, 1.0)
        w, vector = self.w * sign, self.vector * sign
        length = vector.dot(vector)
        squared = length / jnp.where(w == 0.0, 1.0, w * w)
        small = (squared < SMALL) & (w != 0.0)
        t = jnp.where(small, squared, 0.0)
        series = 1.0 - t * (1 / 3 - t * (1 / 5 - t * (1 / 7 - t * (1 / 9 - t * (1 / 11)))))
        size = jnp.sqrt(jnp.where(small, 1.0, length))  # a root of zero has no derivative
        angle = jnp.where(small, series / jnp.where(small, w, 1.0), jnp.arctan2(size, w) / size)
        return vector * (2.0 * angle)
