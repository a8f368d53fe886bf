"""The result of a tuning."""

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from ..fields import Part
from .corners import Corners
from .evaluation import Evaluation
from .floor import Floor
from .goal import Goal
from .problem import Problem
from .settings import Settings
from .store import Record
from .why import broken_limits

if TYPE_CHECKING:
    import pandas as pd


@dataclasses.dataclass(frozen=True)
class Tuned:
    """A finished tuning. Print it for tables.

    - ``problem``, ``settings``: what was asked.
    - ``goal``: of the last stage.
    - ``design``: the best one found.
    - ``before``, ``after``: start and result in every case at rtol 1e-9, with derivatives.
    - ``residual``: what first-order information at rtol 1e-9 still predicts to gain within a tenth of every range,
    relative to the objective [-].
    - ``gradient_error``: difference between the objective's slopes at the search's tolerance and at rtol 1e-9, relative
      to the largest [-].
    - ``ended``: how the search ended, a name of `message.Ended`; ``borne_out``: whether another search that began apart
      found the same; ``message``: both in words.
    - ``floor``: first impacts, which no buffer softens; None where the mechanism has no such floor.
    - ``records``: every evaluation, as in the log.
    - ``captures``: solved in all, the last check included.
    - ``corners``: the design in the corners of the ranges that the problem scatters over; None where nothing scatters.

    **Example:**

    >>> problem = jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)])
    >>> tuned = jb.tune(problem, iterations=2, starts=1)
    >>> print(f"{jb.get(tuned.design, 'buffer.k_A'):.0f} N/m, feasible: {tuned.feasible}")
    405 N/m, feasible: True
    """

    problem: Problem
    settings: Settings
    goal: Goal
    design: Part
    before: Evaluation
    after: Evaluation
    residual: float
    gradient_error: float
    ended: str
    borne_out: bool
    message: str
    floor: Floor | None
    records: tuple[Record, ...]
    captures: int
    corners: Corners | None = None

    @property
    def objective(self) -> tuple[float, float]:
        """The problem's objective [N], before and after."""
        first = Goal(self.problem, self.problem.objective)
        return first.value(self.before), first.value(self.after)

    @property
    def worst_first(self) -> tuple[Part, ...]:
        """The cases' scenarios by their peak contact force with the tuned design, the largest first."""
        return tuple(self.problem.scenarios_met[k] for k in np.argsort(-self.after.quantities[:, 0], kind="stable"))

    @property
    def screened(self) -> int:
        """How many of the captures were solved without derivatives."""
        alone = self.settings.starts == 1
        return 0 if alone else len(self.problem.cases) * sum(it["status"] == "start" for it in self.records)

    @property
    def converged(self) -> bool:
        """Whether the search ended because no larger reduction than its tolerance was left to gain."""
        return self.ended == "converged"

    @property
    def feasible(self) -> bool:
        """Whether the result keeps to every constraint."""
        return self.goal.feasible(self.after)

    @property
    def without_effect(self) -> tuple[str, ...]:
        """Paths of variables that change no quantity of any case, neither at the start nor in the result."""
        points = (self.before, self.after)
        slopes = [slope for point in points for slope in (point.quantities_slope[point.solved], point.margin_slope)]
        still = np.all([np.all(slope == 0.0, axis=tuple(range(slope.ndim - 1))) for slope in slopes], axis=0)
        return tuple(path for path, none in zip(self.problem.paths, still, strict=True) if none)

    @property
    def why(self) -> list[str]:
        """Of an infeasible result, a line for each broken limit, the worst first: in how many scenarios, how far, and
        which variables hold it back to first order; else empty."""
        return [] if self.feasible else [str(limit) for limit in broken_limits(self.goal, self.after)]

    @property
    def above_floor(self) -> float:
        """How far the worst peak is above the floor of its own first impacts, relative [-]; NaN without a floor."""
        if self.floor is None:
            return float("nan")
        return float(np.max(self.after.quantities[:, 0]) / np.max(self.floor.simulated) - 1.0)

    def to_pandas(self) -> "pd.DataFrame":
        """A row for each evaluated design, as in history.csv: objective, worst values over the scenarios, variables."""
        from ..labelled.arrays import frame
        from .table import tuning_history

        return frame(*tuning_history(self))

    def __repr__(self) -> str:
        from .summary import tuned_table

        return tuned_table(self)

    def _repr_html_(self) -> str:
        from ..tables import html
        from .summary import tuned_parts

        return html(*tuned_parts(self))
