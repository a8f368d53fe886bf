"""The best step of a stage's model in a trust region: a linear programme, or a quadratic one with curvature.

Peaks, load cases and constraints are first-order in the step, and their true maxima, not smoothed ones, become the rows
of a programme in epigraph form. A row that falls with the largest peak, a lower limit on it say, has the present
largest impact instead: that bounds the row from above, where the maximum would make the programme non-convex. With ½ dᵀ
B d added, B the Lagrangian's curvature, it is the subproblem of sequential quadratic programming with an exact penalty
in a trust region (Nocedal and Wright, section 18.5, Sℓ₁QP). The duals of its rows are the Lagrangian's multipliers.

What the linear programme can still gain within a tenth of every range is the first-order (KKT) residual: zero exactly
where weights on the active peaks, load cases, limits and bounds balance the slopes (Fletcher, Practical Methods of
Optimization, section 14.2). A step that a schedule shortens does not lower it.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..problem.objective import Objective
from .goal import ROOM, Goal, Tangent
from .programme import Entries, Programme, Row, Source, Step

RESIDUAL_RADIUS = 0.1  # of each variable's range
DAMPING = 0.2  # Powell's: keeps the estimate positive definite


class Multipliers(NamedTuple):
    """The weights in the Lagrangian of each impact's peak, each other quantity at a fixed largest peak, each margin."""

    peaks: Float[np.ndarray, "cases peaks"]
    rest: Float[np.ndarray, "cases rest"]
    margin: Float[np.ndarray, " cases"]

    def slope(self, tangent: Tangent) -> Step:
        """Return the Lagrangian's slope at a design with these multipliers."""
        return (
            np.einsum("ck,ckn->n", self.peaks, tangent.peaks_slope)
            + np.einsum("cq,cqn->n", self.rest, tangent.rest_slope)
            + self.margin @ tangent.margin_slope
        )

    def moved(self, change: Float[np.ndarray, "cases rest"]) -> "Multipliers":
        """Return those at another design, where the rest's derivatives by the largest peak differ by ``change``.

        The peaks' weights are made of these derivatives [unit/N].
        """
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
    """Half-spaces in which steps stay: ``normals @ step <= offsets``, each offset positive."""

    normals: Float[np.ndarray, "cuts variables"]
    offsets: Float[np.ndarray, " cuts"]


class _Model(Programme):
    """A model is a goal's merit to first order as a programme over steps in a box.

    All rows are relative, so of size one.
    """

    def __init__(self, goal: Goal, tangent: Tangent, box: tuple[Step, Step]) -> None:
        super().__init__()
        self.goal, self.tangent, self.cases = goal, tangent, range(len(tangent.margin))
        self.sources = list[tuple[Source, ...]]()
        self.steps = [self.add(0.0, float(a), float(b)) for a, b in zip(*box, strict=True)]
        lowered = (name for it in goal.constraints for name in it.lowered)
        used = goal.problem.peak_quantity in (*goal.objective.weights, *lowered) or bool(np.any(tangent.by_peak))
        # A slot without an impact is far below zero, and so would the scale be if there were none at all.
        self.peak_scale = float(np.max(tangent.peaks, initial=1.0))
        self.peaks = self._peaks(np.maximum(-box[0], box[1])) if used else []

    def row(self, entries: Iterable[tuple[int, float]], right: float, sources: tuple[Source, ...] = ()) -> None:
        """Add a row and note what of the tangent is on its left, by which its dual is given out later."""
        super().row(entries, right)
        self.sources.append(sources)

    def along(self, slope: np.ndarray) -> Entries:
        """Return a slope by the step as entries."""
        return list(zip(self.steps, map(float, slope), strict=True))

    def _peaks(self, reach: Step) -> list[int]:
        """Add for each load case a column for its peak over `peak_scale`.

        It lies above all impacts that may become the largest within reach.
        """
        tangent, scale = self.tangent, self.peak_scale
        # A column has no cost of its own: the rows of the objective and of the limits that contain it press it down.
        columns = [self.add(0.0, 0.0) for _ in self.cases]
        for k, column in enumerate(columns):
            change = np.abs(tangent.peaks_slope[k]) @ reach
            lowest = tangent.peaks[k, 0] - change[0]
            for i in np.flatnonzero((tangent.peaks[k] > 0.0) & (tangent.peaks[k] + change >= lowest)):
                entries = [*self.along(tangent.peaks_slope[k, i] / scale), (column, -1.0)]
                self.row(entries, -float(tangent.peaks[k, i]) / scale, (("peaks", (k, int(i)), 1.0 / scale),))
        return columns

    def weighted(self, k: int, weights: np.ndarray) -> Row:
        """Return a weighted sum of one load case's quantities: entries and a constant.

        Where it rises with the largest peak it has the column of `_peaks`; where it falls with it the present largest
        impact, which the largest peak is never below, while the column may lie above every impact.
        """
        tangent = self.tangent
        # The peak force is the first of the names, if it is one of them.
        peak, others = np.split(weights, [len(weights) - tangent.rest.shape[1]])
        of_peak, rest = float(np.sum(peak)), ("rest", k, others)
        through = float(others @ tangent.by_peak[k])
        by_peak = of_peak + through
        slope = others @ tangent.rest_slope[k]
        constant = float(others @ tangent.rest[k])
        if by_peak > 0.0:
            entries = [*self.along(slope), (self.peaks[k], by_peak * self.peak_scale)]
            return entries, constant - through * float(tangent.largest[k]), (rest,)
        if by_peak == 0.0:
            return self.along(slope), constant, (rest,)
        slope = slope + by_peak * tangent.peaks_slope[k, 0]
        constant += of_peak * float(tangent.largest[k])
        return self.along(slope), constant, (rest, ("peaks", (k, 0), by_peak))

    def aggregate(self, objective: Objective, scale: float, cost: float) -> Entries:
        """Add min t + cap Σ max(0, f - t), the dual of `Objective.case_weights`, over ``scale``; return its entries."""
        cap, weights = objective.cap(len(self.cases)), objective.vector(self.goal.problem.names) / scale
        # No lower bound, because an objective may be negative.
        base = self.add(cost, -np.inf)
        above = [self.add(cost * cap, 0.0) for _ in self.cases]
        for k in self.cases:
            entries, constant, sources = self.weighted(k, weights)
            self.row([*entries, (base, -1.0), (above[k], -1.0)], -constant, sources)
        return [(base, 1.0), *((column, cap) for column in above)]

    def constraints(self) -> list[Row]:
        """Return the rows of `Goal.rows` in their order."""
        return [row for it in self.goal.constraints for row in it.tangent_rows(self)]

    def margin_row(self, k: int) -> Row:
        """Return the row that keeps one load case's margin above zero."""
        tangent = self.tangent
        return self.along(-tangent.margin_slope[k]), float(tangent.margin[k]), (("margin", k, -1.0),)

    def multipliers(self, duals: np.ndarray) -> Multipliers:
        """Gather the rows' duals by what is on their left."""
        tangent = self.tangent
        result = Multipliers(*(np.zeros_like(values) for values in (tangent.peaks, tangent.rest, tangent.margin)))
        for dual, sources in zip(duals, self.sources, strict=True):
            for name, where, coefficient in sources:
                getattr(result, name)[where] += dual * coefficient
        return result


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
    """Minimise the merit's model over steps of at most ``radius`` in each variable, inside bounds and cuts.

    Steps leave ``room`` [-] to the limits (one for all, or one a row). Without ``curvature``, and where the quadratic
    programme can't be solved, the model is that to first order.
    """
    still = np.zeros(len(scaled))
    bend = np.zeros((len(scaled),) * 2) if curvature is None else curvature
    # The bounds of the variables and the trust region are both boxes, so that steps are bounded by their intersection.
    low, high = np.maximum(-radius, -scaled), np.minimum(radius, 1.0 - scaled)
    model = _Model(goal, tangent, (low, high))
    for normal, offset in zip(*cuts, strict=True) if cuts is not None else ():
        model.row(model.along(normal), float(offset))
    model.aggregate(goal.objective, scale, 1.0)
    rows = model.constraints()
    for (entries, right, sources), gap in zip(rows, np.broadcast_to(room, len(rows)), strict=True):
        # The exact penalty: what a row exceeds its limit by costs `penalty`, so that there is always a step.
        excess = model.add(penalty, 0.0)
        model.row([*entries, (excess, -1.0)], right - float(gap), sources)
    minimum = model.solve(bend) or model.solve(0.0 * bend)
    if minimum is None:
        return ModelStep(still, np.nan, model.multipliers(np.zeros(len(model.sources))))
    # Solvers keep to bounds within their tolerance only.
    step = np.clip(minimum.x[: len(scaled)], low, high)

    def merit(step: Step) -> float:
        return goal.predicted_merit(tangent, step, scale, penalty) + 0.5 * float(step @ bend @ step)

    return ModelStep(step, merit(still) - merit(step), model.multipliers(minimum.duals))


def residual(goal: Goal, tangent: Tangent, scaled: Step, scale: float, penalty: float) -> ModelStep:
    """Return the best step within `RESIDUAL_RADIUS` to first order, and what it gains relative to the objective.

    Limits that the design is within by less than `ROOM` count as met exactly.
    """
    slack = -goal.rows(*tangent.after(np.zeros(len(scaled))))
    return best_step(goal, tangent, scaled, RESIDUAL_RADIUS, scale, penalty, room=np.clip(slack, 0.0, ROOM))


def updated_curvature(
    curvature: Float[np.ndarray, "n n"], step: Float[np.ndarray, " n"], change: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "n n"]:
    """Update the Lagrangian's curvature by damped BFGS (Nocedal and Wright, procedure 18.2).

    ``change``: of the Lagrangian's slope over a ``step``.

    It starts from zero, which makes first steps those of the first-order model; the first update that shows positive
    curvature sets its size.
    """
    length, bend = float(step @ step), float(step @ change)
    if length == 0.0 or not np.all(np.isfinite(change)):
        return curvature
    if not np.any(curvature):
        if bend <= 0.0:
            return curvature
        curvature = (bend / length) * np.eye(len(step))
    along = curvature @ step
    expected = float(step @ along)
    # Rounding may leave no curvature along the step, by which the update would divide.
    if expected <= 0.0:
        return curvature
    share = 1.0 if bend >= DAMPING * expected else (1.0 - DAMPING) * expected / (expected - bend)
    change = share * change + (1.0 - share) * along
    return curvature - np.outer(along, along) / expected + np.outer(change, change) / float(step @ change)
