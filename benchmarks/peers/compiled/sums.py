"""Sums of stages with constant weights, compiled one by one: no loop over a tableau, nothing multiplied by nought."""

from __future__ import annotations

import numpy as np
from numba import njit

from ..parameters import Vector
from ..start import STATES


def weighted(weights: Vector):
    """A compiled function of the stages ``k`` (rows of 25, one after another) and a place: the sum with ``weights``."""
    places = np.flatnonzero(weights)
    values, rows, count = weights[places], places * STATES, len(places)

    @njit(inline="always", fastmath={"contract", "reassoc", "nsz"})
    def total(k, i):
        result = values[0] * k[rows[0] + i]
        for j in range(1, count):
            result += values[j] * k[rows[j] + i]
        return result

    return total
