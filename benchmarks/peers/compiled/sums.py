"""Sums of stages with constant weights, compiled one by one: no loop over a tableau, nothing multiplied by nought."""

from __future__ import annotations

import numpy as np
from numba import njit

from ..parameters import Vector


def weighted(weights: Vector, states: int):
    """A compiled function of the stages ``k`` (rows of so many ``states``, one after another) and a place: the sum with
    ``weights``."""
    places = np.flatnonzero(weights)
    values, rows, count = weights[places], places * states, len(places)

    @njit(inline="always", fastmath={"contract", "reassoc", "nsz"})
    def total(k, i):
        result = values[0] * k[rows[0] + i]
        for j in range(1, count):
            result += values[j] * k[rows[j] + i]
        return result

    return total
