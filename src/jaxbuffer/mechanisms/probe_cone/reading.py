"""What a capture's run reads off its start, its end and the crossing of the capture plane."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..._types import Scalar
from ...elements import BufferForce
from ...hybrid import Kind, Log
from ...plane import Vector
from ..assembled import Assembled
from ..layout import Closed, EvaluatedState
from ..reading import Reader
from .assembly import LOWER
from .bodies import TIP, P, T
from .parts import parts_of
from .throat import ThroatState


class CaptureReading(NamedTuple):
    """A capture at one instant.

    - ``throat``: the tip in the cone.
    - ``misses``: of the tip and of the probe's attitude, and their rates, by their names in `Docking`.
    - ``passive_velocity``: of the passive vehicle [m/s].
    - ``relative_energy``: of relative motion [J] (M177).
    - ``since_crossing``: time since what holds the tip began to, 0 before, and where nothing does [s].
    - ``flank_mass``: m_c that the lower flank meets through the joints, the springs soft [kg] (M79).
    - ``axial_mass``: that the buffer's ends meet [kg]; ``stroke_rate`` [m/s]; ``push``: by which buffer and parts
      resist at the buffer's end [N].
    - ``stretched``: force to which the mass that it holds would stretch it [N], 0 where nothing does.
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
    """Return the misses in the plane: y of the tip in the axes of T, the probe's angle against these, both rates."""
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
    holder = holder_in(mechanism)
    flank_mass, axial_mass, *along_pull = masses
    return CaptureReading(
        throat=mechanism.evaluated(at, "throat"),
        misses=misses,
        passive_velocity=at.kin.frame(T).velocity,
        relative_energy=mechanism.relative_energy(at, active),
        since_crossing=0.0 if holder is None else mechanism.evaluated(at, holder.name).since,
        flank_mass=flank_mass,
        axial_mass=axial_mass,
        stroke_rate=mechanism.evaluated(at, "buffer").stroke_rate,
        push=_push(mechanism, at, active),
        stretched=0.0 if holder is None else holder.stretched(mechanism.evaluated(at, holder.name), along_pull[0]),
    )


def holder_in(mechanism: Assembled) -> Any:
    """Return the element that holds the tip behind the capture plane; None of a mechanism whose runs end there."""
    name = mechanism.element("throat").holder
    return None if name is None else mechanism.element(name)


def _crossing_slot(mechanism: Assembled, log: Log) -> Int[Array, ""] | None:
    """Return the entry at which the tip crosses the capture plane and is held, or else the run's end; where nothing
    holds it a captured run ends there."""
    if holder_in(mechanism) is None:
        return None
    crosses, last = crossings(mechanism, log), jnp.maximum(log.count - 1, 0)
    return jnp.where(jnp.any(crosses), jnp.argmax(crosses), last)


def _directions(mechanism: Assembled, at: EvaluatedState) -> Float[Array, "coordinates rank"]:
    """Return the lower flank's normal, the buffer's axis and what pulls at what holds the tip, a column each."""
    axial, holder = mechanism.element("buffer").force, holder_in(mechanism)
    directions = [flank_direction(mechanism, at), mechanism.system.direction(axial.springs(at.kin)[0].blocks)]
    if holder is not None:
        directions.append(mechanism.system.direction(holder.pulled(mechanism.evaluated(at, holder.name))))
    return jnp.stack(directions, axis=1)


READER = reader(planar_misses)


def crossings(mechanism: Assembled, log: Log) -> Bool[Array, " slots"]:
    """Return which entries of a log are the crossing of the capture plane, where what holds the tip begins to close."""
    return (
        (log.kind == Kind.TOUCHDOWN)
        & (log.which == mechanism.contact_names.index(mechanism.element("throat").holder))
        & log.used
    )


def flank_direction(mechanism: Assembled, at: EvaluatedState) -> Float[Array, " coordinates"]:
    """Return A of the lower flank, where A q̇ is the approach speed (M79)."""
    return mechanism.element(TIP).closing_directions(mechanism.system, mechanism.evaluated(at, TIP))[:, LOWER]


def _push(mechanism: Assembled, at: EvaluatedState, active: Closed) -> Scalar:
    """Return the force by which buffer and parts resist where the buffer comes to its end [N]."""
    parts, axial = mechanism.parts, mechanism.element("buffer").force
    if isinstance(axial, BufferForce):
        force = -axial.tension(at.kin)
    else:
        speed = jnp.maximum(mechanism.evaluated(at, "buffer").stroke_rate, 0.0)
        force = parts.design.buffer.k_A * parts.design.buffer.longest_stroke + parts.design.buffer.c_A * speed
    for part in parts_of(parts.design, parts.scenario):
        if (push := part.push(mechanism, at, active)) is not None:
            force = force + push
    return force
