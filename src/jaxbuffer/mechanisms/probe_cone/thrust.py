"""A thrust that pushes the active vehicle along its axis for a while (M178)."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar, stacked
from ...multibody import Kinematics, Load
from ...plane import Vector
from .assembly import S


class Thrust(eqx.Module):
    """A force of ``size`` [N] through the centre of mass of S, for ``time`` [s] from the start."""

    size: Scalar
    time: Scalar

    def force(self, kin: Kinematics, pushing: Scalar) -> Vector:
        """Return the force [N]; ``pushing``: 1 while it acts, then 0."""
        frame = kin.frame(S)
        return Vector(frame.cos, frame.sin) * (self.size * pushing)

    def load(self, kin: Kinematics, pushing: Scalar) -> Load:
        """Return what acts on S."""
        return Load(S, self.force(kin, pushing), jnp.zeros(()))

    def rates(self, kin: Kinematics, pushing: Scalar) -> Float[Array, " 4"]:
        """Return the power that it puts in [W], its force along x and y [N] and its moment about the origin [N m]."""
        force, frame = self.force(kin, pushing), kin.frame(S)
        return stacked([force.dot(frame.velocity), force.x, force.y, frame.origin.cross(force)])
