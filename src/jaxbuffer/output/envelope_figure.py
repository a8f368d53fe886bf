"""The figure of a safe envelope: which runs keep every limit, the border, the largest rectangle of safe ones."""

from typing import TYPE_CHECKING, Any

import numpy as np

from .layout import legend_below
from .style import BLUE, RED, label, panels, styled
from .words import MARKERS, called, edges, field_axis, in_figures, outcome_marks, scaled, signed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..experiments.rectangle import SafeRectangle
    from ..sweeps.grid import Axis

SAFE, UNSAFE = "#B8DCEF", "#F3F3F3"


@styled
def envelope_figure(found: "SafeRectangle") -> "Figure":
    """A cell a run: safe ones blue, the others marked with what they break; angles in degrees."""
    figure, ((axes,),) = panels(8.0, 6.0, 1, 1)
    (first, second), (x, y) = found.axes, found.values
    (across, over), (up, above) = (in_figures(axis.unit) for axis in found.axes)
    right, top = edges(x, first.scale) * over, edges(y, second.scale) * above
    from matplotlib.colors import ListedColormap

    axes.pcolormesh(right, top, found.safe.T.astype(float), cmap=ListedColormap([UNSAFE, SAFE]), vmin=0, vmax=1)
    _border(axes, found.safe, right, top)
    _reasons(axes, found, x * over, y * above)
    rows, columns = np.nonzero(found.safe)
    axes.scatter(x[rows] * over, y[columns] * above, s=8, color=BLUE, linewidths=0, label="safe run")
    runs = f"{found.swept.mechanism.view.run_name}s"
    title = f"{int(found.safe.sum())} of {found.safe.size} {runs} are safe: {found.asked}"
    if found.first is not None and found.second is not None:
        low, high = (np.array(part) * factor for part, factor in ((found.first, over), (found.second, above)))
        corners = np.array([[low[0], high[0]], [low[1], high[0]], [low[1], high[1]], [low[0], high[1]]])
        closed = np.vstack([corners, corners[:1]])
        axes.plot(*closed.T, color=BLUE, linewidth=2.5, marker=".", label="largest rectangle of safe runs")
        title += f"\nlargest rectangle: {_words(low, across, first)}, {_words(high, up, second)}"
    axes.grid(False)
    scaled(axes, "x", first.scale, x[0] * over, x[-1] * over)
    scaled(axes, "y", second.scale, y[0] * above, y[-1] * above)
    across_named, up_named = (field_axis(axis.name, axis.unit) for axis in found.axes)
    label(axes, title, across_named, up_named, legend=False)
    legend_below(figure, *axes.get_legend_handles_labels())
    return figure


def _border(axes: "Axes", safe: np.ndarray, right: np.ndarray, top: np.ndarray) -> None:
    """The line between safe cells and the others."""
    m, n = safe.shape
    style: dict[str, Any] = {"color": "black", "linewidth": 1.4}
    name = "border of what is safe"
    for i in range(m):
        for j in range(n):
            if i + 1 < m and safe[i, j] != safe[i + 1, j]:
                axes.plot([right[i + 1]] * 2, top[j : j + 2], label=name, **style)
                name = ""
            if j + 1 < n and safe[i, j] != safe[i, j + 1]:
                axes.plot(right[i : i + 2], [top[j + 1]] * 2, label=name, **style)
                name = ""


def _reasons(axes: "Axes", found: "SafeRectangle", x: np.ndarray, y: np.ndarray) -> None:
    """A mark on each run that is not safe, for the first thing that it breaks."""
    reasons, marks = found.reasons, outcome_marks(found.swept.mechanism)
    free = [marker for marker in MARKERS if marker not in [marks[reason][0] for reason in marks]]
    free = free or [*MARKERS]
    others = sorted(set(reasons[reasons != ""]) - set(marks))
    marks |= {reason: (free[k % len(free)], "") for k, reason in enumerate(others)}
    for reason in sorted(set(reasons[reasons != ""])):
        rows, columns = np.nonzero(reasons == reason)
        failed = reason.startswith("failed")
        marker, colour = ("s", RED) if failed else (marks[reason][0], "#555555")
        size = min(40.0, 6e3 / reasons.size)
        axes.scatter(x[rows], y[columns], s=size, marker=marker, color=colour, linewidths=0, label=reason)


def _words(part: np.ndarray, unit: str, axis: "Axis") -> str:
    if unit == "°":
        return f"{called(axis.name)} {signed(part[0])} to {signed(part[1])}"
    return f"{called(axis.name)} {part[0]:.4g} to {part[1]:.4g} {unit}".rstrip(" -")
