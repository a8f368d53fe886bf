"""What a capture's run reads off its start, its end and the crossing of the capture plane."""

from collections.abc import Callable
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..._types import Scalar
from ...elements import BufferForce, EndStop, Latch
from ...hybrid import Kind, Log
from ...plane import Vector
from ..assembled import Assembled
from ..layout import Closed, EvaluatedState
from ..reading import Reader
from .assembly import LOWER
from .bodies import TIP, P, T
from .throat import ThroatState


class CaptureReading(NamedTuple):
    """A capture at one instant.

    - ``throat``: the tip in the cone.
    - ``misses``: of the tip and of the probe's attitude, and their rates, by their names in `Docking`.
    - ``passive_velocity``: of the passive vehicle [m/s].
    - ``relative_energy``: of relative motion [J] (M177).
    - ``since_crossing``: time since the latches began to close, 0 before and without latches [s].
    - ``flank_mass``: m_c that the lower flank meets through the joints, the springs soft [kg] (M79).
    - ``axial_mass``: that the buffer's ends meet [kg]; ``stroke_rate`` [m/s]; ``push``: by which buffer and stop resist
      at the buffer's end [N].
    - ``stretched``: force to which the mass that the latches hold would stretch them [N], 0 without latches.
    """

    throat: ThroatState
    misses: dict[str, Scalar]
    passive_velocity: Vector
    relative_energy: Float[Array, ""]
    since_crossing: Scalar
    flank_mass: Float[Array, ""]
    axial_mass: Float[Array, ""]
    stroke_rate: Scalar
    push: Scalar
    stretched: Scalar


def planar_misses(mechanism: Assembled, at: EvaluatedState) -> dict[str, Scalar]:
    """Return the misses in the plane: y of the tip in the axes of T, the probe's angle against these, and both rates."""
    cone, probe = at.kin.frame(T), at.kin.frame(P)
    return {
        "lateral_miss": mechanism.evaluated(at, "throat").tip.y,
        "lateral_miss_rate": tip_motion(mechanism, at)[1].y,
        "attitude_miss": probe.angle - cone.angle,
        "attitude_miss_rate": probe.spin - cone.spin,
    }


def tip_motion(mechanism: Assembled, at: EvaluatedState) -> tuple[Vector, Vector]:
    """Return where the tip's centre is in the axes of T [m], and how it moves in these [m/s]."""
    cone, centre = at.kin.frame(T), mechanism.evaluated(at, TIP).centre
    off = centre.place - cone.origin
    return cone.unturn(off), cone.unturn(centre.velocity - cone.velocity_at(off))


Misses = Callable[[Assembled, EvaluatedState], dict[str, Scalar]]


def reader(misses: Misses) -> Reader:
    """Return what reads off a run in the plane or in space. ``misses``: of tip and probe, as of `CaptureReading`."""

    def look(mechanism: Assembled, at: EvaluatedState, active: Closed, masses: Float[Array, " rank"]) -> CaptureReading:
        return _look(mechanism, at, active, masses, misses(mechanism, at))

    return Reader(look, _crossing_slot, _directions)


def _look(
    mechanism: Assembled,
    at: EvaluatedState,
    active: Closed,
    masses: Float[Array, " rank"],
    misses: dict[str, Scalar],
) -> CaptureReading:
    latches = mechanism.all_of(Latch)
    flank_mass, axial_mass, *held = masses
    return CaptureReading(
        throat=mechanism.evaluated(at, "throat"),
        misses=misses,
        passive_velocity=at.kin.frame(T).velocity,
        relative_energy=mechanism.relative_energy(at, active),
        since_crossing=mechanism.evaluated(at, latches[0].name).since if latches else 0.0,
        flank_mass=flank_mass,
        axial_mass=axial_mass,
        stroke_rate=mechanism.evaluated(at, "buffer").stroke_rate,
        push=_push(mechanism, at, active),
        stretched=_stretched(mechanism, at, latches[0], held[0]) if latches else 0.0,
    )


def _crossing_slot(mechanism: Assembled, log: Log) -> Int[Array, ""] | None:
    """Return the entry at which latches catch the tip, where it crosses the capture plane, or else the run's end;
    without latches a captured run ends there."""
    if not mechanism.all_of(Latch):
        return None
    crosses, last = crossings(mechanism, log), jnp.maximum(log.count - 1, 0)
    return jnp.where(jnp.any(crosses), jnp.argmax(crosses), last)


def _directions(mechanism: Assembled, at: EvaluatedState) -> Float[Array, "coordinates rank"]:
    """Return the lower flank's normal, the buffer's axis and what pulls at latches, a column each."""
    axial = mechanism.element("buffer").force
    directions = [flank_direction(mechanism, at), mechanism.system.direction(axial.springs(at.kin)[0].blocks)]
    directions += [_pull_of(mechanism, at, latch) for latch in mechanism.all_of(Latch)]
    return jnp.stack(directions, axis=1)


READER = reader(planar_misses)


def crossings(mechanism: Assembled, log: Log) -> Bool[Array, " slots"]:
    """Return which entries of a log are the touchdown of the latches, at the crossing of the capture plane."""
    used = jnp.arange(log.kind.shape[0]) < log.count  # slots behind the count may hold anything
    return (log.kind == Kind.TOUCHDOWN) & (log.which == mechanism.contact_names.index("latch")) & used


def flank_direction(mechanism: Assembled, at: EvaluatedState) -> Float[Array, " coordinates"]:
    """Return A of the lower flank, where A q̇ is the approach speed (M79)."""
    return mechanism.element(TIP).closing_directions(mechanism.system, mechanism.evaluated(at, TIP))[:, LOWER]


def _push(mechanism: Assembled, at: EvaluatedState, active: Closed) -> Scalar:
    """Return the force by which buffer and stop resist where the buffer comes to its end [N]."""
    buffer, axial = mechanism.parts.design.buffer, mechanism.element("buffer").force
    if isinstance(axial, BufferForce):
        force = -axial.tension(at.kin)
    else:
        speed = jnp.maximum(mechanism.evaluated(at, "buffer").stroke_rate, 0.0)
        force = buffer.k_A * buffer.longest_stroke + buffer.c_A * speed
    for stop in mechanism.all_of(EndStop):
        # A rebound stop is at the other end of the stroke, and does not push there.
        if not stop.rebound:
            closed = mechanism.closed_switches(active, stop.name)
            force = force + stop.force(mechanism.evaluated(at, stop.name), closed)
    return force


def _force_of(mechanism: Assembled, at: EvaluatedState, latch: Latch) -> tuple[Vector, Scalar]:
    """Return the force of latches as if they were closed [N], and its size."""
    force = latch.force(mechanism.evaluated(at, latch.name), jnp.ones(2))
    return force, jnp.sqrt(force.dot(force) + 1e-24)


def _pull_of(mechanism: Assembled, at: EvaluatedState, latch: Latch) -> Float[Array, " coordinates"]:
    """Return the direction of what pulls at latches."""
    (force, size), it = _force_of(mechanism, at, latch), mechanism.evaluated(at, latch.name)
    pull = force * (-1.0 / size)
    return mechanism.system.direction({P: it.held.along(pull), T: it.opposite.along(-pull)})


def _stretched(mechanism: Assembled, at: EvaluatedState, latch: Latch, mass: Scalar) -> Scalar:
    """Return the force to which the ``mass`` that latches hold would stretch them [N]."""
    force, size = _force_of(mechanism, at, latch)
    # What already comes back stretches the latches no further.
    speed = jnp.maximum(mechanism.evaluated(at, latch.name).velocity.dot(force * (-1.0 / size)), 0.0)
    return jnp.sqrt(size**2 + latch.stiffness * mass * speed**2)
