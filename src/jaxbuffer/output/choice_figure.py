"""The figure of a choice: the objective of the best combinations, and what they leave of each limit."""

import numpy as np

from .._types import Axes, Figure
from ..choosing.alternatives import Alternative
from ..choosing.choice import Choice, limits_of
from .layout import legend_below, with_line_breaks
from .style import BLUE, COLOURS, GREY, MARKS, ORANGE, RED, label, panels, styled

ROWS = 12  # combinations that are drawn
WIDE, SMALL = 150.0, 8  # width of a name and size of text [points]


@styled
def choice_figure(choice: Choice) -> Figure:
    """Draw a bar for the objective of each ranked combination, beside the continuous one, and its margins."""
    drawn = choice.ranked[:ROWS]
    figure, grid = panels(11.0, 0.55 * max(len(drawn), 4) + 2.0, 1, 2)
    _objective(grid[0, 0], choice, drawn)
    _margins(grid[0, 1], choice, drawn)
    (first, of_first), (second, of_second) = (axes.get_legend_handles_labels() for axes in grid[0])
    legend_below(figure, [*first, *second], [*of_first, *of_second])
    tally = choice.tally
    share = 100.0 * tally.spared / max(tally.possible, 1)
    title = f"Best of {tally.combinations} combinations" if choice.feasible else "No combination keeps all limits"
    runs = f"{title}; {tally.runs} runs of {tally.possible}, {share:.0f} % spared"
    figure.suptitle("\n".join(filter(None, (runs, _tightest(choice)))))
    return figure


def _tightest(choice: Choice) -> str:
    """Return the limit that the best combination is nearest to or farthest beyond, in words; "" for none."""
    rows = [] if choice.best is None else limits_of(choice, choice.best)
    if not rows:
        return ""
    first = rows[0]
    at = f", at {first.where}" if first.where else ""
    return f"the first's tightest limit: {first.name} {first.value} ({first.bound}), room {first.room}{at}"


def _objective(axes: Axes, choice: Choice, drawn: tuple[Alternative, ...]) -> None:
    """Draw the objective of each combination, from zero."""
    symbol, factor = choice.criterion.objective.in_figures(choice.criterion.catalogue)
    rows, values = np.arange(len(drawn)), factor * np.array([it.value for it in drawn])
    colours = [BLUE if it.feasible else GREY for it in drawn]
    axes.barh(rows, values, 0.6, color=colours)
    for row, it in zip(rows, drawn, strict=True):
        text = choice.objectives_in_words(it) + ("" if it.feasible else ", beyond limits")
        axes.annotate(text, (0.0, row), (4, 0), textcoords="offset points", va="center", fontsize=SMALL, color="white")
    lines = [("continuous optimum", choice.optimum.value if choice.optimum is not None else np.nan)]
    lines += [("continuous design", choice.continuous.value if choice.continuous is not None else np.nan)]
    for name, value in lines:
        if np.isfinite(value):
            axes.axvline(factor * value, color=ORANGE, linestyle="--", label=name)
    if np.isfinite(choice.ceiling):
        axes.axvline(factor * choice.ceiling, color=GREY, linestyle=":", label="up to here the second objective orders")
    names = [with_line_breaks(choice.in_words(it), WIDE, SMALL) for it in drawn]
    axes.set_yticks(rows, names, fontsize=SMALL)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    label(axes, f"{choice.criterion}", f"objective [{symbol}]" if symbol else "objective", "", legend=False)


def _margins(axes: Axes, choice: Choice, drawn: tuple[Alternative, ...]) -> None:
    """Draw what each combination leaves of each limit in its worst scenario."""
    rows = np.arange(len(drawn))
    limits = [it.limit for it in drawn[0].margins] if drawn else []
    for number, limit in enumerate(limits):
        known = [next(one.share for one in it.margins if one.limit == limit) for it in drawn]
        left = np.array([np.nan if share is None else 100.0 * share for share in known])
        name = limit.line(choice.criterion.catalogue[limit.name])
        # No line joins the marks: combinations have no order but their rank.
        axes.plot(left, rows, MARKS[number % len(MARKS)], color=COLOURS[number % len(COLOURS)], label=name)
    axes.axvline(0.0, color=RED, linewidth=1.5)
    axes.set_yticks(rows, [""] * len(rows))
    axes.set_ylim(len(rows) - 0.5, -0.5)
    label(axes, "Left of each limit in the worst scenario", "left of the limit [%]", "", legend=False)
