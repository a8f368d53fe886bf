"""Columns whose unit or sign may be another: those that a factor of 10^k or -1 makes far more alike the model's."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float
from scipy.ndimage import gaussian_filter1d

from ..fields import Part, as_displayed
from ..mechanisms.registry import mechanism_of
from ..tuning.problem.variable import Variable
from ..value_text import with_unit
from .prediction import Prediction

FACTORS = tuple(sign * 10.0**k for k in range(-6, 7) for sign in (1.0, -1.0))
FAR_BETTER = 4.0  # by which a misfit must fall
WINDOW = 50  # of a record's rows, the share that is averaged over: impacts at other times are alike all the same
MANY = 0.03  # share of a column's rows that are more than spikes


def doubts(prediction: Prediction, predicted: Float[np.ndarray, "columns rows"], design: Part) -> Iterator[str]:
    """Yield a line for each column of a test whose unit or sign may be another.

    **Arguments:** ``prediction`` of the test; ``predicted``: what a design gives for its columns; ``design``: where the
    search starts.
    """
    largest = mechanism_of(design).view.largest(design)
    for (column, sensor), given, model in zip(prediction.sensors.items(), prediction.values, predicted, strict=True):
        where = f'{prediction.recording.name}: column "{column}": unit or sign?'
        limit = largest.get(sensor.quantity, np.inf)
        # With an unknown offset only the column's changes tell its unit.
        level = (np.mean(given), np.mean(model)) if isinstance(sensor.offset, Variable) else (0.0, 0.0)
        alike = better_factor(given - level[0], model - level[1])
        if (within := factor_within(given - level[0], limit)) is not None:
            # Of the powers of ten that bring it within, the one that makes it most alike says more.
            factor = within if alike is None or abs(alike) > within else alike
            most = with_unit(*as_displayed(limit, prediction.units[sensor.quantity]))
            yield f"{where} It exceeds {most}, the largest {sensor.quantity} of this design, unless times {factor:g}."
        elif alike is not None:
            yield f"{where} Times {alike:g} it is far nearer to what the design gives."


def better_factor(measured: Float[np.ndarray, " rows"], predicted: Float[np.ndarray, " rows"]) -> float | None:
    """Return the factor of 10^k or -1 by which a column must be multiplied to be far more alike what a design gives;
    None where it is as alike as it is."""
    given, model = (gaussian_filter1d(it, len(measured) / WINDOW, mode="nearest") for it in (measured, predicted))
    sizes = float(np.linalg.norm(given)), float(np.linalg.norm(model))
    if not (all(np.isfinite(sizes)) and min(sizes) > 0.0):
        return None
    ratio, correlation = sizes[0] / sizes[1], float(given @ model) / (sizes[0] * sizes[1])

    def misfit(factor: float) -> float:
        # Squares of the difference over both sizes: a column that is far too small is as bad as one far too large.
        ratio_left = ratio * abs(factor)
        return ratio_left + 1.0 / ratio_left - 2.0 * np.sign(factor) * correlation

    best = min(FACTORS, key=misfit)
    return best if FAR_BETTER * misfit(best) < misfit(1.0) else None


def factor_within(measured: Float[np.ndarray, " rows"], largest: float) -> float | None:
    """Return the power of ten that brings a column below the largest value that its quantity can have; None where it
    is below already, but for a few rows."""
    size = float(np.quantile(np.abs(measured), 1.0 - MANY))
    return None if size <= largest else 10.0 ** -float(np.ceil(np.log10(size / largest)))
