"""What a corner of tolerances can be worst in: each objective, each limit, and the end that runs must have."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..mechanisms.limit import IMPACTS, Limit
from ..value_text import with_unit
from .evaluation import Evaluation
from .goal import Goal
from .objective import Objective
from .problem import Problem


class Target(NamedTuple):
    """A number of every load case of which a larger one is worse.

    It is that of an ``objective``, of a ``limit``, relative to this and 0 on it, or, where both are None, the negative
    margin of the end that runs must have, 0 where they just have it.
    """

    problem: Problem
    objective: Objective | None = None
    limit: Limit | None = None

    @property
    def limited(self) -> bool:
        """Return whether a number above 0 breaks something."""
        return self.objective is None

    def values(self, evaluation: Evaluation) -> Float[np.ndarray, " cases"]:
        """Return the number of each load case, infinite where its run failed."""
        if self.objective is not None:
            numbers = evaluation.quantities @ self.objective.vector(self.problem.names)
        elif self.limit is None:
            numbers = -evaluation.margin
        elif self.limit.name == IMPACTS:
            numbers = self.limit.rows(evaluation.impacts.astype(float))
        else:
            numbers = self.limit.rows(evaluation.quantities[:, self.problem.names.index(self.limit.name)])
        return np.where(evaluation.solved, numbers, np.inf)

    def slopes(self, evaluation: Evaluation) -> Float[np.ndarray, "cases parameters"]:
        """Return the number's slopes by what the evaluation has slopes by; 0 where there are none."""
        by = evaluation.quantities_slope
        if self.objective is not None:
            slopes = np.einsum("q,cqn->cn", self.objective.vector(self.problem.names), by)
        elif self.limit is None:
            slopes = -evaluation.margin_slope
        elif self.limit.name == IMPACTS:
            # A count of impacts has no slope: it jumps from one whole number to the next.
            slopes = np.zeros_like(evaluation.margin_slope)
        else:
            slopes = self.limit.slopes(by[:, self.problem.names.index(self.limit.name)])
        return np.where(evaluation.solved[:, None], slopes, 0.0)

    @property
    def title(self) -> str:
        """Return what it is, in words."""
        if self.objective is not None:
            return "objective"
        if self.limit is None:
            return str(self.problem.mechanism.tuning.margin).replace("_", " ")
        return IMPACTS if self.limit.name == IMPACTS else self.problem.catalogue[self.limit.name].title

    @property
    def bound(self) -> str:
        """Return the limit in words, after a comma: ", limit ≤ 25 mm"; "" where there is none."""
        if self.limit is None:
            return ""
        shown = ("", 1.0) if self.limit.name == IMPACTS else self.problem.catalogue[self.limit.name].in_figures
        return f", limit {self.limit.bound_text(*shown)}"

    def text(self, value: float) -> str:
        """Return a number in the unit of what it is of: "25.1 mm"."""
        if self.objective is not None:
            return with_unit(*self.objective.shown(value, self.problem.catalogue), 5)
        if self.limit is None:
            return f"{-value:.3g}"
        quantity = self.limit.bound * (1.0 + self.limit.sign * value)
        if self.limit.name == IMPACTS:
            return f"{quantity:.0f}"
        return self.problem.catalogue[self.limit.name].in_words(quantity, 5)


def targets(problem: Problem) -> list[Target]:
    """Return the targets of a problem: objectives over the worst case, limits, the end that runs must have."""
    goal = Goal(problem, problem.objective)
    objectives = [problem.objective, *([] if problem.then is None else [problem.then.objective])]
    # No single corner decides over a mean.
    some = [Target(problem, objective=it) for it in objectives if it.over == "worst"]
    some += [Target(problem, limit=it) for _, it in goal.indexed_limits]
    some += [Target(problem, limit=it) for it in goal.limits.of_impacts]
    return some + ([Target(problem)] if goal.require_success else [])
