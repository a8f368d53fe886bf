"""Pose and motion of a body in space."""

from typing import NamedTuple

from .quaternions import Quaternion
from .vectors import Vector

AXES = Vector(1.0, 0.0, 0.0), Vector(0.0, 1.0, 0.0), Vector(0.0, 0.0, 1.0)
"""The inertial axes."""


class Frame(NamedTuple):
    """Pose and motion of one body, or of the material at a point of it (M208).

    - ``origin``: its centre of mass, in inertial axes [m].
    - ``quaternion``: its rotation from the body's axes into inertial ones.
    - ``axes``: the body's axes in inertial ones, the columns of its rotation matrix.
    - ``velocity``: of the origin, in inertial axes [m/s].
    - ``spin``: angular velocity, in inertial axes [rad/s].
    """

    origin: Vector
    quaternion: Quaternion
    axes: tuple[Vector, Vector, Vector]
    velocity: Vector
    spin: Vector

    def turn(self, local: Vector) -> Vector:
        """Turn a direction or arm into inertial axes. ``local``: the same in the body's axes."""
        x, y, z = self.axes
        return x * local.x + y * local.y + z * local.z

    def unturn(self, inertial: Vector) -> Vector:
        """Turn a direction or arm into the body's axes. ``inertial``: the same in inertial axes."""
        return Vector(*(axis.dot(inertial) for axis in self.axes))

    def in_axes(self, turn: Vector) -> Vector:
        """Return a turn, as a spin, in the body's axes."""
        return self.unturn(turn)

    def from_axes(self, turn: Vector) -> Vector:
        """Return a turn in inertial axes that is given in the body's."""
        return self.turn(turn)

    @property
    def x_axis(self) -> Vector:
        """Return the body's x axis in inertial axes."""
        return self.axes[0]

    def rate_of(self, arm: Vector) -> Vector:
        """Return the rate of an arm, or any other vector, that turns with the body; in inertial axes."""
        return self.spin.cross(arm)

    def velocity_at(self, arm: Vector) -> Vector:
        """Return the velocity of the body's material point at ``arm`` (inertial axes, from the origin) [m/s]."""
        return self.velocity + self.rate_of(arm)

    def centripetal(self, arm: Vector) -> Vector:
        """Return the second rate of an ``arm`` that turns with the body while the spin stays as it is."""
        return self.rate_of(self.rate_of(arm))
