"""Weighted residuals of records, smoothed over some rows, and Levenberg and Marquardt's way to their least squares."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import gaussian_filter1d
from scipy.optimize import OptimizeResult, least_squares

SETTLED = -2  # SciPy's status of a search that its callback ended
INSIDE = 1e-9  # of the range of an unknown: SciPy begins strictly within bounds
WIDEST = 1.0  # deviation of an unknown on which the data say nothing, as a share of its range
STICKS_OUT = 5.0  # deviations of the noise, from which on a row weighs less and counts as an outlier
OUTLIERS = 0.015  # share of a column's rows, from which on they are no outliers but what a model does not describe
LEFT = 1e-3  # by which a sum of squares may still fall where a search ends: 1 is a deviation of an unknown
FALL = 1e-2  # of a last step, above what a run's own error makes of the sum: it moves only what is hardly known


class Block(NamedTuple):
    """Residuals of one record: measured less simulated over the noise, ``values`` (columns, rows) [-], with ``slopes``
    by the unknowns (columns, rows, unknowns)."""

    values: Float[np.ndarray, "columns rows"]
    slopes: Float[np.ndarray, "columns rows unknowns"]


Residuals = Callable[[np.ndarray, float], list[Block]]
"""From the scaled unknowns and a share of each record, counted from its beginning, to a block for each record."""


class LeastSquares(NamedTuple):
    """A point of least squares: scaled unknowns ``x``, mean square ``chi`` of the residuals [-], their ``slopes``
    (residuals, unknowns), and whether the search ``converged``: the sum falls no further than noise counts."""

    x: Float[np.ndarray, " unknowns"]
    chi: float
    slopes: Float[np.ndarray, "residuals unknowns"]
    converged: bool


def outliers(values: Float[np.ndarray, "columns rows"]) -> Bool[np.ndarray, "columns rows"]:
    """Return which residuals stick out of columns that are met otherwise."""
    out = np.abs(values) > STICKS_OUT
    return out & (np.mean(out, axis=1, keepdims=True) <= OUTLIERS)


def mean_squares(
    values: Float[np.ndarray, "columns rows"], used: Bool[np.ndarray, "columns rows"]
) -> Float[np.ndarray, " columns"]:
    """Return the mean square of each column's residuals, of the rows in use that are no outliers."""
    rows = used & ~outliers(values)
    return np.sum(np.where(rows, values**2, 0.0), axis=1) / np.maximum(np.sum(rows, axis=1), 1)


def robust(block: Block) -> Block:
    """Return residuals whose squares are Huber's loss: those that stick out count by their size, not its square."""
    size = np.abs(block.values)
    out = size > STICKS_OUT
    root = np.sqrt(STICKS_OUT * (2.0 * np.where(out, size, STICKS_OUT) - STICKS_OUT))
    values = np.where(out, np.sign(block.values) * root, block.values)
    return Block(values, block.slopes * np.where(out, STICKS_OUT / root, 1.0)[..., None])


def smoothed(block: Block, width: float, squares: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return residuals and slopes as rows, averaged over a Gaussian window of a ``width`` in rows; 0 leaves them.

    Rows that stick out weigh less, unless ``squares`` are asked for. They are scaled so that white noise of one keeps
    its information. An impact that comes a window too early or too late still shows which way to go.
    """
    block = block if squares else robust(block)
    rows = np.concatenate([block.values[..., None], block.slopes], axis=2)
    if width > 0.0:
        # Rows within one width say nearly the same: few of them are kept, and each counts for those that it stands for.
        hop = max(int(width), 1)
        rows = gaussian_filter1d(rows, width, axis=1, mode="constant", truncate=3.0)[:, ::hop] * np.sqrt(hop)
    rows = rows.reshape(-1, rows.shape[2])
    return rows[:, 0], rows[:, 1:]


def information(slopes: Float[np.ndarray, "residuals unknowns"]) -> Float[np.ndarray, "unknowns unknowns"]:
    """Return the inverse of the covariance of unknowns whose residuals have a noise of one."""
    # A prior as wide as the ranges: without it there is no inverse where the data say nothing of an unknown.
    return slopes.T @ slopes + np.eye(slopes.shape[1]) / WIDEST**2


def left(x: np.ndarray, values: np.ndarray, slopes: np.ndarray) -> float:
    """Return by how much a sum of squares would fall from x, were it a parabola between bounds of 0 and 1."""
    gradient = slopes.T @ values
    # An unknown that gains next to nothing on its way to the bound counts as held by that bound.
    free = 2.0 * np.abs(gradient) * np.where(gradient > 0.0, x, 1.0 - x) > LEFT
    return float(gradient[free] @ np.linalg.solve(information(slopes[:, free]), gradient[free]))


def _settling(both: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]) -> Callable[[OptimizeResult], None]:
    """Return what ends a search once the sum of squares falls no further than noise counts."""
    least = math.inf

    def check(intermediate_result: OptimizeResult) -> None:  # SciPy goes by the argument's name
        nonlocal least
        x = np.asarray(intermediate_result.x)
        values, slopes = both(x)
        before, least = least, float(values @ values)
        if before - least < FALL or left(x, values, slopes) < LEFT:
            raise StopIteration

    return check


def minimum(
    residuals: Residuals,
    x: np.ndarray,
    share: float,
    width: float = 0.0,
    *,
    squares: bool = False,
    pull: float = 0.0,
    tolerance: float = 1e-4,
    most: int = 12,
) -> LeastSquares:
    """Return the least squares of records up to a share of their rows, near ``x``.

    **Arguments:** ``residuals``; ``x``: scaled unknowns, between 0 and 1; ``share`` [-] of each record; ``width``: of
    the window that residuals are averaged over [rows]; ``squares``: whether rows that stick out weigh like all
    others; ``pull``: weight of staying at ``x``, for what the rows do not
    tell [-]; ``tolerance``: relative change of the sum of squares at which the search ends [-]; ``most`` evaluations.
    """
    known: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}
    start = np.clip(x, INSIDE, 1.0 - INSIDE)

    def both(point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        key = point.tobytes()
        if key not in known:
            known.clear()  # SciPy asks for the slopes at the point whose residuals it asked for last
            parts = [smoothed(block, width, squares) for block in residuals(point, share)]
            values, slopes = (np.concatenate(them) for them in zip(*parts, strict=True))
            if pull > 0.0:
                values = np.concatenate([values, pull * (point - start)])
                slopes = np.concatenate([slopes, pull * np.eye(len(point))])
            known[key] = values, slopes
        return known[key]

    found = least_squares(
        lambda point: both(point)[0],
        start,
        lambda point: both(point)[1],
        bounds=(0.0, 1.0),
        ftol=tolerance,
        xtol=1e-10,
        gtol=1e-12,
        max_nfev=most,
        callback=_settling(both),
    )
    return LeastSquares(
        found.x, 2.0 * found.cost / len(found.fun), found.jac, found.status > 0 or found.status == SETTLED
    )
