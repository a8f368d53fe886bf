"""Joints: constraint Φ(q) = 0, its Jacobian Φ_q and γ = -(Φ_q q̇)_q q̇, each in closed form.

Every joint yields rows; a row holds the blocks of Φ_q that are not zero, by body. The multiplier of a row is the
joint's reaction in the augmented system ``M q̈ + Φ_qᵀ λ = F`` (Efficient buffering mechanism, eq. 7 and 13).
"""

from typing import NamedTuple

import equinox as eqx

from .._types import Scalar
from .kinematics import GROUND, Kinematics, Vector

Block = tuple[Scalar, Scalar, Scalar]


class Row(NamedTuple):
    """One scalar constraint: its value, ∂Φ/∂(u, v, θ) by body, and γ."""

    phi: Scalar
    blocks: dict[int, Block]
    gamma: Scalar


def _blocks(first: int, a: Block, second: int, b: Block) -> dict[int, Block]:
    return {body: block for body, block in ((first, a), (second, b)) if body != GROUND}


class Joint(eqx.Module):
    """Base of all joints between two bodies (indices, or ``GROUND``)."""

    first: eqx.AbstractVar[int]
    second: eqx.AbstractVar[int]

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        """The joint's scalar constraints at one instant."""
        raise NotImplementedError


class Revolute(Joint):
    """Two points coincide: r_i + A(θ_i) s_i - r_j - A(θ_j) s_j = 0. Two rows [m].

    **Arguments:** ``first``, ``second``: bodies; ``first_point``, ``second_point``: the points in each body's axes [m].
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
    """The bodies keep their relative angle: θ_i - θ_j - ``angle`` = 0. One row [rad]."""

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    angle: Scalar = 0.0

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        i, j = kin.frame(self.first), kin.frame(self.second)
        blocks = _blocks(self.first, (0.0, 0.0, 1.0), self.second, (0.0, 0.0, -1.0))
        return (Row(i.angle - j.angle - self.angle, blocks, 0.0),)


class PointOnLine(Joint):
    """A point of ``second`` stays on a line of ``first``: n(θ_i) · (p_j - p_i) = 0. One row [m].

    **Arguments:** ``first_point``: a point of the line; ``normal``: the line's unit normal, both in the axes of
    ``first``; ``second_point``: the guided point in the axes of ``second`` [m].
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
    """``second`` slides along a line of ``first`` without turning (eq. 7-c and 7-d). Rows: angle [rad], offset [m].

    **Arguments:** as for `PointOnLine`; ``angle``: θ_i - θ_j held fixed [rad].
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
    """Two bodies become one: the points coincide and the relative angle is fixed. Rows: [m], [m], [rad]."""

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: tuple[Scalar, Scalar] = (0.0, 0.0)
    second_point: tuple[Scalar, Scalar] = (0.0, 0.0)
    angle: Scalar = 0.0

    def rows(self, kin: Kinematics) -> tuple[Row, ...]:
        pin = Revolute(self.first, self.second, self.first_point, self.second_point)
        return pin.rows(kin) + FixedAngle(self.first, self.second, self.angle).rows(kin)
