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
from ..contact import Approach, BallPair
from ..hybrid import Linearisation
from ..multibody import Block, Kinematics, MaterialPoint, System
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
    system: System,
    kin: Kinematics,
    springs: Sequence[SpringTerm],
    contacts: ContactTerm,
    spin_inertia: Float[Array, " spins"] | None = None,
    decay: Float[Array, " rest"] | None = None,
) -> Linearisation:
    """Return how the forces act on the velocities and answer to motion.

    **Arguments:** ``contacts``: those of all pairs together; ``spin_inertia`` [kg m²]: of each velocity beyond
    the coordinates' own, if there are any; ``decay``: as of `Linearisation`.
    """
    n, m = system.velocities, contacts.normals.shape[1]
    along = [spring.direction[:, None] for spring in springs]
    directions = jnp.concatenate([*along, contacts.normals, contacts.tangents], axis=1)
    response = system.response(kin, directions[:n])
    if spin_inertia is not None:
        # A ball that spins freely is held by no joint: its own inertia alone resists.
        response = jnp.concatenate([response, directions[n:] / spin_inertia[:, None]])
    return Linearisation(
        directions=directions,
        response=response,
        stiffness=_coupling([s.stiffness for s in springs], contacts.per_depth, jnp.zeros(m)),
        damping=_coupling([s.damping for s in springs], contacts.per_speed, contacts.per_slip[1]),
        coordinates=system.coordinates,
        decay=decay,
        position_rate=system.position_rate(kin.q),
    )


def _coupling(springs: list[Scalar], contact: tuple[Array, Array], friction: Array) -> Float[Array, "rank rank"]:
    """Return the forces' slopes: rows are springs, normal forces, friction; columns what each answers to, in that
    order."""
    m = contact[0].shape[0]
    diagonal = jnp.concatenate([stacked(springs) if springs else jnp.zeros(0), contact[0], friction])
    rank = diagonal.shape[0]
    below = jnp.concatenate([jnp.zeros(rank - m), contact[1]])  # friction answers to what the normal force answers to
    return jnp.eye(rank) * diagonal[:, None] + jnp.eye(rank, k=-m) * below[:, None]


def contact_slopes(pair: BallPair, approach: Approach, memory: Array, active: Array) -> list[tuple[Array, Array]]:
    """Return the derivatives of (F_n, -F_t) of a pair's contacts by penetration, approach speed and slip."""

    def forces(depth: Array, speed: Array, slip: Array) -> tuple[Array, Array]:
        normal = active * pair.law.force(depth, speed, memory)
        return normal, -pair.friction.force(normal, slip)

    point = (-approach.gap, approach.approach_speed, approach.slip)
    # A contact's forces depend on its own numbers alone, so that one tangent gives the slopes of all contacts.
    units = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    size = approach.gap.shape[0]
    return [jax.jvp(forces, point, tuple(jnp.full(size, u) for u in unit))[1] for unit in units]


def inverse_masses(system: System, kin: Kinematics, directions: Float[Array, "coordinates m"]) -> Float[Array, "m m"]:
    """Return A M_c⁻¹ Aᵀ [1/kg], the speeds along some directions that unit impulses along them give while the joints
    hold (M200)."""
    response = system.response(kin, directions)
    return jnp.sum(directions[:, :, None] * response[:, None, :], axis=0)


def contact_directions(
    system: System,
    approach: Approach,
    side: Array,
    ball: MaterialPoint,
    carrier: MaterialPoint,
    free_spin: bool = False,
) -> tuple[Float[Array, "velocities m"], Float[Array, "velocities m"]]:
    """Return columns b with δ̇ = b·w and v_t = b·w of a ball's m contacts.

    **Arguments:** ``side`` of the tangents (see `BallPair`); ``ball``: its centre; ``carrier``: the origin of the
    shape's axes; ``free_spin``: whether the ball spins on its own, with one velocity more, rather than with its body.
    """
    normals: list[Array] = []
    tangents: list[Array] = []
    for k in range(approach.gap.shape[0]):
        lever = side[k] * approach.distance[k]  # the foot seen from the ball's centre: only the slip feels the spin
        for columns, x, y, spin in (
            (normals, -approach.normal_x[k], -approach.normal_y[k], jnp.zeros(())),
            (tangents, approach.tangent_x[k], approach.tangent_y[k], lever),
        ):
            along = Vector(x, y)
            # A ball that spins freely has a velocity of its own behind the coordinates': the slip feels that, not the
            # body's.
            own = 0.0 if free_spin else spin
            foot = Vector(approach.foot_x[k], approach.foot_y[k]).cross(along)
            blocks = {
                carrier.body: _combined(carrier.along(-along), -foot, carrier.turning()),
                ball.body: _combined(ball.along(along), own, ball.turning()),
            }
            column = system.direction(blocks)
            columns.append(jnp.append(column, spin) if free_spin else column)
    return jnp.stack(normals, axis=1), jnp.stack(tangents, axis=1)


def _combined(along: Block, factor: Scalar, turning: Block) -> Block:
    """Return a block plus ``factor`` times another."""
    return tuple(a + factor * b for a, b in zip(along, turning, strict=True))
