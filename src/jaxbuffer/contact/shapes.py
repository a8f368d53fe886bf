"""Shapes in contact: foot and normal of a ball against a segment, rims included, of a pin in a hole, and of a ball in a
surface of revolution."""

from abc import abstractmethod
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp

from .. import plane, space
from .._types import Scalar, Values
from ..plane.unit_vector import check_unit
from ..space.either import Vector

STILL = 1e-12  # m/s: a slip has a direction above it, and friction a slope at rest
THROUGH = 0.5  # of a ball's radius: a centre less far behind a segment has been pushed through it
ROUND = 3.0  # radii of a ball from an end of a segment: farther in nothing behind it has come round that end


class Foot(NamedTuple):
    """The point of a shape that is nearest to a ball's centre, in the shape's axes (M31).

    - ``x``, ``y``: the foot [m].
    - ``normal_x``, ``normal_y``: unit vector from the foot to the centre [-].
    - ``distance``: between them [m].
    """

    x: Values
    y: Values
    normal_x: Values
    normal_y: Values
    distance: Values


class Nearest(NamedTuple):
    """The point of a shape that is nearest to a ball's centre, in the shape's axes, in the plane or in space (M31).

    - ``foot``: that point [m].
    - ``normal``: unit vector from the foot to the centre [-].
    - ``distance``: between them [m].
    """

    foot: Vector
    normal: Vector
    distance: Values


class Shape(eqx.Module):
    """Base of the shapes."""

    @abstractmethod
    def nearest(self, place: Vector, side: Values | Scalar, radius: Scalar) -> Nearest:
        """Return the point that is nearest to a ball's centre.

        **Arguments:** ``place`` of the centre in the shape's axes [m]; ``side``: as of `BallPair`; ``radius`` of the
        ball [m].
        """

    @abstractmethod
    def slip(self, velocity: Vector, normal: Vector, side: Values | Scalar) -> tuple[Vector, Values]:
        """Return a unit tangent [-], and the slip along it [m/s].

        **Arguments:** ``velocity`` of the ball's material point at the foot against the shape's [m/s]; ``normal``, in
        the same axes; ``side``: as of `BallPair`.
        """


class PlaneShape(Shape):
    """Base of the shapes of the plane."""

    def foot(self, x: Values | Scalar, y: Values | Scalar, side: Values | Scalar, radius: Scalar) -> Foot:
        """Return the foot of a ball's centre (x, y) on the shape (M31).

        **Arguments:** ``x``, ``y``: the centre in the shape's axes [m]; ``side``: where a segment's front is, +1 to the
        right of its direction, -1 to the left; ``radius`` of the ball [m].
        """
        raise NotImplementedError

    def nearest(self, place: Vector, side: Values | Scalar, radius: Scalar) -> Nearest:
        foot = self.foot(place.x, place.y, side, radius)
        return Nearest(plane.Vector(foot.x, foot.y), plane.Vector(foot.normal_x, foot.normal_y), foot.distance)

    def slip(self, velocity: Vector, normal: Vector, side: Values | Scalar) -> tuple[Vector, Values]:
        # With the side's sign the tangents of both flanks of a cone point to the throat, so that slips compare.
        tangent = plane.Vector(side * normal.y, -side * normal.x)
        return tangent, jnp.asarray(velocity.dot(tangent))


class Segment(PlaneShape):
    """A straight flank; each field is a scalar or an array with an entry a segment (M30).

    The foot stays on the segment, so both ends are met as points and the normal turns continuously there.

    - ``start_x``, ``start_y``: where it starts [m].
    - ``direction_x``, ``direction_y``: unit vector along it [-].
    - ``length``: [m].
    """

    start_x: Values | Scalar
    start_y: Values | Scalar
    direction_x: Values | Scalar
    direction_y: Values | Scalar
    length: Scalar

    def __check_init__(self) -> None:
        """Raise `InputError` for a direction that is no unit vector: places along the segment would be wrong."""
        check_unit("Segment: direction", self.direction_x, self.direction_y)

    def foot(self, x: Values | Scalar, y: Values | Scalar, side: Values | Scalar, radius: Scalar) -> Foot:
        """Return the foot on each segment.

        A segment has two sides near its ends: a ball that has come round one bears on the back as it does on the front.
        But close behind, and anywhere behind the middle of a long segment, the distance is negative and the normal
        still points to the front: only a step too long, or a contact too soft, can have carried the centre there,
        through the segment.
        """
        from_x, from_y = x - self.start_x, y - self.start_y
        along = from_x * self.direction_x + from_y * self.direction_y
        behind = side * (self.direction_x * from_y - self.direction_y * from_x)
        inside = jnp.minimum(along, self.length - along)
        through = (behind < THROUGH * radius) | (inside > ROUND * radius)
        sign = jnp.where((behind > 0.0) & (inside > 0.0) & through, -1.0, 1.0)
        # Kept on the segment: beyond its ends the end itself is touched, as a point.
        slant = jnp.clip(along, 0.0, self.length)
        foot_x, foot_y = self.start_x + slant * self.direction_x, self.start_y + slant * self.direction_y
        off_x, off_y = x - foot_x, y - foot_y
        distance = sign * jnp.sqrt(off_x * off_x + off_y * off_y)
        return Foot(foot_x, foot_y, off_x / distance, off_y / distance, distance)


class Hole(PlaneShape):
    """A round hole, seen from inside: the wall around a pin (M105).

    The foot lies where the line from the hole's centre through the pin's meets the wall. Where the centres coincide
    there is no such line: the normal is then (-1, 0) and has no derivative.

    - ``x``, ``y``: its centre [m].
    - ``radius``: [m].
    """

    x: Scalar
    y: Scalar
    radius: Scalar

    def foot(self, x: Values | Scalar, y: Values | Scalar, side: Values | Scalar, radius: Scalar) -> Foot:
        off_x, off_y = jnp.asarray(x - self.x), jnp.asarray(y - self.y)
        square = off_x * off_x + off_y * off_y
        apart = square > 0.0
        eccentricity = jnp.sqrt(jnp.where(apart, square, 1.0))  # guarded: no derivative of a root at zero
        # Where the centres coincide any direction would do; this one is fixed (see the class).
        out_x = jnp.where(apart, off_x / eccentricity, 1.0)
        out_y = jnp.where(apart, off_y / eccentricity, 0.0)
        distance = self.radius - jnp.where(apart, eccentricity, 0.0)
        return Foot(self.x + self.radius * out_x, self.y + self.radius * out_y, -out_x, -out_y, distance)


class Revolved(Shape):
    """A surface of revolution about the x axis of the shape's axes, in space: a cone, a funnel, a round hole (M217).

    - ``meridian``: what is turned, in the half plane of x and the distance ρ from the axis; its `foot` is the surface's
      in the half plane of the ball's centre.
    """

    meridian: Segment

    def nearest(self, place: space.Vector, side: Values | Scalar, radius: Scalar) -> Nearest:  # type: ignore[override]
        square = jnp.asarray(place.y * place.y + place.z * place.z)
        # On the axis all directions are alike: any will do, and a root of zero has no derivative.
        off_axis = square > 0.0
        off = jnp.sqrt(jnp.where(off_axis, square, 1.0))
        y, z = jnp.where(off_axis, place.y / off, 1.0), jnp.where(off_axis, place.z / off, 0.0)
        foot = self.meridian.foot(place.x, jnp.where(off_axis, off, 0.0), side, radius)
        around = lambda x, r: space.Vector(x, r * y, r * z)  # noqa: E731
        return Nearest(around(foot.x, foot.y), around(foot.normal_x, foot.normal_y), foot.distance)  # type: ignore[arg-type]

    def slip(  # type: ignore[override]
        self, velocity: space.Vector, normal: space.Vector, side: Values | Scalar
    ) -> tuple[space.Vector, Values]:
        """Return the direction of the slip, and its size (M218)."""
        across = velocity - normal * velocity.dot(normal)
        # Without the small number friction would have no slope where nothing slips.
        size = jnp.sqrt(across.dot(across) + STILL * STILL)
        return across * (1.0 / size), size
