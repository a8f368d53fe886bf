"""Joints: constraint Φ(q, t) = 0, its Jacobian Φ_q and γ, each in closed form (M9).

Every joint gives rows; a row holds the blocks of Φ_q that are not zero, by body. The multiplier of a row is the joint's
reaction in the augmented system ``M q̈ + Φ_qᵀ λ = F`` (M16).
"""

from collections.abc import Callable
from typing import ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp

from .._types import Scalar
from ..plane import Vector
from ..plane.unit_vector import check_unit
from .kinematics import GROUND, Block, Kinematics, MaterialPoint, Point


class Row(NamedTuple):
    """One scalar constraint (M9).

    - ``phi``: Φ [m or rad].
    - ``blocks``: by body, ∂Φ/∂(u, v, θ, modal coordinates): [-, -, m, -] or, of an angle, [1/m, 1/m, -, 1/m].
    - ``gamma``: γ = -(Φ_q q̇)_q q̇, of a drive less Φ_tt [m/s² or rad/s²].
    - ``rate``: Φ_t, which only drives have [m/s or rad/s].
    """

    phi: Scalar
    blocks: dict[int, Block]
    gamma: Scalar
    rate: Scalar = 0.0


def _blocks(first: int, a: Block, second: int, b: Block) -> dict[int, Block]:
    return {body: block for body, block in ((first, a), (second, b)) if body != GROUND}


def _less(block: Block) -> Block:
    """Return the negative of a block."""
    return tuple(-entry for entry in block)


class Joint(eqx.Module):
    """Base of all joints.

    - ``first``, ``second``: bodies i and j (indices, or ``GROUND``).
    - ``driven``: whether it prescribes a motion over time.
    """

    driven: ClassVar[bool] = False
    first: eqx.AbstractVar[int]
    second: eqx.AbstractVar[int]

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        """Return the joint's scalar constraints at one instant. ``kin``: the frames of all bodies."""
        raise NotImplementedError


class Revolute(Joint):
    """Two points coincide: r_i + A(θ_i) s_i - r_j - A(θ_j) s_j = 0. Two rows [m] (M10).

    - ``first``, ``second``: bodies i and j.
    - ``first_point``, ``second_point``: the points, on their bodies.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        i, j = kin.point(self.first, self.first_point), kin.point(self.second, self.second_point)
        phi, gamma = i.place - j.place, j.quadratic - i.quadratic
        return (
            Row(phi.x, _blocks(self.first, _x_block(i), self.second, _less(_x_block(j))), gamma.x),
            Row(phi.y, _blocks(self.first, _y_block(i), self.second, _less(_y_block(j))), gamma.y),
        )


def _x_block(point: MaterialPoint) -> Block:
    """Return `MaterialPoint.along` the x-axis, without its zeros."""
    return (1.0, 0.0, -point.arm.y, *(shape.x for shape in point.shapes))


def _y_block(point: MaterialPoint) -> Block:
    """Return `MaterialPoint.along` the y-axis, without its zeros."""
    return (0.0, 1.0, point.arm.x, *(shape.y for shape in point.shapes))


class FixedAngle(Joint):
    """The bodies keep their relative angle: θ_i - θ_j - ``angle`` = 0. One row [rad] (M11).

    - ``first``, ``second``: bodies i and j.
    - ``angle``: θ_i - θ_j [rad].
    - ``first_point``, ``second_point``: where the angle of a flexible body is taken, a marker.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    angle: Scalar = 0.0
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        i, j = kin.point(self.first, self.first_point), kin.point(self.second, self.second_point)
        blocks = _blocks(self.first, i.turning(), self.second, _less(j.turning()))
        return (Row(i.angle - j.angle - self.angle, blocks, 0.0),)


class PointOnLine(Joint):
    """A point of the second body stays on a line of the first one. One row [m] (M12).

    - ``first``, ``second``: bodies i and j.
    - ``first_point``: a point of the line, on ``first``.
    - ``second_point``: the guided point, on ``second``.
    - ``normal``: (x, y), the line's unit normal in the axes of ``first`` [-].
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)
    normal: tuple[Scalar, Scalar] = (0.0, 1.0)

    def __check_init__(self) -> None:
        """Raise `InputError` for a normal that is no unit vector: the row would be in its length, not in metres."""
        check_unit("PointOnLine: normal", *self.normal)

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        i, j = kin.point(self.first, self.first_point), kin.point(self.second, self.second_point)
        n, d = i.turn(Vector(*self.normal)), j.place - i.place
        # The normal turns with the material of `first`: Φ̇ = n·(v_j - v_i) + ω n⊥·d.
        turned = n.perp()
        gamma = n.dot(i.quadratic - j.quadratic) + i.spin * (
            i.spin * n.dot(d) - 2.0 * turned.dot(j.velocity - i.velocity)
        )
        lever = turned.dot(d)
        first = tuple(lever * spin - speed for spin, speed in zip(i.turning(), i.along(n), strict=True))
        return (Row(n.dot(d), _blocks(self.first, (-n.x, -n.y, *first[2:]), self.second, j.along(n)), gamma),)


class Prismatic(Joint):
    """The second body slides along a line of the first one without turning. Rows: angle [rad], offset [m] (M13).

    - ``first``, ``second``, ``first_point``, ``second_point``, ``normal``: as for `PointOnLine`.
    - ``angle``: θ_i - θ_j, held fixed [rad].
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)
    normal: tuple[Scalar, Scalar] = (0.0, 1.0)
    angle: Scalar = 0.0

    @property
    def _angle(self) -> FixedAngle:
        return FixedAngle(self.first, self.second, self.angle, self.first_point, self.second_point)

    def __check_init__(self) -> None:
        """Raise `InputError` for a normal that is no unit vector: the row would be in its length, not in metres."""
        check_unit("Prismatic: normal", *self.normal)

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        line = PointOnLine(self.first, self.second, self.first_point, self.second_point, self.normal)
        return self._angle.rows(kin) + line.rows(kin)


class Weld(Joint):
    """Two bodies become one: points coincide, the relative angle is fixed. Rows: [m], [m], [rad] (M14).

    - ``first``, ``second``, ``first_point``, ``second_point``: as for `Revolute`.
    - ``angle``: θ_i - θ_j [rad].
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)
    angle: Scalar = 0.0

    @property
    def _angle(self) -> FixedAngle:
        return FixedAngle(self.first, self.second, self.angle, self.first_point, self.second_point)

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        pin = Revolute(self.first, self.second, self.first_point, self.second_point)
        return pin.rows(kin) + self._angle.rows(kin)


class ConstantSpeed(eqx.Module):
    """An angle that grows steadily from ``angle`` [rad] at ``speed`` [rad/s]."""

    angle: Scalar
    speed: Scalar

    def __call__(self, time: Scalar) -> Scalar:
        """Return the angle [rad] at a ``time`` [s]."""
        return self.angle + self.speed * time


class DrivenAngle(Joint):
    """A motor turns the second body against the first one: θ_j - θ_i - φ(t) = 0. One row [rad] (M106).

    Its multiplier is the torque on the first body, and less that the drive's torque on the second.

    - ``first``, ``second``: bodies i and j.
    - ``angle``: φ(t) [rad] as a function of time [s], twice differentiable: a pytree, such as `ConstantSpeed`.
    - ``first_point``, ``second_point``: where the angle of a flexible body is taken, a marker.
    """

    driven: ClassVar[bool] = True
    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    angle: Callable[[Scalar], Scalar]
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        i, j = kin.point(self.first, self.first_point), kin.point(self.second, self.second_point)
        # One push-forward inside another gives φ, its rate and its second derivative.
        once = lambda time: jax.jvp(self.angle, (time,), (jnp.ones(()),))  # noqa: E731
        (angle, speed), (_, acceleration) = jax.jvp(once, (jnp.asarray(kin.time),), (jnp.ones(()),))
        blocks = _blocks(self.first, _less(i.turning()), self.second, j.turning())
        return (Row(j.angle - i.angle - angle, blocks, acceleration, -speed),)
