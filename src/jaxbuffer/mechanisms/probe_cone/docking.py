"""What a run says of docking beyond the crossing of the capture plane: how it crossed, what is left.

All of it is differentiable; what a run does not have (no crossing, no latch, not yet at rest) is NaN.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..._types import Scalar
from ...elements import BufferForce, EndStop, Latch
from ...hybrid import Kind, Log
from ..assembled import Assembled
from ..layout import EvaluatedState
from .bodies import TIP, P, T
from .capture import Docking
from .outcome import Outcome

DOUBLINGS, NEWTON_STEPS = 60, 30  # of a stroke from 1e-9 m on, and towards the stroke whose energy is known


class PlaneCrossing(NamedTuple):
    """Where the tip crossed the capture plane, or else the run's end.

    ``at``: the evaluated state there, which moves with the parameters; ``time`` [s]; ``occurred``: whether it crossed.
    """

    at: EvaluatedState
    time: Float[Array, ""]
    occurred: Bool[Array, ""]


def end_of(mechanism: Assembled, log: Log) -> EvaluatedState:
    """Evaluate the state at a run's end, once for all that is read off there."""
    return mechanism.evaluate(log.rows[_last(log), 0])


def latched(mechanism: Assembled, end: EvaluatedState) -> Bool[Array, ""]:
    """Return whether the latches began to close before the run's ``end``."""
    closing = [mechanism.evaluated(end, latch.name).since > 0.0 for latch in mechanism.all_of(Latch)]
    # A design without latches has nothing to stack.
    return jnp.any(jnp.stack(closing)) if closing else jnp.asarray(False)


def crossing(mechanism: Assembled, log: Log, end: EvaluatedState, code: Int[Array, ""]) -> PlaneCrossing:
    """Return where the tip crossed the capture plane.

    ``end``: the state at the run's end; ``code``: of the outcome. Without latches a captured run ends there; with them
    it is the touchdown of theirs.
    """
    last = _last(log)
    if not mechanism.all_of(Latch):
        return PlaneCrossing(end, log.time[last], code == Outcome.captured)
    which = mechanism.contact_names.index("latch")
    # Slots behind the count may hold anything.
    mine = (log.kind == Kind.TOUCHDOWN) & (log.which == which) & (jnp.arange(log.kind.shape[0]) < log.count)
    slot, listed = jnp.argmax(mine), jnp.any(mine)
    row = log.rows[slot, 0]
    late = mechanism.time_to_contact(row, jnp.asarray(which))
    # Its own change counts only with the time left to the crossing, as in `ContactSystem.saltation`.
    rate = jax.lax.stop_gradient(mechanism.derivative(0.0, row, log.active[slot]))
    state = jnp.where(listed, row + rate * late, end.state)
    # A log that overflowed does not have the entry; the state says when the latches began to close.
    since = mechanism.evaluated(end, "latch").since
    return PlaneCrossing(mechanism.evaluate(state), log.time[last] - since, listed | (since > 0.0))


def docking(
    mechanism: Assembled,
    ends: tuple[EvaluatedState, EvaluatedState],
    log: Log,
    cross: PlaneCrossing,
    code: Int[Array, ""],
    latch_force: Scalar,
) -> Docking:
    """Read off what a run says of docking.

    ``ends``: the states at its start and at its end; ``cross``: where it crossed the capture plane; ``code``: of the
    outcome; ``latch_force``: the largest one [N].
    """
    (start, end), last = ends, _last(log)
    active = log.active[last]
    # At the start no contact is deep, so that none stores energy.
    before, left = mechanism.relative_energy(start, jnp.zeros_like(active)), mechanism.relative_energy(end, active)
    # A factor, so that derivatives are NaN as well.
    known = jnp.where(cross.occurred, 1.0, jnp.nan)
    tip, cone, probe = mechanism.evaluated(cross.at, "throat").tip, cross.at.kin.frame(T), cross.at.kin.frame(P)
    rate = _tip_rate(mechanism, cross.at)
    unlatched = jnp.where(latched(mechanism, end), 1.0, jnp.nan)
    passive = mechanism.parts.design.passive.mass
    push = (end.kin.frame(T).velocity - start.kin.frame(T).velocity) * passive
    return Docking(
        latch_time=cross.time * unlatched,
        settling_time=(log.time[last] - cross.time) * jnp.where(code == Outcome.held, 1.0, jnp.nan),
        latch_share=_latch_share(mechanism, end, latch_force, code == Outcome.torn),
        relative_energy=left / before,
        energy_left=left,
        arrest_stroke=arrest_stroke(mechanism, left),
        lateral_miss=tip.y * known,
        lateral_miss_rate=rate * known,
        attitude_miss=(probe.angle - cone.angle) * known,
        attitude_miss_rate=(probe.spin - cone.spin) * known,
        # The small number keeps the slope finite where nothing has pushed the passive vehicle.
        impulse=jnp.sqrt(push.dot(push) + 1e-30),
    )


def _tip_rate(mechanism: Assembled, at: EvaluatedState) -> Scalar:
    """Return how fast the tip's y in the axes of T changes [m/s]."""
    cone = at.kin.frame(T)
    centre = mechanism.evaluated(at, TIP).centre
    return cone.unturn(centre.velocity - cone.velocity_at(centre.place - cone.origin)).y


def arrest_stroke(mechanism: Assembled, energy: Float[Array, ""]) -> Float[Array, ""]:
    """Return the stroke at which axial spring and end stop store an energy [m], √(2 E/k_A) of a linear spring without a
    stop (M179)."""
    # At zero the root below has no finite slope, and rounding may leave less than that.
    energy = jnp.maximum(energy, 1e-30)
    axial = mechanism.element("buffer").force
    stops = [stop for stop in mechanism.all_of(EndStop) if not stop.rebound]
    if not stops and not isinstance(axial, BufferForce):
        return jnp.sqrt(2.0 * energy / axial.stiffness)

    def stored(stroke: Array) -> Array:
        spring = axial.spring_energy(stroke) if isinstance(axial, BufferForce) else 0.5 * axial.stiffness * stroke**2
        return jnp.asarray(sum((stop.law.energy(stroke - stop.place) for stop in stops), start=spring))

    def step(_: int, stroke: Array) -> Array:
        value, force = jax.jvp(stored, (stroke,), (jnp.ones(()),))
        return stroke - (value - energy) / force

    # The energy is convex in the stroke: from above Newton's method comes down to the root without overshooting it.
    above = jax.lax.fori_loop(0, DOUBLINGS, lambda _, s: jnp.where(stored(s) < energy, 2.0 * s, s), jnp.asarray(1e-9))
    root = jax.lax.fori_loop(0, NEWTON_STEPS, step, jax.lax.stop_gradient(above))
    return step(0, jax.lax.stop_gradient(root))  # whose derivative is that of the root


def _latch_share(mechanism: Assembled, end: EvaluatedState, largest: Scalar, torn: Bool[Array, ""]) -> Float[Array, ""]:
    """Return the largest force of the latches over their strength [-].

    Of torn ones it is above 1: with the force to which the mass that they hold would have stretched them, had they
    held. It is 1 where they just tear, and its slope leads out of that.
    """
    for latch in mechanism.all_of(Latch):
        if latch.strength is not None:
            return jnp.where(torn, _stretched(mechanism, end, latch), largest) / latch.strength
    return jnp.zeros(())


def _stretched(mechanism: Assembled, end: EvaluatedState, latch: Latch) -> Scalar:
    """Return the force to which the mass that a latch holds would stretch it [N]."""
    at = mechanism.evaluated(end, latch.name)
    force = latch.force(at, jnp.ones(2))
    size = jnp.sqrt(force.dot(force) + 1e-24)
    pull = force * (-1.0 / size)
    blocks = {P: at.held.along(pull), T: at.opposite.along(-pull)}
    mass = mechanism.system.effective_mass(end.kin, mechanism.system.direction(blocks))
    # What already comes back stretches the latches no further.
    speed = jnp.maximum(at.velocity.dot(pull), 0.0)
    return jnp.sqrt(size**2 + latch.stiffness * mass * speed**2)


def _last(log: Log) -> Int[Array, ""]:
    """Return the entry of the run's end."""
    return jnp.maximum(log.count - 1, 0)
