"""Force elements between bodies: what they exert, what they store, what they dissipate."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp

from .._types import Scalar
from .kinematics import Kinematics, Vector

PASSING = 1e-6  # m


class Load(NamedTuple):
    """A force [N] through a body's centre of mass and a moment [N m] about it."""

    body: int
    force: Vector
    moment: Scalar


def load_at(body: int, force: Vector, arm: Vector) -> Load:
    """A force acting at ``arm`` (inertial axes, from the centre of mass)."""
    return Load(body, force, arm.cross(force))


class ForceElement(eqx.Module):
    """Base of all force elements."""

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
    """An axial element's instant: length [m], its rate [m/s], unit vector first → second, both arms, rate of D."""

    length: Scalar
    rate: Scalar
    along: Vector
    first_arm: Vector
    second_arm: Vector
    separation_rate: Vector


class AxialSpringDamper(ForceElement):
    """Spring and damper between two points (eq. 8-9): f = k (L - l_0) + c L̇, pulling the ends together when positive.

    **Arguments:** ``stiffness`` [N/m]; ``damping`` [N s/m]; ``free_length`` [m]; the points in their bodies' axes [m].
    ``guide``: direction in which the first body guides the second end, a unit vector in its axes; the length then goes
    on below zero where the ends pass each other. None: the length is the distance.
    ``published_damping``: damp with the whole rate of D as the paper's Rayleigh function does (eq. 10). That resists a
    rigid rotation and does not conserve angular momentum; it exists for comparison only.
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
        """Length, rate and direction at one instant."""
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

    def tension(self, kin: Kinematics) -> Scalar:
        """f [N], positive in tension."""
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
    """Torque -k (θ_j - θ_i - angle) - c (θ̇_j - θ̇_i) on ``second``, opposite on ``first``.

    **Arguments:** ``stiffness`` [N m/rad]; ``damping`` [N m s/rad]; ``angle``: θ_j - θ_i at rest [rad].
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    stiffness: Scalar
    damping: Scalar
    angle: Scalar = 0.0

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
    """A constant force [N] in inertial axes at a point of a body [m, body axes]; weight is one at the origin."""

    body: int = eqx.field(static=True)
    force: tuple[Scalar, Scalar]
    point: tuple[Scalar, Scalar] = (0.0, 0.0)

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        return (load_at(self.body, Vector(*self.force), kin.frame(self.body).turn(Vector(*self.point))),)

    def energy(self, kin: Kinematics) -> Scalar:
        frame = kin.frame(self.body)
        return -Vector(*self.force).dot(frame.origin + frame.turn(Vector(*self.point)))


class AppliedTorque(ForceElement):
    """A constant torque [N m] on a body."""

    body: int = eqx.field(static=True)
    torque: Scalar

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        return (Load(self.body, Vector(0.0, 0.0), self.torque),)

    def energy(self, kin: Kinematics) -> Scalar:
        return -self.torque * kin.frame(self.body).angle
