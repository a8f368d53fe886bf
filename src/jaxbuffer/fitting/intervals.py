"""How sure estimates are: covariance, intervals by profiles of the likelihood, and what the data cannot tell apart."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from .residuals import WIDEST, LeastSquares, Residuals, information, smoothed

SURE = 1.959963984540054  # deviations of a normal distribution on either side of 95 %
CLOSE = 0.97  # correlation from which on data hardly tell two unknowns apart
TRIES = 3  # steps to an end of a profile interval
ALIKE = 0.05  # of the rise at the end of an interval, by which it may be off


class Uncertainty(NamedTuple):
    """What the data leave open of scaled unknowns: ``covariance``, and the ends ``low`` and ``high`` of the intervals
    that hold each with 95 %."""

    covariance: Float[np.ndarray, "unknowns unknowns"]
    low: Float[np.ndarray, " unknowns"]
    high: Float[np.ndarray, " unknowns"]

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
    return Uncertainty(inflation * covariance, np.array(ends[0]), np.array(ends[1]))


def _sum(residuals: Residuals, x: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Return the sum of squares at a point, half its gradient and half its Hessian."""
    parts = [smoothed(block, 0.0) for block in residuals(x, 1.0)]
    values, slopes = (np.concatenate(them) for them in zip(*parts, strict=True))
    return float(values @ values), slopes.T @ values, information(slopes)


def _end(residuals: Residuals, x: np.ndarray, covariance: np.ndarray, least: float, k: int, deviations: float) -> float:
    """Return where the sum of squares, the other unknowns at their best, has risen by the square of some deviations."""
    away = deviations * np.sqrt(covariance[k, k])
    others = np.arange(len(x)) != k
    # The others move along with the one that is held, as the covariance says.
    along = covariance[:, k] / covariance[k, k]
    point = x + away * along
    for _ in range(TRIES):
        # Designs beyond the bounds are not run: there the interval ends, at the latest at its own bound.
        if not np.all((point >= 0.0) & (point <= 1.0)):
            return float(np.clip(point[k], 0.0, 1.0))
        total, gradient, hessian = _sum(residuals, point)
        step = np.zeros_like(x)
        step[others] = -np.linalg.solve(hessian[np.ix_(others, others)], gradient[others])
        # To the bottom of a parabola the sum falls by half its slope along the step, and `gradient` is half the slope.
        rise = total + gradient @ step - least
        if not rise > 0.0 or abs(rise / deviations**2 - 1.0) < ALIKE:
            break
        # Near the minimum the rise is a square of the distance.
        ratio = np.clip(np.sqrt(deviations**2 / rise), 0.5, 2.0)
        point = x + ratio * (point + step - x)
    return float(point[k])


def not_told_apart(names: list[str], known: Uncertainty) -> list[str]:
    """Return a line for each unknown that the data hardly tell, and each pair that they hardly tell apart."""
    lines = [
        f"{name}: the data say next to nothing of it"
        for name, deviation in zip(names, known.deviations, strict=True)
        if deviation > 0.25 * WIDEST
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
