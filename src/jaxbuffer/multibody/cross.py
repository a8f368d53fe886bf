"""Springs and dampers of the cross between two bodies of space that a universal joint connects."""

from typing import NamedTuple, cast

import equinox as eqx
import jax.numpy as jnp

from .._types import Scalar
from ..space import Frame, Vector
from .forces import ForceElement, Load, SpringDirection, turn_at
from .kinematics import Kinematics


class CrossState(NamedTuple):
    """A cross at one instant (M216).

    - ``angles``: of the cross about its axis in the first body, and of the second body about the other axis [rad].
    - ``rates``: of both [rad/s].
    - ``axes``: both, in inertial axes [-].
    """

    angles: tuple[Scalar, Scalar]
    rates: tuple[Scalar, Scalar]
    axes: tuple[Vector, Vector]


class CrossSpringDamper(ForceElement):
    """Spring and damper about either axis of a `Universal` joint's cross, in space: torques -k α - c α̇ and
    -k β - c β̇ (M216).

    - ``first``, ``second``: bodies i and j (indices, or ``GROUND``).
    - ``stiffness``: k [N m/rad].
    - ``damping``: c [N m s/rad].
    - ``first_axis``, ``second_axis``: as of the joint, unit vectors perpendicular to each other where both angles are
      zero, the bodies' axes then being parallel.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    stiffness: Scalar
    damping: Scalar
    first_axis: tuple[Scalar, ...] = (0.0, 1.0, 0.0)
    second_axis: tuple[Scalar, ...] = (0.0, 0.0, 1.0)

    def state(self, kin: Kinematics) -> CrossState:
        """Return angles, rates and axes at one instant (M216)."""
        i, j = (cast(Frame, kin.frame(body)) for body in (self.first, self.second))
        first, second = Vector(*self.first_axis), Vector(*self.second_axis)
        axes = i.turn(first), j.turn(second)
        spin = j.spin - i.spin
        # Each axis of the cross shows how far it has turned about the other one.
        angles = _angle_about(axes[0], i.turn(second), axes[1]), _angle_about(axes[1], axes[0], j.turn(first))
        return CrossState(angles, (spin.dot(axes[0]), spin.dot(axes[1])), axes)

    def springs(self, kin: Kinematics) -> tuple[SpringDirection, ...]:
        i, j = kin.point(self.first, (0.0, 0.0)), kin.point(self.second, (0.0, 0.0))
        along = (
            {self.first: tuple(-entry for entry in i.turning(axis)), self.second: j.turning(axis)}
            for axis in self.state(kin).axes
        )
        return tuple(SpringDirection(blocks, self.stiffness, self.damping) for blocks in along)

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        s = self.state(kin)
        each = zip(s.angles, s.rates, s.axes, strict=True)
        about_first, about_second = (axis * (-self.stiffness * a - self.damping * rate) for a, rate, axis in each)
        torque = about_first + about_second
        ends = kin.point(self.first, (0.0, 0.0)), kin.point(self.second, (0.0, 0.0))
        return turn_at(ends[0], -torque), turn_at(ends[1], torque)

    def energy(self, kin: Kinematics) -> Scalar:
        alpha, beta = self.state(kin).angles
        return 0.5 * self.stiffness * (alpha * alpha + beta * beta)

    def dissipation(self, kin: Kinematics) -> Scalar:
        alpha, beta = self.state(kin).rates
        return self.damping * (alpha * alpha + beta * beta)


def _angle_about(axis: Vector, start: Vector, end: Vector) -> Scalar:
    """Return the angle of ``end`` from ``start`` about an ``axis`` perpendicular to both [rad]."""
    return jnp.arctan2(axis.dot(start.cross(end)), start.dot(end))
