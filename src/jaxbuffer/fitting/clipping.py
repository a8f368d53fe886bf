"""Rows at which a sensor has met the end of its range: they equal the column's largest or smallest value."""

import numpy as np
from jaxtyping import Bool, Float

REPEATED = 0.05  # share of rows whose value another has, up to which a column has fine digits
FINE, COARSE = 3, 5  # rows of one extreme value from which on they are clipped, in columns of fine and coarse digits
BELOW = 10  # values next to the extreme one that it is compared with
OUTNUMBERED = 3.0  # by which it must have more rows than each of them: a smooth maximum has 2.4 times as many


def clipped_rows(values: Float[np.ndarray, " rows"]) -> Bool[np.ndarray, " rows"]:
    """Return which rows of a column are clipped."""
    low, high = float(np.min(values)), float(np.max(values))
    if low == high:
        return np.zeros(len(values), bool)
    sides = [values == high, values == low]
    # A range that is as long on both sides ends at one size.
    if np.isclose(high, -low, rtol=1e-9, atol=0.0):
        sides = [sides[0] | sides[1]]
    result = np.zeros(len(values), bool)
    for side in sides:
        # What rests where the record begins or ends has one value without being clipped.
        at_an_end = np.cumprod(side) + np.cumprod(side[::-1])[::-1] > 0
        if _is_clipped(values, side & ~at_an_end):
            result |= side & ~at_an_end
    return result


def _is_clipped(values: np.ndarray, side: Bool[np.ndarray, " rows"]) -> bool:
    """Return whether the rows of an extreme value are too many for chance or for the digits of the column."""
    count, others = int(np.sum(side)), np.abs(values[~side])
    each, rows = np.unique(others, return_counts=True)
    fine = np.sum(rows[rows > 1]) <= REPEATED * len(others)
    if count < (FINE if fine else COARSE) or len(each) < BELOW:
        return False
    # The values of a smooth maximum become rarer gradually.
    distances = np.abs(each - float(np.abs(values[side][0])))
    nearest = rows[np.argsort(distances)[:BELOW]]
    return count >= OUTNUMBERED * float(np.max(nearest))
