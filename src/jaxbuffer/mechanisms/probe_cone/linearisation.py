"""The capture mechanism's stiff forces: the buffer's axial spring-damper with its end stop, the torsional one, and the
normal force and friction of each flank (M89)."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...hybrid import Linearisation
from ..linearisation import ContactTerm, SpringTerm, contact_directions, contact_slopes, linearised
from .assembly import FLANKS, SIDE, T
from .posture import Posture, ProbeInCone


def linearisation(
    mechanism: ProbeInCone, state: Float[Array, " state"], active: Float[Array, " contacts"]
) -> Linearisation:
    """How the six forces act on the velocities and answer to motion at a state."""
    at = mechanism.posture(state)
    springs = [
        SpringTerm(jnp.pad(mechanism.system.direction(spring.blocks), (0, mechanism.spins)), *spring[1:])
        for spring in mechanism.system.springs(at.kin)
    ]
    if mechanism.stop is not None:
        pushing = active[FLANKS] * (mechanism.stop_force(at, active) > 0.0)
        axial = springs[0]
        springs[0] = axial._replace(
            stiffness=axial.stiffness + pushing * mechanism.stop.linear_stiffness,
            damping=axial.damping + pushing * mechanism.stop.damping,
        )
    memory, exerting = mechanism.memory(state), mechanism.exerting(active)
    slopes = contact_slopes(mechanism.pair, mechanism.rounded(at.approach), memory, exerting)
    contacts = ContactTerm(*flank_directions(mechanism, at), *slopes)
    if mechanism.hinge is not None and at.pin is not None:
        pin = mechanism.hinge.term(mechanism.system, at.pin, active[-1], mechanism.spins)
        contacts = jax.tree.map(lambda *parts: jnp.concatenate(parts, axis=-1), contacts, pin)
    return linearised(mechanism.system, at.kin, springs, contacts, mechanism.probe.tip_inertia)


def flank_directions(
    mechanism: ProbeInCone, at: Posture
) -> tuple[Float[Array, "velocities flanks"], Float[Array, "velocities flanks"]]:
    """Columns b with δ̇ = b·w, and columns b with v_t = b·w, of both flanks."""
    origin = at.kin.point(T, (0.0, 0.0))
    return contact_directions(
        mechanism.system, at.approach, jnp.asarray(SIDE), at.centre, origin, bool(mechanism.spins)
    )
