"""Upright bars of linear elements with lumped masses, on the y axis, and how to follow them."""

from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from jaxbuffer.structures import Bars, FiniteElementSystem, Rods
from jaxbuffer.structures.central_differences import advance


class Bar(NamedTuple):
    """From one height to another [m]."""

    low: float
    high: float


def system(
    bars: Sequence[Bar],
    elements: int,
    *,
    young: float,
    density: float,
    section: float = 1.0,
    gravity: float = 0.0,
    contacts=(),
    held: Sequence[int] = (),
    points: Sequence[tuple[float, float]] = (),
) -> FiniteElementSystem:
    """Nodes come one bar after the other, then ``points``: (height [m], inverse mass [1/kg])."""
    heights = np.concatenate([np.linspace(*bar, elements + 1) for bar in bars] + [[height for height, _ in points]])
    first = np.arange(len(bars)) * (elements + 1)
    ends = np.concatenate([np.stack([k + np.arange(elements), k + np.arange(elements) + 1], axis=1) for k in first])
    positions = jnp.asarray(np.stack([np.zeros_like(heights), heights], axis=1))
    rods = Rods(Bars.of(positions, ends, section), young, density)
    inverse = np.zeros(positions.shape)
    own = len(heights) - len(points)
    inverse[:own, 1] = 1.0 / np.asarray(rods.mass())[:own]
    inverse[own:, 1] = [mass for _, mass in points]
    inverse[list(held)] = 0.0
    return FiniteElementSystem(
        positions, jnp.asarray(inverse), (rods,), tuple(contacts), gravity=jnp.array([0.0, -gravity])
    )


class Followed(NamedTuple):
    """Heights' displacements (steps, nodes), speeds, contact force (steps, pairs), energies at each instant."""

    displacement: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    energies: np.ndarray


def follow(bars: FiniteElementSystem, velocity, step: float, steps: int) -> Followed:
    """``velocity``: (nodes,) of all half a step before the start [m/s]."""
    speeds = np.stack([np.zeros_like(velocity), velocity], axis=1)

    def one(state, _):
        after, seen = advance(bars, state, step, bars.search(state.displacement))
        forces = jnp.concatenate([found.normal for found in seen.contacts]) if seen.contacts else jnp.zeros(0)
        return after, (seen.displacement[:, 1], seen.velocity[:, 1], forces, jnp.stack(seen.energies))

    return Followed(*map(np.asarray, jax.jit(lambda v: jax.lax.scan(one, bars.start(v), length=steps)[1])(speeds)))
