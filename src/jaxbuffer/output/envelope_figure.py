"""The figure of a sweep's safe envelope."""

from typing import Any

import numpy as np

from .._types import Axes, Figure
from ..experiments.rectangle import SafeRectangle
from ..sweeps.axis import Axis
from ..value_text import range_text
from .layout import legend_below
from .style import BLUE, RED, label, panels, styled
from .words import called, edges, field_axis, in_figures, reason_marks, scaled

SAFE, UNSAFE = "#B8DCEF", "#F3F3F3"


@styled
def envelope_figure(rectangle: SafeRectangle) -> Figure:
    """Draw a mark for each run, blue where it is safe and else for what it breaks; shade what lies between safe runs.

    Angles are in degrees, all other numbers as typed.
    """
    figure, ((axes,),) = panels(8.0, 6.0, 1, 1)
    (first, second), (x, y) = rectangle.axes, rectangle.values
    (across, over), (up, above) = (in_figures(axis.unit, axis.typed) for axis in rectangle.axes)
    right, top = x * over, y * above
    from matplotlib.colors import ListedColormap

    # Nothing is known of a cell but its four corners, and nothing beyond the outermost runs.
    proven = _between_safe(rectangle.safe)
    axes.pcolormesh(right, top, proven.T.astype(float), cmap=ListedColormap([UNSAFE, SAFE]), vmin=0, vmax=1)
    _border(axes, proven, right, top)
    _reasons(axes, rectangle, x * over, y * above)
    rows, columns = np.nonzero(rectangle.safe)
    axes.scatter(
        x[rows] * over,
        y[columns] * above,
        s=float(np.clip(24e3 / rectangle.safe.size, 30.0, 140.0)),
        marker=".",
        color=BLUE,
        edgecolors="white",
        linewidths=0.5,
        zorder=3,
        label="safe run",
    )
    title = f"{rectangle.counted} are safe: {rectangle.criterion}"
    if rectangle.first is not None and rectangle.second is not None:
        low, high = (np.array(part) * factor for part, factor in ((rectangle.first, over), (rectangle.second, above)))
        corners = np.array([[low[0], high[0]], [low[1], high[0]], [low[1], high[1]], [low[0], high[1]]])
        closed = np.vstack([corners, corners[:1]])
        axes.plot(*closed.T, color=BLUE, linewidth=2.5, marker=".", label="largest rectangle of safe runs")
        title += f"\nlargest rectangle: {_words(low, across, first)}, {_words(high, up, second)}"
    axes.grid(False)
    scaled(axes, "x", first.scale, x[0] * over, x[-1] * over)
    scaled(axes, "y", second.scale, y[0] * above, y[-1] * above)
    # The marks of the outermost runs are whole.
    axes.set_xlim(*edges(x * over, first.scale)[[0, -1]])
    axes.set_ylim(*edges(y * above, second.scale)[[0, -1]])
    across_named, up_named = (field_axis(axis.name, axis.unit, axis.typed) for axis in rectangle.axes)
    label(axes, title, across_named, up_named, legend=False)
    legend_below(figure, *axes.get_legend_handles_labels())
    return figure


def _between_safe(safe: np.ndarray) -> np.ndarray:
    """Return which cells between runs (m, n) have safe runs at all four corners (m - 1, n - 1)."""
    return safe[:-1, :-1] & safe[1:, :-1] & safe[:-1, 1:] & safe[1:, 1:]


def _border(axes: Axes, safe: np.ndarray, right: np.ndarray, top: np.ndarray) -> None:
    """Draw the line between safe cells and the others."""
    m, n = safe.shape
    style: dict[str, Any] = {"color": "black", "linewidth": 1.4}
    name = "border of what lies between safe runs"
    for i in range(m):
        for j in range(n):
            if i + 1 < m and safe[i, j] != safe[i + 1, j]:
                # Only the first piece has the name: each would have an entry in the legend.
                axes.plot([right[i + 1]] * 2, top[j : j + 2], label=name, **style)
                name = ""
            if j + 1 < n and safe[i, j] != safe[i, j + 1]:
                axes.plot(right[i : i + 2], [top[j + 1]] * 2, label=name, **style)
                name = ""


def _reasons(axes: Axes, rectangle: SafeRectangle, x: np.ndarray, y: np.ndarray) -> None:
    """Draw a mark on each run that is not safe, for the first thing that it breaks."""
    reasons = rectangle.reasons
    # Failures first, so that a study's own limits do not change their marks.
    names = sorted(set(reasons[reasons != ""]), key=lambda reason: (not reason.startswith("failed"), reason))
    for reason, marker in reason_marks(rectangle.swept.mechanism, names).items():
        rows, columns = np.nonzero(reasons == reason)
        colour = RED if reason.startswith("failed") else "#555555"
        size = min(40.0, 6e3 / reasons.size)
        axes.scatter(x[rows], y[columns], s=size, marker=marker, color=colour, linewidths=0, label=reason)


def _words(part: np.ndarray, unit: str, axis: Axis) -> str:
    return f"{called(axis.name)} {range_text(part[0], part[1], unit, 4)}"
