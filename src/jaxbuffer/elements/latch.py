"""Latches that close for good where a point crosses a plane, and then hold it in its seat (M175 to M177).

Their forces grow with the share c of M175, from 0 where the point crosses to 1 when they are closed.
"""

import math
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar
from ..basis import AnyBasis, components, squared
from ..multibody import Block, Kinematics, Load, MaterialPoint, Point, SpringDirection, load_at
from ..space.either import Turn, Vector
from .element import ROUNDED_LENGTH, Closed, Element, Magnitudes, Own, Switch
from .picture import Level, Panel, PanelCurve
from .report import EnergyShare, Report
from .telling import SummaryRow, closed_at, largest


class LatchState(NamedTuple):
    """Latches at one instant.

    - ``since``: time since the point crossed the plane [s].
    - ``share``: c, how far they are closed [-].
    - ``share_rate``: ċ [1/s].
    - ``before``: how far the point is before the plane [m].
    - ``receding``: how fast that grows [m/s].
    - ``off_seat``: r, from the seat to the point [m].
    - ``velocity``: u of the point less that of the other body's material there [m/s].
    - ``angle``, ``spin``: of the first body against the second [rad, rad/s], in space vectors in inertial axes, the
      angle a rotation vector.
    - ``held``, ``opposite``: the point on the first body, and the second body's material point there.
    - ``basis``: plane or space.
    """

    since: Scalar
    share: Scalar
    share_rate: Scalar
    before: Scalar
    receding: Scalar
    off_seat: Vector
    velocity: Vector
    angle: Turn
    spin: Turn
    held: MaterialPoint
    opposite: MaterialPoint
    basis: AnyBasis


class Latch(Element):
    """Latches on one body that catch a point of another.

    - ``first``: index of the body that is held; ``point``: the point of it that is.
    - ``second``: index of the body that holds it, or ``GROUND``.
    - ``plane``: where along the x axis of the second body's frame the latches begin to close [m].
    - ``seat``: K, where they hold the point, in the axes of the second body [m] (M175).
    - ``stiffness`` [N/m], ``damping`` [N s/m]: of the seat, in any direction.
    - ``turn_stiffness`` [N m/rad], ``turn_damping`` [N m s/rad]: against a turn of the bodies (M176), in space of their
      rotation vector (M219).
    - ``preload`` [N], ``preload_length`` [m]: a pull to the seat, which is there as soon as the point is off it by more
      than the length.
    - ``closing_time``: from crossing the plane to closed [s].
    - ``strength``: the force at which they tear, "torn" [N]; None: they hold anything.
    - ``name``: of their energy, and part of the names of force and loss.
    """

    first: int = eqx.field(static=True)
    second: int = eqx.field(static=True)
    point: Point
    plane: Scalar
    seat: tuple[Scalar, ...]
    stiffness: Scalar
    damping: Scalar = 0.0
    turn_stiffness: Scalar = 0.0
    turn_damping: Scalar = 0.0
    preload: Scalar = 0.0
    preload_length: Scalar = 1e-4
    closing_time: Scalar = 0.0
    strength: Scalar | None = None
    name: str = eqx.field(static=True, default="latch")

    @property
    def variables(self) -> tuple[str, ...]:
        return ("since_crossing", "closing_work")

    def scales(self, size: Magnitudes) -> list[Scalar]:
        return [1.0, size.energy]

    @property
    def switches(self) -> tuple[Switch, ...]:
        # The second closes where the latches are closed: there the rate of their share jumps.
        return (Switch(self.name, one_way=True), Switch(f"{self.name} closed", one_way=True))

    def evaluate(self, kin: Kinematics, own: Own) -> LatchState:
        other, body, held = kin.frame(self.second), kin.frame(self.first), kin.point(self.first, self.point)
        off_origin = held.place - other.origin
        local = other.unturn(off_origin)
        moves = other.unturn(held.velocity - other.velocity)
        opposite = kin.point(self.second, tuple(local))
        # The plane turns with the second body: to the relative velocity comes that of the turning axes.
        turning = other._replace(spin=other.in_axes(other.spin)).rate_of(local)
        share, rate = self._share(jnp.asarray(own[0], float))
        return LatchState(
            since=own[0],
            share=share,
            share_rate=rate,
            before=self.plane - local.x,
            receding=-jnp.asarray(moves.x - turning.x),
            off_seat=off_origin - other.turn(kin.basis.vector(*self.seat)),
            velocity=held.velocity - opposite.velocity,
            angle=kin.basis.relative_rotation(other, body),
            spin=body.spin - other.spin,
            held=held,
            opposite=opposite,
            basis=kin.basis,
        )

    def _share(self, since: Float[Array, ""]) -> tuple[Scalar, Scalar]:
        """Return c and ċ [1/s]: with a closing time of zero the latches are closed at once."""
        time = jnp.asarray(self.closing_time, float)
        at_once = time == 0.0
        rate = 1.0 / jnp.where(at_once, 1.0, time)  # a division by zero that is not taken would still give NaN slopes
        x = jnp.clip(since * rate, 0.0, 1.0)
        share = jnp.where(at_once, 1.0, x * x * (3.0 - 2.0 * x))
        return share, jnp.where(at_once, 0.0, 6.0 * x * (1.0 - x) * rate)

    def gaps(self, at: LatchState) -> list[tuple[Scalar, Scalar]]:
        # The second gap is a time, that until the latches are closed; it passes only once the point has crossed the
        # plane.
        return [(at.before, -at.receding), (self.closing_time - at.since, jnp.where(at.since > 0.0, 1.0, 0.0))]

    def rates(self, at: LatchState, closed: Closed) -> list[Scalar]:
        # While the share grows it lets in springs that are already stretched: that work comes from outside (M176).
        return [closed[0], closed[0] * at.share_rate * self._closed_energy(at)]

    def after_closing(self, at: LatchState, own: Own, closing: Closed, speed: Scalar) -> Own:
        # Latches that close in no time store their energy at once, and nothing but the closing has put it in.
        at_once = (closing[0] > 0.5) & (jnp.asarray(self.closing_time) == 0.0)
        return own.at[1].add(jnp.where(at_once, at.share * self._closed_energy(at), 0.0))

    # --- forces and energies ------------------------------------------------------------------------------------------

    def force(self, at: LatchState, closed: Closed) -> Vector:
        """Return the force on the point that is held [N] (M175)."""
        return self._closed_force(at) * -(closed[0] * at.share)

    def _closed_force(self, at: LatchState) -> Vector:
        """Return what closed latches would exert, away from the seat [N]."""
        length = self.preload_length
        # At the seat itself a pull towards it has no direction: within the preload length it falls to zero there.
        pull = self.preload / jnp.sqrt(at.off_seat.dot(at.off_seat) + length * length)
        return at.off_seat * (self.stiffness + pull) + at.velocity * self.damping

    def _closed_energy(self, at: LatchState) -> Scalar:
        """Return what closed latches would store [J]."""
        square, length = at.off_seat.dot(at.off_seat), self.preload_length
        spring = 0.5 * self.stiffness * square + 0.5 * self.turn_stiffness * squared(at.angle)
        return spring + self.preload * (jnp.sqrt(square + length * length) - length)

    def loads(self, at: LatchState, closed: Closed) -> tuple[Load, ...]:
        force = self.force(at, closed)
        moment = (at.angle * self.turn_stiffness + at.spin * self.turn_damping) * (-closed[0] * at.share)
        none = at.basis.vector(0.0, 0.0)
        turning = Load(self.first, none, moment), Load(self.second, none, -moment)
        # Both forces act at one point, on each body's material there, so that they conserve angular momentum (M175).
        return load_at(at.held, force), load_at(at.opposite, -force), *turning

    def stored(self, at: LatchState, closed: Closed) -> dict[str, Scalar]:
        return {self.name: closed[0] * at.share * self._closed_energy(at)}

    @property
    def loss_names(self) -> tuple[str, ...]:
        return (f"{self.name}_damper",)

    def losses(self, at: LatchState, closed: Closed) -> dict[str, Scalar]:
        power = self.damping * at.velocity.dot(at.velocity) + self.turn_damping * squared(at.spin)
        return {f"{self.name}_damper": closed[0] * at.share * power}

    def supplied(self, own: Own) -> dict[str, Scalar]:
        return {f"{self.name}_closing": own[1]}

    # --- ends, and what is watched ------------------------------------------------------------------------------------

    @property
    def outcomes(self) -> tuple[str, ...]:
        return () if self.strength is None else ("torn",)

    def guards(self, at: LatchState) -> list[Scalar]:
        if self.strength is None:
            return []
        # Before they close, their share is zero but where they close at once, and then they act from the crossing on.
        return [_size(self._closed_force(at) * at.share) - self.strength]

    def settled(self, at: LatchState) -> Scalar:
        return (at.since > 0.0) & (at.since >= self.closing_time)

    def closed_by_state(self, at: LatchState) -> list[Scalar]:
        # The point may come back out of the plane a little: whether the latches close is seen in the time since then.
        return [jnp.where(at.since > 0.0, 1.0, 0.0), super().closed_by_state(at)[1]]

    @property
    def observed(self) -> tuple[str, ...]:
        return (f"{self.name}_force",)

    def observables(self, at: LatchState, closed: Closed) -> dict[str, Scalar]:
        return {f"{self.name}_force": _size(self.force(at, closed))}

    def roundoff(self) -> dict[str, Scalar]:
        return {f"{self.name}_force": ROUNDED_LENGTH * self.stiffness}

    def recorded(self, at: LatchState, closed: Closed) -> dict[str, Scalar]:
        return {f"{self.name}_closed": closed[0] * at.share}

    # --- time stepping ------------------------------------------------------------------------------------------------

    def springs(self, at: LatchState, closed: Closed) -> tuple[SpringDirection, ...]:
        """Return a spring along each axis, and one against a turn about each there is."""
        length, share = self.preload_length, closed[0] * at.share
        pull = self.preload / jnp.sqrt(at.off_seat.dot(at.off_seat) + length * length)
        # For implicit steps the pull is a spring that is as stiff along all axes as it is towards the seat.
        stiffness, damping = share * (self.stiffness + pull), share * self.damping
        straight = [
            SpringDirection({self.first: at.held.along(x), self.second: at.opposite.along(-x)}, stiffness, damping)
            for x in at.basis.unit_vectors
        ]
        still = (0.0,) * at.basis.dimensions
        turning = [
            SpringDirection(
                {self.first: (*still, *components(turn)), self.second: (*still, *components(-turn))},
                share * self.turn_stiffness,
                share * self.turn_damping,
            )
            for turn in at.basis.unit_turns
        ]
        return *straight, *turning

    def stiff_force(self, at: LatchState, closed: Closed) -> Scalar:
        return _size(self.force(at, closed))

    # --- what pulls at it ---------------------------------------------------------------------------------------------

    def _pull(self, at: LatchState) -> tuple[Vector, Scalar]:
        """Return the direction of what pulls at closed latches, and the size of their force [N]."""
        force = self.force(at, jnp.ones(2))
        size = _size(force)
        return force * (-1.0 / size), size

    def pulled(self, at: LatchState) -> dict[int, Block]:
        """Return the direction of what pulls at closed latches, by body, as `System.direction` takes it."""
        pull, _ = self._pull(at)
        return {self.first: at.held.along(pull), self.second: at.opposite.along(-pull)}

    def stretched(self, at: LatchState, mass: Scalar) -> Scalar:
        """Return the force to which a ``mass`` that moves as they do would stretch closed latches [N]."""
        pull, size = self._pull(at)
        # What already comes back stretches the latches no further.
        speed = jnp.maximum(at.velocity.dot(pull), 0.0)
        return jnp.sqrt(size**2 + self.stiffness * mass * speed**2)

    @property
    def report(self) -> "LatchReport":
        return LatchReport(self)


class LatchReport(Report[Latch]):
    """What is said and drawn of latches."""

    def summary(self, run: Any) -> list[tuple[str, str]]:
        latch = self.element
        closed = closed_at(run, latch.name)
        if not math.isfinite(closed):
            return []
        held = f", held {float(run.end_time) - closed:.4g} s later" if run.outcome.name == "held" else ""
        strength = "" if latch.strength is None else " strength"
        most = SummaryRow.largest(run, f"{latch.name}_force", "N", limit=latch.strength, note=strength).text
        heading = "latched" if latch.name == "latch" else f"{self.words} closed"
        return [(heading, f"at {closed:.6g} s{held}; {self.words} force at most {most}")]

    @property
    def summary_observables(self) -> tuple[str, ...]:
        return (f"{self.element.name}_force",)

    def moments(self, run: Any) -> dict[str, float]:
        latch = self.element
        # With a closing time they are closed some time after the point has crossed the plane.
        slow = float(np.asarray(latch.closing_time)) > 0.0
        closed = run.switch_times.get(f"{latch.name} closed", math.nan) if slow else closed_at(run, latch.name)
        return {f"{self.words} closed": closed}

    def panels(self, run: Any) -> list[Panel]:
        latch = self.element
        most = largest(run, f"{latch.name}_force")
        levels = [Level(f"largest, {most:.4g} N", most)]
        if latch.strength is not None and most > 0.5 * float(latch.strength):
            levels.append(Level(f"strength, {float(latch.strength):.4g} N", float(latch.strength), limit=True))
        curve = PanelCurve("", run.history.others[f"{latch.name}_force"])
        title = f"{self.words} force"
        # What is latched comes to rest long after the last impact.
        shown = Panel(title.capitalize(), f"{title} [N]", (curve,), (*levels, Level("", 0.0)))
        return [shown._replace(whole=True, to_end=True)]

    @property
    def shares(self) -> tuple[EnergyShare, ...]:
        latch = self.element
        together = "latches" if latch.name == "latch" else self.words
        return (EnergyShare(self.words, f"in the {together}", (latch.name, f"{latch.name}_damper")),)


def _size(force: Vector) -> Scalar:
    """Return the size of a force [N], with a derivative also where it is zero."""
    return jnp.sqrt(force.dot(force) + 1e-24)
