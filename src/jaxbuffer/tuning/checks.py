"""Checks of a tuned design beside its search: the floor of the peak force, and the corners of what scatters.

The floor of the peak contact force is the first impact, which no buffer softens: it is over before a spring or damper
has moved, and sets the peak of a buffer gone soft. Friction and hysteresis lower its closed form (`first_impact`) by
some per cent; so the floor itself is the first impact *simulated* with the buffer taken away, and the closed form
stands beside it and says what it is made of.

A design tuned for samples is run in the corners of the ranges they come from, because samples alone are no bound.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy
from jaxtyping import Float

from ..fields import Curve, Part, get, replace
from .cases import Case
from .evaluation import Evaluator, built_design
from .goal import Goal
from .measurement import measure
from .problem import Problem

GONE = 1e-6  # what is left of the buffer's springs and dampers
DURATIONS = 4.0  # of an undamped Hertz impact, 2.943 δ/v each
SHARPER = 0.1  # of the problem's tolerance
FAR = 10.0  # times the floor at the design: what counts for designs whose parts do not fit, or that fail


@dataclasses.dataclass(frozen=True)
class Floor:
    """A lower limit of the first impact's peak in each load case [N].

    ``simulated`` without a buffer, and ``closed_form``, elastic and frictionless; ``energy`` T_c⁻ [J]; ``lowest``: the
    least that the objective's first impacts can be within the variables' bounds [N], and ``at`` which numbers. NaN
    where a first impact can not be simulated.
    """

    simulated: Float[np.ndarray, " cases"]
    closed_form: Float[np.ndarray, " cases"]
    energy: Float[np.ndarray, " cases"]
    lowest: float
    at: dict[str, float]

    @property
    def unknown(self) -> int:
        """In how many load cases the floor is not known."""
        return int(np.sum(~np.isfinite(self.simulated)))


def floor(problem: Problem, scaled: Float[np.ndarray, " variables"]) -> Floor | None:
    """Compute the floor at a design, and the lowest one within the bounds; None for a mechanism without one."""
    known = problem.mechanism.tuning.floor
    if known is None:
        return None
    simulated = _without_buffer(problem, scaled)[0]
    lowest, best = _lowest(problem, scaled, simulated)
    built = [(built_design(problem, scaled, case), case.scenario) for case in problem.cases]
    closed = [None if design is None else known.first_impact(design, scenario) for design, scenario in built]
    at = dict(zip(problem.paths, map(float, problem.values(best)), strict=True))
    return Floor(
        simulated,
        np.array([np.nan if c is None else float(c.elastic_peak) for c in closed]),
        np.array([np.nan if c is None else float(c.effective_energy) for c in closed]),
        lowest,
        {path: value for path, value in at.items() if path not in _gone(problem.design, known.softeners)},
    )


def _lowest(problem: Problem, scaled: np.ndarray, peaks: np.ndarray) -> tuple[float, np.ndarray]:
    """Search for the least floor within the bounds [N] and where it is, from the design with these ``peaks``."""
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
        # The line search's last point need not be its best, and it may have left the designs that fit.
        best = min(best, (value, where.copy()), key=lambda pair: pair[0])
        return value, slope

    bounds = [(0.0, 1.0)] * len(scaled)
    scipy.optimize.minimize(objective, scaled, jac=True, bounds=bounds, method="L-BFGS-B", tol=1e-6)
    return best


def _without_buffer(problem: Problem, scaled: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return first peaks [N] of all load cases with the buffer gone, and their slopes by the scaled variables.

    They are NaN where there is none.
    """
    known, values = problem.mechanism.tuning.floor, problem.values(scaled)
    assert known is not None
    gone = _gone(problem.design, known.softeners)
    peaks, slopes = np.full(len(problem.cases), np.nan), np.full((len(problem.cases), len(scaled)), np.nan)
    for k, case in enumerate(problem.cases):
        if (built := built_design(problem, scaled, case)) is None:
            continue
        design = replace(built, _gone(built, known.softeners))
        duration = DURATIONS * float(known.first_impact(built, case.scenario).duration)
        run = measure(
            (design, case.scenario),
            mechanism=problem.mechanism,
            measured=problem.measured,
            paths=problem.paths,
            duration=duration,
            rtol=SHARPER * problem.rtol,
        )
        if run.code >= problem.mechanism.outcomes["failed_steps"]:
            continue
        factors = dict(case.factors)
        # The softeners are taken away whatever their variables say, so the floor has no slope by these.
        scale = [
            v.slope(float(x)) * factors.get(v.path, 1.0) * (v.path not in gone)
            for v, x in zip(problem.variables, values, strict=True)
        ]
        peaks[k], slopes[k] = float(run.peaks[0]), run.peaks_slope[0] * np.array(scale)
    return peaks, slopes


def _gone(design: Part, softeners: Sequence[str]) -> dict[str, float]:
    """Return what is left of a design's softeners by path: of measured curves their values, of what is not there
    nothing."""
    numbers = dict[str, Any]()
    for path in softeners:
        value = get(design, path)
        if isinstance(value, Curve):
            numbers |= {f"{path}.{address}": value.get(address) for address in value.value_addresses()}
        elif value is not None:
            numbers[path] = value
    return {path: GONE * float(number) for path, number in numbers.items()}


@dataclasses.dataclass(frozen=True)
class Corners:
    """A design in the corners of the sampled ranges, at every scenario that scatters.

    - ``cases``: the corners; ``broken``: of each what does not hold there, limits and how the run must end; ``values``:
      the objective's, in its unit, NaN where a corner can not be built or its run fails.
    - ``worst``: the corner farthest beyond its limits.
    - ``ranges``: how many there are; ``whole``: whether all their corners were run, or a fraction of them.
    - ``middle``: the objective's largest value in the middle of the ranges; ``middle_holds``: whether it holds there;
      ``middle_touches``: whether anything does there.
    """

    cases: tuple[Case, ...]
    broken: tuple[tuple[str, ...], ...]
    values: Float[np.ndarray, " cases"]
    worst: int
    ranges: int
    whole: bool
    middle: float
    middle_holds: bool
    middle_touches: bool = True

    @property
    def holding(self) -> int:
        """In how many corners the design holds."""
        return sum(not it for it in self.broken)

    @property
    def largest(self) -> float:
        """The objective's largest value, NaN where no corner has one."""
        return float(np.nanmax(self.values)) if np.any(np.isfinite(self.values)) else float("nan")

    def lines(self, problem: Problem) -> list[str]:
        """Return a summary, the corner farthest beyond a limit and the middle, a line each."""
        count, scenarios = len(self.cases), len(problem.scenarios)

        def said(value: float) -> str:
            return problem.objective.said(value, problem.catalogue)

        at = f" at {scenarios} scenarios" if scenarios > 1 else ""
        which = (
            f"all {2**self.ranges} corners" if self.whole else f"{count // scenarios} of the {2**self.ranges} corners"
        )
        lost, label = int(np.sum(~np.isfinite(self.values))), lambda k: self.cases[k].label(self.cases)
        parts = [f"the design holds in {self.holding} of {count}"]
        parts += [f"{lost} can not be built or simulated"] if lost else []
        if lost < count:
            where = label(int(np.nanargmax(self.values)))
            parts.append(f"the largest objective there is {said(self.largest)}, at {where}")
        lines = [f"{which} of the {self.ranges} sampled ranges{at}: {'; '.join(parts)}"]
        if broken := self.broken[self.worst]:
            lines.append(f"the corner farthest beyond a limit, {label(self.worst)}: {'; '.join(broken)}")
        middle = said(self.middle) if np.isfinite(self.middle) else "can not be simulated"
        if self.middle == 0.0 and not self.middle_touches:
            middle = "nothing touches there"
        return [*lines, f"the middle of the ranges: {middle}{'' if self.middle_holds else ', does not hold'}"]


def corners(goal: Goal, evaluator: Evaluator, scaled: Float[np.ndarray, " variables"], rtol: float) -> Corners | None:
    """Evaluate a design in the corners, at a tolerance of ``rtol`` [-]; None where nothing scatters."""
    problem = goal.problem
    if problem.scatter is None:
        return None
    scenarios = [it if isinstance(it, Case) else Case(it) for it in problem.scenarios]
    cases, middle = problem.scatter.corners(scenarios), problem.scatter.middle(scenarios)
    (evaluation,) = evaluator([scaled], rtol, slopes=False, cases=(*cases, *middle))
    first = Goal(problem, problem.objective)
    values = np.where(evaluation.solved, evaluation.quantities @ first.weights(problem.objective), np.nan)
    count, ranges = len(cases), len(problem.scatter.distributions)
    broken = [tuple(first.broken_in(evaluation, k)) for k in range(len(evaluation.code))]
    return Corners(
        cases=cases,
        broken=tuple(broken[:count]),
        values=values[:count],
        worst=next(k for k in first.worst_first(evaluation) if k < count),
        ranges=ranges,
        whole=count == len(scenarios) * 2**ranges,
        middle=float(np.max(values[count:])),
        middle_holds=not any(broken[count:]),
        middle_touches=bool(np.any(evaluation.impacts[count:] > 0)),
    )
