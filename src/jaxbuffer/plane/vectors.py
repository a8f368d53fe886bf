"""Vectors and frames of the plane, of scalars: cheaper in compiled loops than small arrays."""

from typing import NamedTuple

from .._types import Scalar
from ..basis import Entry


class Vector(NamedTuple):
    """A plane vector of two scalars, which in compiled loops is cheaper than a small array.

    - ``x``, ``y``: components.
    """

    x: Entry
    y: Entry

    def __add__(self, other: "Vector") -> "Vector":  # type: ignore[override]
        return Vector(self.x + other.x, self.y + other.y)

    def __sub__(self, other: "Vector") -> "Vector":
        return Vector(self.x - other.x, self.y - other.y)

    def __neg__(self) -> "Vector":
        return Vector(-self.x, -self.y)

    def __mul__(self, factor: Entry) -> "Vector":  # type: ignore[override]
        return Vector(self.x * factor, self.y * factor)

    def dot(self, other: "Vector") -> Entry:
        """Return the scalar product with ``other``."""
        return self.x * other.x + self.y * other.y

    def cross(self, other: "Vector") -> Entry:
        """Return the out-of-plane component of the vector product with ``other`` (M2)."""
        return self.x * other.y - self.y * other.x

    def perp(self) -> "Vector":
        """Return this vector turned by +90° (M2)."""
        return Vector(-self.y, self.x)


class Frame(NamedTuple):
    """Pose and motion of one body, or of the material at a point of it (M1, M3).

    - ``origin``: its centre of mass, or that point, in inertial axes [m].
    - ``angle``: [rad], with its ``cos`` and ``sin`` [-].
    - ``velocity``: of the origin, in inertial axes [m/s].
    - ``spin``: rate of the angle [rad/s].
    """

    origin: Vector
    angle: Scalar
    cos: Scalar
    sin: Scalar
    velocity: Vector
    spin: Scalar

    def turn(self, local: Vector) -> Vector:
        """Turn a direction or arm into inertial axes, A(θ) s (M1). ``local``: the same in the body's axes, s."""
        return Vector(self.cos * local.x - self.sin * local.y, self.sin * local.x + self.cos * local.y)

    def unturn(self, inertial: Vector) -> Vector:
        """Turn a direction or arm into the body's axes, A(θ)ᵀ a (M1). ``inertial``: the same in inertial axes, a."""
        return Vector(
            self.cos * inertial.x + self.sin * inertial.y,
            self.cos * inertial.y - self.sin * inertial.x,
        )

    def in_axes(self, turn: Scalar) -> Scalar:
        """Return a turn, as a spin, in the body's axes: the same."""
        return turn

    def from_axes(self, turn: Scalar) -> Scalar:
        """Return a turn that is given in the body's axes: the same."""
        return turn

    @property
    def x_axis(self) -> Vector:
        """Return the body's x axis in inertial axes."""
        return Vector(self.cos, self.sin)

    def velocity_at(self, arm: Vector) -> Vector:
        """Return the velocity of the body's material point at ``arm`` (inertial axes, from the centre of mass) [m/s]
        (M3)."""
        return self.velocity + self.rate_of(arm)

    def rate_of(self, arm: Vector) -> Vector:
        """Return the rate of an ``arm``, or any other vector, that turns with the body; in inertial axes (M3)."""
        return arm.perp() * self.spin

    def centripetal(self, arm: Vector) -> Vector:
        """Return the second rate of an ``arm`` that turns with the body while the spin stays as it is."""
        return arm * (-self.spin * self.spin)
