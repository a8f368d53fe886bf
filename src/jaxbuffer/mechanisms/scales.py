"""What errors in each number of an assembled mechanism's state are compared with, and how fast each decays."""

from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array

from .._types import Scalar
from ..elements import Magnitudes
from .layout import EvaluatedState, Layout, State


def scales(layout: Layout, size: tuple[Any, Any], magnitudes: Magnitudes) -> State:
    """Return the magnitude below which an error in each number of the state does not matter in itself. ``size``: those
    of the coordinates and of the velocities, one for all or one for each."""
    counts = layout.coordinates, layout.velocities
    place, motion = (jnp.broadcast_to(jnp.asarray(it, float), (n,)) for it, n in zip(size, counts, strict=True))
    return layout.state(
        q=place,
        v=motion,
        lost=[magnitudes.energy] * layout.losses,
        first_energy=magnitudes.energy,
        own=[element.scales(magnitudes) for element in layout.elements],
        time=1.0,
    )


def scale_limits(layout: Layout) -> State | None:
    """Return the largest magnitude that an error in each number may be relative to; None if of all."""
    return _of_elements(layout, [element.scale_limits() for element in layout.elements], jnp.inf)


def decays(layout: Layout, at: EvaluatedState) -> Array | None:
    """Return the rates at which what follows the velocities in the state decays by itself [1/s]; None where nothing
    does."""
    pairs = zip(layout.elements, at.elements, strict=True)
    whole = _of_elements(layout, [element.decays(it) for element, it in pairs], 0.0)
    return None if whole is None else whole[layout.places["spins"].stop :]


def _of_elements(layout: Layout, values: Sequence[list[Scalar] | None], otherwise: float) -> State | None:
    """Return what some elements have for each of their numbers, and a value for all others; None if none has any."""
    if all(of is None for of in values):
        return None
    own = [
        [otherwise] * len(element.variables) if of is None else of
        for element, of in zip(layout.elements, values, strict=True)
    ]
    q, v = jnp.full(layout.coordinates, otherwise), jnp.full(layout.velocities, otherwise)
    lost = [otherwise] * layout.losses
    return layout.state(q=q, v=v, lost=lost, first_energy=otherwise, own=own, time=otherwise)
