"""Joints: constraint Φ(q, t) = 0, its Jacobian Φ_q and γ, each in closed form (M9).

Every joint is a list of primitives between a point of one body and a point of another (M214); they give its rows, and a
row holds the blocks of Φ_q that are not zero, by body. The multiplier of a row is the joint's reaction in the augmented
system ``M q̈ + Φ_qᵀ λ = F`` (M16).

A joint is the same in the plane and in space: what is left out in space lies in the plane z = 0, or is its normal.
"""

from collections.abc import Callable
from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp

from .._types import Scalar
from ..basis import AnyBasis, is_zero
from ..plane.unit_vector import check_unit
from ..space import AXES, Quaternion
from ..space import Vector as SpaceVector
from ..space.vectors import normals_to
from .kinematics import Kinematics, Point
from .primitives import CoincidentPoints, EqualAngles, PerpendicularVectors, Primitive, Row, blocks, negative

Primitives = tuple[Primitive, ...]
Direction = tuple[Scalar, ...]
"""A unit vector (x, y), in space (x, y, z), in the axes of a body [-]."""


class Joint(eqx.Module):
    """Base of all joints.

    - ``first``, ``second``: bodies i and j (indices, or ``GROUND``).
    - ``first_point``, ``second_point``: points on these.
    - ``driven``: whether it prescribes a motion over time.
    """

    driven: ClassVar[bool] = False
    first: eqx.AbstractVar[int]
    second: eqx.AbstractVar[int]

    @property
    def first_point(self) -> Point:
        """Return the point on the first body; each class has a field for it."""
        raise NotImplementedError

    @property
    def second_point(self) -> Point:
        """Return the point on the second body; each class has a field for it."""
        raise NotImplementedError

    def primitives(self, basis: AnyBasis) -> Primitives:
        """Return what holds between the two points. ``basis``: plane or space."""
        raise NotImplementedError

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        """Return the joint's scalar constraints at one instant. ``kin``: the frames of all bodies."""
        i, j = kin.point(self.first, self.first_point), kin.point(self.second, self.second_point)
        return tuple(row for part in self.primitives(kin.basis) for row in part.rows(kin.basis, i, j))


def _in_space(basis: AnyBasis, *primitives: Primitive) -> Primitives:
    """Return what has no meaning in the plane, or holds there by itself: nothing there."""
    return primitives if basis.dimensions == 3 else ()


def _same_rotation(basis: AnyBasis, angle: Any) -> Primitives:
    """Return what keeps the rotation of the first body against the second one: the angle; in space each axis of the
    first stays perpendicular to the next one of the second, turned by the angle."""
    if basis.dimensions == 2:
        return (EqualAngles(angle),)
    x, y, z = AXES
    if not is_zero(angle):
        turn = SpaceVector(*angle) if isinstance(angle, tuple) else SpaceVector(0.0, 0.0, angle)
        x, y, z = Quaternion.of_rotation_vector(turn).axes()
    return (
        PerpendicularVectors((1.0, 0.0, 0.0), y),
        PerpendicularVectors((0.0, 1.0, 0.0), z),
        PerpendicularVectors((0.0, 0.0, 1.0), x),
    )


class Revolute(Joint):
    """Two points coincide: r_i + A(θ_i) s_i - r_j - A(θ_j) s_j = 0. Two rows [m] (M10).

    In space an axis of both bodies is one as well; five rows.

    - ``first``, ``second``: bodies i and j.
    - ``first_point``, ``second_point``: the points, on their bodies.
    - ``axis``: in space, in the axes of either body, by default the plane's normal.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)
    axis: Direction = (0.0, 0.0, 1.0)

    def primitives(self, basis: AnyBasis) -> Primitives:
        across = (PerpendicularVectors(self.axis, normal) for normal in normals_to(self.axis))
        return (CoincidentPoints(), *_in_space(basis, *across))


class Spherical(Joint):
    """Two points coincide, and nothing else does. In space three rows [m] (M212); in the plane a `Revolute`.

    - ``first``, ``second``, ``first_point``, ``second_point``: as for `Revolute`.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)

    def primitives(self, basis: AnyBasis) -> Primitives:
        return (CoincidentPoints(),)


class Universal(Joint):
    """Two points coincide, and an axis of one body stays perpendicular to one of the other: the cross between them.

    Of space alone; rows: [m], [m], [m], [-].

    - ``first``, ``second``, ``first_point``, ``second_point``: as for `Revolute`.
    - ``first_axis``, ``second_axis``: of the cross in the first body, and in the second.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)
    first_axis: Direction = (0.0, 1.0, 0.0)
    second_axis: Direction = (0.0, 0.0, 1.0)

    def primitives(self, basis: AnyBasis) -> Primitives:
        return (CoincidentPoints(), *_in_space(basis, PerpendicularVectors(self.first_axis, self.second_axis)))


class FixedAngle(Joint):
    """The bodies keep their relative angle: θ_i - θ_j - ``angle`` = 0. One row [rad] (M11); in space three [-].

    - ``first``, ``second``: bodies i and j.
    - ``angle``: θ_i - θ_j [rad]; in space about z, or (x, y, z), the rotation vector of i against j in the axes of j.
    - ``first_point``, ``second_point``: where the angle of a flexible body is taken, a marker.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    angle: Any = 0.0
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)

    def primitives(self, basis: AnyBasis) -> Primitives:
        return _same_rotation(basis, self.angle)


class PointOnLine(Joint):
    """A point of the second body stays on a line of the first one. One row [m] (M12); in space two.

    - ``first``, ``second``: bodies i and j.
    - ``first_point``: a point of the line, on ``first``.
    - ``second_point``: the guided point, on ``second``.
    - ``normal``: (x, y), the line's unit normal in the axes of ``first`` [-].
    - ``binormal``: in space the line's other normal, by default the plane's.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)
    normal: Direction = (0.0, 1.0)
    binormal: Direction = (0.0, 0.0, 1.0)

    def __check_init__(self) -> None:
        """Raise `InputError` for normals that are no unit vectors: the rows would be in their length, not in metres."""
        check_unit("PointOnLine: normal", *self.normal)
        check_unit("PointOnLine: binormal", *self.binormal)

    def primitives(self, basis: AnyBasis) -> Primitives:
        return (PerpendicularVectors(self.normal), *_in_space(basis, PerpendicularVectors(self.binormal)))


class Prismatic(Joint):
    """The second body slides along a line of the first one without turning. Rows: angle [rad], offset [m] (M13).

    - ``first``, ``second``, ``first_point``, ``second_point``, ``normal``, ``binormal``: as for `PointOnLine`.
    - ``angle``: θ_i - θ_j, held fixed [rad]; in space as for `FixedAngle`.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)
    normal: Direction = (0.0, 1.0)
    angle: Any = 0.0
    binormal: Direction = (0.0, 0.0, 1.0)

    def __check_init__(self) -> None:
        """Raise `InputError` for normals that are no unit vectors: the rows would be in their length, not in metres."""
        check_unit("Prismatic: normal", *self.normal)
        check_unit("Prismatic: binormal", *self.binormal)

    def primitives(self, basis: AnyBasis) -> Primitives:
        line = PerpendicularVectors(self.normal), *_in_space(basis, PerpendicularVectors(self.binormal))
        return (*_same_rotation(basis, self.angle), *line)


class Weld(Joint):
    """Two bodies become one: points coincide, the relative angle is fixed. Rows: [m], [m], [rad] (M14); in space six.

    - ``first``, ``second``, ``first_point``, ``second_point``: as for `Revolute`.
    - ``angle``: θ_i - θ_j [rad]; in space as for `FixedAngle`.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)
    angle: Any = 0.0

    def primitives(self, basis: AnyBasis) -> Primitives:
        return (CoincidentPoints(), *_same_rotation(basis, self.angle))


class ConstantSpeed(eqx.Module):
    """An angle that grows steadily from ``angle`` [rad] at ``speed`` [rad/s]."""

    angle: Scalar
    speed: Scalar

    def __call__(self, time: Scalar) -> Scalar:
        """Return the angle [rad] at a ``time`` [s]."""
        return self.angle + self.speed * time


class DrivenAngle(Joint):
    """A motor turns the second body against the first one: θ_j - θ_i - φ(t) = 0. One row [rad], in the plane (M106).

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
        on_both = blocks((i, negative(i.turning())), (j, j.turning()))
        return (Row(j.angle - i.angle - angle, on_both, acceleration, -speed),)
