"""Attitude control that turns a body back to the inertial axes (M217)."""

import dataclasses
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp

from .._types import Scalar
from ..basis import AnyBasis, components, squared
from ..multibody import GROUND, Kinematics, Load
from ..plane import PLANE
from ..space.either import Turn, Vector
from .element import Closed, Element, Magnitudes, Own, Switch
from .report import Report


class ControlState(NamedTuple):
    """Attitude control at one instant.

    - ``moment``: on the body while it acts, in inertial axes [N m].
    - ``spin``: of the body, in inertial axes [rad/s].
    - ``gap``, ``closing``: of what ends it [m], and how fast that closes [m/s].
    """

    moment: Turn
    spin: Turn
    gap: Scalar
    closing: Scalar


class AttitudeControl(Element):
    """A moment on a body against its rotation from the inertial axes and its spin, about each of its own axes (M217).

    Thrusters fire in pulses; this smooth law stands for their mean.

    - ``body``: its index.
    - ``stiffness``: k_p [N m/rad], ``damping``: c_p [N m s/rad].
    - ``limit``: M_max, which the moment about no axis exceeds [N m]; None: it has no limit.
    - ``until``: the element with whose first contact, or closing, it ends; None: it acts to the end of the run.
    - ``basis``: of the mechanism, which says it.
    - ``name``: of the energy that it puts in; its switch, which closes where it ends, is the name with " over".
    """

    body: int = eqx.field(static=True)
    stiffness: Scalar
    damping: Scalar
    limit: Scalar | None = None
    until: Element | None = None
    basis: AnyBasis = PLANE
    name: str = eqx.field(static=True, default="attitude_control")

    def in_mechanism(self, speed: Scalar, basis: AnyBasis) -> "AttitudeControl":
        until = None if self.until is None else self.until.in_mechanism(speed, basis)
        return dataclasses.replace(self, basis=basis, until=until)

    @property
    def variables(self) -> tuple[str, ...]:
        return ("work", *(f"impulse_{k}" for k in range(len(self.basis.unit_turns))))

    def scales(self, size: Magnitudes) -> list[Scalar]:
        return [size.energy, *[size.momentum] * len(self.basis.unit_turns)]

    @property
    def switches(self) -> tuple[Switch, ...]:
        # Its end is an event, since the moment jumps there.
        return () if self.until is None else (Switch(f"{self.name} over", one_way=True),)

    def evaluate(self, kin: Kinematics, own: Own) -> ControlState:
        frame = kin.frame(self.body)
        # A rotation vector has the same components in the axes before and after its rotation.
        rotation = components(kin.basis.relative_rotation(kin.frame(GROUND), frame))
        spin = components(frame.spin) if kin.basis.dimensions == 2 else tuple(frame.unturn(frame.spin))
        moments = [self._about_axis(angle, rate) for angle, rate in zip(rotation, spin, strict=True)]
        moment = moments[0] if kin.basis.dimensions == 2 else frame.turn(kin.basis.vector(*moments))
        if self.until is None:
            return ControlState(moment, frame.spin, 1.0, 0.0)
        other = self.until
        gap, closing = other.gaps(other.evaluate(kin, jnp.zeros(len(other.variables))))[0]
        # Of several segments the one that is nearest.
        nearest = jnp.argmin(gap) if jnp.ndim(gap) else None
        pair = (gap, closing) if nearest is None else (jnp.min(gap), jnp.asarray(closing)[nearest])
        return ControlState(moment, frame.spin, *pair)

    def _about_axis(self, angle: Scalar, rate: Scalar) -> Scalar:
        """Return the moment about one of the body's axes [N m] (M217)."""
        wanted = self.stiffness * angle + self.damping * rate
        return -wanted if self.limit is None else -self.limit * jnp.tanh(wanted / self.limit)

    def gaps(self, at: ControlState) -> list[tuple[Scalar, Scalar]]:
        return [] if self.until is None else [(at.gap, at.closing)]

    def moment(self, at: ControlState, closed: Closed) -> Turn:
        """Return the moment, in inertial axes [N m]."""
        return at.moment if self.until is None else at.moment * (1.0 - closed[0])

    def loads(self, at: ControlState, closed: Closed) -> tuple[Load, ...]:
        return (Load(self.body, self.basis.vector(0.0, 0.0), self.moment(at, closed)),)

    def rates(self, at: ControlState, closed: Closed) -> list[Scalar]:
        # Work and impulse are states, so that energy and momentum can be checked though they come from outside.
        moment = components(self.moment(at, closed))
        power = sum((m * rate for m, rate in zip(moment, components(at.spin), strict=True)), start=jnp.zeros(()))
        return [power, *moment]

    def supplied(self, own: Own) -> dict[str, Scalar]:
        return {self.name: own[0]}

    def impulse(self, own: Own) -> tuple[Vector, Turn]:
        return self.basis.vector(0.0, 0.0), self.basis.turn(*own[1:])

    def recorded(self, at: ControlState, closed: Closed) -> dict[str, Scalar]:
        return {"control_moment": jnp.sqrt(squared(self.moment(at, closed)) + 1e-30)}

    @property
    def report(self) -> "ControlReport":
        return ControlReport(self)


class ControlReport(Report[AttitudeControl]):
    """What is said of attitude control."""

    def summary(self, run: Any) -> list[tuple[str, str]]:
        work = -float(run.energy.stored[self.element.name])  # what was put in is counted negative
        return [(self.words, f"put in {work:.6g} J")]
