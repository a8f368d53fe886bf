"""Contact forces of one step of central differences: penalty, Lagrange multipliers, defence node (M140 to M145)."""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..._types import Scalar
from ..incidence import added_at
from .surfaces import Pairs, RigidPlane, Surface

METHODS = ("defence node", "multiplier", "penalty")
ROUNDS = 20  # at most, in which the multipliers' set of closed pairs settles


class NodeContact(eqx.Module):
    """Nodes that may touch a surface.

    - ``slaves``: (pairs,) the nodes.
    - ``surface``: what they touch.
    - ``method``: one of `METHODS`. A defence node serves each pair for itself and is exact where no two pairs share a
      node; multipliers serve all pairs together; a penalty lets nodes in.
    - ``stiffness``: of a penalty, one for all pairs or (pairs,) [N/m].
    - ``friction``: Coulomb's coefficient [-].
    - ``averaged``: whether the force of an instant is the mean of those over the step before it and the step after it,
      rather than one that keeps the pair closed by itself. A pair that opens is then pushed off by half of what
      pressed it, and a bar of linear elements moves exactly at a Courant number of one; below one the force rings
      (M144).
    - ``published``: whether a defence node's force is distributed as Zhong does it, which turns bodies whose nodes have
      unequal masses; else by the shape functions.
    """

    slaves: np.ndarray
    surface: Surface
    method: str = eqx.field(default="defence node", static=True)
    stiffness: Scalar | Float[Array, " pairs"] = 0.0
    friction: Scalar = 0.0
    averaged: bool = eqx.field(default=False, static=True)
    published: bool = eqx.field(default=False, static=True)


class NodeContactForces(NamedTuple):
    """What a contact adds in one step.

    - ``nodes``: (nodes, 2) forces [N].
    - ``normal``: (pairs,) normal forces, never negative [N].
    - ``over_step``: (pairs,) the same over the step that follows [N].
    """

    nodes: Float[Array, "nodes 2"]
    normal: Float[Array, " pairs"]
    over_step: Float[Array, " pairs"]


def contact_forces(
    contact: NodeContact,
    positions: Float[Array, "nodes 2"],
    velocity: Float[Array, "nodes 2"],
    residual: Float[Array, "nodes 2"],
    inverse_mass: Float[Array, "nodes 2"],
    step: Scalar,
    near: Any = None,
    before: Float[Array, " pairs"] | None = None,
) -> NodeContactForces:
    """Return the forces of one contact.

    **Arguments:** ``positions`` [m]; ``velocity``: half a step before [m/s]; ``residual``: all other forces [N];
    ``inverse_mass``: of each direction, 0 where a node is held [1/kg]; ``step`` [s]; ``near``: of segments the
    candidates (see `candidates`); ``before``: normal forces over the step before [N].
    """
    pairs = contact.surface.pairs(contact.slaves, positions, near)
    free = velocity + step * inverse_mass * residual  # half a step later, without contact
    closing = -(pairs.gap / step + pairs.along(contact.slaves, free, pairs.normal))  # speed by which pairs overlap then
    weights = _distribution(contact, pairs, inverse_mass)
    yielding = _yielding(contact.slaves, pairs, weights, inverse_mass)
    if contact.method == "penalty":
        over_step = normal = jnp.where(pairs.present, contact.stiffness * jnp.maximum(-pairs.gap, 0.0), 0.0)
    else:
        matrix = _coupling(contact.slaves, pairs, inverse_mass) if contact.method == "multiplier" else None
        over_step = normal = _closing_forces(matrix, yielding, closing / step, pairs.present)
        if contact.averaged and before is not None:
            answered = yielding * before if matrix is None else matrix @ before
            over_step = _closing_forces(matrix, yielding, 2.0 * closing / step - answered, pairs.present)
            normal = 0.5 * (before + over_step)
    along = jnp.stack([-pairs.normal[:, 1], pairs.normal[:, 0]], axis=1)
    force = normal[:, None] * pairs.normal
    # Python's 0 alone: a traced coefficient may be positive.
    if not (isinstance(contact.friction, float) and contact.friction == 0.0):
        # What would stop the sliding within this step; Coulomb's law allows less, and never drives it backwards.
        stop = -pairs.along(contact.slaves, free, along) / (step * yielding)
        most = contact.friction * normal
        force = force + jnp.clip(stop, -most, most)[:, None] * along
    if isinstance(contact.surface, RigidPlane):
        on_nodes = contact.surface.on_nodes(contact.slaves, force, len(positions))
    else:
        on_nodes = added_at(contact.slaves, force, len(positions))
        on_nodes = on_nodes.at[pairs.nodes].add(-weights[..., None] * force[:, None])
    return NodeContactForces(on_nodes, normal, over_step)


def _distribution(contact: NodeContact, pairs: Pairs, inverse_mass: Array) -> Float[Array, "pairs 2"]:
    """Return how a force is handed to the surface's nodes: by φ (M141), or as published, by φ m/(φ̄ M) with φ̄ = Σφ²
    and M = Σφ m/φ̄ (M142)."""
    if not contact.published:
        return pairs.weights
    inverse = _along(inverse_mass[pairs.nodes], pairs.normal[:, None])
    mass = jnp.where(inverse > 0.0, 1.0 / jnp.where(inverse > 0.0, inverse, 1.0), 0.0)
    shared = pairs.weights * mass
    # Where both nodes are held there is no mass to share a force by.
    return shared / jnp.maximum(jnp.sum(shared, axis=1, keepdims=True), 1e-300)


def _yielding(slaves: np.ndarray, pairs: Pairs, weights: Array, inverse_mass: Array) -> Float[Array, " pairs"]:
    """Return the (pairs,) relative acceleration of node and foot for a force of one [1/kg]."""
    own = _along(inverse_mass[slaves], pairs.normal)
    foot = jnp.sum(pairs.weights * weights * _along(inverse_mass[pairs.nodes], pairs.normal[:, None]), axis=1)
    return own + foot


def _along(vectors: Array, normal: Array) -> Array:
    """Return the diagonal matrix along a normal, nᵀ M⁻¹ n."""
    return jnp.sum(vectors * normal * normal, axis=-1)


def _coupling(slaves: np.ndarray, pairs: Pairs, inverse_mass: Array) -> Float[Array, "pairs pairs"]:
    """Return W = G M⁻¹ Gᵀ (M143): the relative acceleration of each pair for a force of one in each [1/kg]."""
    nodes = jnp.concatenate([jnp.asarray(slaves)[:, None], pairs.nodes], axis=1)
    factors = jnp.concatenate([jnp.ones((len(slaves), 1)), -pairs.weights], axis=1)
    rows = factors[..., None] * pairs.normal[:, None]  # (pairs, 3, 2)
    same = nodes[:, None, :, None] == nodes[None, :, None, :]
    return jnp.einsum("iac,jbc,iac,ijab->ij", rows, rows, inverse_mass[nodes], same.astype(float))


def _closing_forces(
    matrix: Float[Array, "pairs pairs"] | None, yielding: Array, target: Float[Array, " pairs"], present: Array
) -> Float[Array, " pairs"]:
    """Return the forces f ≥ 0 with W f ≥ ``target`` [m/s²] and f (W f - wanted) = 0, where W is the ``matrix``, or
    diagonal, ``yielding``, where each pair is served for itself.

    With a matrix the set of closed pairs is settled first (a primal-dual active set); the equations of that set are
    then solved once, with derivatives.
    """
    if matrix is None:
        return jnp.where(present, jnp.maximum(target, 0.0) / yielding, 0.0)
    # The set is a choice without a derivative; with it settled, the forces have theirs from the equations alone.
    closed = _closed(jax.lax.stop_gradient(matrix), jax.lax.stop_gradient(target), present)
    return jnp.maximum(_holding_forces(matrix, target, closed), 0.0)


def _holding_forces(matrix: Array, target: Array, closed: Array) -> Float[Array, " pairs"]:
    """Return the forces that give the ``closed`` pairs their ``target``, zero on the others."""
    # Open pairs keep a one on the diagonal, so that the system has one size whichever pairs press.
    both = closed[:, None] & closed[None]
    return jnp.linalg.solve(
        jnp.where(both, matrix, 0.0) + jnp.diag(jnp.where(closed, 0.0, 1.0)), jnp.where(closed, target, 0.0)
    )


def _closed(matrix: Array, target: Array, present: Array) -> Bool[Array, " pairs"]:
    """Return which pairs press."""

    def settle(state: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        closed, _, rounds = state
        force = _holding_forces(matrix, target, closed)
        again = (force - (matrix @ force - target) / jnp.diagonal(matrix) > 0.0) & present
        return again, jnp.any(again != closed), rounds + 1

    going = lambda state: state[1] & (state[2] < ROUNDS)  # noqa: E731
    first = (target > 0.0) & present
    # Where no pair is about to overlap, forces of zero meet all conditions, and no system has to be solved.
    return jax.lax.while_loop(going, settle, (first, jnp.any(first), jnp.asarray(0)))[0]
