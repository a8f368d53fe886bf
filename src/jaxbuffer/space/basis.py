"""Space: three components, a body's position by a point and a quaternion, its velocity by six numbers."""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from ..basis import Basis, Entry, PositionRate, Rows
from .frames import AXES, Frame
from .quaternions import Quaternion
from .vectors import Vector

Inertia = tuple[Scalar, Scalar, Scalar]
"""Principal moments of inertia about a body's axes [kg m²]."""


class TurningRate(PositionRate):
    """q̇ = N(q) v of bodies in space: quaternions turn with the spins, all else is as it is (M209).

    - ``q``: positions, of ``bodies`` first.
    """

    q: Float[Array, " coordinates"]
    bodies: int = eqx.field(static=True)

    @property
    def surplus(self) -> int:
        return self.bodies

    def of(self, v: Float[Array, "velocities *columns"]) -> Float[Array, "coordinates *columns"]:
        rates: list[Array] = []
        for k, quaternion in enumerate(self._quaternions()):
            turning = quaternion.rate(Vector(*v[6 * k + 3 : 6 * k + 6]))
            rates += [v[6 * k : 6 * k + 3], jnp.stack(turning)]
        return jnp.concatenate([*rates, v[6 * self.bodies :]])

    def velocity(self, rate: Float[Array, "coordinates *columns"]) -> Float[Array, "velocities *columns"]:
        velocities: list[Array] = []
        for k, quaternion in enumerate(self._quaternions()):
            spin = quaternion.spin(Quaternion(*rate[7 * k + 3 : 7 * k + 7]))
            velocities += [rate[7 * k : 7 * k + 3], jnp.stack(spin)]
        return jnp.concatenate([*velocities, rate[7 * self.bodies :]])

    def _quaternions(self) -> list[Quaternion]:
        return [Quaternion(*self.q[7 * k + 3 : 7 * k + 7]) for k in range(self.bodies)]


class Space(Basis[Vector, Vector, Frame]):
    """Space. A body's position is (x, y, z, quaternion), its velocity that of its centre of mass and its spin, both in
    inertial axes (M209)."""

    dimensions: ClassVar[int] = 3
    positions: ClassVar[int] = 7
    velocities: ClassVar[int] = 6
    inertia_turns: ClassVar[bool] = True

    def vector(self, *components: Entry) -> Vector:
        return Vector(*components)

    def turn(self, *components: Entry) -> Vector:
        return Vector(*components)

    @property
    def unit_vectors(self) -> tuple[Vector, ...]:
        return AXES

    @property
    def unit_turns(self) -> tuple[Vector, ...]:
        return AXES

    def along_axes(self, arm: Vector) -> tuple[tuple[Scalar, ...], ...]:
        return tuple((*unit, *arm.cross(unit)) for unit in AXES)

    def frames(self, q: Float[Array, " coordinates"], v: Float[Array, " velocities"], bodies: int) -> tuple[Frame, ...]:
        return tuple(_frame(q[7 * k : 7 * k + 7], v[6 * k : 6 * k + 6]) for k in range(bodies))

    def ground(self) -> Frame:
        zero = Vector(0.0, 0.0, 0.0)
        return Frame(zero, Quaternion(1.0, 0.0, 0.0, 0.0), AXES, zero, zero)

    def position_rate(self, q: Float[Array, " coordinates"], bodies: int) -> "TurningRate":
        return TurningRate(q, bodies)

    def relative_rotation(self, first: Frame, second: Frame) -> Vector:
        return second.quaternion.after(first.quaternion.inverse()).rotation_vector()

    def diagonal(self, mass: Scalar, inertia: Inertia) -> tuple[Scalar, ...]:
        return (mass, mass, mass, 0.0, 0.0, 0.0)

    def inertia_block(self, frame: Frame, inertia: Inertia) -> Rows:
        """Return the lower half of R I Rᵀ [kg m²] (M211)."""
        weighted = [axis * moment for axis, moment in zip(frame.axes, inertia, strict=True)]
        entry = lambda i, j: sum(w[i] * axis[j] for w, axis in zip(weighted, frame.axes, strict=True))  # noqa: E731
        return [[entry(i, j) for j in range(i + 1)] for i in range(3)]

    def spin_momentum(self, frame: Frame, inertia: Inertia) -> Vector:
        local = frame.unturn(frame.spin)
        return frame.turn(Vector(*(moment * part for moment, part in zip(inertia, local, strict=True))))

    def gyroscopic_moment(self, frame: Frame, inertia: Inertia) -> Vector:
        """Return -ω × (R I Rᵀ ω) [N m] (M211)."""
        return self.spin_momentum(frame, inertia).cross(frame.spin)


def _frame(q: Float[Array, " 7"], v: Float[Array, " 6"]) -> Frame:
    quaternion = Quaternion(q[3], q[4], q[5], q[6])
    velocity, spin = Vector(v[0], v[1], v[2]), Vector(v[3], v[4], v[5])
    return Frame(Vector(q[0], q[1], q[2]), quaternion, quaternion.axes(), velocity, spin)


SPACE = Space()
