"""The shear below a surface that is struck: on the axis of a Hertzian pressure (M159)."""

import jax.numpy as jnp

from .._types import Scalar, Values


def hertz_shear(depth: Values | Scalar, poisson: Scalar) -> Values:
    """Return the largest shear stress at a depth on the axis of a Hertzian pressure, over the pressure's peak.

    The peak pressure may change with time, q0(t): the shear follows it. The tank paper's eq. 1 is the difference of the
    principal stresses, twice this (docs/model.md, slips).

    **Arguments:** ``depth``: s, over the radius of the contact [-]; ``poisson``: ν [-].

    **Returns:** τ/q0 [-].

    **Source:** Johnson, Contact Mechanics, section 3.4.

    **Example:** the best known of them: 0.31 of the peak pressure, half a radius below the surface.

    >>> f"{float(hertz_shear(0.481, 0.3)):.3f}"
    '0.310'
    """
    s = jnp.asarray(depth, float)
    radial = (1.0 + poisson) * (1.0 - s * jnp.arctan2(1.0, s)) - 0.5 / (1.0 + s * s)
    return 0.5 * jnp.abs(1.0 / (1.0 + s * s) - radial)
