"""Derivatives by differences of tight solves, with a step chosen by their own convergence and their own uncertainty.

They share nothing with the derivative rule: values of captures only. Steps are halved from a coarse one; where the
extrapolated differences of two successive pairs agree best, rounding and curvature are balanced, and how far they agree
is the uncertainty.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

COARSEST = 2e-3  # relative step
STEPS = 6


class Difference(NamedTuple):
    """For each quantity its derivative by the relative move, its uncertainty (infinite where no two steps could be
    compared), and the steps taken."""

    value: np.ndarray
    uncertainty: np.ndarray
    steps: int


def difference(
    evaluate: Callable[[float], np.ndarray], inside: Callable[[float], bool], settled: np.ndarray, noise: float
) -> Difference:
    """Differentiate at zero.

    **Arguments:** ``evaluate``: the quantities after a relative move, NaN for one that can't be compared with the
    unmoved ones; ``inside``: whether a move stays within bounds (differences are one-sided where it doesn't);
    ``settled``: the uncertainty of each quantity that is small enough to stop; ``noise``: relative error of the values,
    so that no two differences may agree by luck.
    """
    best, uncertainty = np.full(settled.shape, np.nan), np.full(settled.shape, np.inf)
    up, down = inside(2.0 * COARSEST), inside(-2.0 * COARSEST)
    if not (up or down):
        return Difference(best, uncertainty, 0)
    sign = 1.0 if up else -1.0
    start = np.zeros(()) if up and down else evaluate(0.0)
    plain: list[np.ndarray] = []
    for count in range(STEPS):
        step = sign * COARSEST / 2**count
        near = evaluate(step)
        if up and down:
            plain.append((near - evaluate(-step)) / (2.0 * step))
        else:
            plain.append((4.0 * near - evaluate(2.0 * step) - 3.0 * start) / (2.0 * step))
        if count < 2:
            continue
        # Both stencils are off by a multiple of the step's square, which this takes out.
        older, newer = ((4.0 * plain[i] - plain[i - 1]) / 3.0 for i in (count - 1, count))
        apart = np.maximum(np.abs(newer - older), np.abs(noise * near / step))
        better = apart < uncertainty
        best, uncertainty = np.where(better, newer, best), np.where(better, apart, uncertainty)
        if np.all(uncertainty <= settled):
            break
    return Difference(best, uncertainty, len(plain))


def balanced_direction(elasticities: np.ndarray, floor: float) -> np.ndarray:
    """A relative move in which every parameter changes a quantity by the same amount and in the same sense, so that
    an error in any of the elasticities shows; the largest component is 1."""
    move = np.where(elasticities < 0.0, -1.0, 1.0) / np.maximum(np.abs(elasticities), floor)
    return move / np.max(np.abs(move))
