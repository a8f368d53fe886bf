"""The stiff forces of a mechanism, linearised in closed form for implicit steps (M89).

Scalar forces act along directions b with rates b·w: each spring-damper along its own, each contact along its normal and
its tangent. Freezing the directions leaves out geometric and gyroscopic terms: they are not stiff.
"""

from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..contact import Approach, BallOnSegments
from ..hybrid import Linearisation
from ..multibody import GROUND, Kinematics, System
from ..plane import Vector


class SpringTerm(NamedTuple):
    """A spring-damper: ``direction`` b (velocities,) with the rate of its length b·w, ``stiffness``, ``damping``."""

    direction: Float[Array, " velocities"]
    stiffness: Scalar
    damping: Scalar


class ContactTerm(NamedTuple):
    """Contacts of one pair, m of them.

    ``normals`` and ``tangents`` (velocities, m): directions with δ̇ = b·w and v_t = b·w; ``per_depth``, ``per_speed``
    and ``per_slip``: derivatives of (F_n, -F_t), m each, by penetration, approach speed and slip.
    """

    normals: Float[Array, "velocities m"]
    tangents: Float[Array, "velocities m"]
    per_depth: tuple[Float[Array, " m"], Float[Array, " m"]]
    per_speed: tuple[Float[Array, " m"], Float[Array, " m"]]
    per_slip: tuple[Float[Array, " m"], Float[Array, " m"]]


def linearised(
    system: System, kin: Kinematics, springs: Sequence[SpringTerm], contacts: ContactTerm, spin_inertia: Scalar = 1.0
) -> Linearisation:
    """How the forces act on the velocities and answer to motion.

    **Arguments:** ``contacts``: those of all pairs together; ``spin_inertia`` [kg m²] of velocities beyond the
    coordinates' own, if there are any.
    """
    n, m = system.coordinates, contacts.normals.shape[1]
    along = [spring.direction[:, None] for spring in springs]
    directions = jnp.concatenate([*along, contacts.normals, contacts.tangents], axis=1)
    response = system.response(kin, directions[:n])
    if directions.shape[0] > n:
        response = jnp.concatenate([response, directions[n:] / spin_inertia])
    return Linearisation(
        directions=directions,
        response=response,
        stiffness=_coupling([s.stiffness for s in springs], contacts.per_depth, jnp.zeros(m)),
        damping=_coupling([s.damping for s in springs], contacts.per_speed, contacts.per_slip[1]),
        coordinates=n,
    )


def _coupling(springs: list[Scalar], contact: tuple[Array, Array], friction: Array) -> Float[Array, "rank rank"]:
    """Rows: springs, normal forces, friction; columns: what each answers to, in the same order."""
    m = contact[0].shape[0]
    diagonal = jnp.concatenate([stacked(springs) if springs else jnp.zeros(0), contact[0], friction])
    rank = diagonal.shape[0]
    below = jnp.concatenate([jnp.zeros(rank - m), contact[1]])  # friction answers to what the normal force answers to
    return jnp.eye(rank) * diagonal[:, None] + jnp.eye(rank, k=-m) * below[:, None]


def contact_slopes(pair: BallOnSegments, approach: Approach, memory: Array, active: Array) -> list[tuple[Array, Array]]:
    """Derivatives of (F_n, -F_t) of a pair's contacts by penetration, approach speed and slip."""

    def forces(depth: Array, speed: Array, slip: Array) -> tuple[Array, Array]:
        normal = active * pair.law.force(depth, speed, memory)
        return normal, -pair.friction.force(normal, slip)

    point = (-approach.gap, approach.approach_speed, approach.slip)
    units = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    size = approach.gap.shape[0]
    return [jax.jvp(forces, point, tuple(jnp.full(size, u) for u in unit))[1] for unit in units]


def contact_directions(
    approach: Approach, side: Array, arm: Vector, body: int, carrier: int, coordinates: int, free_spin: bool = False
) -> tuple[Float[Array, "velocities m"], Float[Array, "velocities m"]]:
    """Columns b with δ̇ = b·w and v_t = b·w of a ball's m contacts.

    **Arguments:** ``arm`` of the ball's centre from its body's centre of mass [m]; ``side`` of the tangents (see
    `BallOnSegments`); ``body`` and ``carrier``: indices; ``free_spin``: whether the ball spins on its own, with one
    velocity more, rather than with its body.
    """
    m = approach.gap.shape[0]
    x = jnp.concatenate([-approach.normal_x, approach.tangent_x])
    y = jnp.concatenate([-approach.normal_y, approach.tangent_y])
    foot_x, foot_y = jnp.tile(approach.foot_x, 2), jnp.tile(approach.foot_y, 2)
    # The foot seen from the ball's centre: only the slip feels the ball's spin.
    spin = jnp.concatenate([jnp.zeros(m), side * approach.distance])
    turn = arm.x * y - arm.y * x + (0.0 if free_spin else spin)
    zero = jnp.zeros(2 * m)
    rows = [zero] * coordinates
    for index, block in ((body, (x, y, turn)), (carrier, (-x, -y, foot_y * x - foot_x * y))):
        if index != GROUND:
            rows[3 * index : 3 * index + 3] = block
    both = jnp.stack([*rows, *([spin] if free_spin else [])])
    return both[:, :m], both[:, m:]
