"""The figure of a tuning."""

from typing import TYPE_CHECKING

import numpy as np

from ..fields import get
from .style import BLUE, GREY, ORANGE, RED, label, line, panels, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..tuning.tuned import Tuned


@styled
def tune_figure(tuned: "Tuned") -> "Figure":
    """Peak force in every scenario before and after, objective, variables in their bounds, worst values."""
    figure, ((cases, objective), (variables, trade)) = panels(10.0, 7.0, 2, 2)
    problem, floor = tuned.problem, tuned.floor
    number = np.arange(1, len(problem.cases) + 1)
    for point, colour, name in ((tuned.before, ORANGE, "before"), (tuned.after, BLUE, "after")):
        peaks, met = point.quantities[:, 0], point.succeeded
        cases.plot(number[met], peaks[met], "o", color=colour, markersize=4, label=name)
        if not np.all(met):
            missed = f"{name}, not {problem.mechanism.success or 'solved'}"
            cases.plot(number[~met], peaks[~met], "x", color=colour, label=missed)
    if floor is not None:
        cases.plot(number, floor.simulated, "_", color=GREY, markersize=12, label="floor: first impact, no buffer")
    _integer_axis(cases)
    label(cases, "Peak contact force", "scenario [-]", "peak force [N]")
    _convergence(objective, tuned)
    _variables(variables, tuned)
    _limits(trade, tuned)
    before, after = tuned.objective
    figure.suptitle(f"{problem.objective}: {before:.5g} N before, {after:.5g} N after")
    return figure


def _convergence(axes: "Axes", tuned: "Tuned") -> None:
    """Objective of every evaluated design; a line through each search's accepted ones."""
    records = tuned.records
    searches = sorted({(it["stage"], it["search"]) for it in records if it["status"] != "start"})
    starts = [it for it in records if it["status"] == "start"]
    axes.plot([it["evaluation"] for it in starts], [it["objective"] for it in starts], ".", color=GREY, label="starts")
    for k, key in enumerate(searches):
        mine = [it for it in records if (it["stage"], it["search"]) == key and it["status"] != "start"]
        taken = [it for it in mine if it["accepted"]]
        name = f"search {key[1] + 1}" if key[0] == 0 else "then"
        axes.plot([it["evaluation"] for it in taken], [it["objective"] for it in taken], label=name, **line(k))
    lost = [it for it in records if not it["feasible"]]
    if lost:
        axes.plot(
            [it["evaluation"] for it in lost], [it["objective"] for it in lost], "x", color=RED, label="infeasible"
        )
    label(axes, "Objective of every design tried", "evaluation [-]", "objective [N]")


def _variables(axes: "Axes", tuned: "Tuned") -> None:
    """Where accepted designs of all searches stand between the bounds."""
    taken = [it for it in tuned.records if it["accepted"] and it["status"] != "start"] or list(tuned.records)
    for k, variable in enumerate(tuned.problem.variables):
        scaled = [variable.scaled(it["values"][variable.path]) for it in taken]
        axes.plot([it["evaluation"] for it in taken], scaled, label=variable.path, marker=".", **line(k))
        axes.plot(
            taken[-1]["evaluation"] + 1,
            variable.scaled(float(get(tuned.design, variable.path))),
            "D",
            color=line(k)["color"],
        )
    axes.set_ylim(-0.03, 1.5)  # room for the legend
    axes.set_yticks([0.0, 0.5, 1.0], ["low", "middle", "high"])
    label(axes, "Accepted designs, and the result (◆)", "evaluation [-]", "place between bounds [-]", columns=2)


def _limits(axes: "Axes", tuned: "Tuned") -> None:
    """The largest of each quantity over the scenarios, relative to before."""
    before, after = (np.max(point.quantities, axis=0) for point in (tuned.before, tuned.after))
    names, catalogue = list(tuned.problem.quantities), tuned.problem.mechanism.quantities
    share = 100.0 * (np.divide(after, before, out=np.ones_like(after), where=before != 0.0) - 1.0)
    axes.barh(range(len(names)), share, color=[BLUE if x <= 0.0 else ORANGE for x in share])
    axes.axvline(0.0, color="black", linewidth=0.6)
    axes.set_yticks(
        range(len(names)),
        [f"{n}: {b:.3g} → {a:.3g} {catalogue[n].unit}" for n, b, a in zip(names, before, after, strict=True)],
    )
    axes.invert_yaxis()
    label(axes, "Worst over the scenarios, before → after", "change [%]", "quantity [-]", False)


def _integer_axis(axes: "Axes") -> None:
    from matplotlib.ticker import MaxNLocator

    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
