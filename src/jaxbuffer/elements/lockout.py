"""A lockout that holds an axial element's stroke where it is when a point crosses a plane (M184)."""

import math
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp

from .._types import Scalar
from ..multibody import AxialSpringDamper, Kinematics, Load, MaterialPoint, Point, SpringDirection, load_at
from ..plane import Vector
from .element import ROUNDED_LENGTH, Closed, Element, Magnitudes, Own, Switch
from .picture import Level, Panel, PanelCurve
from .report import EnergyShare, Report
from .telling import SummaryRow, closed_at, largest

LENGTH = 1e-3  # m, with which errors of the stroke that is held are compared


class LockoutState(NamedTuple):
    """A lockout at one instant.

    - ``before``: how far the point is before the plane [m]; ``receding``: how fast that grows [m/s].
    - ``stroke``: s [m]; ``rate``: ṡ [m/s].
    - ``held``: s_h, the stroke that is held [m]; ``engaged``: 1 from the crossing on, 0 before it.
    - ``along``: unit vector from the first end of the axial element to the second [-]; ``first``, ``second``: the ends.
    """

    before: Scalar
    receding: Scalar
    stroke: Scalar
    rate: Scalar
    held: Scalar
    engaged: Scalar
    along: Vector
    first: MaterialPoint
    second: MaterialPoint


class Lockout(Element):
    """A spring and damper that from an event on hold the stroke s = l_0 - L of an axial element, whichever way it goes.

    It engages where a point of one body crosses a plane of another, for good, and without a force of its spring: it
    holds the stroke of that instant.

    - ``guide``: the axial element.
    - ``first``, ``point``: the body whose point crosses, and the point; ``second``: that with the plane, or ``GROUND``.
    - ``plane``: where it is along the x axis of the second body's frame [m].
    - ``stiffness`` [N/m], ``damping`` [N s/m]: of what holds.
    - ``name``: of its energy and its switch and, with ``_force``, ``_stroke``, ``_extension`` and ``_damper`` added, of
      its force, of the stroke or extension that it holds and of its loss.
    """

    guide: AxialSpringDamper
    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    point: Point
    plane: Scalar
    stiffness: Scalar
    damping: Scalar = 0.0
    name: str = eqx.field(static=True, default="lockout")

    @property
    def variables(self) -> tuple[str, ...]:
        return ("held", "engaged")

    def scales(self, size: Magnitudes) -> list[Scalar]:
        return [LENGTH, 1.0]

    @property
    def switches(self) -> tuple[Switch, ...]:
        return (Switch(self.name, one_way=True),)

    def evaluate(self, kin: Kinematics, own: Own) -> LockoutState:
        axial, other, point = self.guide.state(kin), kin.frame(self.second), kin.point(self.first, self.point)
        local, moves = other.unturn(point.place - other.origin), other.unturn(point.velocity - other.velocity)
        return LockoutState(
            before=self.plane - local.x,
            # The plane turns with its body: to the relative velocity comes that of the turning axes.
            receding=-jnp.asarray(moves.x + other.spin * local.y),
            stroke=self.guide.free_length - axial.length,
            rate=-axial.rate,
            held=own[0],
            engaged=own[1],
            along=axial.along,
            first=axial.first,
            second=axial.second,
        )

    def gaps(self, at: LockoutState) -> list[tuple[Scalar, Scalar]]:
        return [(at.before, -at.receding)]

    def after_start(self, at: LockoutState, own: Own, closed: Closed) -> tuple[LockoutState, Own]:
        own = closed[0] * jnp.stack([jnp.asarray(at.stroke, float), jnp.ones(())])
        return at._replace(held=own[0], engaged=own[1]), own

    def after_closing(self, at: LockoutState, own: Own, closing: Closed, speed: Scalar) -> Own:
        # At the crossing itself, a first-order step away from the located state: with it moves the stroke that is held.
        stroke = at.stroke - at.rate * at.before / at.receding
        return jnp.where(closing[0] > 0.5, jnp.stack([jnp.asarray(stroke, float), jnp.ones(())]), own)

    def rates(self, at: LockoutState, closed: Closed) -> list[Scalar]:
        return [0.0, 0.0]  # they change where it engages alone

    def closed_by_state(self, at: LockoutState) -> list[Scalar]:
        return [at.engaged]  # the point may have come back out of the plane

    def settled(self, at: LockoutState) -> Scalar:
        return jnp.asarray(at.engaged) > 0.5

    # --- force and energies -------------------------------------------------------------------------------------------

    def force(self, at: LockoutState, closed: Closed) -> Scalar:
        """Return the force against a larger stroke [N], below zero against a smaller one (M184)."""
        return closed[0] * (self.stiffness * (at.stroke - at.held) + self.damping * at.rate)

    def loads(self, at: LockoutState, closed: Closed) -> tuple[Load, ...]:
        push = at.along * self.force(at, closed)
        return load_at(at.first, -push), load_at(at.second, push)

    def stored(self, at: LockoutState, closed: Closed) -> dict[str, Scalar]:
        return {self.name: closed[0] * 0.5 * self.stiffness * (at.stroke - at.held) ** 2}

    @property
    def loss_names(self) -> tuple[str, ...]:
        return (f"{self.name}_damper",)

    def losses(self, at: LockoutState, closed: Closed) -> dict[str, Scalar]:
        return {f"{self.name}_damper": closed[0] * self.damping * at.rate**2}

    # --- what is watched, and time stepping ---------------------------------------------------------------------------

    @property
    def observed(self) -> tuple[str, ...]:
        # What is held may be a stroke or an extension: each is observed for its largest value, and one of them is zero.
        return (f"{self.name}_force", f"{self.name}_stroke", f"{self.name}_extension")

    def observables(self, at: LockoutState, closed: Closed) -> dict[str, Scalar]:
        held = closed[0] * at.held
        force = jnp.abs(self.force(at, closed))
        return {f"{self.name}_force": force, f"{self.name}_stroke": held, f"{self.name}_extension": -held}

    @property
    def lower_bounds(self) -> dict[str, float]:
        return {f"{self.name}_stroke": 0.0, f"{self.name}_extension": 0.0}

    def roundoff(self) -> dict[str, Scalar]:
        lengths = dict.fromkeys((f"{self.name}_stroke", f"{self.name}_extension"), ROUNDED_LENGTH)
        return {f"{self.name}_force": ROUNDED_LENGTH * self.stiffness, **lengths}

    def recorded(self, at: LockoutState, closed: Closed) -> dict[str, Scalar]:
        return {f"{self.name}_force": self.force(at, closed)}  # with its sign: below zero where it pulls

    def springs(self, at: LockoutState, closed: Closed) -> tuple[SpringDirection, ...]:
        blocks = {at.first.body: at.first.along(-at.along), at.second.body: at.second.along(at.along)}
        return (SpringDirection(blocks, closed[0] * self.stiffness, closed[0] * self.damping),)

    def stiff_force(self, at: LockoutState, closed: Closed) -> Scalar:
        return jnp.abs(self.force(at, closed))

    @property
    def report(self) -> "LockoutReport":
        return LockoutReport(self)


class LockoutReport(Report[Lockout]):
    """What is said and drawn of a lockout."""

    @property
    def _force(self) -> str:
        return f"{self.element.name}_force"

    def summary(self, run: Any) -> list[tuple[str, str]]:
        engaged = closed_at(run, self.element.name)
        if not math.isfinite(engaged):
            return []
        most = SummaryRow.largest(run, self._force, "N").text
        stroke = 1e3 * float(held_stroke(run, self.element.name))
        return [(self.words, f"holds a stroke of {stroke:.4g} mm from {engaged:.6g} s on; force at most {most}")]

    def moments(self, run: Any) -> dict[str, float]:
        return {f"{self.words} engaged": closed_at(run, self.element.name)}

    def panels(self, run: Any) -> list[Panel]:
        most = largest(run, self._force)
        curve, levels = PanelCurve("", run.history.others[self._force]), (Level(f"largest, {most:.4g} N", most),)
        title = f"{self.words} force"
        shown = Panel(title.capitalize(), f"{title} [N]", (curve,), (*levels, Level("", 0.0)))
        return [shown._replace(whole=True, to_end=True)]

    @property
    def shares(self) -> tuple[EnergyShare, ...]:
        name = self.element.name
        return (EnergyShare(self.words, f"in the {self.words}", (name, f"{name}_damper")),)


def held_stroke(run: Any, name: str) -> Any:
    """Return the stroke that a lockout holds in a run [m], below zero of an extension, 0 where it has not engaged."""
    return run.maxima[f"{name}_stroke"] - run.maxima[f"{name}_extension"]
