"""Combinations run at every load case at tight tolerance, and judged."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from ..fields import Part
from ..tuning.evaluation import Evaluation, gather
from ..tuning.goal import Goal
from ..tuning.problem import Problem
from ..tuning.tuned import Tuned
from .catalogue import CataloguePart
from .choice import Alternative, margins
from .criterion import Criterion
from .runs import Runs


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
    objective, constant = criterion.of_runs or problem.objective, criterion.constant(totals)
    goal = Goal(problem, objective)
    # Where price and mass decide alone, the problem's own objective must add nothing to them.
    value, before = (goal.value(it) if criterion.of_runs else 0.0 for it in (evaluation, searched))
    above = [limit for limit in criterion.limits if not limit.keeps(totals[limit.name])]
    broken = [limit.sentence(totals[limit.name], criterion.catalogue[limit.name]) for limit in above]
    return Alternative(
        names=tuple(part.name for part in parts),
        design=problem.design,
        value=float(value + constant),
        searched=float(before + constant),
        totals=totals,
        evaluation=evaluation,
        feasible=goal.feasible(evaluation) and not above,
        broken=(*broken, *goal.broken(evaluation)),
        margins=margins(problem, evaluation),
        deciding=int(np.argmax(evaluation.quantities @ goal.weights(objective))),
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
        deciding=int(np.argmax(tuned.after.quantities @ goal.weights(problem.objective))),
        tuned=tuned,
    )
