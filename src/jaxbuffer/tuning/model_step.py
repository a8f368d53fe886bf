"""The best step of a stage's model: a linear programme, with the Lagrangian's curvature a quadratic one.

Peaks, cases and constraints are first-order in the step, and their true maxima, not smoothed ones, become the rows of a
programme in epigraph form. A row that falls with the largest peak, a lower limit on it say, has the present largest
impact instead: that bounds the row from above, where the maximum would make the programme non-convex. With ½ dᵀ B d
added, B the Lagrangian's curvature, it is the subproblem of sequential quadratic programming with an exact penalty in a
trust region (Nocedal and Wright, section 18.5, Sℓ₁QP). The duals of its rows are the Lagrangian's multipliers.

What the linear programme can still gain within a tenth of every range is the first-order (KKT) residual: zero exactly
where weights on the active peaks, cases, limits and bounds balance the slopes (Fletcher, Practical Methods of
Optimization, section 14.2). A step that a schedule shortens does not lower it.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from .goal import ROOM, Goal, Tangent
from .objective import Objective
from .programme import Entries, Programme

RESIDUAL_RADIUS = 0.1  # of each variable's range

Step = Float[np.ndarray, " variables"]
Source = tuple[str, int | tuple[int, int], np.ndarray | float]  # of a row: field of the tangent, where, coefficient
Row = tuple[Entries, float, tuple[Source, ...]]


class Multipliers(NamedTuple):
    """The weight of each impact's peak, other quantity at a fixed largest peak, and margin in the Lagrangian."""

    peaks: Float[np.ndarray, "cases peaks"]
    rest: Float[np.ndarray, "cases rest"]
    margin: Float[np.ndarray, " cases"]

    def slope(self, tangent: Tangent) -> Step:
        """The Lagrangian's slope at a design with these multipliers."""
        return (
            np.einsum("ck,ckn->n", self.peaks, tangent.peaks_slope)
            + np.einsum("cq,cqn->n", self.rest, tangent.rest_slope)
            + self.margin @ tangent.margin_slope
        )

    def moved(self, change: Float[np.ndarray, "cases rest"]) -> "Multipliers":
        """Those at another design, where the rest's derivatives by the largest peak are others by ``change`` [unit/N]:
        the peaks' weights are made of them."""
        through, total = np.sum(self.rest * change, axis=1), np.sum(self.peaks, axis=1)
        factor = 1.0 + np.divide(through, total, out=np.zeros_like(total), where=total != 0.0)
        return self._replace(peaks=self.peaks * factor[:, None])


class ModelStep(NamedTuple):
    """The best step of the model, the relative reduction of the merit that the model predicts, and the multipliers.

    The reduction is NaN where no solver found a step: such a search has not converged.
    """

    step: Step
    predicted_reduction: float
    multipliers: Multipliers


class Cuts(NamedTuple):
    """Half-spaces that steps keep to: ``normals @ step <= offsets``, each offset positive."""

    normals: Float[np.ndarray, "cuts variables"]
    offsets: Float[np.ndarray, " cuts"]


class _Model:
    """A goal's merit to first order as a programme over steps in a box. All rows are relative, so of size one."""

    def __init__(self, goal: Goal, tangent: Tangent, box: tuple[Step, Step]) -> None:
        self.goal, self.tangent, self.cases = goal, tangent, range(len(tangent.margin))
        self.programme, self.sources = Programme(), list[tuple[Source, ...]]()
        self.steps = [self.programme.add(0.0, float(a), float(b)) for a, b in zip(*box, strict=True)]
        used = goal.weights(goal.objective)[0] > 0.0 or "peak_force" in goal.problem.limits.at_most
        used = used or (goal.ceiling is not None and goal.weights(goal.ceiling.objective)[0] > 0.0)
        used = used or bool(np.any(tangent.by_peak))
        self.peak_scale = max(float(np.max(tangent.peaks)), 1.0)
        self.peaks = self._peaks(np.maximum(-box[0], box[1])) if used else []

    def row(self, entries: Entries, right: float, sources: tuple[Source, ...] = ()) -> None:
        """Another row, and what of the tangent is on its left."""
        self.programme.row(entries, right)
        self.sources.append(sources)

    def along(self, slope: np.ndarray) -> Entries:
        """A slope by the step as entries."""
        return list(zip(self.steps, map(float, slope), strict=True))

    def _peaks(self, reach: Step) -> list[int]:
        """Each case's peak over `peak_scale`: a column above all impacts that may become the largest within reach."""
        tangent, scale = self.tangent, self.peak_scale
        columns = [self.programme.add(0.0, 0.0) for _ in self.cases]
        for k, column in enumerate(columns):
            change = np.abs(tangent.peaks_slope[k]) @ reach
            lowest = tangent.peaks[k, 0] - change[0]
            for i in np.flatnonzero((tangent.peaks[k] > 0.0) & (tangent.peaks[k] + change >= lowest)):
                entries = [*self.along(tangent.peaks_slope[k, i] / scale), (column, -1.0)]
                self.row(entries, -float(tangent.peaks[k, i]) / scale, (("peaks", (k, int(i)), 1.0 / scale),))
        return columns

    def weighted(self, k: int, weights: np.ndarray) -> Row:
        """A weighted sum of one case's quantities: entries and a constant. Where it rises with the largest peak it has
        the column of `_peaks`; where it falls with it the present largest impact, which the largest peak is never
        below, while the column may lie above every impact."""
        tangent, rest = self.tangent, ("rest", k, weights[1:])
        through = float(weights[1:] @ tangent.by_peak[k])
        by_peak = float(weights[0]) + through
        slope = weights[1:] @ tangent.rest_slope[k]
        constant = float(weights[1:] @ tangent.rest[k])
        if by_peak > 0.0:
            entries = [*self.along(slope), (self.peaks[k], by_peak * self.peak_scale)]
            return entries, constant - through * float(tangent.largest[k]), (rest,)
        slope = slope + by_peak * tangent.peaks_slope[k, 0]
        constant += float(weights[0]) * float(tangent.largest[k])
        return self.along(slope), constant, (rest, ("peaks", (k, 0), by_peak))

    def aggregate(self, objective: Objective, scale: float, cost: float) -> Entries:
        """min t + cap Σ max(0, f - t), the dual of `Objective.case_weights`, over ``scale``; its entries."""
        cap, weights = objective.cap(len(self.cases)), self.goal.weights(objective) / scale
        base = self.programme.add(cost, -np.inf)
        above = [self.programme.add(cost * cap, 0.0) for _ in self.cases]
        for k in self.cases:
            entries, constant, sources = self.weighted(k, weights)
            self.row([*entries, (base, -1.0), (above[k], -1.0)], -constant, sources)
        return [(base, 1.0), *((column, cap) for column in above)]

    def constraints(self) -> list[Row]:
        """The rows of `Goal.rows` in their order."""
        goal, tangent, rows = self.goal, self.tangent, list[Row]()
        for quantity, limit in goal.limited():
            one = np.zeros(len(goal.problem.names))
            one[quantity] = 1.0 / limit
            for k in self.cases:
                entries, constant, sources = self.weighted(k, one)
                rows.append((entries, float(np.sign(limit)) - constant, sources))
        if goal.must_succeed:
            for k in self.cases:
                rows.append((self.along(-tangent.margin_slope[k]), float(tangent.margin[k]), (("margin", k, -1.0),)))
        if goal.ceiling is not None:
            scale = goal.ceiling.scale
            rows.append((self.aggregate(goal.ceiling.objective, scale, 0.0), goal.ceiling.value / scale, ()))
        return rows

    def multipliers(self, duals: np.ndarray) -> Multipliers:
        """The rows' duals, gathered by what is on their left."""
        tangent = self.tangent
        found = Multipliers(*(np.zeros_like(values) for values in (tangent.peaks, tangent.rest, tangent.margin)))
        for dual, sources in zip(duals, self.sources, strict=True):
            for name, where, coefficient in sources:
                getattr(found, name)[where] += dual * coefficient
        return found


def best_step(
    goal: Goal,
    tangent: Tangent,
    scaled: Step,
    radius: float,
    scale: float,
    penalty: float,
    cuts: Cuts | None = None,
    room: Float[np.ndarray, " rows"] | float = 0.0,
    curvature: Float[np.ndarray, "n n"] | None = None,
) -> ModelStep:
    """Minimise the merit's model over steps of at most ``radius`` in each variable, inside bounds and cuts and with
    ``room`` [-] to the limits (one for all, or one a row). Without ``curvature``, and where the quadratic programme
    can't be solved, the model is that to first order."""
    still = np.zeros(len(scaled))
    bend = np.zeros((len(scaled),) * 2) if curvature is None else curvature
    low, high = np.maximum(-radius, -scaled), np.minimum(radius, 1.0 - scaled)
    model = _Model(goal, tangent, (low, high))
    for normal, offset in zip(*cuts, strict=True) if cuts is not None else ():
        model.row(model.along(normal), float(offset))
    model.aggregate(goal.objective, scale, 1.0)
    rows = model.constraints()
    for (entries, right, sources), given in zip(rows, np.broadcast_to(room, len(rows)), strict=True):
        excess = model.programme.add(penalty, 0.0)
        model.row([*entries, (excess, -1.0)], right - float(given), sources)
    minimum = model.programme.solve(bend) or model.programme.solve(0.0 * bend)
    if minimum is None:
        return ModelStep(still, np.nan, model.multipliers(np.zeros(len(model.sources))))
    step = np.clip(minimum.x[: len(scaled)], low, high)

    def merit(step: Step) -> float:
        return goal.predicted_merit(tangent, step, scale, penalty) + 0.5 * float(step @ bend @ step)

    return ModelStep(step, merit(still) - merit(step), model.multipliers(minimum.duals))


def residual(goal: Goal, tangent: Tangent, scaled: Step, scale: float, penalty: float) -> ModelStep:
    """The best step within `RESIDUAL_RADIUS` to first order, and what it gains relative to the objective.

    Limits that the design keeps to by less than `ROOM` count as met exactly.
    """
    slack = -goal.rows(*tangent.after(np.zeros(len(scaled))))
    return best_step(goal, tangent, scaled, RESIDUAL_RADIUS, scale, penalty, room=np.clip(slack, 0.0, ROOM))
