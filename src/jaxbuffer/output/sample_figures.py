"""Figures of a sample: quantities over each number, Sobol' indices as bars, predicted against computed."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .._types import Axes, Figure
from ..experiments.indices import Indices
from ..experiments.sample import Sample
from ..experiments.surface import Surface
from ..value_text import percent_text, with_unit
from .layout import legend_below
from .style import BLUE, GREY, ORANGE, RED, label, panels, styled
from .words import field_axis, in_figures, outcome_marks, scaled, shown, success_marks

ROWS, COLUMNS = 3, 6  # quantities and numbers that are drawn
METHODS = {"sobol": "Sobol'", "saltelli": "Saltelli", "gaussian_process": "Gaussian process"}  # others in words


@styled
def sample_figure(sample: Sample) -> Figure:
    """Draw the mechanism's first quantities over each number, every end of a run in its own colour and mark."""
    mechanism, drawn = sample.mechanism, sample.grid.axes[:COLUMNS]
    names = mechanism.defaults_for(sample.design, [axis.path for axis in sample.grid.axes]).mapped[:ROWS]
    figure, grid = panels(max(2.6 * len(drawn), 5.0) + 0.6, 2.3 * len(names) + 1.0, len(names), len(drawn))
    columns, outcomes = sample.values, np.array([outcome.name for outcome in sample.outcomes])
    aims = mechanism.successes or (mechanism.outcomes.time_is_up(),)
    ends = sorted(set(outcomes[sample.solved]), key=lambda end: end not in aims)
    marks = outcome_marks(mechanism)
    best = success_marks([end for end in aims if end in ends])
    for number, (row, name) in enumerate(zip(grid, names, strict=True), 1):
        title, unit, factor = shown(mechanism.quantities[name])
        for axes, axis in zip(row, drawn, strict=True):
            many = in_figures(axis.unit, axis.typed)[1]
            for end in ends:
                here = sample.solved & (outcomes == end)
                marker, colour = (best | marks)[end]
                style: dict[str, Any] = {"color": colour, "marker": marker, "s": 9 if marker == "o" else 18}
                axes.scatter(
                    many * columns[axis.path][here],
                    factor * sample.columns[name][here],
                    label=end,
                    linewidths=0,
                    **style,
                )
            scaled(axes, "x", axis.scale, many * axis.low, many * axis.high)
            low = axes.get_ylim()[0]
            # Zero is shown where the values begin near it, so that heights can be compared.
            axes.set_ylim(bottom=min(low, 0.0) if low > -0.05 * axes.get_ylim()[1] else low)
            below = field_axis(axis.name, axis.unit, axis.typed) if number == len(names) else ""
            label(axes, "", below, "", legend=False)
        row[0].set_ylabel(f"{title}\n[{unit}]")
    legend_below(figure, *grid[0, 0].get_legend_handles_labels())
    # Failed runs have no values, and are missing in every panel.
    lost = int(np.sum(sample.done & ~sample.solved))
    parts = [f"Sample of {len(sample.grid)} {mechanism.view.run_name}s, {_worded(sample.grid.method)}"]
    parts += [f"{lost} failed"] if lost else []
    parts += [f"{len(drawn)} of {len(sample.grid.axes)} numbers"] if len(drawn) < len(sample.grid.axes) else []
    figure.suptitle(", ".join(parts))
    return figure


@styled
def indices_figure(indices: Indices) -> Figure:
    """Draw first-order and total index of each number as bars with their intervals, a panel a quantity."""
    names = list(indices.estimates)
    figure, grid = panels(7.5, (0.45 * len(indices.paths) + 1.3) * len(names) + 0.6, len(names), 1)
    for axes, name in zip(grid[:, 0], names, strict=True):
        it = indices.estimates[name]
        order = np.argsort(it.total)
        places = np.arange(len(order))
        for values, ends, shift, colour, what in (
            (it.total, it.total_interval, -0.2, ORANGE, "total: together with the others"),
            (it.first, it.first_interval, 0.2, BLUE, "first-order: alone"),
        ):
            reach = np.abs(ends[:, order] - values[order])
            axes.barh(places + shift, values[order], 0.38, color=colour, label=what)
            axes.errorbar(
                values[order], places + shift, xerr=reach, fmt="none", ecolor="black", elinewidth=1.0, capsize=2.5
            )
        axes.set_yticks(places, [indices.paths[k] for k in order])
        axes.axvline(0.0, color="black", linewidth=0.8)
        # An index lies between 0 and 1, but its estimate and the ends of its interval need not.
        axes.set_xlim(min(0.0, 1.05 * float(it.first_interval.min())), max(1.0, 1.05 * float(it.total_interval.max())))
        through = f", from {it.rows} rows of runs"
        if (surface := indices.surfaces.get(name)) is not None:
            through = f", by a response surface that misses {percent_text(surface.error.relative)}{_warned(surface)}"
        label(axes, f"{name.replace('_', ' ')}{through}", "share of the variance [-]", "", legend=False)
    handles, words = grid[0, 0].get_legend_handles_labels()
    # Bars are drawn from the bottom up, so that the legend in reverse has them in the order in which they are seen.
    legend_below(figure, handles[::-1], words[::-1])
    figure.suptitle(f"Sobol' indices with {percent_text(indices.confidence, 'g')} intervals")
    return figure


def _warned(surface: Surface) -> str:
    return "" if surface.trusted else ": not to be trusted"


@styled
def surfaces_figure(surfaces: Sequence[Surface]) -> Figure:
    """Draw predicted against computed values, by fits that had not seen the run; a panel a quantity."""
    figure, grid = panels(4.6 * len(surfaces), 4.8, 1, len(surfaces))
    for axes, surface in zip(grid[0], surfaces, strict=True):
        _predicted(axes, surface)
    return figure


def _predicted(axes: Axes, surface: Surface) -> None:
    unit, factor = surface.shown
    unit = "°" if unit == "deg" else unit
    computed, predicted = factor * surface.computed, factor * surface.predicted
    both = np.concatenate([computed, predicted])
    ends = np.array([both.min(), both.max()])
    axes.plot(ends, ends, color=GREY, linewidth=1.0, label="equal")
    axes.plot(computed, predicted, "o", color=BLUE, markersize=3, label="a run not seen")
    worst = int(np.argmax(np.abs(surface.predicted - surface.computed)))
    axes.plot(
        computed[worst], predicted[worst], "s", color=RED, markersize=7, fillstyle="none",
        label=f"worst, off by {with_unit(factor * surface.error.largest, unit, 3)}",
    )  # fmt: skip
    if surface.logarithmic and ends[1] > 10.0 * ends[0]:
        axes.set_xscale("log")
        axes.set_yscale("log")
    axes.set_aspect("equal")
    what = surface.quantity.replace("_", " ")
    error = f"{with_unit(factor * surface.error.rms, unit, 3)} rms, {percent_text(surface.error.relative)}"
    title = f"{what}, {_worded(surface.kind)}\ncross-validated error {error}{_warned(surface)}"
    label(axes, title, f"computed {what} [{unit}]", f"predicted {what} [{unit}]")


def _worded(method: str) -> str:
    return METHODS.get(method, method.replace("_", " "))
