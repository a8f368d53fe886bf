"""What a bar's modal coordinates mean along it: deflection, axial force, bending moment, stress (M118).

Stations are Python's numbers, 0 at the start of the bar and 1 at its end; values follow in their order. Moments need
more modes than deflections do: print the number of modes with them.
"""

from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._types import Scalar
from .bar import FlexibleBar
from .modes import Modal

Stations = Sequence[float] | np.ndarray
AtStations = Float[Array, " stations"]


def deflection(body: FlexibleBar, q: Modal, stations: Stations) -> Float[Array, "stations 2"]:
    """Return the (stations, 2) displacement Φ q along and across the bar, in the body's axes [m].

    **Arguments:** ``body``: the bar; ``q``: (modes,) modal coordinates [m]; ``stations``: ξ = 0…1.
    """
    xi, lateral = np.array(stations), body.lateral
    along = _combined(body.shapes.axial(xi, 0), q[lateral:])
    return jnp.stack([along, _combined(body.shapes.lateral(xi, 0), q[:lateral])], axis=1)


def axial_force(body: FlexibleBar, q: Modal, stations: Stations) -> AtStations:
    """Return the (stations,) axial force N = E A u′, positive in tension [N]. **Arguments:** as `deflection` has
    them."""
    strain = _combined(body.shapes.axial(np.array(stations), 1), q[body.lateral :]) / body.bar.length
    return body.bar.axial_stiffness * strain


def bending_moment(body: FlexibleBar, q: Modal, stations: Stations) -> AtStations:
    """Return the (stations,) bending moment M = E I w″, positive where the side of negative y is stretched [N m].

    **Arguments:** as `deflection` has them.
    """
    curvature = _combined(body.shapes.lateral(np.array(stations), 2), q[: body.lateral]) / body.bar.length**2
    return body.bar.bending_stiffness * curvature


def stress(body: FlexibleBar, q: Modal, stations: Stations, y: Scalar) -> AtStations:
    """Return the (stations,) stress σ = N/A - M y/I along the bar, positive in tension [Pa].

    **Arguments:** as `deflection` has them; ``y``: place in the section, across the bar's axis [m].
    """
    bent = bending_moment(body, q, stations) * (y / body.bar.second_moment)
    return axial_force(body, q, stations) / body.bar.area - bent


def _combined(shapes: np.ndarray, q: Modal) -> AtStations:
    """Sum (stations, modes) shapes times (modes,) coordinates."""
    return jnp.sum(jnp.asarray(shapes) * q[None, :], axis=1)
