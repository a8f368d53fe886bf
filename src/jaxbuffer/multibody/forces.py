"""Force elements between bodies: what they exert, what they store, what they dissipate."""

from collections.abc import Mapping
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp

from .._types import Scalar
from ..plane import Vector
from .kinematics import Kinematics

PASSING = 1e-6  # m


class Load(NamedTuple):
    """What acts on one body (M19).

    - ``body``: its index, or ``GROUND``.
    - ``force``: through the centre of mass, in inertial axes [N].
    - ``moment``: about the centre of mass [N m].
    """

    body: int
    force: Vector
    moment: Scalar


def load_at(body: int, force: Vector, arm: Vector) -> Load:
    """The load of a force that acts away from the centre of mass (M19).

    **Arguments:** ``body``: its index; ``force``: in inertial axes [N]; ``arm``: from the centre of mass, in inertial
    axes [m].
    """
    return Load(body, force, arm.cross(force))


class SpringDirection(NamedTuple):
    """How a spring-damper acts: the rate of its length is the sum over bodies of ``blocks`` (u, v, θ) times the body's
    velocity; ``stiffness`` and ``damping`` per unit of that length."""

    blocks: Mapping[int, tuple[Scalar, Scalar, Scalar]]
    stiffness: Scalar
    damping: Scalar


class ForceElement(eqx.Module):
    """Base of all force elements. ``kin``: the frames of all bodies at one instant."""

    def springs(self, kin: Kinematics) -> tuple[SpringDirection, ...]:
        """The spring-dampers in it, with their directions frozen: what implicit steps take for stiff."""
        return ()

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        """Loads on the bodies."""
        raise NotImplementedError

    def energy(self, kin: Kinematics) -> Scalar:
        """Stored energy [J]."""
        return 0.0

    def dissipation(self, kin: Kinematics) -> Scalar:
        """Power turned into heat [W]."""
        return 0.0


class AxialState(NamedTuple):
    """An axial element at one instant (M22).

    - ``length``: L [m]; with a guide it may be negative (M25).
    - ``rate``: L̇ [m/s].
    - ``along``: unit vector from the first end to the second [-].
    - ``first_arm``, ``second_arm``: of the ends, from their bodies' centres of mass, in inertial axes [m].
    - ``separation_rate``: Ḋ [m/s].
    """

    length: Scalar
    rate: Scalar
    along: Vector
    first_arm: Vector
    second_arm: Vector
    separation_rate: Vector


class AxialSpringDamper(ForceElement):
    """Spring and damper between two points; its tension is f = k (L - l_0) + c L̇ (M23).

    - ``first``, ``second``: bodies (indices, or ``GROUND``).
    - ``first_point``, ``second_point``: (x, y) of the ends in the axes of their bodies [m].
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
    first_point: tuple[Scalar, Scalar]
    second_point: tuple[Scalar, Scalar]
    stiffness: Scalar
    damping: Scalar
    free_length: Scalar
    published_damping: bool = eqx.field(static=True, default=False)
    guide: tuple[float, float] | None = eqx.field(static=True, default=None)

    def state(self, kin: Kinematics) -> AxialState:
        """Length, rate and direction at one instant (M22, M25)."""
        i, j = kin.frame(self.first), kin.frame(self.second)
        a, b = i.turn(Vector(*self.first_point)), j.turn(Vector(*self.second_point))
        separation = j.origin + b - i.origin - a
        rate = j.velocity_at(b) - i.velocity_at(a)
        if self.guide is None:
            length = jnp.sqrt(separation.dot(separation))
            along = separation * (1.0 / length)
        else:
            axis = i.turn(Vector(*self.guide))
            signed = separation.dot(axis)
            passing = signed < PASSING  # the ends' line has no direction where they meet: the guide's serves
            line = Vector(*(jnp.where(passing, g, d) for g, d in zip(axis, separation, strict=True)))
            size = jnp.sqrt(line.dot(line))
            length, along = jnp.where(passing, signed, size), line * (1.0 / size)
        return AxialState(length, rate.dot(along), along, a, b, rate)

    def springs(self, kin: Kinematics) -> tuple[SpringDirection, ...]:
        s = self.state(kin)
        u, a, b = s.along, s.first_arm, s.second_arm
        blocks = {self.first: (-u.x, -u.y, -a.cross(u)), self.second: (u.x, u.y, b.cross(u))}
        return (SpringDirection(blocks, self.stiffness, self.damping),)

    def tension(self, kin: Kinematics) -> Scalar:
        """f [N], positive in tension (M23)."""
        s = self.state(kin)
        return self.stiffness * (s.length - self.free_length) + self.damping * s.rate

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        s = self.state(kin)
        elastic = s.along * (self.stiffness * (s.length - self.free_length))
        viscous = s.separation_rate if self.published_damping else s.along * s.rate
        pull = elastic + viscous * self.damping
        return load_at(self.first, pull, s.first_arm), load_at(self.second, -pull, s.second_arm)

    def energy(self, kin: Kinematics) -> Scalar:
        return 0.5 * self.stiffness * (self.state(kin).length - self.free_length) ** 2

    def dissipation(self, kin: Kinematics) -> Scalar:
        s = self.state(kin)
        squared = s.separation_rate.dot(s.separation_rate) if self.published_damping else s.rate * s.rate
        return self.damping * squared


class TorsionalSpringDamper(ForceElement):
    """Torque -k (θ_j - θ_i - angle) - c (θ̇_j - θ̇_i) on the second body, opposite on the first (M26).

    - ``first``, ``second``: bodies i and j (indices, or ``GROUND``).
    - ``stiffness``: k [N m/rad].
    - ``damping``: c [N m s/rad].
    - ``angle``: θ_j - θ_i at rest [rad].
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    stiffness: Scalar
    damping: Scalar
    angle: Scalar = 0.0

    def springs(self, kin: Kinematics) -> tuple[SpringDirection, ...]:
        blocks = {self.first: (0.0, 0.0, -1.0), self.second: (0.0, 0.0, 1.0)}
        return (SpringDirection(blocks, self.stiffness, self.damping),)

    def torque(self, kin: Kinematics) -> Scalar:
        """Torque on ``second`` [N m]."""
        i, j = kin.frame(self.first), kin.frame(self.second)
        return -self.stiffness * (j.angle - i.angle - self.angle) - self.damping * (j.spin - i.spin)

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        torque = self.torque(kin)
        none = Vector(0.0, 0.0)
        return Load(self.first, none, -torque), Load(self.second, none, torque)

    def energy(self, kin: Kinematics) -> Scalar:
        i, j = kin.frame(self.first), kin.frame(self.second)
        return 0.5 * self.stiffness * (j.angle - i.angle - self.angle) ** 2

    def dissipation(self, kin: Kinematics) -> Scalar:
        i, j = kin.frame(self.first), kin.frame(self.second)
        return self.damping * (j.spin - i.spin) ** 2


class AppliedForce(ForceElement):
    """A constant force at a point of a body (M27). Weight is one at the centre of mass.

    - ``body``: its index.
    - ``force``: (x, y) in inertial axes [N].
    - ``point``: (x, y) in the body's axes [m].
    """

    body: int = eqx.field(static=True)
    force: tuple[Scalar, Scalar]
    point: tuple[Scalar, Scalar] = (0.0, 0.0)

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        return (load_at(self.body, Vector(*self.force), kin.frame(self.body).turn(Vector(*self.point))),)

    def energy(self, kin: Kinematics) -> Scalar:
        frame = kin.frame(self.body)
        return -Vector(*self.force).dot(frame.origin + frame.turn(Vector(*self.point)))


class AppliedTorque(ForceElement):
    """A constant torque on a body (M27).

    - ``body``: its index.
    - ``torque``: [N m].
    """

    body: int = eqx.field(static=True)
    torque: Scalar

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        return (Load(self.body, Vector(0.0, 0.0), self.torque),)

    def energy(self, kin: Kinematics) -> Scalar:
        return -self.torque * kin.frame(self.body).angle
