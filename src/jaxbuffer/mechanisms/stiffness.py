"""The stiff forces of the capture mechanism, linearised in closed form for implicit steps.

Six scalar forces act along six directions b with rates b·w: the axial spring-damper with its end stop, the torsional
one, and on each flank the normal force and friction. Freezing the directions leaves out geometric and gyroscopic terms:
not stiff.
"""

from typing import TYPE_CHECKING

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..contact import Approach
from .assembly import FLANKS, SIDE, N
from .hybrid import Linearisation
from .probe_in_cone import Posture

if TYPE_CHECKING:
    from .capture import CaptureMechanism


def linearisation(
    mechanism: "CaptureMechanism", state: Float[Array, " state"], active: Float[Array, " contacts"]
) -> Linearisation:
    """How the six forces act on the velocities and answer to motion at a state."""
    at, buffer = mechanism.posture(state), mechanism.design.buffer
    approach = mechanism.rounded(at.approach)
    per_depth, per_speed, per_slip = _contact_slopes(mechanism, approach, mechanism.memory(state), active)
    directions = jnp.concatenate([_buffer_directions(mechanism, at), contact_directions(mechanism, at)], 1)
    response = mechanism.system.response(at.kin, directions[:N])
    if mechanism.spins:
        response = jnp.concatenate([response, directions[N:] / mechanism.probe.tip_inertia])
    axial_stiffness, axial_damping = buffer.k_A, buffer.c_A
    if mechanism.stop is not None:
        pushing = active[FLANKS] * (mechanism.stop_force(at, active) > 0.0)
        axial_stiffness = axial_stiffness + pushing * mechanism.stop.linear_stiffness
        axial_damping = axial_damping + pushing * mechanism.stop.damping
    return Linearisation(
        directions=directions,
        response=response,
        stiffness=_coupling(axial_stiffness, buffer.k_T, per_depth, jnp.zeros(2)),
        damping=_coupling(axial_damping, buffer.c_T, per_speed, per_slip[1]),
        coordinates=N,
    )


def _contact_slopes(
    mechanism: "CaptureMechanism", approach: Approach, memory: Array, active: Array
) -> list[tuple[Array, Array]]:
    """Derivatives of (F_n, -F_t) of both flanks by penetration, approach speed and slip."""
    pair = mechanism.pair

    def forces(depth: Array, speed: Array, slip: Array) -> tuple[Array, Array]:
        normal = mechanism.exerting(active) * pair.law.force(depth, speed, memory)
        return normal, -pair.friction.force(normal, slip)

    point = (-approach.gap, approach.approach_speed, approach.slip)
    units = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    return [jax.jvp(forces, point, tuple(jnp.full(2, u) for u in unit))[1] for unit in units]


def _coupling(axial: Scalar, torsional: Scalar, contact: tuple[Array, Array], friction: Array) -> Float[Array, "6 6"]:
    """Rows: axial, torsional, normal (2), friction (2); columns: what each answers to, in the same order."""
    diagonal = jnp.concatenate([stacked([axial, torsional]), contact[0], friction])
    below = jnp.concatenate([jnp.zeros(4), contact[1]])  # friction answers to what the normal force answers to
    shifted = jnp.eye(6, k=-2)
    return jnp.eye(6) * diagonal[:, None] + shifted * below[:, None]


def _buffer_directions(mechanism: "CaptureMechanism", at: Posture) -> Float[Array, "velocities 2"]:
    """Columns b with L̇ = b·w and θ̇_B - θ̇_S = b·w."""
    twist = [0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    still = (0, mechanism.spins)
    return jnp.stack([jnp.pad(axial_direction(at), still), jnp.pad(stacked(twist), still)], axis=1)


def axial_direction(at: Posture) -> Float[Array, " coordinates"]:
    """b with L̇ = b·q̇: how a unit force in the axial spring-damper acts on the coordinates."""
    u, a, b = at.axial.along, at.axial.first_arm, at.axial.second_arm
    return stacked([0.0, 0.0, 0.0, -u.x, -u.y, -a.cross(u), u.x, u.y, b.cross(u), 0.0, 0.0, 0.0])


def contact_directions(mechanism: "CaptureMechanism", at: Posture) -> Float[Array, "velocities 4"]:
    """Columns b with δ̇ = b·w (both flanks), then v_t = b·w (both flanks)."""
    arm, approach = at.arm, at.approach
    x = jnp.concatenate([-approach.normal_x, approach.tangent_x])
    y = jnp.concatenate([-approach.normal_y, approach.tangent_y])
    foot_x, foot_y = jnp.tile(approach.foot_x, 2), jnp.tile(approach.foot_y, 2)
    # The foot seen from the tip's centre: only the slip feels the tip's spin.
    spin = jnp.concatenate([jnp.zeros(2), SIDE * approach.distance])
    turn = arm.x * y - arm.y * x + (0.0 if mechanism.spins else spin)
    zero = jnp.zeros(4)
    return jnp.stack([zero] * 6 + [x, y, turn, -x, -y, foot_y * x - foot_x * y] + [spin] * mechanism.spins)
