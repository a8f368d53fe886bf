"""One evaluated design as a record of the log."""

import numpy as np

from .evaluation import Evaluation
from .goal import Goal
from .search import Branch
from .store import Record

STATUS = ("running", "converged", "stalled", "behind")


def record(goal: Goal, point: Evaluation, number: int, stage: int, search: int, branch: Branch | None) -> Record:
    """A design tried.

    **Arguments:** ``number`` of the evaluation; ``stage``; ``search``: number of the search; ``branch``: the search
    after it was tried, None for a start.
    """
    problem = goal.problem
    values = map(float, problem.values(point.scaled))
    return {
        "evaluation": number,
        "stage": stage,
        "search": search,
        "step": 0 if branch is None else branch.steps,
        "accepted": branch is None or branch.point is point,
        "objective": goal.value(point),
        "unit": goal.objective.unit(problem.catalogue),
        "feasible": goal.feasible(point),
        "excess": float(np.sum(goal.excess(point))),
        "radius": None if branch is None else branch.radius,
        "residual": None if branch is None or np.isnan(branch.residual) else branch.residual,
        "status": "start" if branch is None else STATUS[branch.status],
        "captures": len(problem.cases) * (number + 1),
        "values": dict(zip(problem.paths, values, strict=True)),
        "outcome": [problem.mechanism.outcomes(int(code)).name for code in point.code],
        "succeeded": [bool(met) for met in point.succeeded],
        "impacts": [int(count) for count in point.impacts],
        "margin": point.margin.tolist(),
        **{name: point.quantities[:, q].tolist() for q, name in enumerate(problem.names)},
    }
