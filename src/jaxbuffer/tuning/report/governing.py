"""What decides a design: its limits, the end of its runs and its objectives, each in the load case that governs it."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..search.constraints import EndMargin, QuantityLimit
from ..search.evaluation import Evaluation
from ..search.goal import Goal

FAR = 0.5  # room of a limit that a mechanism always has, beyond which it decides nothing
OBJECTIVE, THEN = "objective", "then"  # what the objectives are called among limited quantities


class GovernedQuantity(NamedTuple):
    """A limited quantity or an objective of a design, in the load cases that govern it.

    ``name`` of the quantity, or `OBJECTIVE`, `THEN`; ``room`` to the limit, relative to it [-], infinite for an
    objective; ``value`` in its unit; ``weights``: how much each load case counts, by its place, 1 for a limit's single
    one; ``slope``: returns the slopes of its share in a load case of an evaluation, given by its place there.
    """

    name: str
    room: float
    value: float
    weights: Mapping[int, float]
    slope: Callable[[Evaluation, int], Float[np.ndarray, " parameters"]]

    def elasticities(self, point: Evaluation, places: Mapping[int, int]) -> Float[np.ndarray, " parameters"]:
        """Return the relative change of the value by what an evaluation has slopes by.

        **Arguments:** ``places``: where the evaluation has the load cases.
        """
        slopes = [weight * self.slope(point, places[case]) for case, weight in self.weights.items()]
        return np.asarray(np.sum(slopes, axis=0) / self.value)


def governed_quantities(goal: Goal, after: Evaluation) -> list[GovernedQuantity]:
    """Return what decides a design, the limit with the least room first, then the objectives.

    What has no slopes, and what is zero, is left out.

    **Arguments:** ``after``: the design in all load cases.
    """
    problem, limits = goal.problem, list[GovernedQuantity]()
    for it in goal.constraints:
        limit = _of_limit(it, after) if isinstance(it, QuantityLimit) else None
        # A limit that nobody asked for decides only where it is near.
        if limit is not None and (limit.name in problem.limits.names or limit.room <= FAR):
            limits.append(limit)
    end = _of_end(goal, after)
    limits += [] if end is None else [end]
    objectives = {OBJECTIVE: Goal(problem, problem.objective)}
    objectives |= {} if goal.ceiling is None else {THEN: goal}
    each = [*sorted(limits, key=lambda it: it.room), *(_of_objective(*pair, after) for pair in objectives.items())]
    # A quantity with limits from both sides stands in the way of the nearer one.
    nearest = {it.name: it for it in reversed(each) if it.value}
    return [it for it in each if it is nearest.get(it.name)]


def _of_limit(limit: QuantityLimit, after: Evaluation) -> GovernedQuantity | None:
    """Return a limit in the load case that is nearest to it; None where it is known of none."""
    numbers = limit.numbers(after)
    if not np.any(known := np.isfinite(numbers) & after.solved):
        return None
    case = int(np.argmax(np.where(known, numbers, -np.inf)))
    return _of_quantity(limit.limit.name, -float(numbers[case]), limit.column, case, after)


def _of_end(goal: Goal, after: Evaluation) -> GovernedQuantity | None:
    """Return the end that runs must have, in the load case with the least margin: the time until it, or what is left
    that must fall until then; None for an end of which neither is known."""
    problem, end = goal.problem, goal.problem.end
    if end is None or not end.quantity or not any(isinstance(it, EndMargin) for it in goal.constraints):
        return None
    case = int(np.argmin(np.where(after.solved, after.margin, np.inf)))
    if problem.succeeded(after.code[case]):
        name = next((name for name in problem.names if problem.catalogue[name].awaits == end.name), "")
    else:
        name = end.quantity if problem.mechanism.succeeded(int(after.code[case])) else ""
    if name not in problem.names or not after.solved[case]:
        return None
    return _of_quantity(name, float(after.margin[case]), problem.names.index(name), case, after)


def _of_quantity(name: str, room: float, column: int, case: int, after: Evaluation) -> GovernedQuantity:
    def slope(point: Evaluation, place: int) -> np.ndarray:
        return np.asarray(point.quantities_slope[place, column])

    return GovernedQuantity(name, room, float(after.quantities[case, column]), {case: 1.0}, slope)


def _of_objective(name: str, goal: Goal, after: Evaluation) -> GovernedQuantity:
    """Return an objective, in the load cases that count."""
    weights = goal.objective.case_weights(after.quantities @ goal.weights)
    counting = {int(case): float(weights[case]) for case in np.flatnonzero(weights)}

    def slope(point: Evaluation, place: int) -> np.ndarray:
        return np.asarray(goal.weights @ point.quantities_slope[place])

    return GovernedQuantity(name, np.inf, goal.value(after), counting, slope)
