"""A tuned design in the corners of tolerances and of sampled ranges: in how many of them it holds."""

import dataclasses
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ...value_text import with_unit
from ..problem.cases import Case, corner_signs, in_sentence
from ..problem.problem import Problem
from ..problem.tolerances import moved
from ..search.evaluation import Evaluation, Evaluator
from ..search.goal import Goal

SEARCHED = (
    "the worst corners were searched for along the slopes and from each to its neighbours: no proof that no other"
    " corner is worse"
)


@dataclasses.dataclass(frozen=True)
class Corners:
    """A design in the corners of what scatters, at every scenario.

    - ``cases``: the corners; ``broken``: of each what does not hold there, limits and how the run must end; ``values``:
      the objective's, in its unit, NaN where a corner can not be built or its run fails.
    - ``worst``: the corner farthest beyond its limits.
    - ``ranges``: how many there are; ``whole``: whether all their corners were run, or a fraction of them.
    - ``middle``: the objective's largest value in the middle of the ranges, as drawn where there are tolerances;
      ``middle_holds``: whether it holds there; ``middle_touches``: whether anything does there.
    - ``what``: the ranges in words; ``searched``: whether the worst corner was searched for.
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
    what: str = "sampled ranges"
    searched: bool = False

    @property
    def holding(self) -> int:
        """Return in how many corners the design holds."""
        return sum(not it for it in self.broken)

    @property
    def hold(self) -> bool:
        """Return whether the design holds in all of them and in the middle."""
        return self.holding == len(self.cases) and self.middle_holds

    @property
    def verdict(self) -> str:
        """Return in words in how many corners the design holds."""
        if self.hold:
            count, which = len(self.cases), "" if self.whole else " that were run"
            return f"the design holds in {count} of {count} corners of the {self.what}{which}"
        if self.holding == len(self.cases):
            return f"the design holds in every corner of the {self.what}, and not in their middle"
        which = f"{len(self.cases)} corners" if self.whole else f"the {len(self.cases)} corners that were run"
        return f"the design holds in {self.holding} of {which} of the {self.what} only"

    @property
    def largest(self) -> float:
        """Return the objective's largest value, NaN where no corner has one."""
        return float(np.nanmax(self.values)) if np.any(np.isfinite(self.values)) else float("nan")

    def lines(self, problem: Problem) -> list[str]:
        """Return a summary, the corner farthest beyond a limit and the middle, a line each."""
        count, scenarios = len(self.cases), len(problem.scenarios)

        def shown(value: float) -> str:
            return with_unit(*problem.objective.shown(value, problem.catalogue), 5)

        at = f" at {scenarios} scenarios" if scenarios > 1 else ""
        which = (
            f"all {2**self.ranges} corners" if self.whole else f"{count // scenarios} of the {2**self.ranges} corners"
        )
        lost = int(np.sum(~np.isfinite(self.values)))

        def named(k: int) -> str:
            return corner_in_sentence(problem, self.cases[k].label(self.cases), k, count)

        parts = [f"the design holds in {self.holding} of {count}"]
        parts += [f"{lost} can not be built or simulated"] if lost else []
        if lost < count:
            where = named(int(np.nanargmax(self.values)))
            parts.append(f"the largest objective there is {shown(self.largest)}, at {where}")
        lines = [f"{which} of the {self.ranges} {self.what}{at}: {'; '.join(parts)}"]
        if self.searched:
            lines.append(SEARCHED)
        if broken := self.broken[self.worst]:
            lines.append(f"the corner farthest beyond a limit, {named(self.worst)}: {'; '.join(broken)}")
        middle = shown(self.middle) if np.isfinite(self.middle) else "can not be simulated"
        if self.middle == 0.0 and not self.middle_touches:
            middle = "nothing touches there"
        return [*lines, f"{self.middle_title}: {middle}{'' if self.middle_holds else ', does not hold'}"]

    @property
    def middle_title(self) -> str:
        """Return what the middle of the ranges is, in words."""
        return "as drawn, without tolerances" if self.what == "tolerances" else "the middle of the ranges"


def corner_in_sentence(problem: Problem, label: str, k: int, count: int) -> str:
    """Return a corner as a sentence names it, with its scenario's number where there are several.

    **Arguments:** ``k``: its place among ``count`` corners, which stand scenario by scenario.
    """
    scenarios = len(problem.scenarios)
    # With samples the numbers are those of the samples, and no corner is of one of them.
    several = scenarios > 1 and problem.scatter is None
    return in_sentence(label, str(k * scenarios // count + 1) if several else "")


class CornerRuns(NamedTuple):
    """The runs of a design in corners and middle.

    ``evaluation`` of all ``cases``, the corners first; ``corners``: how many these are; ``signs`` of the tolerances in
    each, and the ``bases`` that these differ from.
    """

    evaluation: Evaluation
    cases: tuple[Case, ...]
    corners: int
    signs: Float[np.ndarray, "corners tolerances"]
    bases: tuple[Case, ...]


def run_corners(
    problem: Problem, evaluator: Evaluator, scaled: Float[np.ndarray, " variables"], rtol: float
) -> CornerRuns | None:
    """Run a design in the corners, without derivatives, at a tolerance of ``rtol`` [-]; None where nothing scatters."""
    scatter, tolerances = problem.scatter, problem.tolerances
    sampled = 0 if scatter is None else len(scatter.distributions)
    if not sampled and not tolerances:
        return None
    scenarios = [it if isinstance(it, Case) else Case(it) for it in problem.scenarios]
    rows = corner_signs(sampled + len(tolerances))
    # Those that a search found, in the middle of what is sampled.
    of_search = np.column_stack([np.zeros((len(problem.signs), sampled)), problem.corner_rows[: len(problem.signs)]])
    # An empty list has no columns, and so cannot stand below the other rows.
    rows = np.concatenate([rows, [row for row in of_search if not np.any(np.all(row == rows, axis=1))] or rows[:0]])

    def bases(signs: np.ndarray) -> list[Case]:
        pairs = [(case, row[:sampled]) for case in scenarios for row in signs]
        return [case if scatter is None else scatter.at([case], row[None])[0] for case, row in pairs]

    middle = bases(np.zeros((1, rows.shape[1])))
    of_tolerances = np.tile(rows[:, sampled:], (len(scenarios), 1))
    pairs = list(zip(bases(rows), of_tolerances, strict=True))
    cases = (*(moved(base, tolerances, row) for base, row in pairs), *middle)
    (evaluation,) = evaluator([scaled], rtol, slopes=False, cases=cases)
    return CornerRuns(evaluation, cases, len(pairs), of_tolerances, tuple(base for base, _ in pairs))


def corners(problem: Problem, runs: CornerRuns) -> Corners:
    """Return in which corners a design holds."""
    goal, evaluation, count = Goal(problem, problem.objective), runs.evaluation, runs.corners
    sampled = 0 if problem.scatter is None else len(problem.scatter.distributions)
    ranges = sampled + len(problem.tolerances)
    values = np.where(evaluation.solved, evaluation.quantities @ problem.objective.vector(problem.names), np.nan)
    broken = [tuple(goal.broken_in(evaluation, k, runs.cases)) for k in range(len(runs.cases))]
    names = [name for name, there in (("tolerances", problem.tolerances), ("sampled ranges", sampled)) if there]
    return Corners(
        cases=runs.cases[:count],
        broken=tuple(broken[:count]),
        values=values[:count],
        # The middle of the ranges is among the runs, but is no corner.
        worst=next(k for k in goal.worst_first(evaluation) if k < count),
        ranges=ranges,
        whole=count == len(problem.scenarios) * 2**ranges,
        middle=float(np.max(values[count:])),
        middle_holds=not any(broken[count:]),
        middle_touches=bool(np.any(evaluation.impacts[count:] > 0)),
        what=" and ".join(names),
        searched=problem.needs_search,
    )
