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
from ..basis import components, plus
from ..contact import Approach, BallPair
from ..hybrid import Linearisation
from ..multibody import Block, Kinematics, MaterialPoint, System
from ..space.either import Turn, Vector
from ..space.vectors import normals_to

STILL = 1e-9  # of a tangent: what gives one that vanishes a direction


class SpringTerm(NamedTuple):
    """A spring-damper: ``direction`` b (velocities,) with the rate of its length b·w, ``stiffness``, ``damping``."""

    direction: Float[Array, " velocities"]
    stiffness: Scalar
    damping: Scalar


class ContactTerm(NamedTuple):
    """Contacts of one pair, m of them.

    ``normals`` and ``tangents`` (velocities, m): directions with δ̇ = b·w and v_t = b·w; ``per_depth``, ``per_speed``
    and ``per_slip``: derivatives of (F_n, -F_t), m each, by penetration, approach speed and slip; ``across``: in space,
    what friction does against a change of the slip's direction, a damper a contact.
    """

    normals: Float[Array, "velocities m"]
    tangents: Float[Array, "velocities m"]
    per_depth: tuple[Float[Array, " m"], Float[Array, " m"]]
    per_speed: tuple[Float[Array, " m"], Float[Array, " m"]]
    per_slip: tuple[Float[Array, " m"], Float[Array, " m"]]
    across: tuple[SpringTerm, ...] = ()


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
) -> tuple[Float[Array, "velocities m"], Float[Array, "velocities m"], Float[Array, "velocities across"]]:
    """Return columns b with δ̇ = b·w and columns b with v_t = b·w of a ball's m contacts, and in space, where m columns
    more do, with the speed across both.

    **Arguments:** ``side`` of the tangents (see `BallPair`); ``ball``: its centre; ``carrier``: the origin of the
    shape's axes; ``free_spin``: whether the ball spins on its own, with velocities more, rather than with its body.
    """
    normals: list[Array] = []
    tangents: list[Array] = []
    across: list[Array] = []
    basis, planar = system.basis, system.basis.dimensions == 2
    still = jnp.zeros(()) if planar else basis.turn(0.0, 0.0, 0.0)

    def column(k: int, along: Vector, lever: Turn) -> Array:
        """Return how a speed of the ball against the carrier at the foot goes with the velocities. ``lever``: of the
        foot seen from the ball's centre."""
        foot = -jax.tree.map(lambda entry: entry[k], approach.foot).cross(along)
        # A ball that spins freely has velocities of its own behind the coordinates': the slip feels those, not the
        # body's.
        own = still if free_spin else lever
        blocks = {
            carrier.body: _sum(carrier.along(-along), carrier.turning(foot)),
            ball.body: _sum(ball.along(along), ball.turning(own)),
        }
        whole = system.direction(blocks)
        return jnp.concatenate([whole, stacked(components(lever))]) if free_spin else whole

    for k in range(approach.gap.shape[0]):
        normal, tangent = jax.tree.map(lambda entry: entry[k], (approach.normal, approach.tangent))  # noqa: B023
        normals.append(column(k, -normal, still))
        if planar:
            tangents.append(column(k, tangent, side[k] * approach.distance[k]))
            continue
        # Where nothing slips any two directions do: there friction is the same in all.
        along = tangent + normals_to(normal)[0] * STILL
        along = along * (1.0 / jnp.sqrt(along.dot(along)))
        arm = normal * -approach.distance[k]
        for columns, direction in ((tangents, along), (across, normal.cross(along))):
            columns.append(column(k, direction, arm.cross(direction)))
    thin = jnp.zeros((len(normals[0]), 0))
    return jnp.stack(normals, axis=1), jnp.stack(tangents, axis=1), jnp.stack(across, axis=1) if across else thin


def _sum(a: Block, b: Block) -> Block:
    """Return the sum of two blocks."""
    return tuple(plus(x, y) for x, y in zip(a, b, strict=True))
