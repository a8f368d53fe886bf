"""The control of a body's attitude: a moment from outside that turns it back to the inertial axes (M221)."""

import dataclasses
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from ..basis import AnyBasis, components, squared
from ..multibody import GROUND, Kinematics, Load, SpringDirection
from ..plane import PLANE
from ..space.either import Frame, Turn, Vector
from .element import ROUNDED_LENGTH, Closed, Element, Magnitudes, Own, Switch
from .report import Report
from .telling import SummaryRow


class ControlState(NamedTuple):
    """A control at one instant.

    - ``frame``: of the body.
    - ``angles``, ``spins``: the body's rotation vector from the inertial axes and its spin, in its own axes, about each
      axis there is [rad, rad/s].
    - ``gap``, ``closing``: of what the control acts until [m, m/s]; 1 and 0 where it acts to the end.
    - ``basis``: plane or space.
    """

    frame: Frame
    angles: tuple[Scalar, ...]
    spins: tuple[Scalar, ...]
    gap: Scalar
    closing: Scalar
    basis: AnyBasis


class AttitudeControl(Element):
    """A moment -M_max tanh((k_p φ + c_p ω)/M_max) on a body about each of its own axes, in the plane about one (M221).

    φ is the angle of the body, in space its rotation vector from the inertial axes, which jumps at half a turn. The
    moment belongs to no pair of bodies: its work and its angular impulse are counted as put in from outside.

    - ``body``: its index.
    - ``stiffness``: k_p [N m/rad]; ``damping``: c_p [N m s/rad].
    - ``limit``: M_max of each axis [N m].
    - ``until``: the element, a `BallContact` or a `Latch` say, at whose first closing the control ends; None: it acts
      to the end.
    - ``name``: of the energy that it puts in and, with ``_moment`` added, of its moment; its switch, which closes where
      it ends, is the name with " over".
    - ``basis``: of the mechanism, which says it.
    """

    body: int = eqx.field(static=True)
    stiffness: Scalar
    damping: Scalar
    limit: Scalar
    until: Element | None = None
    basis: AnyBasis = PLANE
    name: str = eqx.field(static=True, default="control")

    def in_mechanism(self, speed: Scalar, basis: AnyBasis) -> "AttitudeControl":
        until = None if self.until is None else self.until.in_mechanism(speed, basis)
        return dataclasses.replace(self, until=until, basis=basis)

    @property
    def variables(self) -> tuple[str, ...]:
        return ("work", *(f"angular_impulse_{k}" for k in range(len(self.basis.unit_turns))))

    def scales(self, size: Magnitudes) -> list[Scalar]:
        return [size.energy, *[size.momentum] * len(self.basis.unit_turns)]

    @property
    def switches(self) -> tuple[Switch, ...]:
        return () if self.until is None else (Switch(f"{self.name} over", one_way=True),)

    def evaluate(self, kin: Kinematics, own: Own) -> ControlState:
        frame = kin.frame(self.body)
        # A rotation vector is the same in the inertial axes and in the body's.
        angles = components(kin.basis.relative_rotation(kin.frame(GROUND), frame))
        gap, closing = self._until(kin)
        return ControlState(frame, angles, components(frame.in_axes(frame.spin)), gap, closing, kin.basis)

    def _until(self, kin: Kinematics) -> tuple[Scalar, Scalar]:
        """Return how far what ends the control is from closing [m], and how fast that passes [m/s]."""
        if self.until is None:
            return 1.0, 0.0
        # Its gaps are those of positions and velocities, whatever numbers of its own it has.
        at = self.until.evaluate(kin, jnp.zeros(len(self.until.variables)))
        gaps, speeds = (jnp.atleast_1d(jnp.asarray(it)) for it in self.until.gaps(at)[0])
        least = jnp.min(gaps)
        return least, jnp.max(jnp.where(gaps <= least, speeds, -jnp.inf))

    def gaps(self, at: ControlState) -> list[tuple[Scalar, Scalar]]:
        return [] if self.until is None else [(at.gap, at.closing)]

    def closed_at_start(self, at: ControlState) -> list[Scalar]:
        # Where the bodies touch at the start no event would end the control, which then never acts.
        return [jnp.where(gap <= ROUNDED_LENGTH, 1.0, 0.0) for gap, _ in self.gaps(at)]

    def moment(self, at: ControlState, closed: Closed) -> Turn:
        """Return the moment on the body, in inertial axes [N m]."""
        acting = self._acting(closed) * self.limit
        pairs = zip(at.angles, at.spins, strict=True)
        of_axes = (-acting * jnp.tanh(self._unlimited(angle, spin) / self.limit) for angle, spin in pairs)
        return at.frame.from_axes(at.basis.turn(*of_axes))

    def _unlimited(self, angle: Scalar, spin: Scalar) -> Scalar:
        """Return the moment about an axis that a control without a limit would exert against its angle and spin."""
        return self.stiffness * angle + self.damping * spin

    def _acting(self, closed: Closed) -> Scalar:
        return 1.0 if self.until is None else 1.0 - closed[0]

    def loads(self, at: ControlState, closed: Closed) -> tuple[Load, ...]:
        return (Load(self.body, at.basis.vector(0.0, 0.0), self.moment(at, closed)),)

    def rates(self, at: ControlState, closed: Closed) -> list[Scalar]:
        # Work and impulse are states, so that energy and momentum can be checked though they come from outside.
        moment = components(self.moment(at, closed))
        power = sum((m * spin for m, spin in zip(moment, components(at.frame.spin), strict=True)), start=0.0)
        return [power, *moment]

    def supplied(self, own: Own) -> dict[str, Scalar]:
        return {self.name: own[0]}

    def impulse(self, own: Own) -> tuple[Vector, Turn]:
        return self.basis.vector(0.0, 0.0), self.basis.turn(*(own[k] for k in range(1, len(self.variables))))

    @property
    def observed(self) -> tuple[str, ...]:
        return (f"{self.name}_moment",)

    def observables(self, at: ControlState, closed: Closed) -> dict[str, Scalar]:
        # The small number below the root keeps its slope finite where nothing turns.
        return {f"{self.name}_moment": jnp.sqrt(squared(self.moment(at, closed)) + 1e-24)}

    def roundoff(self) -> dict[str, Scalar]:
        return {f"{self.name}_moment": ROUNDED_LENGTH * self.stiffness}

    @property
    def reversing(self) -> int:
        return len(self.basis.unit_turns)

    def reversals(self, at: ControlState, closed: Closed) -> Float[Array, "reversing axes"]:
        pairs = zip(at.angles, at.spins, strict=True)
        of_axes = jnp.stack([jnp.asarray(self._unlimited(angle, spin) / self.limit) for angle, spin in pairs])
        # A moment about each axis: none of them turns about as a vector does.
        others = jnp.zeros((len(of_axes), at.basis.dimensions - 1))
        return self._acting(closed) * jnp.concatenate([of_axes[:, None], others], axis=1)

    def springs(self, at: ControlState, closed: Closed) -> tuple[SpringDirection, ...]:
        """Return a spring-damper against a turn about each of the body's axes, as stiff as the moment's slope is."""
        still = (0.0,) * at.basis.dimensions
        springs = []
        for unit, angle, spin in zip(at.basis.unit_turns, at.angles, at.spins, strict=True):
            slope = self._acting(closed) * (1.0 - jnp.tanh(self._unlimited(angle, spin) / self.limit) ** 2)
            about = {self.body: (*still, *components(at.frame.from_axes(unit)))}
            springs.append(SpringDirection(about, slope * self.stiffness, slope * self.damping))
        return tuple(springs)

    @property
    def report(self) -> "AttitudeControlReport":
        return AttitudeControlReport(self)


class AttitudeControlReport(Report[AttitudeControl]):
    """What is said of an attitude control."""

    def summary(self, run: Any) -> list[tuple[str, str]]:
        control = self.element
        most = SummaryRow.largest(run, f"{control.name}_moment", "N m").text
        work = -float(run.energy.stored[control.name])  # what was put in is counted negative
        return [(self.words, f"at most {most}, which put in {work:.6g} J")]
