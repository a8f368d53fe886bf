"""The floor of the peak contact force: the first impact, which no buffer softens.

The first impact is over before a spring or damper has moved: it sets the peak of a buffer gone soft. Friction and
hysteresis lower its closed form (`first_impact`) by some per cent; so the floor itself is the first impact *simulated*
with the buffer taken away, and the closed form stands beside it and says what it is made of.
"""

import dataclasses

import numpy as np
from jaxtyping import Float

from ..first_impact import first_impact
from ..mechanisms import get, replace
from .evaluation import measure
from .problem import Problem

GONE = 1e-6  # what is left of the buffer's springs and dampers
BUFFER = ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T")
DURATIONS = 4.0  # of an undamped Hertz impact, 2.943 δ/v each
SHARPER = 0.1  # of the problem's tolerance


@dataclasses.dataclass(frozen=True)
class Floor:
    """A lower limit of the first impact's peak in each case [N]: ``simulated`` without a buffer, and ``closed_form``,
    elastic and frictionless; ``energy`` T_c⁻ [J]; ``lowest``: the least that the objective's first impacts can be
    within the variables' bounds [N], and the numbers that reach it."""

    simulated: Float[np.ndarray, " cases"]
    closed_form: Float[np.ndarray, " cases"]
    energy: Float[np.ndarray, " cases"]
    lowest: float
    at: dict[str, float]


def floor(problem: Problem, places: Float[np.ndarray, " variables"]) -> Floor:
    """The floor at a design, and the lowest one within the bounds."""
    from scipy.optimize import minimize

    def objective(where: np.ndarray) -> tuple[float, np.ndarray]:
        peaks, slopes = _without_buffer(problem, where)
        weights = problem.objective.case_weights(peaks)
        return float(weights @ peaks), weights @ slopes

    found = minimize(objective, places, jac=True, bounds=[(0.0, 1.0)] * len(places), method="L-BFGS-B", tol=1e-6)
    closed = [first_impact(case.of(problem.built(places)), case.scenario) for case in problem.cases]
    at = dict(zip(problem.paths, map(float, problem.values(found.x)), strict=True))
    return Floor(
        _without_buffer(problem, places)[0],
        np.array([float(c.elastic_peak) for c in closed]),
        np.array([float(c.effective_energy) for c in closed]),
        float(found.fun),
        {path: value for path, value in at.items() if path not in BUFFER},
    )


def _without_buffer(problem: Problem, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First peaks [N] of all cases with the buffer gone, and their slopes by the places."""
    drawn, values = problem.built(places), problem.values(places)
    peaks, slopes = [], []
    for case in problem.cases:
        built = case.of(drawn)
        design = replace(built, {path: GONE * float(get(built, path)) for path in BUFFER})
        duration = DURATIONS * float(first_impact(built, case.scenario).duration)
        found = measure(design, case.scenario, problem.paths, duration, SHARPER * problem.rtol)
        factors = dict(case.factors)
        scale = [
            v.slope(float(x)) * factors.get(v.path, 1.0) * (v.path not in BUFFER)
            for v, x in zip(problem.variables, values, strict=True)
        ]
        peaks.append(float(found.peaks[0]))
        slopes.append(found.peaks_slope[0] * np.array(scale))
    return np.array(peaks), np.array(slopes)
