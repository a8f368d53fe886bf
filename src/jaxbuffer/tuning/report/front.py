"""The front of several objectives, and its table."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from ...labelled.saved import Saved
from ...tables import table, text
from ..problem.problem import Problem
from .tuned import Tuned

SAME = 1e-6  # relative: values that are no further apart are taken for one, well above their errors at rtol 1e-9


@dataclasses.dataclass(frozen=True)
class Front(Saved):
    """A front of objectives. Print it for a table.

    - ``problem``: what may change, in which cases, and what holds at every point.
    - ``objectives``: k names; the first was lowered under ``limits`` (points, k - 1) on the others, in their units;
      infinite where there was none.
    - ``points``: a `Tuned` each: tight re-evaluation, first-order residual, error of its gradients, design.
    - ``identity``: a hash of all that makes it the front it is, as its folder has it; "" where that is not known.
    - ``values`` (points, k): each objective's worst value over the cases at rtol 1e-9, in its unit.

    **Example:**

    >>> problem = jb.Problem(
    ...     jb.BarDrop(), [jb.BarDropScenario()], [jb.Variable("impact.stiffness", 1e10, 1e12)], duration=0.25
    ... )
    >>> front = jb.pareto(problem, ["peak_force", "penetration"], points=2, starts=1, iterations=3)
    >>> front.values.shape, front.dominated.tolist()
    ((2, 2), [False, False])
    """

    problem: Problem
    objectives: tuple[str, ...]
    limits: Float[np.ndarray, "points others"]
    points: tuple[Tuned, ...]
    identity: str = ""

    @property
    def values(self) -> Float[np.ndarray, "points k"]:
        """Return each objective's worst value over the cases, in its unit."""
        return np.array([worst_values(point, self.objectives) for point in self.points])

    @property
    def feasible(self) -> Bool[np.ndarray, " points"]:
        """Return which points are within every limit."""
        return np.array([point.feasible for point in self.points])

    @property
    def dominated(self) -> Bool[np.ndarray, " points"]:
        """Return which feasible points another feasible one is better than: nowhere worse, somewhere lower."""
        return dominated(self.values, self.feasible)

    @property
    def non_dominated(self) -> Bool[np.ndarray, " points"]:
        """Return which points make the front: those that are feasible, and not dominated."""
        return self.feasible & ~self.dominated

    def __repr__(self) -> str:
        return front_table(self)


def dominated(values: Float[np.ndarray, "points k"], feasible: Bool[np.ndarray, " points"]) -> np.ndarray:
    """Return which feasible points are dominated by a feasible one.

    Of points that are the same within `SAME` all but the first are.
    """
    result = np.zeros(len(values), bool)
    room = SAME * np.abs(values)
    for i in np.flatnonzero(feasible):
        for j in np.flatnonzero(feasible):
            no_worse = np.all(values[j] <= values[i] + room[i])
            result[i] |= i != j and bool(no_worse and (np.any(values[j] < values[i] - room[i]) or j < i))
    return result


def worst_values(tuned: Tuned, names: Sequence[str]) -> np.ndarray:
    """Return the worst value of each quantity over a tuned design's load cases, in its unit."""
    columns = [tuned.problem.names.index(name) for name in names]
    return np.asarray(tuned.after.quantities[:, columns].max(axis=0))


def front_table(front: Front) -> str:
    """Return a table of each point's objectives, limits and certificate, and what is not on the front."""
    catalogue = front.problem.catalogue
    sampled = front.problem.samples
    over = f"of {sampled}, no bound" if sampled else f"over the scenarios ({len(front.problem.cases)})"
    units, factors = zip(*(catalogue[name].in_figures for name in front.objectives), strict=True)
    headings = [f"{name} [{unit}]" for name, unit in zip(front.objectives, units, strict=True)]
    headings += [f"{name} ≤" for name in front.objectives[1:]]
    right = ("point", *headings, "residual [-]", "gradient error [-]")
    shown = table(f"Front of {' and '.join(front.objectives)}, worst {over}", right=right)
    shown.add_column("")
    for k, (point, values, limits) in enumerate(zip(front.points, front.values, front.limits, strict=True)):
        shown.add_row(
            str(k + 1),
            *(f"{value:.6g}" for value in values * np.array(factors)),
            *("free" if np.isinf(limit) else f"{limit:.5g}" for limit in limits * np.array(factors[1:])),
            f"{point.residual:.1e}",
            f"{point.gradient_error:.1e}",
            point_status(front, k),
        )
    count, lost = int(front.dominated.sum()), int((~front.feasible).sum())
    lines = [f"{int(front.non_dominated.sum())} of {len(front.points)} points are on the front"]
    if count:
        lines.append(f"{count} left out: another point is as good or better in every objective")
    if lost:
        lines.append(f"{lost} left out: no design was found that keeps to the limits")
    if any(point.ended == "limit_of_steps" for point in front.points):
        iterations = front.points[0].settings.iterations
        lines.append(
            f"searches stopped at their limit of {iterations} steps: raise iterations in [tune] or --iterations"
        )
    return text(
        shown, "; ".join(lines), "Values at rtol 1e-9; residual: what first-order information there still gains."
    )


def point_status(front: Front, k: int) -> str:
    """Return what a point is: "front", "dominated" or "limits broken", and whether it converged."""
    if not front.feasible[k]:
        return "limits broken"
    if front.dominated[k]:
        return "dominated"
    return "front" if front.points[k].converged else "front, not converged"
