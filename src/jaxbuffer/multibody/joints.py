"""Joints: constraint Φ(q) = 0, its Jacobian Φ_q and γ = -(Φ_q q̇)_q q̇, each in closed form (M9).

Every joint gives rows; a row holds the blocks of Φ_q that are not zero, by body. The multiplier of a row is the joint's
reaction in the augmented system ``M q̈ + Φ_qᵀ λ = F`` (M16).
"""

from typing import NamedTuple

import equinox as eqx

from .._types import Scalar
from ..plane import Vector
from .kinematics import GROUND, Kinematics

Block = tuple[Scalar, Scalar, Scalar]


class Row(NamedTuple):
    """One scalar constraint (M9).

    - ``phi``: Φ [m or rad].
    - ``blocks``: by body, ∂Φ/∂(u, v, θ): [-, -, m] or, of an angle, [1/m, 1/m, -].
    - ``gamma``: γ [m/s² or rad/s²].
    """

    phi: Scalar
    blocks: dict[int, Block]
    gamma: Scalar


def _blocks(first: int, a: Block, second: int, b: Block) -> dict[int, Block]:
    return {body: block for body, block in ((first, a), (second, b)) if body != GROUND}


class Joint(eqx.Module):
    """Base of all joints.

    - ``first``, ``second``: bodies i and j (indices, or ``GROUND``).
    """

    first: eqx.AbstractVar[int]
    second: eqx.AbstractVar[int]

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        """The joint's scalar constraints at one instant. ``kin``: the frames of all bodies."""
        raise NotImplementedError


class Revolute(Joint):
    """Two points coincide: r_i + A(θ_i) s_i - r_j - A(θ_j) s_j = 0. Two rows [m] (M10).

    - ``first``, ``second``: bodies i and j.
    - ``first_point``, ``second_point``: (x, y) of the points in the axes of their bodies [m].
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: tuple[Scalar, Scalar] = (0.0, 0.0)
    second_point: tuple[Scalar, Scalar] = (0.0, 0.0)

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        i, j = kin.frame(self.first), kin.frame(self.second)
        a, b = i.turn(Vector(*self.first_point)), j.turn(Vector(*self.second_point))
        phi = i.origin + a - j.origin - b
        gamma = a * (i.spin * i.spin) - b * (j.spin * j.spin)
        return (
            Row(phi.x, _blocks(self.first, (1.0, 0.0, -a.y), self.second, (-1.0, 0.0, b.y)), gamma.x),
            Row(phi.y, _blocks(self.first, (0.0, 1.0, a.x), self.second, (0.0, -1.0, -b.x)), gamma.y),
        )


class FixedAngle(Joint):
    """The bodies keep their relative angle: θ_i - θ_j - ``angle`` = 0. One row [rad] (M11).

    - ``first``, ``second``: bodies i and j.
    - ``angle``: θ_i - θ_j [rad].
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    angle: Scalar = 0.0

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        i, j = kin.frame(self.first), kin.frame(self.second)
        blocks = _blocks(self.first, (0.0, 0.0, 1.0), self.second, (0.0, 0.0, -1.0))
        return (Row(i.angle - j.angle - self.angle, blocks, 0.0),)


class PointOnLine(Joint):
    """A point of the second body stays on a line of the first one. One row [m] (M12).

    - ``first``, ``second``: bodies i and j.
    - ``first_point``: (x, y) of a point of the line in the axes of ``first`` [m].
    - ``second_point``: (x, y) of the guided point in the axes of ``second`` [m].
    - ``normal``: (x, y), the line's unit normal in the axes of ``first`` [-].
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: tuple[Scalar, Scalar] = (0.0, 0.0)
    second_point: tuple[Scalar, Scalar] = (0.0, 0.0)
    normal: tuple[Scalar, Scalar] = (0.0, 1.0)

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        i, j = kin.frame(self.first), kin.frame(self.second)
        n = i.turn(Vector(*self.normal))
        a, b = i.turn(Vector(*self.first_point)), j.turn(Vector(*self.second_point))
        d = j.origin + b - i.origin - a
        # The line's point moves with `first`, and so does the normal: ∂Φ/∂θ_i = n⊥·d - n·a⊥ = n⊥·(d + a).
        from_origin = d + a
        slip = j.velocity_at(b) - i.velocity
        gamma = i.spin * (i.spin * n.dot(from_origin) - 2.0 * n.perp().dot(slip)) + j.spin * j.spin * n.dot(b)
        blocks = _blocks(
            self.first,
            (-n.x, -n.y, n.perp().dot(from_origin)),
            self.second,
            (n.x, n.y, n.dot(b.perp())),
        )
        return (Row(n.dot(d), blocks, gamma),)


class Prismatic(Joint):
    """The second body slides along a line of the first one without turning. Rows: angle [rad], offset [m] (M13).

    - ``first``, ``second``, ``first_point``, ``second_point``, ``normal``: as for `PointOnLine`.
    - ``angle``: θ_i - θ_j, held fixed [rad].
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: tuple[Scalar, Scalar] = (0.0, 0.0)
    second_point: tuple[Scalar, Scalar] = (0.0, 0.0)
    normal: tuple[Scalar, Scalar] = (0.0, 1.0)
    angle: Scalar = 0.0

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        line = PointOnLine(self.first, self.second, self.first_point, self.second_point, self.normal)
        return FixedAngle(self.first, self.second, self.angle).rows(kin) + line.rows(kin)


class Weld(Joint):
    """Two bodies become one: points coincide, the relative angle is fixed. Rows: [m], [m], [rad] (M14).

    - ``first``, ``second``, ``first_point``, ``second_point``: as for `Revolute`.
    - ``angle``: θ_i - θ_j [rad].
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: tuple[Scalar, Scalar] = (0.0, 0.0)
    second_point: tuple[Scalar, Scalar] = (0.0, 0.0)
    angle: Scalar = 0.0

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        pin = Revolute(self.first, self.second, self.first_point, self.second_point)
        return pin.rows(kin) + FixedAngle(self.first, self.second, self.angle).rows(kin)
