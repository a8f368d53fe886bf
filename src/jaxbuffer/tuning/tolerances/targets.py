"""What a corner of tolerances can be worst in: each objective, and each constraint."""

import dataclasses

import numpy as np
from jaxtyping import Float

from ...value_text import with_unit
from ..problem.objective import Objective
from ..problem.problem import Problem
from ..search.constraints import Constraint
from ..search.evaluation import Evaluation
from ..search.goal import Goal


@dataclasses.dataclass(frozen=True)
class ObjectiveTarget:
    """An objective, of whose number in every load case a larger one is worse; it says what a `Constraint` says."""

    problem: Problem
    objective: Objective

    limited = False  # no number of it breaks anything
    title, bound = "objective", ""

    def values(self, point: Evaluation) -> Float[np.ndarray, " cases"]:
        """Return its number in each load case, infinite where the run failed."""
        return np.where(point.solved, point.quantities @ self.objective.vector(self.problem.names), np.inf)

    def slopes(self, point: Evaluation) -> Float[np.ndarray, "cases parameters"]:
        """Return the slopes of its numbers by what the evaluation has slopes by, 0 where there are none."""
        slopes = np.einsum("q,cqn->cn", self.objective.vector(self.problem.names), point.quantities_slope)
        return np.where(point.solved[:, None], slopes, 0.0)

    def text(self, number: float) -> str:
        """Return one of its numbers in its unit: "201 N"."""
        return with_unit(*self.objective.shown(number, self.problem.catalogue), 5)


Target = ObjectiveTarget | Constraint
"""A number of every load case of which a larger one is worse."""


def targets(problem: Problem) -> list[Target]:
    """Return the targets of a problem: objectives over the worst case, and constraints."""
    objectives = [problem.objective, *([] if problem.then is None else [problem.then.objective])]
    # No single corner decides over a mean.
    some = [ObjectiveTarget(problem, it) for it in objectives if it.over == "worst"]
    return [*some, *Goal(problem, problem.objective).constraints]
