"""What stands in the way of a tuned design: limits, bounds of variables, the first impact."""

from collections.abc import Collection, Sequence

import numpy as np
from rich.table import Table

from ...mechanisms.limit import IMPACTS
from ...value_text import percent_text, relative_change, with_unit
from ..problem.problem import Problem
from ..search.checks import PeakForceBound
from ..search.evaluation import Evaluation
from ..search.goal import Goal
from .broken_limits import levers_text
from .limit_rows import ShownRow, limit_rows, limit_table

ROUNDED = 6  # decimals of a room: a search for a lower bound ends no nearer to it
NEAR = 0.05  # relative distance from its lower bound within which a force is near it


def limits_in_the_way(
    goal: Goal, after: Evaluation, lower_bound: PeakForceBound | None, inactive: Collection[str] = ()
) -> Table | None:
    """Return the table of limits, variables on their bounds, and lower bounds; None where there is nothing of these.

    **Arguments:** ``after``: the design in all load cases; ``lower_bound``: of its first impacts, None where it is not
    known; ``inactive``: paths of variables that change nothing.
    """
    problem, limits = goal.problem, goal.limits
    labels = [problem.label(k) for k in range(len(problem.cases))]
    reported = np.where(problem.known(after.code) & after.solved[:, None], after.quantities, np.nan)
    values = [
        dict(zip(problem.names, row, strict=True)) | {IMPACTS: int(count)}
        for row, count in zip(reported.tolist(), after.impacts, strict=True)
    ]
    rows = limit_rows((*limits.each, *limits.of_impacts), values, labels)
    always = problem.mechanism.always(problem.design)
    shown = [ShownRow.of(row, problem.catalogue, always) for row in rows]
    if problem.success is not None and problem.limits.require_success:
        end = ShownRow.of_end(problem.success, labels, after.succeeded.tolist())
        # An end that is missed comes first, as broken limits do.
        shown.insert(0 if end.state == "broken" else len(shown), end)
    for variable, value in zip(problem.variables, problem.values(after.scaled), strict=True):
        # Of the variables those on a bound that have an effect.
        if not (side := variable.at_bound(float(value))) or variable.path in inactive:
            continue
        low = side == "at low bound"
        bound = with_unit(*problem.shown(variable.path, variable.low if low else variable.high))
        text = with_unit(*problem.shown(variable.path, float(value)), 5)
        shown.append(ShownRow(variable.path, text, f"{'≥' if low else '≤'} {bound}", "0 %", state=side))
    shown += [] if lower_bound is None else _lower_bounds(problem, after, lower_bound, labels)
    return limit_table(shown, several=len(labels) > 1) if shown else None


def _lower_bounds(
    problem: Problem, after: Evaluation, lower_bound: PeakForceBound, labels: Sequence[str]
) -> list[ShownRow]:
    """Return a row for each quantity with a lower bound: the peak force at this design, limited ones within the
    variables' bounds."""
    bounds = {name: (least.value, least.case) for name, least in lower_bound.least.items()}
    peak = problem.peak_quantity
    if peak is not None and np.isfinite(lower_bound.highest) and lower_bound.highest > 0.0:
        bounds.setdefault(peak, (lower_bound.highest, int(np.argmax(lower_bound.simulated))))
    rows = []
    for name, (bound, case) in bounds.items():
        quantity, limit = problem.catalogue[name], problem.limits.at_most.get(name)
        value = float(np.max(after.quantities[:, problem.names.index(name)]))
        above = relative_change(bound, value)
        if above is None:
            continue
        state = "above the limit" if limit is not None and bound > limit else "near" if above < NEAR else ""
        shown, least = quantity.in_words(value, 4), quantity.in_words(bound, 4)
        title = f"first impact: {quantity.title or name}"
        room = percent_text(round(above, ROUNDED), ".3g")
        rows.append(ShownRow(title, shown, f"≥ {least}", room, labels[case], state))
    return rows


def first_impact_levers(problem: Problem, lower_bound: PeakForceBound, after: Evaluation) -> list[str]:
    """Return which numbers that are no variables move the first impact, and how much less or more the variables do;
    none unless the largest peak force is near its lower bound."""
    above, each = relative_change(lower_bound.highest, float(np.max(after.peak_force))), lower_bound.elasticities
    outside = levers_text({path: value for path, value in each.items() if path not in problem.paths})
    if not outside or above is None or above >= NEAR:
        return []
    # However weak: that is what the others are compared with.
    inside = [f"{path} {with_unit(value, '', 2, sign=True)}" for path, value in each.items() if path in problem.paths]
    return [
        f"  numbers that are no variables move it, {outside}",
        f"  of the variables {', '.join(inside) or 'none does'}",
    ]
