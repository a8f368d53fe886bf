"""The result of a tuning."""

import dataclasses

import numpy as np

from ..mechanisms import Design
from .evaluation import Evaluation
from .floor import Floor
from .goal import Goal
from .problem import Problem
from .search import Settings
from .store import Record


@dataclasses.dataclass(frozen=True)
class Tuned:
    """A finished tuning. Print it for tables.

    ``design``: the best one found; ``before``, ``after``: start and result in every case at rtol 1e-9, with
    derivatives; ``goal``: of the last stage; ``residual`` [-]: what first-order information at rtol 1e-9 still promises
    within a tenth of every range, relative to the objective; ``gradient_error`` [-]: difference between the objective's
    slopes at the search's tolerance and at rtol 1e-9, relative to the largest; ``floor``: first impacts, which no
    buffer softens; ``records``: every evaluation, as in the log; ``captures``: solved in all, the last check included.
    """

    problem: Problem
    settings: Settings
    goal: Goal
    design: Design
    before: Evaluation
    after: Evaluation
    residual: float
    gradient_error: float
    converged: bool
    message: str
    floor: Floor
    records: tuple[Record, ...]
    captures: int

    @property
    def objective(self) -> tuple[float, float]:
        """The problem's objective [N], before and after."""
        first = Goal(self.problem, self.problem.objective)
        return first.value(self.before), first.value(self.after)

    @property
    def screened(self) -> int:
        """How many of the captures were solved without derivatives."""
        alone = self.settings.starts == 1
        return 0 if alone else len(self.problem.cases) * sum(it["status"] == "start" for it in self.records)

    @property
    def feasible(self) -> bool:
        """Whether the result keeps to every constraint."""
        return self.goal.feasible(self.after)

    @property
    def above_floor(self) -> float:
        """How far the worst peak is above the floor of its own first impacts, relative [-]."""
        return float(np.max(self.after.quantities[:, 0]) / np.max(self.floor.simulated) - 1.0)

    def __repr__(self) -> str:
        from .summary import tuned_table

        return tuned_table(self)
