"""A plate with holes that stands in a liquid: what flows through it, and what that does to both (M204, M205)."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._types import Scalar
from .incidence import added_at


class Holes(NamedTuple):
    """What the holes of a plate are like for a liquid (M205).

    - ``inertia``: τ, length of liquid that is accelerated with the flow, over the open share [m].
    - ``carried``: κ, the share of the plate's own motion in which the liquid in the holes takes part [-].
    - ``loss``: ζ, pressure lost over ρq²/2 [-].
    - ``added``: length of liquid that moves with the plate as if it were part of it [m].
    """

    inertia: Scalar
    carried: Scalar
    loss: Scalar
    added: Scalar

    @staticmethod
    def of(thickness: Scalar, diameter: Scalar, aperture: Scalar) -> "Holes":
        """Make round holes with sharp edges that have the share ``aperture`` of the area together [-]."""
        aperture = jnp.asarray(aperture, float)
        root = jnp.sqrt(aperture)
        beyond = 0.85 * diameter * (1.0 - 1.47 * root + 0.47 * root**3)
        inertia = (thickness + beyond) / aperture
        contracted = 0.63 + 0.37 * aperture**3
        loss = (1.0 / (contracted * aperture) - 1.0) ** 2
        return Holes(inertia, thickness / inertia, loss, thickness * aperture * beyond / (thickness + beyond))


class Through(NamedTuple):
    """A step of the flow through a plate.

    - ``after``: (pairs,) s half a step later [m/s].
    - ``kinetic``: of the liquid in the holes [J]; ``half``, ``whole``: energy lost there in the step's first half and
      in all of it [J].
    """

    after: Float[Array, " pairs"]
    kinetic: Float[Array, ""]
    half: Float[Array, ""]
    whole: Float[Array, ""]

    @staticmethod
    def none(before: Float[Array, " pairs"]) -> "Through":
        """Return the flow without a plate: none."""
        return Through(before, *(jnp.zeros(()),) * 3)


class Perforated(NamedTuple):
    """An upright plate, a metre deep, with a liquid on either side whose nodes lie opposite each other.

    The flow q, volume over area and time against the plate's velocity v, and that are known by s = q + κ v.

    - ``left``, ``right``: (pairs,) the liquid's nodes on either side; ``area``: of the plate that belongs to each [m²].
    - ``plate``: (rows, across) the structure's nodes; ``shares``: (pairs, rows) of each row in the plate's place there.
    - ``holes``: in it; ``density``: ρ of the liquid [kg/m³].
    """

    left: Int[np.ndarray, " pairs"]
    right: Int[np.ndarray, " pairs"]
    area: Float[Array, " pairs"]
    plate: Int[np.ndarray, "rows across"]
    shares: Float[Array, "pairs rows"]
    holes: Holes
    density: Scalar

    def jump(self, pressure: Float[Array, " liquid"]) -> Float[Array, " pairs"]:
        """Return by how much the pressure on the left is above that on the right [Pa]."""
        return pressure[self.left] - pressure[self.right]

    def moved(self, velocity: Float[Array, "structure 2"]) -> Float[Array, " pairs"]:
        """Return the plate's velocity there, to the right [m/s]."""
        return self.shares @ jnp.mean(velocity[self.plate, 0], axis=1)

    def resistance(
        self, velocity: Float[Array, "structure 2"], before: Float[Array, " pairs"], step: Scalar
    ) -> Float[Array, " pairs"]:
        """Return R [Pa], ρ ζ |q| q/2 of the flow half a step before, less by what it brakes that itself, so that no
        step is too long for it."""
        flow = before - self.holes.carried * self.moved(velocity)
        braking = 0.5 * self.holes.loss * jnp.abs(flow)
        return self.density * braking * flow / (1.0 + step * braking / self.holes.inertia)

    def push(
        self, pressure: Float[Array, " liquid"], resistance: Float[Array, " pairs"], structure: int
    ) -> Float[Array, "structure 2"]:
        """Return the liquid's forces on the plate [N]."""
        on_plate = (1.0 - self.holes.carried) * self.jump(pressure) + self.holes.carried * resistance
        rows = self.shares.T @ (self.area * on_plate) / self.plate.shape[1]
        # An upright plate is pushed along its normal alone.
        sideways = added_at(self.plate.ravel(), jnp.repeat(rows, self.plate.shape[1]), structure)
        return jnp.stack([sideways, jnp.zeros(structure)], axis=1)

    def swept(
        self, velocity: Float[Array, "structure 2"], through: Float[Array, " pairs"], liquid: int
    ) -> Float[Array, " liquid"]:
        """Return the volume over time that leaves the liquid at each of its nodes [m²/s], by the plate's ``velocity``
        and s, or the rate of that by their rates."""
        across = self.area * ((1.0 - self.holes.carried) * self.moved(velocity) + through)
        return added_at(np.concatenate([self.left, self.right]), jnp.concatenate([across, -across]), liquid)

    def flow(
        self,
        pressure: Float[Array, " liquid"],
        resistance: Float[Array, " pairs"],
        before: Float[Array, " pairs"],
        velocity: tuple[Float[Array, "structure 2"], Float[Array, "structure 2"]],
        step: Scalar,
    ) -> Through:
        """Take a step of ρ τ ṡ = jump - R, with the plate's ``velocity`` half a step before and half a step later."""
        after = before + step * (self.jump(pressure) - resistance) / (self.density * self.holes.inertia)
        first, last = (s - self.holes.carried * self.moved(v) for s, v in zip((before, after), velocity, strict=True))
        lost = 0.5 * step * self.area * resistance
        # The flows half a step before and after, not a square, as in M127: with them the sum of energies is constant.
        kinetic = 0.5 * self.density * self.holes.inertia * jnp.sum(self.area * before * after)
        return Through(after, kinetic, jnp.sum(lost * first), jnp.sum(lost * (first + last)))

    def added_mass(self) -> Float[Array, "rows across"]:
        """Return the mass of liquid that moves with the plate's nodes sideways [kg]."""
        rows = self.density * self.holes.added * (self.shares.T @ self.area) / self.plate.shape[1]
        return jnp.repeat(rows[:, None], self.plate.shape[1], axis=1)

    def fastest(
        self, mass: Float[Array, " liquid"], free: Float[Array, " liquid"], inverse_mass: Float[Array, "structure 2"]
    ) -> Float[Array, ""]:
        """Return what plate and holes add to the square of the system's highest frequency, at most [1/s²]: the largest
        row sum of what jumps do to a jump. ``mass``: of the liquid's nodes [s²]; ``free``: 0 where no pressure can
        be."""
        softer = free[self.left] / mass[self.left] + free[self.right] / mass[self.right]
        rows = (1.0 - self.holes.carried) ** 2 * (self.shares.T @ self.area) / self.plate.shape[1]
        moved = self.shares @ jnp.mean(rows[:, None] * inverse_mass[self.plate, 0], axis=1)
        return jnp.max(self.area * softer * (self.density * moved + 1.0 / self.holes.inertia))


def at_heights(heights: Float[Array, " pairs"], rows: Float[Array, " rows"]) -> Float[Array, "pairs rows"]:
    """Return the shares of the plate's ``rows`` [m], which follow each other upwards, in its place at some ``heights``
    [m]."""
    # Interpolating each row's unit vector gives its shares.
    return jax.vmap(lambda of_row: jnp.interp(heights, rows, of_row), out_axes=1)(jnp.eye(len(rows)))
