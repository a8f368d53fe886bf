"""Air that is shut in above a liquid: a uniform pressure by the volume that is left to it."""

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar
from .boundary import boundary_areas, enclosed
from .incidence import added_at

EXPONENT = 1.4  # of air without time to exchange heat


class Gas(eqx.Module):
    """A gas that presses on a whole wall, at once on its dry part and through a liquid that it cannot compress.

    - ``wall``: (nodes,) that enclose gas and liquid, as of `enclosed`.
    - ``volume``: of the gas at the start, ``whole``: of gas and liquid then [m²].
    - ``pressure``: absolute, at the start [Pa]; outside it is the same always.
    """

    wall: np.ndarray
    volume: Float[Array, ""]
    whole: Float[Array, ""]
    pressure: Scalar

    def share(self, positions: Float[Array, "nodes 2"]) -> Float[Array, ""]:
        """Return V/V0, the share of the volume at the start [-]."""
        # The liquid keeps its volume: the gas alone takes what the wall encloses less or more.
        return 1.0 + (enclosed(positions[self.wall]) - self.whole) / self.volume

    def overpressure(self, positions: Float[Array, "nodes 2"]) -> Float[Array, ""]:
        """Return the overpressure of the gas over the outside [Pa]: p0 ((V0/V)^γ - 1)."""
        return self.pressure * (self.share(positions) ** -EXPONENT - 1.0)

    def push(self, positions: Float[Array, "nodes 2"]) -> Float[Array, "nodes 2"]:
        """Return the gas's forces on the nodes [N]."""
        # The outside presses on the other side of the wall: only the difference acts.
        forces = self.overpressure(positions) * boundary_areas(positions[self.wall])
        return added_at(self.wall, forces, len(positions))

    def energy(self, positions: Float[Array, "nodes 2"]) -> Float[Array, ""]:
        """Return the energy stored in it, less what the outside has done [J]: the integral of -(p - p0) dV."""
        share = self.share(positions)
        stored = (share ** (1.0 - EXPONENT) - 1.0) / (EXPONENT - 1.0) + share - 1.0
        return self.pressure * self.volume * stored
