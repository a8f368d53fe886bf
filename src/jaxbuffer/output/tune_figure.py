"""Figures of a tuning and of a front."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .._types import Axes, Figure
from ..fields import get
from ..mechanisms.limit import Limit
from ..mechanisms.run import Run
from ..tuning.report.front import Front
from ..tuning.report.tuned import Tuned
from ..tuning.search.evaluation import main_values
from ..value_text import before_and_after, percent_text, range_text, relative_change, unit_text, with_unit
from .layout import legend_below, with_line_breaks
from .pulses import force_over_time, last_contact
from .style import BLUE, COLOURS, GREY, ORANGE, RED, blank, label, panels, styled
from .words import force_text, in_thousands, seconds, shown

POINTS = (("before", ORANGE, "o"), ("after", BLUE, "D"))
ROW, MOST = 0.2, 40  # inch a scenario, and how many of them are drawn, those where the main quantity is largest
SMALL, LINE, WIDE = 7, 0.12, 170.0  # points of a row's text; inch a line of it; points that it is wide
NAMED, LONGEST = 12, 40  # of more scenarios one with a longer name, in characters: then all have numbers alone
WIDEST = 200.0  # per cent of a limit that are drawn; what is beyond stands at the edge as an arrow
ROUNDING = 1e-12  # of the largest quantity of a unit, below which another one is rounding
PANELS = 4  # pairs of objectives that are drawn
NEAR = 0.06  # of an axis: points less apart have their numbers in one text


@styled
def tune_figure(tuned: Tuned, worst: Sequence[Run] = ()) -> Figure:
    """Draw the main quantity in every scenario before and after, variables in their bounds, what is limited, and the
    search.

    **Arguments:** ``tuned``; ``worst``: runs with histories of `worst_case`, with the design before and after, whose
    force is drawn over time; none: that panel is left out.
    """
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    problem = tuned.problem
    stages = sorted({it["stage"] for it in tuned.records})
    draws = [_limits, _variables, *(lambda axes, tuned, stage=stage: _search(axes, tuned, stage) for stage in stages)]
    limits = _rows(tuned)
    # All rows are as high as the label with the most lines.
    each = LINE * (1 + max(it.text.count("\n") for it in limits)) + 0.06
    right = [each * len(limits) + 0.9, 0.4 * len(problem.variables) + 0.9, *(2.3 for _ in stages)]
    rows = ROW * min(len(problem.cases), MOST) + 1.0
    left = [2.6, rows] if worst else [rows]
    layout = ConstrainedLayoutEngine(w_pad=0.12)  # inch; the right column's labels are long
    figure = blank(13.0, max(sum(left), sum(right)) + 1.0, layout)
    columns = figure.add_gridspec(1, 2)
    first = columns[0].subgridspec(len(left), 1, height_ratios=left)
    second = columns[1].subgridspec(len(right), 1, height_ratios=right)
    if worst:
        _force(figure.add_subplot(first[0]), tuned, worst)
    cases = figure.add_subplot(first[len(left) - 1])
    _cases(cases, tuned)
    for row, draw in enumerate(draws):
        draw(figure.add_subplot(second[row]), tuned)
    legend_below(figure, *cases.get_legend_handles_labels())
    unit, factor = problem.objective.in_figures(problem.catalogue)
    before, after = (with_unit(factor * value, unit, 5) for value in tuned.objective)
    counts = [f", {count}" for point in (tuned.before, tuned.after) if (count := tuned.end_count(point)) is not None]
    whole = f"{before} before{counts[0]}; {after} after{counts[1]}" if counts else f"{before} before, {after} after"
    figure.suptitle(f"{_objective_text(problem, problem.objective)}: {whole}")
    return figure


def _objective_text(problem: Any, objective: Any) -> str:
    """Return an objective in words."""
    return str(problem.format(objective)).replace("_", " ").replace("cases", "scenarios")


def worst_case(tuned: Tuned) -> int:
    """Return in which scenario the main quantity is largest with the tuned design."""
    return int(np.argmax(main_values(tuned.problem, tuned.after)))


def _cases(axes: Axes, tuned: Tuned) -> None:
    """Draw a row for each scenario, or for those where it is largest: its main quantity before and after."""
    problem, lower_bound = tuned.problem, tuned.lower_bound
    count = len(problem.cases)
    main, points = problem.main_quantity, (tuned.before, tuned.after)
    title, unit, factor = shown(problem.catalogue[main])
    # In the order of the problem.
    drawn = np.sort(np.argsort(-main_values(problem, tuned.after), kind="stable")[:MOST])
    row = np.arange(len(drawn))
    values = [factor * main_values(problem, point)[drawn] for point in points]
    axes.hlines(row, values[0], values[1], color=GREY, linewidth=1.0, zorder=1)
    for (name, colour, marker), point, each in zip(POINTS, points, values, strict=True):
        met = point.succeeded[drawn]
        axes.plot(each[met], row[met], marker, color=colour, markersize=5, label=name)
        if not np.all(met):
            missed = f"{name}, not {problem.success or 'solved'}"
            axes.plot(each[~met], row[~met], "x", color=colour, markersize=7, label=missed)
    if lower_bound is not None and main == problem.peak_quantity:
        axes.plot(
            lower_bound.simulated[drawn],
            row,
            "|",
            color="black",
            markersize=9,
            label="lower bound: first impact, no buffer",
        )
    limit = problem.limits.at_most.get(main)
    if limit is not None:
        axes.axvline(factor * limit, color=RED, label=f"limit, {with_unit(factor * limit, unit, 4)}")
    names = [problem.label(k) for k in drawn]
    # Scenarios of a sample differ in many numbers. A few have room for all of that, with line breaks.
    numbered = len(names) > NAMED and max(map(len, names)) > LONGEST
    texts = [with_line_breaks(name, WIDE, SMALL) for name in names]
    axes.set_yticks(row, [problem.number_text(k) for k in drawn] if numbered else texts, fontsize=SMALL)
    # The axis goes down, so that the first scenario stands at the top.
    axes.set_ylim(len(row) - 0.4, -0.6)
    if not problem.catalogue[main].signed:
        axes.set_xlim(left=0.0)
    some = f", the {MOST} of {count} scenarios where it is largest" if count > MOST else ""
    which = "number of the scenario [-]" if numbered else ""
    label(axes, f"{title[:1].upper()}{title[1:]}{some}", f"{title} [{unit}]", which, legend=False)


def _force(axes: Axes, tuned: Tuned, worst: Sequence[Run]) -> None:
    """Draw the contact force over time in the worst scenario."""
    until = max(last_contact(run) for run in worst)
    unit, factor = seconds(until)
    for (name, colour, _), run in zip(POINTS, worst, strict=True):
        time, force = force_over_time(run)
        time, force = factor * time[time <= until], force[time <= until]
        most = force_text(float(run.peak_force))
        axes.plot(time, force, color=colour, linewidth=0.9, label=f"{name}, at most {most}")
    problem = tuned.problem
    worst_place = worst_case(tuned)
    which = "sample with the largest force" if problem.samples else "worst scenario"
    label(
        axes, f"Force in the {which}, {problem.label(worst_place)}", f"time [{unit}]", "contact force [N]", beside=True
    )


def _variables(axes: Axes, tuned: Tuned) -> None:
    """Draw where each variable stands between its bounds, before and after, with its value."""
    variables = tuned.problem.variables
    row = np.arange(len(variables))
    values = [[float(get(design, v.path)) for v in variables] for design in (tuned.problem.design, tuned.design)]
    scaled = [[v.scaled(value) for v, value in zip(variables, each, strict=True)] for each in values]
    axes.hlines(row, 0.0, 1.0, color=GREY, linewidth=0.6, zorder=1)
    for (name, colour, marker), places in zip(POINTS, scaled, strict=True):
        axes.plot(np.clip(places, 0.0, 1.0), row, marker, color=colour, markersize=5, label=name)
    names = []
    for k, v in enumerate(variables):
        (before, typed), (after, _) = (tuned.problem.shown(v.path, each[k]) for each in values)
        low, high = (tuned.problem.shown(v.path, end)[0] for end in (v.low, v.high))
        symbol, factor = in_thousands(typed, low, high, before, after)
        text = f"{before_and_after(factor * before, factor * after)}{unit_text(symbol)}"
        axes.text(1.03, k, text, va="center", fontsize=SMALL)
        names.append(f"{v.path}\n{range_text(factor * low, factor * high, symbol, 4)}")
    axes.set_yticks(row, names, fontsize=SMALL)
    # The room beyond the high bound is for the values' texts.
    axes.set_xlim(-0.03, 1.75)
    axes.set_xticks([0.0, 0.5, 1.0], ["low", "middle", "high"])
    axes.set_ylim(len(row) - 0.5, -0.5)
    label(axes, "Variables between their bounds, before → after", "place between bounds [-]", "", False)


class QuantityChange(NamedTuple):
    """A quantity's worst value over the scenarios ``before`` and ``after``; its ``limit``, None for none; ``lowest``:
    whether that is a lower limit, and the values the least ones; ``text``: all of it in words and figures."""

    before: float
    after: float
    limit: float | None
    lowest: bool
    text: str


def _rows(tuned: Tuned) -> list[QuantityChange]:
    """Return the largest of each quantity over the scenarios, or the least of one with a lower limit alone.

    Quantities that are not limited and zero throughout, or rounding beside the largest of their unit, are left out.
    """
    problem, rows = tuned.problem, []
    # A limit of the problem is checked to be no higher than what always holds, and takes its place.
    allowed = {**problem.mechanism.always(problem.design), **problem.limits.at_most}
    both = np.abs(np.concatenate([tuned.before.quantities, tuned.after.quantities]))
    largest, units = np.max(both, axis=0), [problem.catalogue[name].unit for name in problem.names]
    for k, name in enumerate(problem.names):
        size = max(largest[q] for q, unit in enumerate(units) if unit == units[k])
        if largest[k] <= ROUNDING * size and name not in allowed and name not in problem.limits.at_least:
            continue
        lowest = name in problem.limits.at_least and name not in allowed
        limit = problem.limits.at_least[name] if lowest else allowed.get(name)
        worst = np.min if lowest else np.max
        before, after = (float(worst(tuned.reported(point)[:, k])) for point in (tuned.before, tuned.after))
        title, symbol, factor = shown(problem.catalogue[name])
        symbol, thousandth = in_thousands(symbol, *(factor * it for it in (before, after, limit or 0.0)))
        factor *= thousandth
        text = f"{before_and_after(factor * before, factor * after)}{unit_text(symbol)}"
        if limit is not None:
            text += f", {'at least' if lowest else 'limit'} {with_unit(factor * limit, symbol, 4)}"
            text += _room(tuned, k, Limit(name, limit, lowest), after)
        text = f"{with_line_breaks(f'{title}:', WIDE, SMALL)}\n{text}"
        rows.append(QuantityChange(before, after, limit, lowest, text))
    # Margins first.
    return sorted(rows, key=lambda row: row.limit is None)


def _room(tuned: Tuned, quantity: int, limit: Limit, worst: float) -> str:
    """Return the room that the tuned design has to a limit and, of several scenarios, in which one, on a line."""
    room = limit.margin(worst)
    if room is None or not math.isfinite(worst):
        return ""
    where = ""
    if len(tuned.problem.cases) > 1:
        case = int(np.flatnonzero(tuned.reported(tuned.after)[:, quantity] == worst)[0])
        where = f" in {tuned.problem.number_text(case)}"
    return f"\nroom {percent_text(room, '.3g')}{where}"


def _limits(axes: Axes, tuned: Tuned) -> None:
    """Draw the worst of each quantity over the scenarios in shares of its limit, or of what it was where it has
    none."""
    rows = _rows(tuned)
    row = np.arange(len(rows))
    for (name, colour, marker), side in zip(POINTS, ("before", "after"), strict=True):
        share = np.array([_share(it, getattr(it, side)) for it in rows])
        beyond = share > WIDEST
        axes.plot(share[~beyond], row[~beyond], marker, color=colour, markersize=5, label=name)
        axes.plot(np.full(beyond.sum(), WIDEST), row[beyond], ">", color=colour, markersize=6)
    for k, it in enumerate(rows):
        if it.limit is not None:
            axes.plot([100.0, 100.0], [k - 0.4, k + 0.4], color=RED, linewidth=2.0)
    axes.set_yticks(row, [it.text for it in rows], fontsize=SMALL)
    axes.set_ylim(len(row) - 0.5, -0.5)
    axes.set_xlim(0.0, min(axes.get_xlim()[1], 1.03 * WIDEST))
    x = "share of the limit (red), or of the value before [%]"
    over = "Largest over the samples" if tuned.problem.samples else "Worst over the scenarios"
    label(axes, f"{over}, before → after", x, "", False)


def _share(row: QuantityChange, value: float) -> float:
    """Return what share of its limit a value is [%], or of the value before where it has none; NaN, which is not drawn,
    where that has no meaning: of a value before that is zero or has another sign."""
    if row.limit is not None:
        return 100.0 * value / row.limit
    change = relative_change(row.before, value)
    return float("nan") if change is None else 100.0 * (1.0 + change)


def _search(axes: Axes, tuned: Tuned, stage: int) -> None:
    """Draw every design tried in a stage, and the best so far among those within all limits."""
    from matplotlib.ticker import MaxNLocator

    records = [it for it in tuned.records if it["stage"] == stage]
    kinds: list[tuple[str, str, str, Any]] = [
        ("starts", ".", GREY, lambda it: it["status"] == "start" and it["feasible"]),
        ("search", "o", COLOURS[2], lambda it: it["status"] != "start" and it["feasible"]),
        ("infeasible", "x", RED, lambda it: not it["feasible"]),
    ]
    problem = tuned.problem
    objective = problem.then.objective if stage and problem.then is not None else problem.objective
    unit, factor = objective.in_figures(problem.catalogue)
    for name, marker, colour, chosen in kinds:
        some = [it for it in records if chosen(it)]
        if some:
            x, y = [it["evaluation"] for it in some], [factor * it["objective"] for it in some]
            axes.plot(x, y, marker, color=colour, markersize=4, label=name)
    # Infinity stands for an infeasible design, which is never the best so far.
    best = np.minimum.accumulate([factor * it["objective"] if it["feasible"] else np.inf for it in records])
    known = np.isfinite(best)
    if np.any(known):
        numbers = np.array([it["evaluation"] for it in records])
        axes.step(numbers[known], best[known], where="post", color=BLUE, label="best so far")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    value = f"objective [{unit}]"
    label(
        axes,
        f"Every design tried for:\n{_objective_text(tuned.problem, objective)}",
        "evaluation [-]",
        value,
        beside=True,
    )


@styled
def front_figure(front: Front) -> Figure:
    """Draw the first objective over each other one.

    Marked are the front, its points that did not converge, and those that another one is better than.
    """
    others = front.objectives[1 : PANELS + 1]
    figure, grid = panels(6.4 * len(others), 4.6, 1, len(others))
    drawn = [shown(front.problem.catalogue[name]) for name in front.objectives]
    (first, unit, factor), values = drawn[0], front.values
    for axes, k in zip(grid[0], range(1, len(front.objectives)), strict=False):
        name, other, scale = drawn[k]
        order = [i for i in np.argsort(values[:, k]) if front.non_dominated[i]]
        # With more objectives a front is a surface, of which a panel shows a projection: no line joins its points.
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
        # Each axis spans a hundredth of its values at least, so that rounding does not look like a front.
        for limits, set_limits in ((axes.get_xlim, axes.set_xlim), (axes.get_ylim, axes.set_ylim)):
            low, high = limits()
            half = max(0.5 * (high - low), 0.005 * abs(0.5 * (low + high)))
            set_limits(0.5 * (low + high) - half, 0.5 * (low + high) + half)
        _number(axes, order, scale * values[order, k], factor * values[order, 0])
        which = "largest of the samples" if front.problem.samples else "worst scenario"
        label(axes, "", f"{name}, {which} [{other}]", f"{first}, {which} [{unit}]")
    lost = int((~front.feasible).sum())
    count = len(front.problem.cases)
    over = f"{count} scenarios" if count > 1 else "one scenario"
    title = f"Front of {len(front.points)} tuned designs over {over}"
    figure.suptitle(f"{title}, {lost} without a feasible design" if lost else title)
    return figure


def _number(axes: Axes, points: Sequence[int], x: np.ndarray, y: np.ndarray) -> None:
    """Write its number beside each point; points too near each other for a text each have one together."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    groups: list[list[int]] = []
    for k in range(len(points)):
        # In their order along the front only neighbours can be too near each other.
        last = groups[-1][-1] if groups else k
        near = abs(x[k] - x[last]) < NEAR * (right - left) and abs(y[k] - y[last]) < NEAR * (high - low)
        if groups and near:
            groups[-1].append(k)
        else:
            groups.append([k])
    for group in groups:
        text, at = ", ".join(str(points[k] + 1) for k in group), (x[group[0]], y[group[0]])
        axes.annotate(text, at, (4, 5), textcoords="offset points", fontsize=8)
