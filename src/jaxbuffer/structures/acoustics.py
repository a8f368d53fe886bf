"""A liquid as a linear acoustic medium: pressure on a conforming mesh, coupled to a wall (M147 to M149).

    [M_s   0 ] [ü]   [K_s -A ] [u]   [F]
    [ρAᵀ  M_f] [p̈] + [ 0  K_f] [p] = [0]

with K_f = ∫∇N∇N, M_f = ∫NN/c². The tank paper's eq. 4 lacks ρ in the mass coupling and repeats Aᵀ in the stiffness,
where 0 belongs.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._types import Scalar
from .boundary import boundary_areas
from .incidence import Incidence, added_at
from .mapping import Mapping, Rule
from .perforated import Perforated


class Cover(NamedTuple):
    """A wall above a free surface, which may come down on it.

    - ``surface``: (pairs,) nodes of the surface, ``width``: the area of each [m²].
    - ``wall``: (pairs, 2) nodes of the wall above it, ``shares``: (pairs, 2) of each in the wall's height there.
    - ``gap``: (pairs,) between surface and wall at rest [m].
    """

    surface: Int[np.ndarray, " pairs"]
    width: Float[Array, " pairs"]
    wall: Int[Array, "pairs 2"]
    shares: Float[Array, "pairs 2"]
    gap: Float[Array, " pairs"]

    @staticmethod
    def of(
        surface: np.ndarray, at: Float[Array, "pairs 2"], wall: np.ndarray, above: Float[Array, "nodes 2"]
    ) -> "Cover":
        """Put the wall's nodes ``wall`` at ``above`` [m], from left to right, over the nodes ``surface`` ``at`` [m];
        both begin at x = 0 or at a wall on the left. A node on a wall counts where its strip's middle is."""
        x, width = above[:, 0], jnp.abs(boundary_areas(at)[:, 1])
        x = jnp.where(x < 0.0, jax.lax.cummin(x, reverse=True), jax.lax.cummax(x))  # walls that lean out over it
        # On the axis of a half the first node's strip goes on in the mirror image; on a wall it is on one side alone.
        first = jnp.where(at[0, 0] < -width[0], 0.5 * width[0], 0.0)
        places = at[:, 0].at[-1].add(-0.5 * width[-1]).at[0].add(first)
        # A place beyond the wall's first or last node goes on in line with its last two.
        after = jnp.clip(jnp.searchsorted(x, places, side="right"), 1, len(wall) - 1)
        near = jnp.stack([after - 1, after], axis=1)
        share = (places - x[near[:, 0]]) / (x[near[:, 1]] - x[near[:, 0]])
        shares = jnp.stack([1.0 - share, share], axis=1)
        return Cover(
            surface, width, jnp.asarray(wall)[near], shares, jnp.sum(shares * above[near, 1], axis=1) - at[:, 1]
        )

    def overlap(
        self, displacement: Float[Array, "structure 2"], raised: Float[Array, " pairs"]
    ) -> Float[Array, " pairs"]:
        """Return the volume by which liquid and wall would overlap at each node [m²]; ``raised``: of the liquid that
        has gone up through the surface [m²]."""
        moved = jnp.sum(self.shares * displacement[self.wall, 1], axis=1)
        # A wall that comes up from the surface does not pull it along.
        return jnp.maximum(raised - self.width * (self.gap + moved), 0.0)

    def push(self, pressure: Float[Array, " pairs"], structure: int) -> Float[Array, "structure 2"]:
        """Return what the ``pressure`` [Pa] on its surface does to the wall [N]."""
        up = (self.width * pressure)[:, None] * self.shares
        # Which nodes are above follows from positions that may be traced: no gather can be prepared (see `added_at`).
        return jnp.zeros((structure, 2)).at[self.wall, 1].add(up)


class Liquid(NamedTuple):
    """A liquid, a metre deep.

    - ``incidence``: which nodes the elements' corners are, counted among the liquid's own.
    - ``stiffness``: (elements, 4, 4) K_f of each element [-].
    - ``mass``: (nodes,) M_f, lumped [s²].
    - ``free``: (nodes,) 1, or 0 where the pressure is held at zero: on the free surface.
    - ``density``: ρ [kg/m³].
    - ``wall``: (pairs,) the wall's nodes, and ``wet``: the liquid's nodes in the same places.
    - ``outward``: (pairs, 2) area of the wall that belongs to each, times its normal out of the liquid: A [m²].
    - ``follows``: whether A is that of the wall as it moves, so that the volume which it encloses is exact; K_f and M_f
      remain those of the mesh at rest.
    - ``cover``: above its surface, or None. What lies half an element below the surface is compressed where both meet.
    - ``plate``: that stands in it, or None.
    """

    incidence: Incidence
    stiffness: Float[Array, "elements 4 4"]
    mass: Float[Array, " nodes"]
    free: Float[Array, " nodes"]
    density: Scalar
    wall: Int[np.ndarray, " pairs"]
    wet: Int[np.ndarray, " pairs"]
    outward: Float[Array, "pairs 2"]
    follows: bool = False
    cover: Cover | None = None
    plate: Perforated | None = None

    def push(
        self, pressure: Float[Array, " nodes"], structure: int, positions: Float[Array, "structure 2"] | None = None
    ) -> Float[Array, "structure 2"]:
        """Return A p: what the liquid does to the ``structure`` nodes of the wall's mesh [N], at rest or at
        ``positions``."""
        outward = self.outward if positions is None else boundary_areas(positions[self.wall])
        return added_at(self.wall, pressure[self.wet][:, None] * outward, structure)

    def _swept(
        self, outward: Float[Array, "pairs 2"], wall: Float[Array, "structure 2"], through: Float[Array, " holes"]
    ) -> Float[Array, " nodes"]:
        """Return the volume over time that leaves the liquid at each node [m²/s], by velocities of the wall and through
        a plate [m/s]."""
        swept = added_at(self.wet, jnp.sum(outward * wall[self.wall], axis=1), len(self.mass))
        return swept if self.plate is None else swept + self.plate.swept(wall, through, len(self.mass))

    def rate(
        self,
        impulse: Float[Array, " nodes"],
        velocity: Float[Array, "structure 2"],
        through: Float[Array, " holes"],
        positions: Float[Array, "structure 2"],
    ) -> Float[Array, " nodes"]:
        """Return ṗ [Pa/s] of a liquid that `follows`, from ∫p dt [Pa s] and the wall at one instant: M147 integrated
        once."""
        swept = self._swept(boundary_areas(positions[self.wall]), velocity, through)
        inside = jnp.einsum("eij,ej->ei", self.stiffness, self.incidence.to_corners(impulse))
        return -self.free * (self.density * swept + self.incidence.to_nodes(inside)) / self.mass

    def acceleration(
        self, pressure: Float[Array, " nodes"], wall: Float[Array, "structure 2"], through: Float[Array, " holes"]
    ) -> Float[Array, " nodes"]:
        """Return p̈ [Pa/s²] under the accelerations of wall and plate, and of what flows through it [m/s²]."""
        inside = jnp.einsum("eij,ej->ei", self.stiffness, self.incidence.to_corners(pressure))
        return self.struck(wall, through) - self.free * self.incidence.to_nodes(inside) / self.mass

    def struck(self, wall: Float[Array, "structure 2"], through: Float[Array, " holes"]) -> Float[Array, " nodes"]:
        """Return what accelerations of the wall and through a plate [m/s²] add to p̈ [Pa/s²], or sudden velocities
        [m/s] to ṗ [Pa/s]."""
        return -self.free * self.density * self._swept(self.outward, wall, through) / self.mass

    def met(
        self,
        pressure: Float[Array, " nodes"],
        displacement: Float[Array, "structure 2"],
        raised: Float[Array, " pairs"],
    ) -> Float[Array, " nodes"]:
        """Return the pressure with that of the surface below its cover [Pa]: M_f p = ρ times the volume of the
        overlap."""
        if self.cover is None:
            return pressure
        met = self.density * self.cover.overlap(displacement, raised) / self.mass[self.cover.surface]
        return pressure.at[self.cover.surface].set(met)

    def rising(
        self, impulse: Float[Array, " nodes"], velocity: Float[Array, "structure 2"], through: Float[Array, " holes"]
    ) -> Float[Array, " pairs"]:
        """Return the volume that goes up through the surface in a second [m²/s]: what M147, integrated once, leaves
        there."""
        if self.cover is None:
            return jnp.zeros(0)
        inside = jnp.einsum("eij,ej->ei", self.stiffness, self.incidence.to_corners(impulse))
        swept = self._swept(self.outward, velocity, through)
        return -(self.incidence.to_nodes(inside) / self.density + swept)[self.cover.surface]

    def energy(
        self, pressure: Float[Array, " nodes"], before: Float[Array, " nodes"], after: Float[Array, " nodes"]
    ) -> Float[Array, ""]:
        """Return the energy of compression and of motion [J]. ``before``, ``after``: ∫p dt half a step before and after
        [Pa s]."""
        corners = self.incidence.to_corners
        # Of half steps before and after, as in M149: with them the sum of energies is constant but for rounding.
        moving = jnp.einsum("ei,eij,ej->", corners(before), self.stiffness, corners(after))
        return 0.5 * (jnp.sum(self.mass * pressure**2) + moving) / self.density

    def fastest(self) -> Float[Array, ""]:
        """Return a bound of the highest natural frequency between rigid walls [rad/s]."""
        own = self.incidence.to_corners(self.mass)
        # No eigenvalue exceeds the largest sum of a row's sizes (Gershgorin), and a bound is enough for a stable step.
        share = self.stiffness / jnp.sqrt(own[:, :, None] * own[:, None])
        return jnp.sqrt(jnp.max(self.incidence.to_nodes(jnp.sum(jnp.abs(share), axis=2))))


def element_matrices(
    positions: Float[Array, "nodes 2"], corners: np.ndarray, sound_speed: Scalar
) -> tuple[Float[Array, "elements 4 4"], Float[Array, "elements 4 4"]]:
    """Return K_f [-] and the consistent M_f [s²] of each element.

    **Arguments:** ``positions`` [m]; ``corners``: (elements, 4), counter-clockwise; ``sound_speed``: c [m/s].
    """
    at = jnp.asarray(positions, float)[corners]
    rule = Rule.of()
    weight, _, gradient = Mapping.of(at, rule)
    stiffness = jnp.einsum("ep,epci,epdi->ecd", weight, gradient, gradient)
    mass = jnp.einsum("ep,pc,pd->ecd", weight, rule.shapes, rule.shapes) / sound_speed**2
    return stiffness, mass
