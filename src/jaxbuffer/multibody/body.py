"""A rigid body."""

import equinox as eqx

from .._types import Scalar
from ..space.basis import Inertia
from .flexible.modes import Marker


class Body(eqx.Module):
    """A rigid body.

    - ``mass``: [kg].
    - ``inertia``: about its centre of mass; in space (x, y, z), about its axes, which are principal ones [kg m²].
    """

    mass: Scalar
    inertia: Scalar | Inertia

    @property
    def centre_of_mass(self) -> tuple[Scalar, Scalar] | Marker:
        """Return where its weight acts."""
        # The origin of a rigid body's frame is its centre of mass.
        return (0.0, 0.0)
