"""A thrust that pushes a body along an axis of its own for a while (M178)."""

import dataclasses
from typing import Any, NamedTuple

import equinox as eqx

from .._types import Scalar
from ..basis import AnyBasis, components
from ..multibody import Kinematics, Load
from ..plane import PLANE
from ..plane.unit_vector import check_unit
from ..space.either import Frame, Turn, Vector
from .element import Closed, Element, Magnitudes, Own, Switch
from .report import Report


class ThrustState(NamedTuple):
    """A thrust at one instant: the ``frame`` of the body that it pushes, and the ``time`` since the start [s]."""

    frame: Frame
    time: Scalar


class Thrust(Element):
    """A force through the centre of mass of a body, along an axis of its frame, from the start for some time.

    - ``body``: its index.
    - ``size``: F [N].
    - ``time``: how long it pushes [s].
    - ``axis``: unit vector in the axes of the body [-].
    - ``basis``: of the mechanism, which says it.
    - ``name``: of the energy that it puts in; its switch, which closes where it ends, is the name with " over".
    """

    body: int = eqx.field(static=True)
    size: Scalar
    time: Scalar
    axis: tuple[float, ...] = eqx.field(static=True, default=(1.0, 0.0))
    basis: AnyBasis = PLANE
    name: str = eqx.field(static=True, default="thrust")

    def __check_init__(self) -> None:
        """Raise `InputError` for an axis that is no unit vector: the force would be another than ``size``."""
        check_unit(f"{self.name}: axis", *self.axis)

    @property
    def variables(self) -> tuple[str, ...]:
        return ("time", "work", *impulse_names(self.basis))

    def in_mechanism(self, speed: Scalar, basis: AnyBasis) -> "Thrust":
        return dataclasses.replace(self, basis=basis)

    def scales(self, size: Magnitudes) -> list[Scalar]:
        return [1.0, size.energy, *[size.momentum] * len(impulse_names(self.basis))]

    @property
    def switches(self) -> tuple[Switch, ...]:
        # The end of the thrust is an event, since the force jumps there.
        return (Switch(f"{self.name} over", one_way=True),)

    def evaluate(self, kin: Kinematics, own: Own) -> ThrustState:
        return ThrustState(kin.frame(self.body), own[0])

    def gaps(self, at: ThrustState) -> list[tuple[Scalar, Scalar]]:
        return [(self.time - at.time, 1.0)]

    def force(self, at: ThrustState, closed: Closed) -> Vector:
        """Return the force [N]."""
        ahead = self.axis[0] == 1.0
        along = at.frame.x_axis if ahead else at.frame.turn(self.basis.vector(*self.axis))
        return along * (self.size * (1.0 - closed[0]))

    def loads(self, at: ThrustState, closed: Closed) -> tuple[Load, ...]:
        return (Load(self.body, self.force(at, closed), self.basis.turn(*[0.0] * len(self.basis.unit_turns))),)

    def rates(self, at: ThrustState, closed: Closed) -> list[Scalar]:
        # Work and impulses are states, so that energy and momentum can be checked though they come from outside (M178).
        force = self.force(at, closed)
        return [1.0, force.dot(at.frame.velocity), *force, *components(at.frame.origin.cross(force))]

    def supplied(self, own: Own) -> dict[str, Scalar]:
        return {self.name: own[1]}

    def impulse(self, own: Own) -> tuple[Vector, Turn]:
        return impulses(self.basis, own[2:])

    def settled(self, at: ThrustState) -> Scalar:
        return at.time >= self.time

    @property
    def report(self) -> "ThrustReport":
        return ThrustReport(self)


def impulse_names(basis: AnyBasis) -> tuple[str, ...]:
    """Return the names of the components of an impulse and an angular impulse, as `variables` of an element."""
    axes = "xyz"[: basis.dimensions]
    turns = ("turn",) if len(basis.unit_turns) == 1 else tuple(f"turn_{axis}" for axis in axes)
    return tuple(f"impulse_{name}" for name in (*axes, *turns))


def impulses(basis: AnyBasis, own: Own) -> tuple[Vector, Turn]:
    """Return impulse and angular impulse from their components."""
    entries = [own[k] for k in range(len(impulse_names(basis)))]
    return basis.vector(*entries[: basis.dimensions]), basis.turn(*entries[basis.dimensions :])


class ThrustReport(Report[Thrust]):
    """What is said and drawn of a thrust."""

    def summary(self, run: Any) -> list[tuple[str, str]]:
        thrust = self.element
        work = -float(run.energy.stored[thrust.name])  # what was put in is counted negative
        return [(self.words, f"{float(thrust.size):.6g} N for {float(thrust.time):.6g} s, which put in {work:.6g} J")]
