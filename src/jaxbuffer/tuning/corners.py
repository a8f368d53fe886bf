"""A tuned design in the corners of the ranges that its problem scatters over: samples alone are no bound."""

import dataclasses

import numpy as np
from jaxtyping import Float

from .cases import Case
from .evaluation import Evaluator
from .goal import Goal
from .problem import Problem

Values = Float[np.ndarray, " cases"]


@dataclasses.dataclass(frozen=True)
class Corners:
    """A design in the corners of the sampled ranges, at every scenario that scatters.

    - ``cases``: the corners; ``broken``: of each what does not hold there, limits and how the run must end; ``values``:
      the objective's, in its unit, NaN where a corner can not be built or its run fails.
    - ``worst``: the corner farthest beyond its limits.
    - ``ranges``: how many there are; ``whole``: whether all their corners were run, or a fraction of them.
    - ``middle``: the objective's largest value in the middle of the ranges; ``middle_holds``: whether it holds there.
    """

    cases: tuple[Case, ...]
    broken: tuple[tuple[str, ...], ...]
    values: Values
    worst: int
    ranges: int
    whole: bool
    middle: float
    middle_holds: bool

    @property
    def holding(self) -> int:
        """In how many corners the design holds."""
        return sum(not it for it in self.broken)

    @property
    def largest(self) -> float:
        """The objective's largest value, NaN where no corner has one."""
        return float(np.nanmax(self.values)) if np.any(np.isfinite(self.values)) else float("nan")

    def lines(self, problem: Problem) -> list[str]:
        """What is to be said of them."""
        count, scenarios = len(self.cases), len(problem.scenarios)
        said = lambda value: problem.objective.said(value, problem.catalogue)  # noqa: E731
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
        return [*lines, f"the middle of the ranges: {middle}{'' if self.middle_holds else ', does not hold'}"]


def corners(goal: Goal, evaluator: Evaluator, scaled: Float[np.ndarray, " variables"], rtol: float) -> Corners | None:
    """A design in the corners, at a tolerance of ``rtol`` [-]; None where nothing scatters."""
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
    )
