"""What joints are made of: two points coincide, and a vector stays perpendicular to another (M212, M213).

Rows, their rates and their right-hand sides come from these alone, in the plane and in space.
"""

from collections.abc import Mapping
from typing import NamedTuple

from .._types import Scalar
from ..basis import AnyBasis
from .kinematics import GROUND, Block, MaterialPoint, block_difference


class Row(NamedTuple):
    """One scalar constraint (M9).

    - ``phi``: Φ [m or rad].
    - ``blocks``: by body, how Φ̇ goes with its velocities: in the plane ∂Φ/∂(u, v, θ, modal coordinates), [-, -, m, -]
      or, of an angle, [1/m, 1/m, -, 1/m].
    - ``gamma``: γ = -(Φ_q q̇)_q q̇, of a drive less Φ_tt [m/s² or rad/s²].
    - ``rate``: Φ_t, which only drives have [m/s or rad/s].
    """

    phi: Scalar
    blocks: Mapping[int, Block]
    gamma: Scalar
    rate: Scalar = 0.0


class CoincidentPoints(NamedTuple):
    """Two points coincide: a row for each inertial axis [m] (M212)."""

    def rows(self, basis: AnyBasis, i: MaterialPoint, j: MaterialPoint) -> tuple[Row, ...]:
        """Return p_i - p_j = 0."""
        phi, gamma = i.place - j.place, j.quadratic - i.quadratic
        # The points' speeds along inertial axes, without their zeros.
        first, second = (basis.along_axes(end.arm) for end in (i, j))
        return tuple(
            Row(
                phi[k],
                blocks(
                    (i, (*first[k], *(shape[k] for shape in i.shapes))),
                    (j, negative((*second[k], *(shape[k] for shape in j.shapes)))),
                ),
                gamma[k],
            )
            for k in range(basis.dimensions)
        )


class PerpendicularVectors(NamedTuple):
    """A vector a of the first body stays perpendicular to a vector b: one row (M213).

    - ``first``: a in the axes of the first body.
    - ``second``: b in the axes of the second body [-]; None for the line from the first point to the second [m].
    """

    first: tuple[Scalar, ...]
    second: tuple[Scalar, ...] | None = None

    def rows(self, basis: AnyBasis, i: MaterialPoint, j: MaterialPoint) -> tuple[Row, ...]:
        """Return a·b = 0, of which either vector turns with the material it belongs to."""
        a = i.turn(basis.vector(*self.first))
        if self.second is None:
            b, b_rate, b_second = j.place - i.place, j.velocity - i.velocity, j.quadratic - i.quadratic
            on_i, on_j = block_difference(i.turning(a.cross(b)), i.along(a)), j.along(a)
        else:
            b = j.turn(basis.vector(*self.second))
            b_rate, b_second = j.frame.rate_of(b), j.frame.centripetal(b)
            on_i, on_j = i.turning(a.cross(b)), j.turning(b.cross(a))
        second = i.frame.centripetal(a).dot(b) + 2.0 * i.frame.rate_of(a).dot(b_rate) + a.dot(b_second)
        return (Row(a.dot(b), blocks((i, on_i), (j, on_j)), -second),)


class EqualAngles(NamedTuple):
    """In the plane the bodies keep their relative angle: θ_i - θ_j - ``angle`` = 0, one row [rad] (M11).

    It takes the place of perpendicular vectors of two bodies there, being linear, with one solution and no other half a
    turn away.
    """

    angle: Scalar

    def rows(self, basis: AnyBasis, i: MaterialPoint, j: MaterialPoint) -> tuple[Row, ...]:
        """Return θ_i - θ_j - α_0 = 0."""
        return (Row(i.angle - j.angle - self.angle, blocks((i, i.turning()), (j, negative(j.turning()))), 0.0),)


Primitive = CoincidentPoints | PerpendicularVectors | EqualAngles
"""A condition on two material points, of bodies i and j, that gives rows."""


def blocks(*of: tuple[MaterialPoint, Block]) -> dict[int, Block]:
    """Return a row's blocks by body; the ground has none."""
    return {point.body: block for point, block in of if point.body != GROUND}


def negative(block: Block) -> Block:
    """Return the negative of a block."""
    return tuple(-entry for entry in block)
