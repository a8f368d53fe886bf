"""The floor of the peak contact force: the first impact, which no buffer softens.

The first impact is over before a spring or damper has moved: it sets the peak of a buffer gone soft. Friction and
hysteresis lower its closed form (`first_impact`) by some per cent; so the floor itself is the first impact *simulated*
with the buffer taken away, and the closed form stands beside it and says what it is made of.
"""

import dataclasses

import numpy as np
from jaxtyping import Float

from ..fields import get, replace
from .evaluation import Wanted, fitted, measure
from .problem import Problem

GONE = 1e-6  # what is left of the buffer's springs and dampers
DURATIONS = 4.0  # of an undamped Hertz impact, 2.943 δ/v each
SHARPER = 0.1  # of the problem's tolerance
FAR = 10.0  # times the floor at the design: what counts for designs whose parts do not fit, or that fail


@dataclasses.dataclass(frozen=True)
class Floor:
    """A lower limit of the first impact's peak in each case [N]: ``simulated`` without a buffer, and ``closed_form``,
    elastic and frictionless; ``energy`` T_c⁻ [J]; ``lowest``: the least that the objective's first impacts can be
    within the variables' bounds [N], and the numbers that reach it. NaN where a first impact can not be simulated."""

    simulated: Float[np.ndarray, " cases"]
    closed_form: Float[np.ndarray, " cases"]
    energy: Float[np.ndarray, " cases"]
    lowest: float
    at: dict[str, float]

    @property
    def unknown(self) -> int:
        """In how many cases the floor is not known."""
        return int(np.sum(~np.isfinite(self.simulated)))


def floor(problem: Problem, scaled: Float[np.ndarray, " variables"]) -> Floor | None:
    """The floor at a design, and the lowest one within the bounds; None for a mechanism that knows of none."""
    known = problem.mechanism.floor
    if known is None:
        return None
    simulated = _without_buffer(problem, scaled)[0]
    lowest, best = _lowest(problem, scaled, simulated)
    built = [(fitted(problem, scaled, case), case.scenario) for case in problem.cases]
    closed = [None if design is None else known.first_impact(design, scenario) for design, scenario in built]
    at = dict(zip(problem.paths, map(float, problem.values(best)), strict=True))
    return Floor(
        simulated,
        np.array([np.nan if c is None else float(c.elastic_peak) for c in closed]),
        np.array([np.nan if c is None else float(c.effective_energy) for c in closed]),
        lowest,
        {path: value for path, value in at.items() if path not in known.softeners},
    )


def _lowest(problem: Problem, scaled: np.ndarray, peaks: np.ndarray) -> tuple[float, np.ndarray]:
    """The least floor within the bounds [N] and where it is, from the design with these ``peaks`` on."""
    from scipy.optimize import minimize

    here = problem.objective.aggregate(peaks)
    if not np.isfinite(here):
        return np.nan, scaled
    best = (here, scaled)

    def objective(where: np.ndarray) -> tuple[float, np.ndarray]:
        nonlocal best
        peaks, slopes = _without_buffer(problem, where)
        weights = problem.objective.case_weights(peaks)
        value, slope = float(weights @ peaks), weights @ slopes
        if not (np.isfinite(value) and np.all(np.isfinite(slope))):
            return FAR * here, np.zeros_like(where)
        best = min(best, (value, where.copy()), key=lambda found: found[0])
        return value, slope

    minimize(objective, scaled, jac=True, bounds=[(0.0, 1.0)] * len(scaled), method="L-BFGS-B", tol=1e-6)
    return best


def _without_buffer(problem: Problem, scaled: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First peaks [N] of all cases with the buffer gone, and their slopes by the scaled variables; NaN where there is
    none."""
    known, values = problem.mechanism.floor, problem.values(scaled)
    assert known is not None
    peaks, slopes = np.full(len(problem.cases), np.nan), np.full((len(problem.cases), len(scaled)), np.nan)
    for k, case in enumerate(problem.cases):
        if (built := fitted(problem, scaled, case)) is None:
            continue
        design = replace(built, {path: GONE * float(get(built, path)) for path in known.softeners})
        duration = DURATIONS * float(known.first_impact(built, case.scenario).duration)
        found = measure(Wanted.of(problem), design, case.scenario, duration, SHARPER * problem.rtol)
        if found.code >= problem.mechanism.outcomes["failed_steps"]:
            continue
        factors = dict(case.factors)
        scale = [
            v.slope(float(x)) * factors.get(v.path, 1.0) * (v.path not in known.softeners)
            for v, x in zip(problem.variables, values, strict=True)
        ]
        peaks[k], slopes[k] = float(found.peaks[0]), found.peaks_slope[0] * np.array(scale)
    return peaks, slopes
