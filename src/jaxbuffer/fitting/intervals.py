"""How sure estimates are: covariance, intervals by profiles of the likelihood, and what the data cannot tell apart."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from scipy.optimize import lsq_linear

from .residuals import WIDEST, LeastSquares, Residuals, information, smoothed

SURE = 1.959963984540054  # deviations of a normal distribution on either side of 95 %
CLOSE = 0.97  # correlation from which on data hardly tell two unknowns apart
TRIES = 12  # steps to an end of a profile interval; one or two, unless a side is flat or near a bound
ALIKE = 0.05  # of the rise at the end of an interval, by which it may be off


class Uncertainty(NamedTuple):
    """What the data leave open of scaled unknowns: ``covariance``, the ends ``low`` and ``high`` of the intervals that
    hold each with 95 %, and whether both ends were established (``closed``)."""

    covariance: Float[np.ndarray, "unknowns unknowns"]
    low: Float[np.ndarray, " unknowns"]
    high: Float[np.ndarray, " unknowns"]
    closed: Bool[np.ndarray, " unknowns"]

    @property
    def deviations(self) -> Float[np.ndarray, " unknowns"]:
        """Return the standard deviations of the scaled unknowns."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Float[np.ndarray, "unknowns unknowns"]:
        """Return the correlation matrix [-]."""
        return self.covariance / np.outer(self.deviations, self.deviations)


def uncertainty(residuals: Residuals, best: LeastSquares, inflation: float = 1.0) -> Uncertainty:
    """Return how sure a minimum is, by profiles: an interval ends where the least squares rise by 3.84.

    **Arguments:** ``inflation``: of the variance, where residuals exceed the noise [-].
    """
    covariance = np.linalg.inv(information(best.slopes))
    least = _sum(residuals, best.x)[0]
    ends = [
        [_end(residuals, best.x, covariance, least, k, side * np.sqrt(inflation)) for k in range(len(best.x))]
        for side in (-SURE, SURE)
    ]
    low, high = (np.array([end for end, _ in side]) for side in ends)
    closed = np.array([low and high for (_, low), (_, high) in zip(*ends, strict=True)])
    return Uncertainty(inflation * covariance, low, high, closed)


def _sum(residuals: Residuals, x: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Return the sum of squares at a point, half its gradient and half its Hessian."""
    parts = [smoothed(block, 0.0) for block in residuals(x, 1.0)]
    values, slopes = (np.concatenate(them) for them in zip(*parts, strict=True))
    return float(values @ values), slopes.T @ values, information(slopes)


def _end(
    residuals: Residuals, x: np.ndarray, covariance: np.ndarray, least: float, k: int, deviations: float
) -> tuple[float, bool]:
    """Return where the sum of squares, the other unknowns at their best, has risen by the square of some deviations,
    or the unknown's bound if it rises less as far as that; and whether that was established."""
    others = np.arange(len(x)) != k
    # The others move along with the one that is held, as the covariance says; designs beyond the bounds are not run.
    along = covariance[:, k] / covariance[k, k]
    bound, rise_asked = float(deviations > 0.0), deviations**2
    inner, outer, bracketed = (x[k], 0.0), (bound, np.inf), False
    point, place = x, x[k] + deviations * np.sqrt(covariance[k, k])
    for attempt in range(TRIES):
        place = float(np.clip(place, 0.0, 1.0))
        point = np.clip(point + (place - point[k]) * along, 0.0, 1.0)
        point[k] = place
        with np.errstate(invalid="ignore"):
            total, gradient, hessian = _sum(residuals, point)
        step, rise = np.zeros_like(x), np.inf
        if np.isfinite(total):  # else the run failed, and its slopes say nothing
            step[others] = _bounded_step(gradient[others], hessian[np.ix_(others, others)], point[others])
            # Half the gradient and half the Hessian, as they are, make the parabola's whole fall.
            rise = max(total + 2.0 * (gradient @ step) + step @ hessian @ step - least, 0.0)
        if abs(rise / rise_asked - 1.0) < ALIKE or (rise < rise_asked and place == bound):
            return place, True
        if rise < rise_asked:
            inner = (place, rise)
        else:
            outer, bracketed = (place, rise), True
        place = _between(inner, outer, rise_asked, attempt) if bracketed else _further(inner, x[k], rise_asked)
        point = point + step
    return (outer if np.isfinite(outer[1]) else inner)[0], False


def _bounded_step(gradient: np.ndarray, hessian: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return the step to the bottom of a parabola between bounds of 0 and 1."""
    if len(point) == 0:
        return point
    lower = np.linalg.cholesky(hessian)
    return lsq_linear(lower.T, -np.linalg.solve(lower, gradient), (0.0 - point, 1.0 - point)).x


def _further(inner: tuple[float, float], best: float, rise_asked: float) -> float:
    """Return where to look for the end of an interval beyond a place with too small a rise, ``inner``."""
    # Near the minimum the rise is a square of the distance; on a flat side it is less, and the bound is the limit.
    ratio = np.clip(np.sqrt(rise_asked / max(inner[1], 1e-300)), 1.1, 4.0)
    return best + ratio * (inner[0] - best)


def _between(inner: tuple[float, float], outer: tuple[float, float], rise_asked: float, attempt: int) -> float:
    """Return where to look next between two places with too small a rise and too large a one; infinite where the run
    failed."""
    if np.isinf(outer[1]) or attempt % 3 == 2:  # a secant may leave one end where it is for ever
        return 0.5 * (inner[0] + outer[0])
    roots = np.sqrt([inner[1], rise_asked, outer[1]])
    return inner[0] + (outer[0] - inner[0]) * (roots[1] - roots[0]) / (roots[2] - roots[0])


def not_told_apart(names: list[str], known: Uncertainty) -> list[str]:
    """Return a line for each unknown that the data hardly tell, and each pair that they hardly tell apart."""
    lines = [
        f"{name}: the data say next to nothing of it"
        for name, deviation in zip(names, known.deviations, strict=True)
        if deviation > 0.25 * WIDEST
    ]
    lines += [
        f"{name}: the sum of squares was not followed to both ends of its interval, which may be narrower"
        for name, closed in zip(names, known.closed, strict=True)
        if not closed
    ]
    correlation = known.correlation
    for i in range(len(names)):
        for j in range(i):
            if abs(correlation[i, j]) > CLOSE:
                lines.append(
                    f"{names[j]} and {names[i]}: correlation {correlation[i, j]:+.3f}; one combination of them is known"
                    " far better than either"
                )
    return lines
