"""The sweep's grid: approach speed by misalignment by contact distance, 10 000 captures of Table 2's design."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .peers.parameters import Parameters

if TYPE_CHECKING:
    from jaxbuffer import Scenario

SPEEDS = np.linspace(0.05, 0.25, 25)  # [m/s]
MISALIGNMENTS = np.linspace(-0.1, 0.1, 20)  # [rad]
DISTANCES = np.linspace(0.02, 0.06, 20)  # [m]
SIZE = SPEEDS.size * MISALIGNMENTS.size * DISTANCES.size


def points(count: int) -> NDArray[np.float64]:
    """``count`` points (count, 3) of the grid [m/s, rad, m], drawn by chance but always the same, in the grid's order.

    More than there are repeat the grid.
    """
    every = np.stack(np.meshgrid(SPEEDS, MISALIGNMENTS, DISTANCES, indexing="ij"), axis=-1).reshape(-1, 3)
    drawn = np.random.default_rng(0).permutation(SIZE)[: count % SIZE]
    return np.concatenate([np.tile(every, (count // SIZE, 1)), every[np.sort(drawn)]])


def parameters(count: int) -> list[Parameters]:
    """The points as the peers read them."""
    return [
        Parameters(approach_speed=float(speed), misalignment=float(angle), contact_distance=float(distance))
        for speed, angle, distance in points(count)
    ]


def own_scenarios(cases: Sequence[Parameters]) -> Scenario:
    """The scenarios of the ``cases`` as the product reads them, leaves (cases,)."""
    from jaxbuffer import Scenario

    names = ("approach_speed", "contact_distance", "misalignment", "passive_rate")
    return Scenario(**{name: np.array([getattr(case, name) for case in cases]) for name in names})
