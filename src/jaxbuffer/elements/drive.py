"""Drives: a prescribed motion, and a motor whose torque falls with its speed (M106, M107, M206)."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from ..multibody import (
    GROUND,
    DrivenAngle,
    Kinematics,
    Load,
    Point,
    Row,
    SpringDirection,
    TorsionalSpringDamper,
    turn_at,
)
from .element import Closed, Element, Magnitudes, Own

TORQUES = ("drive_torque", "braking_torque")


def watched_torque(names: tuple[str, ...], torque: Scalar) -> dict[str, Scalar]:
    """Return a torque [N m] and its negative by name, or nothing without names. The largest value of the negative is
    that of the least torque."""
    return dict(zip(names, (torque, -torque), strict=False))


class DriveState(NamedTuple):
    """A drive at one instant: ``rows`` of its constraint, and ``spin`` of the second body against the first [rad/s]."""

    rows: tuple[Row, ...]
    spin: Scalar


class Drive(Element):
    """A drive that turns one body against another by an angle that is known over time, whatever torque that takes.

    The mechanism adds the joint to those of its system, and keeps the time.

    - ``joint``: the angle over time (M106), see `ConstantSpeed`.
    - ``supplied_as``: the name of the energy that it puts in (M107).
    - ``watched``: names of its torque [N m] and of the negative of that, both watched for their largest values; where
      the bodies do not turn against each other, both are given as 0. Empty: they are not watched.
    """

    joint: DrivenAngle
    supplied_as: str = eqx.field(static=True, default="drives")
    watched: tuple[str, ...] = eqx.field(static=True, default=TORQUES)
    name: str = eqx.field(static=True, default="drive")

    @property
    def driving_joint(self) -> DrivenAngle:
        return self.joint

    @property
    def variables(self) -> tuple[str, ...]:
        return ("work",)

    def scales(self, size: Magnitudes) -> list[Scalar]:
        return [size.energy]

    def evaluate(self, kin: Kinematics, own: Own) -> DriveState:
        joint = self.joint
        first, second = kin.point(joint.first, joint.first_point), kin.point(joint.second, joint.second_point)
        return DriveState(joint.rows(kin), second.spin - first.spin)

    def reaction_rates(self, at: DriveState, multipliers: Float[Array, " rows"]) -> list[Scalar]:
        # The power is λ·Φ_t (M107).
        return [sum((multipliers[k] * row.rate for k, row in enumerate(at.rows)), start=jnp.zeros(()))]

    def supplied(self, own: Own) -> dict[str, Scalar]:
        return {self.supplied_as: own[0]}

    @property
    def observed_of_rate(self) -> tuple[str, ...]:
        return self.watched

    def observables_of_rate(self, at: DriveState, acceleration: Array, own_rate: Own) -> dict[str, Scalar]:
        turning = at.spin != 0.0
        # The torque is the power over the speed; a division by zero that is not taken would still give NaN slopes.
        torque = jnp.where(turning, own_rate[0] / jnp.where(turning, at.spin, 1.0), 0.0)
        return watched_torque(self.watched, torque)

    def roundoff(self) -> dict[str, Scalar]:
        # A torque may be below zero all the time, and its largest value then counts as well.
        return dict.fromkeys(self.watched, -jnp.inf)


class Motor(Element):
    """A motor whose torque M_0 (1 - ω/ω_0) on one body against another falls with its speed (M206).

    It puts in M_0 ω, of which it loses M_0 ω²/ω_0 in itself.

    - ``body``: index of the body that it turns; ``carrier``: of what carries it, or ``GROUND``.
    - ``torque``: M_0 at rest [N m]; ``no_load_speed``: ω_0, at which there is none [rad/s].
    - ``angle``: of the body against the carrier at which nothing has been put in [rad].
    - ``point``, ``carrier_point``: where it acts on a flexible body, a marker.
    - ``supplied_as``, ``lost_in``: names of the energy that it puts in, and of that which it loses.
    - ``watched``: names of its torque [N m] and of the negative of that, as of `Drive`.
    """

    body: int = eqx.field(static=True)
    torque: Scalar
    no_load_speed: Scalar
    angle: Scalar = 0.0
    carrier: int = eqx.field(static=True, default=GROUND)
    point: Point = (0.0, 0.0)
    carrier_point: Point = (0.0, 0.0)
    supplied_as: str = eqx.field(static=True, default="drives")
    lost_in: str = eqx.field(static=True, default="motor")
    watched: tuple[str, ...] = eqx.field(static=True, default=TORQUES)
    name: str = eqx.field(static=True, default="motor")

    @property
    def damper(self) -> TorsionalSpringDamper:
        """Return the damper of M_0/ω_0 that, with a constant torque, is the motor."""
        return TorsionalSpringDamper(
            first=self.carrier,
            second=self.body,
            stiffness=0.0,
            damping=self.torque / self.no_load_speed,
            first_point=self.carrier_point,
            second_point=self.point,
        )

    def loads(self, at: Kinematics, closed: Closed) -> tuple[Load, ...]:
        body, carrier = at.point(self.body, self.point), at.point(self.carrier, self.carrier_point)
        return turn_at(body, self.torque), turn_at(carrier, -self.torque), *self.damper.loads(at)

    def stored(self, at: Kinematics, closed: Closed) -> dict[str, Scalar]:
        # The torque M_0 is constant: what it has put in follows from the angle alone, without a state of its own.
        body, carrier = at.point(self.body, self.point), at.point(self.carrier, self.carrier_point)
        return {self.supplied_as: -self.torque * (body.angle - carrier.angle - self.angle)}

    @property
    def loss_names(self) -> tuple[str, ...]:
        return (self.lost_in,)

    def losses(self, at: Kinematics, closed: Closed) -> dict[str, Scalar]:
        return {self.lost_in: self.damper.dissipation(at)}

    @property
    def observed(self) -> tuple[str, ...]:
        return self.watched

    def observables(self, at: Kinematics, closed: Closed) -> dict[str, Scalar]:
        return watched_torque(self.watched, self.torque + self.damper.torque(at))

    def roundoff(self) -> dict[str, Scalar]:
        return dict.fromkeys(self.watched, -jnp.inf)

    def springs(self, at: Kinematics, closed: Closed) -> tuple[SpringDirection, ...]:
        return self.damper.springs(at)
