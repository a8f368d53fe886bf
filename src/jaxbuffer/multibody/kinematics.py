"""Where every body is and how it moves: poses, points fixed on bodies, their arms and velocities.

Coordinates are stored body by body, ``q = (u_1, v_1, θ_1, u_2, …)`` [m, m, rad], velocities in the same order.
A body is an index into that order; ``GROUND`` is the inertial frame.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from .trigonometry import cos_sin

GROUND: int = -1


class Vector(NamedTuple):
    """A plane vector (x, y) of scalars: cheaper in compiled loops than small arrays."""

    x: Scalar
    y: Scalar

    def __add__(self, other: "Vector") -> "Vector":  # type: ignore[override]
        return Vector(self.x + other.x, self.y + other.y)

    def __sub__(self, other: "Vector") -> "Vector":
        return Vector(self.x - other.x, self.y - other.y)

    def __neg__(self) -> "Vector":
        return Vector(-self.x, -self.y)

    def __mul__(self, factor: Scalar) -> "Vector":  # type: ignore[override]
        return Vector(self.x * factor, self.y * factor)

    def dot(self, other: "Vector") -> Scalar:
        return self.x * other.x + self.y * other.y

    def cross(self, other: "Vector") -> Scalar:
        """The out-of-plane component of the vector product."""
        return self.x * other.y - self.y * other.x

    def perp(self) -> "Vector":
        """This vector turned by +90°."""
        return Vector(-self.y, self.x)


class Frame(NamedTuple):
    """Pose and motion of one body: origin [m], angle [rad] with its cosine and sine, velocity [m/s], spin [rad/s]."""

    origin: Vector
    angle: Scalar
    cos: Scalar
    sin: Scalar
    velocity: Vector
    spin: Scalar

    def turn(self, local: Vector) -> Vector:
        """A direction or arm given in the body's axes, in inertial axes."""
        return Vector(self.cos * local.x - self.sin * local.y, self.sin * local.x + self.cos * local.y)

    def unturn(self, inertial: Vector) -> Vector:
        """A direction or arm given in inertial axes, in the body's axes."""
        return Vector(
            self.cos * inertial.x + self.sin * inertial.y,
            self.cos * inertial.y - self.sin * inertial.x,
        )

    def velocity_at(self, arm: Vector) -> Vector:
        """Velocity of the material point at ``arm`` (inertial axes, from the body's origin) [m/s]."""
        return self.velocity + arm.perp() * self.spin


class Kinematics(eqx.Module):
    """Frames of all bodies at one instant, each made once: what is not asked for is not compiled."""

    q: Float[Array, " coordinates"]
    v: Float[Array, " coordinates"]
    frames: tuple[Frame, ...]

    def __init__(self, q: Float[Array, " coordinates"], v: Float[Array, " coordinates"]):
        self.q, self.v = q, v
        cos, sin = cos_sin(q[2::3])
        self.frames = tuple(
            Frame(Vector(q[k], q[k + 1]), q[k + 2], cos[body], sin[body], Vector(v[k], v[k + 1]), v[k + 2])
            for body, k in enumerate(range(0, q.shape[0], 3))
        )

    def frame(self, body: int) -> Frame:
        """The frame of one body (or of ``GROUND``)."""
        if body == GROUND:
            zero, one = jnp.zeros(()), jnp.ones(())
            return Frame(Vector(zero, zero), zero, one, zero, Vector(zero, zero), zero)
        return self.frames[body]
