"""Vectors as three numbers, compiled into the functions that use them."""

from __future__ import annotations

import math

from numba import njit

Triple = tuple[float, float, float]


@njit(inline="always")
def plus(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@njit(inline="always")
def minus(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(inline="always")
def times(s, a):
    return s * a[0], s * a[1], s * a[2]


@njit(inline="always")
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(inline="always")
def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(inline="always")
def size(a):
    return math.sqrt(dot(a, a))


@njit(inline="always")
def axes_of(w, x, y, z):
    """The three axes of a body with a quaternion of any length, in inertial axes."""
    s = 2.0 / (w * w + x * x + y * y + z * z)
    return (
        (1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)),
        (s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x)),
        (s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)),
    )


@njit(inline="always")
def inside(axes, a):
    """An inertial vector in a body's axes."""
    return dot(axes[0], a), dot(axes[1], a), dot(axes[2], a)


@njit(inline="always")
def outside(axes, a):
    """A vector in a body's axes in inertial ones."""
    return plus(plus(times(a[0], axes[0]), times(a[1], axes[1])), times(a[2], axes[2]))


@njit(inline="always")
def inertia_times(across, along, axis, a):
    """An axisymmetric inertia, ``across`` and ``along`` its ``axis``, times a vector."""
    return plus(times(across, a), times((along - across) * dot(axis, a), axis))
