"""A stop at either end of an axial element's way (M28, M174)."""

from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp

from .._types import Scalar
from ..contact import KelvinVoigt
from ..multibody import AxialSpringDamper, Kinematics, Load, MaterialPoint, SpringDirection, load_at
from ..plane import Vector
from .element import Closed, Element, EnergyShare, Own, Switch
from .telling import largest, reached

USUAL = {"stop": "end stop", "rebound": "rebound stop"}  # what stops of these names are called


class StopState(NamedTuple):
    """A stop at one instant.

    - ``depth``: by how much the stroke is beyond the place where the stop begins [m], negative before it.
    - ``rate``: its rate [m/s].
    - ``along``: unit vector from the first end of the axial element to the second [-].
    - ``first``, ``second``: these ends.
    """

    depth: Scalar
    rate: Scalar
    along: Vector
    first: MaterialPoint
    second: MaterialPoint


class EndStop(Element):
    """A spring and damper that act while the stroke s = l_0 - L of an axial element is beyond a place, and never pull.

    - ``guide``: the axial element, whose ends the stop pushes apart where it is run in, and together where it is run
      out.
    - ``law``: stiffness [N/m] and damping [N s/m].
    - ``place``: s_m, the stroke at which it begins [m] (M28); of a rebound stop how far beyond the free length the
      element is then [m] (M174).
    - ``rebound``: whether it stops the way out.
    - ``watched``: whether its largest force is wanted.
    - ``name``: of its energy, its switch and, with ``_force`` and ``_damper`` added, of its force and its loss.
    """

    guide: AxialSpringDamper
    law: KelvinVoigt
    place: Scalar
    rebound: bool = eqx.field(static=True, default=False)
    watched: bool = eqx.field(static=True, default=True)
    name: str = eqx.field(static=True, default="stop")

    @property
    def switches(self) -> tuple[Switch, ...]:
        return (Switch(self.name, force=f"{self.name}_force" if self.watched else None),)

    def evaluate(self, kin: Kinematics, own: Own) -> StopState:
        axial = self.guide.state(kin)
        inwards = -1.0 if self.rebound else 1.0
        stroke, rate = self.guide.free_length - axial.length, -axial.rate
        return StopState(inwards * stroke - self.place, inwards * rate, axial.along, axial.first, axial.second)

    def gaps(self, at: StopState) -> list[tuple[Scalar, Scalar]]:
        return [(-at.depth, at.rate)]

    def force(self, at: StopState, closed: Closed) -> Scalar:
        """Return the force against the motion beyond its place [N], 0 while it is open."""
        return closed[0] * self.law.force(jnp.asarray(at.depth), jnp.asarray(at.rate), jnp.ones(()))

    def loads(self, at: StopState, closed: Closed) -> tuple[Load, ...]:
        force = self.force(at, closed)
        # The end stop pushes the ends apart (M28), the rebound stop pulls them together (M174).
        push = at.along * (-force if self.rebound else force)
        return load_at(at.first, -push), load_at(at.second, push)

    def stored(self, at: StopState, closed: Closed) -> dict[str, Scalar]:
        return {self.name: closed[0] * self.law.energy(jnp.asarray(at.depth))}

    @property
    def loss_names(self) -> tuple[str, ...]:
        return (f"{self.name}_damper",)

    def losses(self, at: StopState, closed: Closed) -> dict[str, Scalar]:
        # What the stop takes less what the spring in it takes: the force is cut off at zero, where it would pull.
        elastic = closed[0] * self.law.elastic(jnp.asarray(at.depth))
        return {f"{self.name}_damper": (self.force(at, closed) - elastic) * at.rate}

    @property
    def observed(self) -> tuple[str, ...]:
        return (f"{self.name}_force",) if self.watched else ()

    def observables(self, at: StopState, closed: Closed) -> dict[str, Scalar]:
        return {name: self.force(at, closed) for name in self.observed}

    @property
    def words(self) -> str:
        return USUAL.get(self.name, super().words)

    def summary(self, run: Any) -> list[tuple[str, str]]:
        force = f"{self.name}_force"
        most = f", at most {largest(run, force):.6g} N{reached(run, force)}" if self.watched else ""
        return [(self.words, f"from {1e3 * float(self.place):.6g} mm on{most}")]

    @property
    def shares(self) -> tuple[EnergyShare, ...]:
        return (EnergyShare(self.words, f"in the {self.words}", (self.name, f"{self.name}_damper")),)

    def springs(self, at: StopState, closed: Closed) -> tuple[SpringDirection, ...]:
        # Where the damper would pull, the force is cut off at zero and answers to nothing.
        pushing = closed[0] * (self.force(at, closed) > 0.0)
        blocks = {at.first.body: at.first.along(-at.along), at.second.body: at.second.along(at.along)}
        return (SpringDirection(blocks, pushing * self.law.linear_stiffness, pushing * self.law.damping),)

    def stiff_force(self, at: StopState, closed: Closed) -> Scalar:
        return self.force(at, closed)
