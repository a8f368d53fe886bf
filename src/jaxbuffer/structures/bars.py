"""Bars: two-node elements that carry a force along them (M138)."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar
from .incidence import Incidence


class Bars(NamedTuple):
    """Two-node elements under small strain.

    - ``incidence``: which nodes the ends are.
    - ``direction``: (elements, 2) from the first end to the second [-].
    - ``length``: (elements,) [m].
    - ``section``: area [m²].
    """

    incidence: Incidence
    direction: Float[Array, "elements 2"]
    length: Float[Array, " elements"]
    section: Scalar

    @staticmethod
    def of(positions: Float[Array, "nodes 2"], ends: np.ndarray, section: Scalar) -> "Bars":
        """Make bars from the nodes' positions [m], the ends' nodes (elements, 2) and the section's area [m²]."""
        incidence = Incidence.of(ends, len(positions))
        at = incidence.to_corners(jnp.asarray(positions, float))
        along = at[:, 1] - at[:, 0]
        length = jnp.linalg.norm(along, axis=1)
        return Bars(incidence, along / length[:, None], length, section)

    def strains(self, displacements: Float[Array, "elements 2 2"]) -> Float[Array, " elements"]:
        """Return the (elements,) strains [-] from the ends' displacements [m]."""
        return jnp.sum((displacements[:, 1] - displacements[:, 0]) * self.direction, axis=1) / self.length

    def forces(self, stress: Float[Array, " elements"]) -> Float[Array, "elements 2 2"]:
        """Return the forces with which the bars resist, at their ends [N]. ``stress``: (elements,) [Pa]."""
        pull = (stress * self.section)[:, None] * self.direction
        return jnp.stack([-pull, pull], axis=1)

    def lumped_mass(self, density: Scalar) -> Float[Array, " nodes"]:
        """Return the (nodes,) lumped masses, half of each bar's mass at each of its ends (M129) [kg]. ``density``:
        [kg/m³]."""
        half = 0.5 * density * self.section * self.length
        return self.incidence.to_nodes(jnp.repeat(half[:, None], 2, axis=1))
