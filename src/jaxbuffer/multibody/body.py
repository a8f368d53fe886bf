"""A rigid body in the plane."""

import equinox as eqx

from .._types import Scalar


class Body(eqx.Module):
    """A rigid body.

    - ``mass``: [kg].
    - ``inertia``: about its centre of mass [kg m²].
    """

    mass: Scalar
    inertia: Scalar
