"""The capture mechanism's stiff forces: the buffer's axial spring-damper with its end stop, the torsional one, and the
normal force and friction of each flank (M89)."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar
from ...contact import KelvinVoigt
from ...hybrid import Linearisation
from ..linearisation import ContactTerm, SpringTerm, contact_directions, contact_slopes, linearised
from .assembly import SIDE, T
from .posture import Posture, ProbeInCone


def linearisation(
    mechanism: ProbeInCone,
    at: Posture,
    active: Float[Array, " contacts"],
    decay: Float[Array, " rest"] | None = None,
) -> Linearisation:
    """How the six forces act on the velocities and answer to motion at a posture; ``decay``: as of `Linearisation`."""
    springs = [
        SpringTerm(jnp.pad(mechanism.system.direction(spring.blocks), (0, mechanism.spins)), *spring[1:])
        for spring in mechanism.system.springs(at.kin)
    ]
    if mechanism.stop is not None:
        pushing = mechanism.closed(active, "stop") * (mechanism.stop_force(at, active) > 0.0)
        springs[0] = _with_stop(springs[0], mechanism.stop, pushing)
    if mechanism.rebound is not None:
        pushing = mechanism.closed(active, "rebound") * (mechanism.rebound_force(at, active) > 0.0)
        springs[0] = _with_stop(springs[0], mechanism.rebound, pushing)
    if mechanism.latch is not None:
        springs += mechanism.latch.terms(mechanism.system, mechanism.acting_latch(at, active), mechanism.spins)
    memory, exerting = mechanism.memory(at.state), mechanism.exerting(active)
    slopes = contact_slopes(mechanism.pair, mechanism.rounded(at.approach), memory, exerting)
    contacts = ContactTerm(*flank_directions(mechanism, at), *slopes)
    if mechanism.hinge is not None and at.pin is not None:
        pin = mechanism.hinge.term(mechanism.system, at.pin, mechanism.closed(active, "pin"), mechanism.spins)
        contacts = jax.tree.map(lambda *parts: jnp.concatenate(parts, axis=-1), contacts, pin)
    return linearised(mechanism.system, at.kin, springs, contacts, mechanism.probe.tip_inertia, decay)


def _with_stop(axial: SpringTerm, stop: KelvinVoigt, pushing: Scalar) -> SpringTerm:
    """The axial spring-damper with a stop beside it, as far as that is ``pushing``: 1 or 0."""
    return axial._replace(
        stiffness=axial.stiffness + pushing * stop.linear_stiffness, damping=axial.damping + pushing * stop.damping
    )


def flank_directions(
    mechanism: ProbeInCone, at: Posture
) -> tuple[Float[Array, "velocities flanks"], Float[Array, "velocities flanks"]]:
    """Columns b with δ̇ = b·w, and columns b with v_t = b·w, of both flanks."""
    origin = at.kin.point(T, (0.0, 0.0))
    return contact_directions(
        mechanism.system, at.approach, jnp.asarray(SIDE), at.centre, origin, bool(mechanism.spins)
    )
