"""The figure of a front: the first objective over each other one."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..tuning.pareto import Front
from .style import BLUE, GREY, RED, label, panels, styled
from .words import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANELS = 4  # pairs of objectives that are drawn
NEAR = 0.06  # of an axis: points less apart have their numbers in one text


@styled
def front_figure(front: Front) -> "Figure":
    """The first objective over each other one: the front, its points that did not converge, and those that another one
    is better than."""
    others = front.objectives[1 : PANELS + 1]
    figure, grid = panels(6.4 * len(others), 4.6, 1, len(others))
    drawn = [shown(front.problem.catalogue[name]) for name in front.objectives]
    (first, unit, factor), values = drawn[0], front.values
    for axes, k in zip(grid[0], range(1, len(front.objectives)), strict=False):
        name, other, scale = drawn[k]
        order = [i for i in np.argsort(values[:, k]) if front.kept[i]]
        line = "-" if len(front.objectives) == 2 else ""
        axes.plot(scale * values[order, k], factor * values[order, 0], "o", linestyle=line, color=BLUE, label="front")
        if unsure := [i for i in order if not front.points[i].converged]:
            hollow = {"markerfacecolor": "white", "markeredgecolor": RED, "markeredgewidth": 1.5}
            axes.plot(
                scale * values[unsure, k], factor * values[unsure, 0], "o", label="front, not converged", **hollow
            )
        if front.dominated.any():
            left = front.dominated
            axes.plot(scale * values[left, k], factor * values[left, 0], "x", color=GREY, label="dominated")
        _widen(axes)
        _number(axes, order, scale * values[order, k], factor * values[order, 0])
        label(axes, "", f"{name}, worst scenario [{other}]", f"{first}, worst scenario [{unit}]")
    lost = int((~front.feasible).sum())
    count = len(front.problem.cases)
    over = f"{count} scenarios" if count > 1 else "one scenario"
    title = f"Front of {len(front.points)} tuned designs over {over}"
    figure.suptitle(f"{title}, {lost} without a feasible design" if lost else title)
    return figure


def _number(axes: "Axes", points: Sequence[int], x: np.ndarray, y: np.ndarray) -> None:
    """Write its number beside each point; points too near each other for a text each have one together."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    groups: list[list[int]] = []
    for k in range(len(points)):
        last = groups[-1][-1] if groups else k
        near = abs(x[k] - x[last]) < NEAR * (right - left) and abs(y[k] - y[last]) < NEAR * (high - low)
        if groups and near:
            groups[-1].append(k)
        else:
            groups.append([k])
    for group in groups:
        text, at = ", ".join(str(points[k] + 1) for k in group), (x[group[0]], y[group[0]])
        axes.annotate(text, at, (4, 5), textcoords="offset points", fontsize=8)


def _widen(axes: "Axes") -> None:
    """Let each axis span a hundredth of its values at least, so that rounding does not look like a front."""
    for limits, set_limits in ((axes.get_xlim, axes.set_xlim), (axes.get_ylim, axes.set_ylim)):
        low, high = limits()
        middle = 0.5 * (low + high)
        half = max(0.5 * (high - low), 0.005 * abs(middle))
        set_limits(middle - half, middle + half)
