"""What a run says of docking beyond the crossing of the capture plane: how it crossed, what is left.

All of it is differentiable; what a run does not have (no crossing, nothing that holds it, not yet at rest) is NaN.
"""

from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..._types import Scalar
from ...elements import BufferForce
from ...hybrid import Log
from ..assembled import Assembled
from ..run import Solved
from .capture import Docking
from .outcome import Outcome
from .parts import parts_of
from .reading import CaptureReading, crossings, holder_in

D = TypeVar("D", bound=Docking)
DOUBLINGS, NEWTON_STEPS = 60, 30  # of a stroke from 1e-9 m on, and towards the stroke whose energy is known


class PlaneCrossing(NamedTuple):
    """Where the tip crossed the capture plane, or else the run's end.

    ``at``: the reading there, which moves with the parameters; ``time`` [s]; ``occurred``: whether it crossed.
    """

    at: CaptureReading
    time: Float[Array, ""]
    occurred: Bool[Array, ""]


def crossing(mechanism: Assembled, solved: Solved, code: Int[Array, ""]) -> PlaneCrossing:
    """Return where the tip crossed the capture plane. ``code``: of the outcome."""
    end_time = solved.log.time[_last(solved.log)]
    if holder_in(mechanism) is None:
        return PlaneCrossing(solved.end.own, end_time, code == Outcome.captured)
    # A log that overflowed does not have the entry; the state says when what holds the tip began to close.
    since = solved.end.own.since_crossing
    occurred = jnp.any(crossings(mechanism, solved.log)) | (since > 0.0)
    return PlaneCrossing(solved.event.own, end_time - since, occurred)


def docking(
    mechanism: Assembled,
    ends: tuple[CaptureReading, CaptureReading],
    log: Log,
    cross: PlaneCrossing,
    code: Int[Array, ""],
    latch_force: Scalar,
    kind: type[D],
) -> D:
    """Read off what a run says of docking.

    ``ends``: the readings of its start and of its end; ``cross``: where it crossed the capture plane; ``code``: of the
    outcome; ``latch_force``: the largest one [N]; ``kind``: of plane or space.
    """
    (start, end), last = ends, _last(log)
    # A factor, so that derivatives are NaN as well.
    known = jnp.where(cross.occurred, 1.0, jnp.nan)
    latched = jnp.where(end.since_crossing > 0.0, 1.0, jnp.nan)
    push = (end.passive_velocity - start.passive_velocity) * mechanism.parts.design.passive.mass
    # The largest force of the latches over their strength. Of torn ones it is above 1: with the force to which the mass
    # that they hold would have stretched them, had they held. Its slope leads out of 1, where they just tear.
    holder, share = holder_in(mechanism), jnp.zeros(())
    if holder is not None and holder.strength is not None:
        share = jnp.where(code == Outcome.torn, end.stretched, latch_force) / holder.strength
    return kind(
        latch_time=cross.time * latched,
        settling_time=(log.time[last] - cross.time) * jnp.where(code == Outcome.held, 1.0, jnp.nan),
        latch_share=share,
        relative_energy=end.relative_energy / start.relative_energy,
        energy_left=end.relative_energy,
        arrest_stroke=arrest_stroke(mechanism, end.relative_energy),
        **{name: value * known for name, value in cross.at.misses.items()},
        # The small number keeps the slope finite where nothing has pushed the passive vehicle.
        impulse=jnp.sqrt(push.dot(push) + 1e-30),
    )


def arrest_stroke(mechanism: Assembled, energy: Float[Array, ""]) -> Float[Array, ""]:
    """Return the stroke at which axial spring and parts store an energy [m], √(2 E/k_A) of a linear spring
    alone (M179)."""
    # At zero the root below has no finite slope, and rounding may leave less than that.
    energy = jnp.maximum(energy, 1e-30)
    axial = mechanism.element("buffer").force
    stored_in = [
        of_part
        for part in parts_of(mechanism.parts.design, mechanism.parts.scenario)
        if (of_part := part.stroke_energy(mechanism)) is not None
    ]
    if not stored_in and not isinstance(axial, BufferForce):
        return jnp.sqrt(2.0 * energy / axial.stiffness)

    def stored(stroke: Array) -> Array:
        spring = axial.spring_energy(stroke) if isinstance(axial, BufferForce) else 0.5 * axial.stiffness * stroke**2
        return jnp.asarray(sum((of_part(stroke) for of_part in stored_in), start=spring))

    def step(_: int, stroke: Array) -> Array:
        value, force = jax.jvp(stored, (stroke,), (jnp.ones(()),))
        return stroke - (value - energy) / force

    # The energy is convex in the stroke: from above Newton's method comes down to the root without overshooting it.
    above = jax.lax.fori_loop(0, DOUBLINGS, lambda _, s: jnp.where(stored(s) < energy, 2.0 * s, s), jnp.asarray(1e-9))
    root = jax.lax.fori_loop(0, NEWTON_STEPS, step, jax.lax.stop_gradient(above))
    return step(0, jax.lax.stop_gradient(root))  # whose derivative is that of the root


def _last(log: Log) -> Int[Array, ""]:
    """Return the entry of the run's end."""
    return jnp.maximum(log.count - 1, 0)
