"""A soft layer under a rigid plane: a cushion between the plane and the nodes it meets (M146)."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._types import Scalar
from .forces import NodeContactForces
from .surfaces import RigidPlane

SOLID = 0.8  # of the layer's thickness: compressed further, it is solid


class Layer(eqx.Module):
    """A cushion that is bonded to a rigid plane and presses on nodes, each by its own strip of it, never pulls.

    It is a spring and a damper in parallel until `SOLID` of its thickness is used up; from then on ``solid`` stiffness
    is added, so that its end is felt.

    - ``slaves``: (nodes,) that it meets.
    - ``plane``: what it is bonded to, with its free surface ``thickness`` [m] from it.
    - ``width``: (nodes,) of each node's strip [m²].
    - ``stiffness`` [Pa/m], ``damping`` [Pa s/m]: of an area; ``solid``: added where it is solid [Pa/m].
    """

    slaves: np.ndarray
    plane: RigidPlane
    width: Float[Array, " nodes"]
    thickness: Scalar
    stiffness: Scalar
    damping: Scalar
    solid: Scalar

    def compression(self, positions: Float[Array, "nodes 2"]) -> Float[Array, " pressed"]:
        """Return by how much it is pressed together at each of its nodes (nodes,), negative where it is not met [m]."""
        return self.thickness - self.plane.pairs(self.slaves, positions, None).gap

    def forces(self, positions: Float[Array, "nodes 2"], velocity: Float[Array, "nodes 2"]) -> NodeContactForces:
        """Return the forces that it adds in one step. ``positions`` [m]; ``velocity``: half a step before [m/s]."""
        pairs = self.plane.pairs(self.slaves, positions, None)
        depth = self.thickness - pairs.gap
        pressed = jnp.maximum(depth, 0.0)
        beyond = jnp.maximum(depth - SOLID * self.thickness, 0.0)
        rate = -pairs.along(self.slaves, velocity, pairs.normal)
        # The damper has no part before the layer is met.
        pressure = self.stiffness * pressed + self.solid * beyond + self.damping * rate * (depth > 0.0)
        normal = self.width * jnp.maximum(pressure, 0.0) * (depth > 0.0)
        force = normal[:, None] * pairs.normal
        return NodeContactForces(self.plane.on_nodes(self.slaves, force, len(positions)), normal, normal)

    def fastest(self, inverse_mass: Float[Array, "nodes 2"]) -> Float[Array, ""]:
        """Return the highest natural frequency of a node on the solid layer [rad/s]."""
        return jnp.sqrt(jnp.max((self.stiffness + self.solid) * self.width * inverse_mass[self.slaves, 1]))
