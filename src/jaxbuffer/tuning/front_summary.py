"""A front as a table, for people."""

from typing import TYPE_CHECKING

import numpy as np

from ..tables import table, text

if TYPE_CHECKING:
    from .pareto import Front


def front_table(front: "Front") -> str:
    """Each point's objectives, limits and certificate, and what is not on the front."""
    catalogue = front.problem.catalogue
    sampled = front.problem.samples
    over = f"of {sampled}, no bound" if sampled else f"over the scenarios ({len(front.problem.cases)})"
    shown = table(f"Front of {' and '.join(front.objectives)}, worst {over}")
    shown.add_column("point", justify="right")
    units, factors = zip(*(catalogue[name].in_figures for name in front.objectives), strict=True)
    for name, unit in zip(front.objectives, units, strict=True):
        shown.add_column(f"{name} [{unit}]", justify="right")
    for name in front.objectives[1:]:
        shown.add_column(f"{name} ≤", justify="right")
    shown.add_column("residual [-]", justify="right")
    shown.add_column("gradient error [-]", justify="right")
    shown.add_column("", justify="left")
    for k, (point, values, limits) in enumerate(zip(front.points, front.values, front.limits, strict=True)):
        shown.add_row(
            str(k + 1),
            *(f"{value:.6g}" for value in values * np.array(factors)),
            *("free" if np.isinf(limit) else f"{limit:.5g}" for limit in limits * np.array(factors[1:])),
            f"{point.residual:.1e}",
            f"{point.gradient_error:.1e}",
            standing(front, k),
        )
    count, lost = int(front.dominated.sum()), int((~front.feasible).sum())
    lines = [f"{int(front.kept.sum())} of {len(front.points)} points are on the front"]
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


def standing(front: "Front", k: int) -> str:
    """What is to be said of a point: "front", "dominated" or "limits broken", and whether it converged."""
    if not front.feasible[k]:
        return "limits broken"
    if front.dominated[k]:
        return "dominated"
    return "front" if front.points[k].converged else "front, not converged"
