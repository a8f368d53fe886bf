"""Figures of a sweep."""

import itertools
import math
from typing import Any

import numpy as np

from .._types import Axes, Figure
from ..sweeps.axis import Axis
from ..sweeps.result import Sweep
from .layout import legend_below
from .style import COLUMNS, GREY, RED, label, line, panels, styled
from .words import (
    called,
    edges,
    field_axis,
    in_figures,
    outcome_marks,
    scaled,
    shown,
    success_marks,
    value_in_words,
)

FAILED, UNDONE = "failed", "not computed"
SLICES = 9
WIDE = 30.0  # a ratio from which on colours are on a logarithmic scale
POINTS = ("o", "s", "^", "D", "v", "P")


@styled
def sweep_figure(swept: Sweep) -> Figure:
    """Draw what a sweep found.

    Over one number it draws lines, one for each combination of choices; over two, heat maps of some quantities; over
    more, or choices besides, the main quantity in slices.
    """
    axes = swept.grid.axes
    moving = [k for k, axis in enumerate(axes) if len(axis) > 1]
    numbers = [k for k in moving if axes[k].unit]
    # A map needs two numbers: choices have no order along an axis.
    if len(numbers) < 2:
        along = (numbers or moving or [0])[0]
        return _lines(swept, along, [k for k in moving if k != along])
    if len(moving) == 2:
        return _maps(swept, moving[0], moving[1])
    return _slices(swept, moving)


def _lines(swept: Sweep, along: int, by: list[int]) -> Figure:
    """Draw some quantities over one field, a line for each combination of the values of the others (``by``)."""
    mapped = _mapped(swept)
    columns = math.ceil(len(mapped) / 2)
    figure, grid = panels(4.5 * columns, 6.5, 2, columns)
    axis, axes_of = swept.grid.axes[along], swept.grid.axes
    # Values may be listed in any order; a line joins neighbours.
    order = np.argsort(_places(axis))
    x, marks, others = _places(axis)[order], _marks(swept), [axes_of[k] for k in by]
    outcomes = _by_line(_outcomes(swept), along, by)[:, order]
    words = [", ".join(map(_axis_value, others, it)) for it in itertools.product(*(other.values for other in others))]
    for axes, name in zip(grid.flat, mapped, strict=False):
        title, y, factor = _drawn(swept, name)
        several = _by_line(factor * swept.shaped(name), along, by)[:, order]
        for k, (values, ended) in enumerate(zip(several, outcomes, strict=True)):
            style = (
                {**line(k), "marker": "."}
                if axis.unit
                else {**line(k), "marker": POINTS[k % len(POINTS)], "linestyle": ""}
            )
            axes.plot(x, values, label=words[k] or None, **style)
            for outcome, (marker, colour, _) in marks.items():
                here = ended == outcome
                # one that failed has no value: its mark stands on the horizontal axis
                heights = np.where(np.isfinite(values), values, 0.0)[here]
                if here.any():
                    edge = {"markeredgecolor": "black", "markeredgewidth": 0.4}
                    axes.plot(x[here], heights, marker, color=colour, markersize=7, label=outcome, **edge)
        axes.set_ylim(0.0, 1.03 * axes.get_ylim()[1])
        _scaled(axes, axis)
        # By name, since every line adds the marks of the same outcomes.
        handles = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        label(axes, title, _name(axis), y, legend=bool(handles) and not by)
    _remove(grid, len(mapped))
    if by:
        names = sorted(handles, key=lambda name: name in marks)  # lines, then ends of runs
        legend_below(figure, [handles[name] for name in names], names)
    figure.suptitle(_title(swept))
    return figure


def _by_line(array: np.ndarray, along: int, by: list[int]) -> np.ndarray:
    """Return an array in the grid's shape as (combinations of the axes ``by``, values ``along``)."""
    fixed = [k for k in range(array.ndim) if k != along and k not in by]
    return np.transpose(array, [*fixed, *by, along]).reshape(-1, array.shape[along])


def _axis_value(axis: Axis, value: Any) -> str:
    """Return one value of an axis in a legend or a title; a choice's name is its whole path."""
    if axis.unit:
        return f"{called(axis.name)} {value_in_words(float(value), axis.unit, axis.typed)}"
    return f"{axis.path.replace('.', ' ').replace('_', ' ')} {axis.words(value)}"


def _places(axis: Axis) -> np.ndarray:
    """Return where an axis' values stand in a figure: numbers where they are, angles in degrees, choices side by
    side."""
    return in_figures(axis.unit, axis.typed)[1] * axis.values if axis.unit else np.arange(float(len(axis)))


def _scaled(axes: Axes, axis: Axis) -> None:
    """Set the horizontal scale, or a choice's values in words."""
    if axis.unit:
        places = _places(axis)
        scaled(axes, "x", axis.scale, float(places.min()), float(places.max()))
    else:
        axes.set_xticks(_places(axis), [axis.words(value) for value in axis.values], rotation=20, ha="right")
        axes.set_xlim(-0.5, len(axis) - 0.5)


def _maps(swept: Sweep, across: int, up: int) -> Figure:
    names = _mapped(swept)
    columns = math.ceil(len(names) / 2)
    figure, grid = panels(5.5 * columns, 8.0, 2, columns)
    for axes, name in zip(grid.flat, names, strict=False):
        title, unit, factor = _drawn(swept, name)
        values = factor * swept.shaped(name)
        colours = _logarithmic(swept, name, values)
        image = _map(axes, swept, (across, up), values, (slice(None),) * values.ndim, **colours)
        label(axes, title, _name(swept.grid.axes[across]), _name(swept.grid.axes[up]), legend=False)
        figure.colorbar(image, ax=axes, label=unit)
    _remove(grid, len(names))
    _legend(figure, swept)
    figure.suptitle(_title(swept))
    return figure


def _mapped(swept: Sweep) -> list[str]:
    """Return the mechanism's mapped quantities that some run has."""
    varied = [] if swept.grid is None else [axis.path for axis in swept.grid.axes]
    names = swept.mechanism.defaults_for(swept.design, varied).mapped
    # A quantity of a part that the design does not have is NaN in all runs.
    known = [name for name in names if np.isfinite(swept.shaped(name)).any()]
    return known or list(names[:1])


def _remove(grid: np.ndarray, first: int) -> None:
    """Remove the panels that nothing is drawn in, from the first of them on."""
    for axes in grid.flat[first:]:
        axes.remove()


def _logarithmic(swept: Sweep, name: str, values: np.ndarray) -> dict[str, Any]:
    """Return a logarithmic scale of colours for a share that spreads widely: a few large ones would hide the rest."""
    known = values[np.isfinite(values)]
    if swept.mechanism.quantities[name].unit != "-" or not known.size or known.min() <= 0.0:
        return {}
    from matplotlib.colors import LogNorm

    return {"norm": LogNorm(known.min(), known.max())} if known.max() > WIDE * known.min() else {}


def _slices(swept: Sweep, moving: list[int]) -> Figure:
    """Draw maps over the two longest fields; the values of the others are spread over the panels."""
    # Maps are over numbers only; choices are among what is spread over the panels.
    numbers = [k for k in moving if swept.grid.axes[k].unit]
    # The other fields then make the fewest slices, of which only some are drawn.
    across, up = sorted(sorted(numbers, key=lambda k: -len(swept.grid.axes[k]))[:2])
    others = [k for k in moving if k not in (across, up)]
    every = list(itertools.product(*(range(len(swept.grid.axes[k])) for k in others)))
    places = np.unique(np.linspace(0, len(every) - 1, min(SLICES, len(every))).round().astype(int))
    columns = min(COLUMNS, len(places))
    rows = math.ceil(len(places) / columns)
    figure, grid = panels(2.0 + 3.0 * columns, 3.4 * rows + 0.8, rows, columns)
    main = _mapped(swept)[0]
    title_of_all, axis_label, factor = _drawn(swept, main)
    values = factor * swept.shaped(main)
    finite = values[np.isfinite(values)]
    # All slices have the same colours, so that one bar serves them.
    limits = {"vmin": finite.min(), "vmax": finite.max()} if finite.size else {}
    every_panel = list(grid.flat)
    for axes, place in zip(every_panel, places.tolist(), strict=False):
        cut: list[Any] = [slice(None)] * values.ndim
        for k, index in zip(others, every[place], strict=True):
            cut[k] = slice(index, index + 1)
        image = _map(axes, swept, (across, up), values, tuple(cut), **limits)
        between = ", " if all(swept.grid.axes[k].unit for k in others) else "\n"
        fixed = ((swept.grid.axes[k], index) for k, index in zip(others, every[place], strict=True))
        title = between.join(_axis_value(axis, axis.values[index]) for axis, index in fixed)
        label(axes, title, _name(swept.grid.axes[across]), _name(swept.grid.axes[up]), legend=False)
    _remove(grid, len(places))
    figure.colorbar(image, ax=every_panel[: len(places)], label=axis_label)
    _legend(figure, swept)
    some = f"; {len(places)} of {len(every)} slices" if len(places) < len(every) else ""
    figure.suptitle(f"{title_of_all}. {_title(swept)}{some}")
    return figure


def _map(
    axes: Axes, swept: Sweep, plane: tuple[int, int], values: np.ndarray, cut: tuple[slice, ...], **limits: Any
) -> Any:
    """Draw a heat map of a cut through the grid, every run that did not succeed marked."""
    first, second = (swept.grid.axes[k] for k in plane)
    right, upwards = np.argsort(first.values), np.argsort(second.values)

    def flat(array: np.ndarray) -> np.ndarray:
        face = array[cut].reshape([len(swept.grid.axes[k]) for k in sorted(plane)])
        return face[np.ix_(right, upwards)].T

    x, y = _places(first)[right], _places(second)[upwards]
    # Failed runs have no value: their cells stay empty, and their marks are seen.
    cells = np.ma.masked_invalid(flat(values))
    image = axes.pcolormesh(edges(x, first.scale), edges(y, second.scale), cells, cmap="viridis", **limits)
    outcomes = flat(_outcomes(swept))
    # The more runs there are, the smaller their marks, which would hide the map.
    size = min(40.0, 6e3 / outcomes.size)
    for outcome, (marker, _, colour) in _marks(swept).items():
        rows, columns = np.nonzero(outcomes == outcome)
        if rows.size:
            axes.scatter(x[columns], y[rows], s=size, marker=marker, color=colour, edgecolors="black", linewidths=0.4)
    axes.grid(False)
    scaled(axes, "x", first.scale, float(x[0]), float(x[-1]))
    scaled(axes, "y", second.scale, float(y[0]), float(y[-1]))
    return image


def _legend(figure: Figure, swept: Sweep) -> None:
    from matplotlib.lines import Line2D

    present = set(_outcomes(swept).ravel())
    handles = {
        outcome: Line2D([], [], linestyle="", marker=marker, color=colour, markeredgecolor="black")
        for outcome, (marker, _, colour) in _marks(swept).items()
        if outcome in present
    }
    legend_below(figure, [*handles.values()], [*handles])


def _drawn(swept: Sweep, name: str) -> tuple[str, str, float]:
    """Return a quantity's title, its axis with the unit, and how many of those a unit of it is."""
    title, unit, factor = shown(swept.mechanism.quantities[name])
    return title[:1].upper() + title[1:], f"{title} [{unit}]", factor


def _marks(swept: Sweep) -> dict[str, tuple[str, str, str]]:
    """Return marker, colour in lines and colour in maps of each outcome that is not what should be.

    Successes other than the best that occurs are marked, too: those that are not yet at rest where other runs are.
    """
    ended = outcome_marks(swept.mechanism).items()
    ranked = success_marks(_successes(swept))
    lesser = {name: (*ranked[name], "white") for name in [*ranked][1:]}
    return (
        lesser
        | {name: (marker, colour, "white") for name, (marker, colour) in ended}
        | {
            FAILED: ("s", RED, RED),
            UNDONE: (".", GREY, GREY),
        }
    )


def _outcomes(swept: Sweep) -> np.ndarray:
    """Return words in the grid's shape: an outcome's name, "failed" for all that failed, or "not computed"."""
    names = [FAILED if outcome.failed else outcome.name for outcome in swept.outcomes]
    words = [name if done else UNDONE for name, done in zip(names, swept.done, strict=True)]
    return np.array(words).reshape(swept.grid.shape)


def _successes(swept: Sweep) -> list[str]:
    """Return the successes that occur, the best one first."""
    return [name for name in swept.mechanism.successes if np.any(swept.code == swept.mechanism.outcomes[name])]


def _name(axis: Axis) -> str:
    return field_axis(axis.name, axis.unit, axis.typed) if axis.unit else axis.path.replace(".", " ").replace("_", " ")


def _title(swept: Sweep) -> str:
    mechanism = swept.mechanism
    fixed = [_axis_value(axis, axis.values[0]) for axis in swept.grid.axes if len(axis) == 1]
    parts = [f"Sweep of {len(swept.grid)} {mechanism.view.run_name}s"]
    names = _successes(swept) or ([] if mechanism.success is None else [mechanism.success])
    parts += [f"{int(np.sum(swept.done & (swept.code == mechanism.outcomes[name])))} {name}" for name in names]
    done = int(swept.done.sum())
    parts += [] if done == len(swept) else [f"{done} of {len(swept)} run"]
    return ", ".join([*parts, *fixed])
