"""A stop at either end of an axial element's way (M28, M174), also of rubber (M183)."""

import math
from typing import Any, ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp

from .._types import Scalar
from ..contact import ContactLaw, KelvinVoigt
from ..multibody import AxialSpringDamper, Kinematics, Load, MaterialPoint, SpringDirection, load_at
from ..space.either import Vector
from .element import Closed, Element, Own, Switch
from .report import EnergyShare, Report
from .telling import SummaryRow, largest

USUAL = {"stop": "end stop", "rebound": "rebound stop"}  # what stops of these names are called
SOLID = 0.05  # of its thickness: where a rubber block is as good as solid, and its force goes on straight


class RubberBlock(KelvinVoigt):
    """A block of rubber between plates, which stiffens as it is pressed together, with a damper beside it (M183).

    - ``linear_stiffness``: k of small compressions [N/m]; ``damping``: c [N s/m].
    - ``thickness``: h of the unloaded block [m].
    """

    source: ClassVar[str] = "Treloar 1975; bonded blocks, by their stiffness, Gent & Lindley 1959"
    validity: ClassVar[str] = "compact rubber, pressed together by up to half of its thickness; no foams"
    thickness: Scalar
    # The closed forms of the linear spring do not hold here.
    depth = ContactLaw.depth
    max_penetration = ContactLaw.max_penetration
    delivered_restitution = ContactLaw.delivered_restitution  # type: ignore[assignment]

    @property
    def force_at_half(self) -> Scalar:
        """Return the elastic force at half of the thickness [N], up to which the law is valid: k h (2² - 1/2)/3."""
        return self.linear_stiffness * self.thickness * 3.5 / 3.0

    def _stretch(self, penetration: Any) -> tuple[Any, Any]:
        """Return λ, and the compression beyond where the block counts as solid [m]."""
        stretch = 1.0 - jnp.maximum(penetration, 0.0) / self.thickness
        # An attempted step may go through the block, where λ would be negative: there the force goes on straight.
        return jnp.maximum(stretch, SOLID), jnp.maximum(SOLID - stretch, 0.0) * self.thickness

    def elastic(self, penetration: Any) -> Any:
        (stretch, beyond), third = self._stretch(penetration), self.linear_stiffness / 3.0
        return third * (self.thickness * (stretch**-2 - stretch) + (2.0 / SOLID**3 + 1.0) * beyond)

    def energy(self, penetration: Any) -> Any:
        (stretch, beyond), h = self._stretch(penetration), self.thickness
        straight = h * (SOLID**-2 - SOLID) * beyond + (1.0 / SOLID**3 + 0.5) * beyond**2
        return self.linear_stiffness / 3.0 * (h**2 * (1.0 / stretch + 0.5 * stretch**2 - 1.5) + straight)

    def force(self, penetration: Any, approach_speed: Any, touchdown_speed: Any) -> Any:
        return jnp.maximum(0.0, self.elastic(penetration) + self.damping * approach_speed)


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
    - ``law``: stiffness [N/m] and damping [N s/m], or a `RubberBlock`.
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

    def springs(self, at: StopState, closed: Closed) -> tuple[SpringDirection, ...]:
        # Where the damper would pull, the force is cut off at zero and answers to nothing.
        pushing = closed[0] * (self.force(at, closed) > 0.0)
        blocks = {at.first.body: at.first.along(-at.along), at.second.body: at.second.along(at.along)}
        stiffness = self.law.linear_stiffness
        if isinstance(self.law, RubberBlock):
            stiffness = jax.jvp(self.law.elastic, (jnp.asarray(at.depth),), (jnp.ones(()),))[1]
        return (SpringDirection(blocks, pushing * stiffness, pushing * self.law.damping),)

    def stiff_force(self, at: StopState, closed: Closed) -> Scalar:
        return self.force(at, closed)

    @property
    def report(self) -> "EndStopReport":
        return EndStopReport(self)


class EndStopReport(Report[EndStop]):
    """What is said and drawn of a stop."""

    @property
    def words(self) -> str:
        return USUAL.get(self.element.name, super().words)

    def summary(self, run: Any) -> list[tuple[str, str]]:
        stop = self.element
        most = f", at most {SummaryRow.largest(run, f'{stop.name}_force', 'N').text}" if stop.watched else ""
        return [(self.words, f"from {1e3 * float(stop.place):.6g} mm on{most}")]

    @property
    def summary_observables(self) -> tuple[str, ...]:
        return self.element.observed

    def moments(self, run: Any) -> dict[str, float]:
        name = f"{self.element.name}_force"
        if not self.element.watched:
            return {}
        return {f"{self.words} pressed most": run.maximum_times.get(name, math.nan)}

    def warnings(self, run: Any) -> list[str]:
        stop = self.element
        if not (stop.watched and isinstance(stop.law, RubberBlock)):
            return []
        most, valid = largest(run, f"{stop.name}_force"), float(stop.law.force_at_half)
        if not most > valid:
            return []
        beyond = f"more than the {valid:.4g} N at half of its thickness, up to which its law is valid"
        return [f"the rubber of the {self.words} takes {most:.4g} N, {beyond}"]

    @property
    def shares(self) -> tuple[EnergyShare, ...]:
        stop = self.element
        return (EnergyShare(self.words, f"in the {self.words}", (stop.name, f"{stop.name}_damper")),)
