"""The first-order model of a stage as a linear programme: its exact minimum within a box, by HiGHS.

Peaks, cases and constraints are piecewise linear in the step, so the best step of the *true* maxima (no smoothing) is
a linear programme. What it still promises within a tenth of every range is the first-order (KKT) residual: zero exactly
where weights on the active peaks, cases, limits and bounds balance the slopes (Fletcher, Practical Methods of
Optimization, section 14.2). A step that a schedule shortens does not lower it.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from .goal import NAMES, ROOM, Goal, Tangent
from .problem import Objective

RESIDUAL_RADIUS = 0.1  # of each variable's range

Step = Float[np.ndarray, " variables"]
Entries = list[tuple[int, float]]  # column and coefficient


class _Programme:
    """Variables added one block at a time, rows Σ a x ≤ b one at a time."""

    def __init__(self) -> None:
        self.cost: list[float] = []
        self.bounds: list[tuple[float | None, float | None]] = []
        self.entries: list[tuple[int, int, float]] = []
        self.right: list[float] = []

    def add(self, cost: float, low: float | None, high: float | None = None) -> int:
        self.cost.append(cost)
        self.bounds.append((low, high))
        return len(self.cost) - 1

    def row(self, entries: list[tuple[int, float]], right: float) -> None:
        self.entries += [(len(self.right), column, value) for column, value in entries if value != 0.0]
        self.right.append(right)

    def solve(self) -> np.ndarray | None:
        from scipy.optimize import linprog
        from scipy.sparse import coo_array

        rows, columns, values = zip(*self.entries, strict=True)
        matrix = coo_array((values, (rows, columns)), shape=(len(self.right), len(self.cost))).tocsr()
        found = linprog(self.cost, A_ub=matrix, b_ub=self.right, bounds=self.bounds, method="highs")
        return found.x if found.success else None


class Linear(NamedTuple):
    """The best step of the first-order model, and the relative decrease of the merit that it promises."""

    step: Step
    promise: float


class Cuts(NamedTuple):
    """Half-spaces that steps keep to: ``normals @ step <= offsets``, each offset positive."""

    normals: Float[np.ndarray, "cuts variables"]
    offsets: Float[np.ndarray, " cuts"]

    def shortened(self, step: Step) -> Step:
        """The step, or as much of it as they allow."""
        reach = self.normals @ step
        beyond = reach > self.offsets
        return step * float(np.min(self.offsets[beyond] / reach[beyond], initial=1.0))


def best_step(
    goal: Goal,
    tangent: Tangent,
    places: Step,
    radius: float,
    scale: float,
    penalty: float,
    cuts: Cuts | None = None,
    room: Float[np.ndarray, " rows"] | float = 0.0,
) -> Linear:
    """Minimise the merit's first-order model over steps of at most ``radius`` in each place, inside bounds and cuts and
    with ``room`` [-] to the limits (one for all, or one a row)."""
    programme = _Programme()
    low, high = np.maximum(-radius, -places), np.minimum(radius, 1.0 - places)
    steps = [programme.add(0.0, float(a), float(b)) for a, b in zip(low, high, strict=True)]
    cases = len(tangent.margin)
    used = goal.objective.vector()[0] > 0.0 or "peak_force" in goal.problem.limits.at_most
    used = used or (goal.ceiling is not None and goal.ceiling.objective.vector()[0] > 0.0)
    peak = [programme.add(0.0, 0.0) for _ in range(cases)] if used else []
    for k, column in enumerate(peak):
        change = radius * np.abs(tangent.peaks_slope[k]).sum(axis=1)
        lowest = tangent.peaks[k, 0] - change[0]
        for i in np.flatnonzero((tangent.peaks[k] > 0.0) & (tangent.peaks[k] + change >= lowest)):
            slope = list(zip(steps, map(float, tangent.peaks_slope[k, i]), strict=True))
            programme.row([*slope, (column, -1.0)], -float(tangent.peaks[k, i]))

    def weighted(k: int, weights: np.ndarray) -> tuple[Entries, float]:
        """A weighted sum of one case's quantities as entries and a constant."""
        slope = weights[1:] @ tangent.rest_slope[k]
        entries = list(zip(steps, map(float, slope), strict=True))
        if weights[0] > 0.0:
            entries.append((peak[k], float(weights[0])))
        return entries, float(weights[1:] @ tangent.rest[k])

    def aggregate(objective: Objective, cost: float) -> Entries:
        """min t + cap Σ max(0, f - t), the dual of `Objective.case_weights`; its entries."""
        cap = objective.cap(cases)
        base = programme.add(cost, None)
        above = [programme.add(cost * cap, 0.0) for _ in range(cases)]
        for k in range(cases):
            entries, constant = weighted(k, objective.vector())
            programme.row([*entries, (base, -1.0), (above[k], -1.0)], -constant)
        return [(base, 1.0), *((column, cap) for column in above)]

    for normal, offset in zip(*cuts, strict=True) if cuts is not None else ():
        programme.row(list(zip(steps, map(float, normal), strict=True)), float(offset))
    aggregate(goal.objective, 1.0 / scale)
    rows = _rows(goal, tangent, steps, weighted, aggregate)
    kept = np.broadcast_to(room, goal.rows(*tangent.after(np.zeros(len(places)))).shape)
    for k, (entries, right) in enumerate(rows):
        excess = programme.add(penalty, 0.0)
        programme.row([*entries, (excess, -1.0)], right - float(kept[k]))
    solution = programme.solve()
    still = np.zeros(len(places))
    if solution is None:
        return Linear(still, 0.0)
    step = np.clip(solution[: len(places)], low, high)
    before = goal.promised(tangent, still, scale, penalty)
    return Linear(step, before - goal.promised(tangent, step, scale, penalty))


def _rows(
    goal: Goal,
    tangent: Tangent,
    steps: list[int],
    weighted: Callable[[int, np.ndarray], tuple[Entries, float]],
    aggregate: Callable[[Objective, float], Entries],
) -> Iterator[tuple[Entries, float]]:
    """The constraints as entries ≤ right, in the order of `Goal.rows`."""
    cases = range(len(tangent.margin))
    for quantity, limit in goal.limited():
        one = np.zeros(len(NAMES))
        one[quantity] = 1.0 / limit
        for k in cases:
            entries, constant = weighted(k, one)
            yield entries, 1.0 - constant
    if goal.problem.limits.captured:
        for k in cases:
            slope = zip(steps, map(float, -tangent.margin_slope[k]), strict=True)
            yield list(slope), float(tangent.margin[k])
    if goal.ceiling is not None:
        yield [(c, a / goal.ceiling.value) for c, a in aggregate(goal.ceiling.objective, 0.0)], 1.0


def residual(goal: Goal, tangent: Tangent, places: Step, scale: float, penalty: float) -> Linear:
    """The best step within `RESIDUAL_RADIUS`, and what it still promises relative to the objective.

    Limits that the design keeps to by less than `ROOM` count as met exactly.
    """
    slack = -goal.rows(*tangent.after(np.zeros(len(places))))
    return best_step(goal, tangent, places, RESIDUAL_RADIUS, scale, penalty, room=np.clip(slack, 0.0, ROOM))
