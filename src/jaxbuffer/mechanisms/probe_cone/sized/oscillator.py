"""One mass that meets a spring and damper: its first swing, its largest force, when it is at rest; and two of them in a
row, as a buffer behind a latch. Source: textbook (Harris and Piersol 2002, chapter 8); the rows are linear algebra."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Complex, Float

INSTANTS = 2000  # of a motion that is followed until it is at rest


def first_swing(ratio: float) -> float:
    """Return the largest displacement of a mass that meets a spring and damper, over v/ω [-]. ``ratio``: its damping
    ratio [-], below 1."""
    root = math.sqrt(1.0 - ratio**2)
    return math.exp(-ratio / root * math.atan2(root, ratio))


def largest_force(ratio: float) -> float:
    """Return its largest force over v √(k m) [-]: of a ratio of 0.5 or more it is the damper's at once."""
    if ratio >= 0.5:
        return 2.0 * ratio
    root = math.sqrt(1.0 - ratio**2)
    return math.exp(-ratio / root * math.atan2(root * (1.0 - 4.0 * ratio**2), ratio * (3.0 - 4.0 * ratio**2)))


def at_rest_after(ratio: float, frequency: float, share: float) -> float:
    """Return after how long at most a ``share`` of its energy is left [s], by the envelope of its energy.

    **Arguments:** ``ratio``: the damping ratio [-], in (0, 1); ``frequency``: ω without damping [rad/s].
    """
    # E/E₀ ≤ (1 + ζ)/(1 - ζ) e^(-2ζωt), whatever its phase.
    return max(math.log((1.0 + ratio) / ((1.0 - ratio) * share)), 0.0) / (2.0 * ratio * frequency)


class SpringsInARow(NamedTuple):
    """A mass [kg] that meets two springs with dampers in a row, with nothing between them that weighs (M187).

    ``first``, ``second``: their stiffnesses [N/m]; ``first_damping``, ``second_damping`` [N s/m]: not both zero.
    """

    mass: float
    first: float
    first_damping: float
    second: float
    second_damping: float

    @property
    def stiffness(self) -> float:
        """Return that of both in a row [N/m]."""
        return self.first * self.second / (self.first + self.second)

    def matrix(self) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, " 3"]]:
        """Return A of ẏ = A y, where y is the mass's displacement, its velocity, and the first spring's share of the
        displacement; and the force's row: f = row · y."""
        # Both bear the same force: k₁ s + c₁ ṡ = k₂ (z - s) + c₂ (ż - ṡ).
        moved = np.array([self.second, self.second_damping, -(self.first + self.second)])
        moved /= self.first_damping + self.second_damping
        force = self.first_damping * moved + np.array([0.0, 0.0, self.first])
        return np.array([[0.0, 1.0, 0.0], -force / self.mass, moved]), force

    def motion(self, times: Float[np.ndarray, " times"]) -> Float[np.ndarray, "3 times"]:
        """Return y at some times [s] after it has met them at 1 m/s."""
        rates, vectors = self._modes
        parts = np.linalg.solve(vectors, np.array([0.0, 1.0, 0.0], complex))
        return np.real((vectors * parts) @ np.exp(np.outer(rates, times)))

    @property
    def _modes(self) -> tuple[Complex[np.ndarray, " 3"], Complex[np.ndarray, "3 3"]]:
        rates, vectors = np.linalg.eig(self.matrix()[0])
        return rates.astype(complex), vectors.astype(complex)

    def arrest(self, share: float) -> "Arrest":
        """Return what comes of meeting them at 1 m/s, until a ``share`` of the energy is left."""
        rates, _ = self._modes
        slowest = -float(np.max(rates.real))
        # Its envelope falls with the slowest mode; half as long again for the phase and the factor before it.
        times = np.linspace(0.0, 1.5 * math.log(1.0 / share) / (2.0 * slowest), INSTANTS)
        z, speed, s = self.motion(times)
        energy = 0.5 * (self.mass * speed**2 + self.first * s**2 + self.second * (z - s) ** 2)
        above = np.flatnonzero(energy > share * 0.5 * self.mass)
        force = np.abs(self.matrix()[1] @ np.stack([z, speed, s]))
        return Arrest(float(times[above[-1]]), float(np.max(force)), float(np.max(s)))


class Arrest(NamedTuple):
    """What comes of a mass that meets `SpringsInARow` at 1 m/s: ``at_rest`` [s], the largest ``force`` [N] and the
    largest ``swing`` of the first spring [m], both for each m/s."""

    at_rest: float
    force: float
    swing: float
