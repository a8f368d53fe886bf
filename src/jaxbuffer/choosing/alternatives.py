"""Combinations run at every load case at tight tolerance, and judged."""

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..fields import Part
from ..mechanisms.limit import Limit
from ..tuning.problem.objective import Objective
from ..tuning.problem.problem import Problem
from ..tuning.report.tuned import Tuned
from ..tuning.search.evaluation import Evaluation, gather
from ..tuning.search.goal import Goal
from .catalogue import CataloguePart
from .criterion import Criterion, constant, objective_of_runs
from .order import order
from .runs import Runs


class LimitMargin(NamedTuple):
    """How far the worst load case keeps from a limit.

    ``value``: there, in the quantity's unit; ``share``: of the limit, relative [-], below 0 beyond it, None where it is
    not known; ``case``: its place.
    """

    limit: Limit
    value: float
    share: float | None
    case: int


@dataclasses.dataclass(frozen=True)
class Alternative:
    """One combination of parts, run at every load case at tight tolerance.

    - ``names``: of its parts, in the order of the catalogues.
    - ``design``: with them, and with the tuned variables if they were ``tuned``.
    - ``value``: the objective, price and mass included; ``searched``: the same at the problem's tolerance.
    - ``totals``: sums of price and mass [kg].
    - ``evaluation``: every load case.
    - ``feasible``: whether it keeps all limits; ``broken``: a line for each that it breaks.
    - ``margins``: from each limit, the tightest first.
    - ``deciding``: the place of the load case with the largest objective.
    - ``second``: the second objective, price and mass included; None without one.
    """

    names: tuple[str, ...]
    design: Part
    value: float
    searched: float
    totals: Mapping[str, float]
    evaluation: Evaluation
    feasible: bool
    broken: tuple[str, ...]
    margins: tuple[LimitMargin, ...]
    deciding: int
    tuned: Tuned | None = None
    second: float | None = None


def alternatives(criterion: Criterion, runs: Runs, numbers: Sequence[int], tight: float) -> dict[int, Alternative]:
    """Run combinations, by their numbers, at every load case, and judge them by the runs at ``tight`` rtol [-]."""
    cases, made = range(len(criterion.problem.cases)), dict[int, Alternative]()
    wanted = [(number, case) for number in numbers for case in cases]
    # At both tolerances, because the change between them says how sure the ranking is.
    measured, searched = runs.each(wanted, tight), runs.each(wanted)
    for place, number in enumerate(numbers):
        design = runs.combinations.built(number)
        assert isinstance(design, Part), "those that do not fit are none of the best"
        problem = dataclasses.replace(criterion.problem, design=design)
        own = slice(place * len(cases), (place + 1) * len(cases))
        both = [gather(problem, problem.start(), list(problem.cases), it[own]) for it in (measured, searched)]
        made[number] = _alternative(criterion, problem, runs.combinations.parts(number), *both)
    return made


def _alternative(
    criterion: Criterion,
    problem: Problem,
    parts: Sequence[CataloguePart],
    evaluation: Evaluation,
    searched: Evaluation,
) -> Alternative:
    """Judge a combination; ``problem``: with its design."""
    names = dict.fromkeys(name for part in parts for name in part.totals)
    totals = {name: sum(part.totals[name] for part in parts if name in part.totals) for name in names}
    goal = Goal(problem, criterion.of_runs or problem.objective)
    above = [limit for limit in criterion.limits if not limit.keeps(totals[limit.name])]
    broken = [limit.sentence(totals[limit.name], criterion.catalogue[limit.name]) for limit in above]
    return Alternative(
        names=tuple(part.name for part in parts),
        design=problem.design,
        value=_value(problem, criterion.objective, evaluation, totals),
        searched=_value(problem, criterion.objective, searched, totals),
        totals=totals,
        evaluation=evaluation,
        feasible=goal.feasible(evaluation) and not above,
        broken=(*broken, *goal.broken(evaluation)),
        margins=margins(problem, evaluation),
        deciding=int(np.argmax(evaluation.quantities @ goal.weights)),
        second=_second(criterion, problem, evaluation, totals),
    )


def with_variables(criterion: Criterion, alternative: Alternative, tuned: Tuned) -> Alternative:
    """Return a combination with its variables as they were tuned."""
    problem = dataclasses.replace(tuned.problem, design=tuned.design)
    goal = Goal(problem, problem.objective)
    return dataclasses.replace(
        alternative,
        design=tuned.design,
        value=tuned.objective[1] + float(criterion.constant(alternative.totals)),
        evaluation=tuned.after,
        feasible=tuned.feasible,
        broken=tuple(goal.broken(tuned.after)),
        margins=margins(problem, tuned.after),
        deciding=int(np.argmax(tuned.after.quantities @ problem.objective.vector(problem.names))),
        second=_second(criterion, problem, tuned.after, alternative.totals),
        tuned=tuned,
    )


def _value(problem: Problem, objective: Objective, evaluation: Evaluation, totals: Mapping[str, float]) -> float:
    """Return an objective of runs, price and mass."""
    # Where price and mass decide alone, the problem's own objective must add nothing to them.
    share = objective_of_runs(objective)
    return float((0.0 if share is None else Goal(problem, share).value(evaluation)) + constant(objective, totals))


def _second(
    criterion: Criterion, problem: Problem, evaluation: Evaluation, totals: Mapping[str, float]
) -> float | None:
    return None if criterion.then is None else _value(problem, criterion.then.objective, evaluation, totals)


def best_first(criterion: Criterion, made: Sequence[Alternative], ceiling: float) -> list[int]:
    """Return the places of combinations in their order: feasible ones first, those within the ceiling by the second
    objective; those that are not feasible stay in theirs."""
    feasible = [k for k, it in enumerate(made) if it.feasible]
    values = np.array([made[k].value for k in feasible])
    seconds = values if criterion.then is None else np.array([made[k].second for k in feasible], float)
    return [feasible[k] for k in order(values, seconds, ceiling)] + [k for k, it in enumerate(made) if not it.feasible]


def ceiling(criterion: Criterion, made: Iterable[Alternative]) -> float:
    """Return up to which objective the second one orders combinations, of which the best of ``made`` decides; infinite
    without a second one, and where none is feasible."""
    then, lowest = criterion.then, math.inf
    if then is None:
        return lowest
    for it in made:
        if it.feasible:
            own = then.ceiling(it.value)
            # Its own tuning has raised the objective, within the tolerance of the least that it had reached.
            if it.tuned is not None and it.tuned.goal.ceiling is not None:
                own = it.tuned.goal.ceiling.value + then.ceiling(float(criterion.constant(it.totals)))
            lowest = min(lowest, own)
    return lowest


def margins(problem: Problem, evaluation: Evaluation) -> tuple[LimitMargin, ...]:
    """Return how far a design keeps from each limit in its worst load case, the tightest first."""
    known, made = reported(problem, evaluation), []
    for it in Goal(problem, problem.objective).on_quantities:
        limit, values = it.limit, known[:, it.column]
        # A run without the number keeps no limit, so it counts as the worst.
        worst = int(np.argmax(np.nan_to_num(limit.rows(values), nan=np.inf)))
        made.append(LimitMargin(limit, float(values[worst]), limit.margin(float(values[worst])), worst))
    return tuple(sorted(made, key=lambda it: -np.inf if it.share is None else it.share))


def reported(problem: Problem, evaluation: Evaluation) -> Float[np.ndarray, "cases quantities"]:
    """Return the quantities of every load case, NaN where a run failed or waited for one in vain."""
    known = problem.known(evaluation.code) & evaluation.solved[:, None]
    return np.where(known, evaluation.quantities, np.nan)
