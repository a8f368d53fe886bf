"""The plane: two components, a body's position by a point and an angle, its velocity by their rates."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from ..basis import Basis, Entry, PositionRate, Rows
from .trigonometry import cos_sin
from .vectors import Frame, Vector


class Plane(Basis[Vector, Scalar, Frame]):
    """The plane. A turn is a number, and velocities are the rates of positions (M4)."""

    dimensions: ClassVar[int] = 2
    positions: ClassVar[int] = 3
    velocities: ClassVar[int] = 3
    inertia_turns: ClassVar[bool] = False

    def vector(self, *components: Entry) -> Vector:
        return Vector(*components)

    def turn(self, *components: Entry) -> Scalar:
        (angle,) = components
        return angle

    @property
    def unit_vectors(self) -> tuple[Vector, ...]:
        return Vector(1.0, 0.0), Vector(0.0, 1.0)

    @property
    def unit_turns(self) -> tuple[Scalar, ...]:
        return (1.0,)

    def along_axes(self, arm: Vector) -> tuple[tuple[Scalar, ...], ...]:
        return (1.0, 0.0, -arm.y), (0.0, 1.0, arm.x)

    def frames(self, q: Float[Array, " coordinates"], v: Float[Array, " velocities"], bodies: int) -> tuple[Frame, ...]:
        # All angles in one call: as array operations they cost a few nanoseconds together (see `cos_sin`).
        cos, sin = cos_sin(q[2 : 3 * bodies : 3])
        return tuple(
            Frame(Vector(q[k], q[k + 1]), q[k + 2], cos[body], sin[body], Vector(v[k], v[k + 1]), v[k + 2])
            for body, k in enumerate(range(0, 3 * bodies, 3))
        )

    def ground(self) -> Frame:
        zero, one = jnp.zeros(()), jnp.ones(())
        return Frame(Vector(zero, zero), zero, one, zero, Vector(zero, zero), zero)

    def position_rate(self, q: Float[Array, " coordinates"], bodies: int) -> PositionRate:
        return PositionRate()

    def relative_rotation(self, first: Frame, second: Frame) -> Scalar:
        return second.angle - first.angle

    def diagonal(self, mass: Scalar, inertia: Scalar) -> tuple[Scalar, ...]:
        return (mass, mass, inertia)

    def inertia_block(self, frame: Frame, inertia: Scalar) -> Rows:
        return [[inertia]]

    def spin_momentum(self, frame: Frame, inertia: Scalar) -> Scalar:
        return inertia * frame.spin

    def gyroscopic_moment(self, frame: Frame, inertia: Scalar) -> Scalar:
        return 0.0


PLANE = Plane()
