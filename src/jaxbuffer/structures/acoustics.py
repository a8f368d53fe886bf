"""A liquid as a linear acoustic medium: pressure on a conforming mesh, coupled to a wall (M147 to M149).

    [M_s   0 ] [ü]   [K_s -A ] [u]   [F]
    [ρAᵀ  M_f] [p̈] + [ 0  K_f] [p] = [0]

with K_f = ∫∇N∇N, M_f = ∫NN/c². Seed 003's (4) lacks ρ in the mass coupling and repeats Aᵀ in the stiffness, where 0
belongs.
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._types import Scalar
from .incidence import Incidence, added_at
from .mapping import Mapping, Rule


class Liquid(NamedTuple):
    """A liquid, a metre deep.

    - ``incidence``: which nodes the elements' corners are, counted among the liquid's own.
    - ``stiffness``: (elements, 4, 4) K_f of each element [-].
    - ``mass``: (nodes,) M_f, lumped [s²].
    - ``free``: (nodes,) 1, or 0 where the pressure is held at zero: on the free surface.
    - ``density``: ρ [kg/m³].
    - ``wall``: (pairs,) the wall's nodes, and ``wet``: the liquid's nodes in the same places.
    - ``outward``: (pairs, 2) area of the wall that belongs to each, times its normal out of the liquid: A [m²].
    """

    incidence: Incidence
    stiffness: Float[Array, "elements 4 4"]
    mass: Float[Array, " nodes"]
    free: Float[Array, " nodes"]
    density: Scalar
    wall: Int[np.ndarray, " pairs"]
    wet: Int[np.ndarray, " pairs"]
    outward: Float[Array, "pairs 2"]

    def push(self, pressure: Float[Array, " nodes"], structure: int) -> Float[Array, "structure 2"]:
        """A p: what the liquid does to the ``structure`` nodes of the wall's mesh [N]."""
        return added_at(self.wall, pressure[self.wet][:, None] * self.outward, structure)

    def acceleration(
        self, pressure: Float[Array, " nodes"], wall: Float[Array, "structure 2"]
    ) -> Float[Array, " nodes"]:
        """p̈ [Pa/s²] under the wall's acceleration ü [m/s²]."""
        inside = jnp.einsum("eij,ej->ei", self.stiffness, self.incidence.to_corners(pressure))
        return self.struck(wall) - self.free * self.incidence.to_nodes(inside) / self.mass

    def struck(self, wall: Float[Array, "structure 2"]) -> Float[Array, " nodes"]:
        """What an acceleration of the wall [m/s²] adds to p̈ [Pa/s²], or a sudden velocity [m/s] to ṗ [Pa/s]."""
        pushed = jnp.sum(self.outward * wall[self.wall], axis=1)
        return -self.free * self.density * added_at(self.wet, pushed, len(self.mass)) / self.mass

    def energy(
        self, pressure: Float[Array, " nodes"], before: Float[Array, " nodes"], after: Float[Array, " nodes"]
    ) -> Float[Array, ""]:
        """Of compression and of motion [J]. ``before``, ``after``: ∫p dt half a step before and after [Pa s]."""
        corners = self.incidence.to_corners
        moving = jnp.einsum("ei,eij,ej->", corners(before), self.stiffness, corners(after))
        return 0.5 * (jnp.sum(self.mass * pressure**2) + moving) / self.density

    def fastest(self) -> Float[Array, ""]:
        """A bound of the highest natural frequency between rigid walls [rad/s]."""
        own = self.incidence.to_corners(self.mass)
        share = self.stiffness / jnp.sqrt(own[:, :, None] * own[:, None])
        return jnp.sqrt(jnp.max(self.incidence.to_nodes(jnp.sum(jnp.abs(share), axis=2))))


def element_matrices(
    positions: Float[Array, "nodes 2"], corners: np.ndarray, sound_speed: Scalar
) -> tuple[Float[Array, "elements 4 4"], Float[Array, "elements 4 4"]]:
    """K_f [-] and the consistent M_f [s²] of each element.

    **Arguments:** ``positions`` [m]; ``corners``: (elements, 4), counter-clockwise; ``sound_speed``: c [m/s].
    """
    at = jnp.asarray(positions, float)[corners]
    rule = Rule.of()
    weight, _, gradient = Mapping.of(at, rule)
    stiffness = jnp.einsum("ep,epci,epdi->ecd", weight, gradient, gradient)
    mass = jnp.einsum("ep,pc,pd->ecd", weight, rule.shapes, rule.shapes) / sound_speed**2
    return stiffness, mass
