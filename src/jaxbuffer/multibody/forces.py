"""Force elements between bodies: what they exert, what they store, what they dissipate."""

from collections.abc import Mapping
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp

from .. import space
from .._types import Scalar
from ..basis import components, is_zero, squared, times
from ..plane.unit_vector import check_unit
from ..space.either import Turn, Vector
from .kinematics import Block, Kinematics, MaterialPoint, Point

PASSING = 1e-6  # m


class Load(NamedTuple):
    """What acts on one body (M19).

    - ``body``: its index, or ``GROUND``.
    - ``force``: through the origin of its frame, in inertial axes [N].
    - ``moment``: about that [N m]; in space a vector.
    - ``modal``: on each modal coordinate [N]; empty for a rigid body.
    """

    body: int
    force: Vector
    moment: Scalar | space.Vector
    modal: tuple[Scalar, ...] = ()


def load_at(point: MaterialPoint, force: Vector, moment: Turn = 0.0) -> Load:
    """Return the load of a force and a moment that act at a material point (M19).

    **Arguments:** ``point``; ``force``: in inertial axes [N]; ``moment``: [N m], in space a vector.
    """
    lever = point.arm.cross(force)
    pairs = zip(point.shapes, point.rotations, strict=True)
    modal = tuple(shape.dot(force) + rotation * moment for shape, rotation in pairs)
    return Load(point.body, force, lever if is_zero(moment) else lever + moment, modal)


def turn_at(point: MaterialPoint, moment: Scalar | space.Vector) -> Load:
    """Return the load of a moment alone that acts at a material point (M19). ``moment``: [N m], in space a vector."""
    modal = tuple(times(rotation, components(moment)[-1]) for rotation in point.rotations)
    # Without a third component the vector of space is zero as well.
    return Load(point.body, type(point.arm)(0.0, 0.0), moment, modal)


class SpringDirection(NamedTuple):
    """How a spring-damper acts: the rate of its length is the sum over bodies of ``blocks`` (see `Block`) times the
    body's velocity; ``stiffness`` and ``damping`` per unit of that length."""

    blocks: Mapping[int, Block]
    stiffness: Scalar
    damping: Scalar


class ForceElement(eqx.Module):
    """Base of all force elements. ``kin``: the frames of all bodies at one instant."""

    def springs(self, kin: Kinematics) -> tuple[SpringDirection, ...]:
        """Return the spring-dampers in it, with their directions frozen: what implicit steps take for stiff."""
        return ()

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        """Return the loads on the bodies."""
        raise NotImplementedError

    def energy(self, kin: Kinematics) -> Scalar:
        """Return the stored energy [J]."""
        return 0.0

    def dissipation(self, kin: Kinematics) -> Scalar:
        """Return the power turned into heat [W]."""
        return 0.0


class AxialState(NamedTuple):
    """An axial element at one instant (M22).

    - ``length``: L [m]; with a guide it may be negative (M25).
    - ``rate``: L̇ [m/s].
    - ``along``: unit vector from the first end to the second [-].
    - ``first``, ``second``: the ends.
    - ``separation_rate``: Ḋ [m/s].
    """

    length: Scalar
    rate: Scalar
    along: Vector
    first: MaterialPoint
    second: MaterialPoint
    separation_rate: Vector


class AxialSpringDamper(ForceElement):
    """Spring and damper between two points; its tension is f = k (L - l_0) + c L̇ (M23).

    - ``first``, ``second``: bodies (indices, or ``GROUND``).
    - ``first_point``, ``second_point``: the ends, on their bodies.
    - ``stiffness``: k [N/m].
    - ``damping``: c [N s/m].
    - ``free_length``: l_0 [m].
    - ``published_damping``: damp with Ḋ, the whole rate of the separation, as the paper does (M24). That resists a
      rigid rotation and does not conserve angular momentum; it is there for comparison.
    - ``guide``: unit vector in the axes of the first body, along which it guides the second end. The length then goes
      on below zero where the ends pass each other (M25). None: the length is the distance of the ends.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    first_point: Point
    second_point: Point
    stiffness: Scalar
    damping: Scalar
    free_length: Scalar
    published_damping: bool = eqx.field(static=True, default=False)
    guide: tuple[float, ...] | None = eqx.field(static=True, default=None)

    def __check_init__(self) -> None:
        """Raise `InputError` for a guide that is no unit vector: the length along it would be another."""
        if self.guide is not None:
            check_unit("guide", *self.guide)

    def state(self, kin: Kinematics) -> AxialState:
        """Return length, rate and direction at one instant (M22, M25)."""
        i, j = kin.point(self.first, self.first_point), kin.point(self.second, self.second_point)
        separation, rate = j.place - i.place, j.velocity - i.velocity
        if self.guide is None:
            length = jnp.sqrt(separation.dot(separation))
            along = separation * (1.0 / length)
        else:
            axis = i.turn(kin.basis.vector(*self.guide))
            signed = separation.dot(axis)
            passing = signed < PASSING  # the ends' line has no direction where they meet: the guide's serves
            # Chosen before the root is taken: a root of zero has no derivative, even in a branch that is not taken.
            line = kin.basis.vector(*(jnp.where(passing, g, d) for g, d in zip(axis, separation, strict=True)))
            size = jnp.sqrt(line.dot(line))
            length, along = jnp.where(passing, signed, size), line * (1.0 / size)
        return AxialState(length, rate.dot(along), along, i, j, rate)

    def springs(self, kin: Kinematics) -> tuple[SpringDirection, ...]:
        s = self.state(kin)
        blocks = {self.first: s.first.along(-s.along), self.second: s.second.along(s.along)}
        return (SpringDirection(blocks, self.stiffness, self.damping),)

    def tension(self, kin: Kinematics) -> Scalar:
        """Return f [N], positive in tension (M23)."""
        s = self.state(kin)
        return self.stiffness * (s.length - self.free_length) + self.damping * s.rate

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        s = self.state(kin)
        elastic = s.along * (self.stiffness * (s.length - self.free_length))
        # The published damper resists the whole rate of separation, rigid rotation included.
        viscous = s.separation_rate if self.published_damping else s.along * s.rate
        pull = elastic + viscous * self.damping
        return load_at(s.first, pull), load_at(s.second, -pull)

    def energy(self, kin: Kinematics) -> Scalar:
        return 0.5 * self.stiffness * (self.state(kin).length - self.free_length) ** 2

    def dissipation(self, kin: Kinematics) -> Scalar:
        s = self.state(kin)
        squared = s.separation_rate.dot(s.separation_rate) if self.published_damping else s.rate * s.rate
        return self.damping * squared


class TorsionalSpringDamper(ForceElement):
    """Torque -k (θ_j - θ_i - angle) - c (θ̇_j - θ̇_i) on the second body, opposite on the first (M26).

    In space the rotation vector of the second body against the first, and their spins, take the place of angles (M215).

    - ``first``, ``second``: bodies i and j (indices, or ``GROUND``).
    - ``stiffness``: k [N m/rad].
    - ``damping``: c [N m s/rad].
    - ``angle``: θ_j - θ_i at rest [rad], in the plane; in space the bodies' axes are parallel at rest.
    - ``first_point``, ``second_point``: where a flexible body is held, a marker.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    stiffness: Scalar
    damping: Scalar
    angle: Scalar = 0.0
    first_point: Point = (0.0, 0.0)
    second_point: Point = (0.0, 0.0)

    def _ends(self, kin: Kinematics) -> tuple[MaterialPoint, MaterialPoint]:
        return kin.point(self.first, self.first_point), kin.point(self.second, self.second_point)

    def _twist(self, kin: Kinematics, i: MaterialPoint, j: MaterialPoint) -> Turn:
        """Return the rotation of the second body against the first, less that at rest [rad]."""
        turn: Turn = kin.basis.relative_rotation(i.frame, j.frame)
        return turn - self.angle if kin.basis.dimensions == 2 else turn

    def springs(self, kin: Kinematics) -> tuple[SpringDirection, ...]:
        i, j = self._ends(kin)
        along = (
            {self.first: tuple(-entry for entry in i.turning(turn)), self.second: j.turning(turn)}
            for turn in kin.basis.unit_turns
        )
        return tuple(SpringDirection(blocks, self.stiffness, self.damping) for blocks in along)

    def torque(self, kin: Kinematics) -> Turn:
        """Return the torque on ``second`` [N m], in space a vector."""
        i, j = self._ends(kin)
        return self._twist(kin, i, j) * -self.stiffness - (j.spin - i.spin) * self.damping

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        torque = self.torque(kin)
        return tuple(turn_at(end, moment) for end, moment in zip(self._ends(kin), (-torque, torque), strict=True))

    def energy(self, kin: Kinematics) -> Scalar:
        return 0.5 * self.stiffness * squared(self._twist(kin, *self._ends(kin)))

    def dissipation(self, kin: Kinematics) -> Scalar:
        i, j = self._ends(kin)
        return self.damping * squared(j.spin - i.spin)


class AppliedForce(ForceElement):
    """A constant force at a point of a body (M27). A rigid body's weight is one at the centre of mass.

    - ``body``: its index.
    - ``force``: (x, y), in space (x, y, z), in inertial axes [N].
    - ``point``: where it acts.
    """

    body: int = eqx.field(static=True)
    force: tuple[Scalar, ...]
    point: Point = (0.0, 0.0)

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        return (load_at(kin.point(self.body, self.point), kin.basis.vector(*self.force)),)

    def energy(self, kin: Kinematics) -> Scalar:
        return -kin.basis.vector(*self.force).dot(kin.point(self.body, self.point).place)


class AppliedTorque(ForceElement):
    """A constant torque on a body, in the plane (M27).

    - ``body``: its index.
    - ``torque``: [N m].
    - ``point``: where it acts on a flexible body, a marker.
    """

    body: int = eqx.field(static=True)
    torque: Scalar
    point: Point = (0.0, 0.0)

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        return (turn_at(kin.point(self.body, self.point), self.torque),)

    def energy(self, kin: Kinematics) -> Scalar:
        return -self.torque * kin.point(self.body, self.point).angle
