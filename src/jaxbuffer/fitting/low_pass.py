"""A sensor's first-order low-pass, τ y' = s - y, exact for signals that are parabolas between nodes."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from scipy.linalg import solve_banded

SHORTEST = 1e-9  # s, of a time constant: below it a sensor is as quick as any record
SERIES = 0.5  # of an interval over the time constant, below which weights are series
TERMS = 14


def weights(z: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return what is left of a filter's state after an interval of z time constants, and the weights of the signal at
    the interval's start, middle and end."""
    small = z.real < SERIES
    long, short = np.where(small, 1.0, z), np.where(small, z, 0.0)
    m0 = -np.expm1(-z)
    # m_k = ∫ z e^{-z (1 - x)} x^k dx over [0, 1], by parts 1 - k m_{k-1} / z, which cancels in short intervals.
    m1 = np.where(small, _moment(short, 1), 1.0 + np.expm1(-long) / long)
    m2 = np.where(small, _moment(short, 2), 1.0 - 2.0 * (1.0 + np.expm1(-long) / long) / long)
    return np.exp(-z), m0 - 3.0 * m1 + 2.0 * m2, 4.0 * (m1 - m2), 2.0 * m2 - m1


def _moment(z: np.ndarray, k: int) -> np.ndarray:
    """Return m_k of a short interval: z Σ_n (-z)^n k! / (n + k + 1)!."""
    term, total = z / (k + 1), z / (k + 1)
    for n in range(1, TERMS):
        term = -term * z / (n + k + 1)
        total = total + term
    return total


def _moved(z: np.ndarray) -> list[np.ndarray]:
    """Return the derivatives of the `weights` by the logarithm of z."""
    # A complex step: exact where a difference would cancel.
    step = 1e-30
    return [it.imag / step for it in weights(z + 1j * step * z)]


def _summed(by: Sequence[np.ndarray], *rows: np.ndarray) -> np.ndarray:
    return sum((it[:, None] * row for it, row in zip(by, rows, strict=True)), np.zeros_like(rows[0]))


class Filtered:
    """The answer of a low-pass with one time constant to signals that are known at nodes and midway between them.

    **Arguments:** ``nodes``: times that do not fall [s]; ``lag``: the time constant τ [s].
    """

    def __init__(self, nodes: Float[np.ndarray, " nodes"], lag: float) -> None:
        self.nodes, self.lag = nodes, max(lag, SHORTEST)
        self.z = np.diff(nodes) / self.lag
        self.decay, *self.weights = weights(self.z)

    def answer(
        self, on: Float[np.ndarray, "nodes columns"], between: Float[np.ndarray, "intervals columns"]
    ) -> Float[np.ndarray, "nodes columns"]:
        """Return y at the nodes, with y = s at the first one."""
        return self._recursion(self._gains(on, between, self.weights), on[0])

    def slope(self, on: np.ndarray, between: np.ndarray, answer: np.ndarray) -> Float[np.ndarray, "nodes columns"]:
        """Return dy/dτ [1/s] at the nodes."""
        decay, *moved = _moved(self.z)
        gains = self._gains(on, between, moved) + decay[:, None] * answer[:-1]
        return self._recursion(-gains / self.lag, np.zeros_like(on[0]))

    def within(
        self, times: Float[np.ndarray, " instants"], on: np.ndarray, between: np.ndarray
    ) -> tuple[Float[np.ndarray, "instants columns"], ...]:
        """Return y at any times between the first node and the last, the signals there, and dy/dτ of the first one."""
        answer = self.answer(on, between)
        by_lag = self.slope(on[:, :1], between[:, :1], answer[:, :1])
        k = np.clip(np.searchsorted(self.nodes, times, side="right") - 1, 0, len(self.z) - 1)
        length = self.nodes[k + 1] - self.nodes[k]
        # Two nodes may coincide, where a step ends at a row's time say: between them is no length to divide by.
        x = np.where(length > 0.0, (times - self.nodes[k]) / np.where(length > 0.0, length, 1.0), 1.0)

        def parabola(x: np.ndarray) -> np.ndarray:
            parts = (1.0 - x) * (1.0 - 2.0 * x), 4.0 * x * (1.0 - x), x * (2.0 * x - 1.0)
            return _summed(parts, on[k], between[k], on[k + 1])

        signal, z = parabola(x), x * self.z[k]
        given = answer[k], on[k], parabola(0.5 * x), signal
        moved = _summed(_moved(z), *(it[:, :1] for it in given))
        decay = np.exp(-z)[:, None]
        return _summed(weights(z), *given), signal, decay * by_lag[k] - moved / self.lag

    def _gains(self, on: np.ndarray, between: np.ndarray, by: list[np.ndarray]) -> np.ndarray:
        return _summed(by, on[:-1], between, on[1:])

    def _recursion(self, gains: np.ndarray, first: np.ndarray) -> np.ndarray:
        """Return y with y_0 = ``first`` and y_{k+1} = decay_k y_k + gains_k."""
        count = len(gains) + 1
        bands = np.stack([np.ones(count), np.append(-self.decay, 0.0)])
        # The recursion is a system with two diagonals: solved for all columns at once, without a loop over the nodes.
        return solve_banded((1, 0), bands, np.concatenate([first[None], gains]))
