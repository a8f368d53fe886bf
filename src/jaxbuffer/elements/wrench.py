"""A force and a moment from outside that a body is given, constant until they are set anew (M223)."""

import dataclasses
from typing import NamedTuple

import equinox as eqx

from .._types import Scalar
from ..basis import AnyBasis, components
from ..multibody import Kinematics, Load
from ..plane import PLANE
from ..space.either import Frame, Turn, Vector
from .element import Closed, Element, Magnitudes, Own
from .thrust import impulse_names, impulses


class WrenchState(NamedTuple):
    """A wrench at one instant: the ``frame`` of the body, and ``force`` [N] and ``moment`` [N m] in inertial axes."""

    frame: Frame
    force: Vector
    moment: Turn


class Wrench(Element):
    """A force through the centre of mass of a body, and a moment on it.

    Neither belongs to a pair of bodies: their work, impulse and angular impulse are counted as put in from outside.

    - ``body``: its index.
    - ``force``: its components, two in the plane and three in space [N].
    - ``moment``: its components, one in the plane and three in space [N m].
    - ``turning``: whether the components are along the axes of the body, which turn with it, rather than inertial.
    - ``basis``: of the mechanism, which says it.
    - ``name``: of the energy that it puts in.
    """

    body: int = eqx.field(static=True)
    force: tuple[Scalar, ...]
    moment: tuple[Scalar, ...]
    turning: bool = eqx.field(static=True, default=False)
    basis: AnyBasis = PLANE
    name: str = eqx.field(static=True, default="wrench")

    @property
    def variables(self) -> tuple[str, ...]:
        return ("work", *impulse_names(self.basis))

    def in_mechanism(self, speed: Scalar, basis: AnyBasis) -> "Wrench":
        return dataclasses.replace(self, basis=basis)

    def scales(self, size: Magnitudes) -> list[Scalar]:
        return [size.energy, *[size.momentum] * len(impulse_names(self.basis))]

    def evaluate(self, kin: Kinematics, own: Own) -> WrenchState:
        frame = kin.frame(self.body)
        force, moment = self.basis.vector(*self.force), self.basis.turn(*self.moment)
        if self.turning:
            return WrenchState(frame, frame.turn(force), frame.from_axes(moment))
        return WrenchState(frame, force, moment)

    def loads(self, at: WrenchState, closed: Closed) -> tuple[Load, ...]:
        return (Load(self.body, at.force, at.moment),)

    def rates(self, at: WrenchState, closed: Closed) -> list[Scalar]:
        # Work and impulses are states, so that energy and momentum can be checked though they come from outside (M178).
        moments, spins = components(at.moment), components(at.frame.spin)
        power = at.force.dot(at.frame.velocity)
        for moment, spin in zip(moments, spins, strict=True):
            power = power + moment * spin
        about = components(at.frame.origin.cross(at.force))
        return [power, *at.force, *(arm + moment for arm, moment in zip(about, moments, strict=True))]

    def supplied(self, own: Own) -> dict[str, Scalar]:
        return {self.name: own[0]}

    def impulse(self, own: Own) -> tuple[Vector, Turn]:
        return impulses(self.basis, own[1:])
