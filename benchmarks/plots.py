"""The plots of a part as PNG files."""

from __future__ import annotations

from pathlib import Path

from .figures import Part, Plot

COLOURS = ("#d62728", "#7f7f7f", "#1f77b4", "#2ca02c", "#9467bd", "#8c564b", "#17becf", "#bcbd22", "#e377c2", "#ff7f0e")


def draw(plot: Plot, file: Path) -> None:
    """One plot on logarithmic axes; curves of one label share a colour and an entry of the legend."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    colours: dict[str, str] = {}
    for curve in plot.curves:
        label = None if curve.label in colours else curve.label
        colour = colours.setdefault(curve.label, COLOURS[len(colours) % len(COLOURS)])
        axes.loglog(curve.xs, curve.ys, "o-", markersize=3.5, linewidth=1.2, color=colour, label=label)
    if plot.line is not None:
        axes.axhline(plot.line, color="black", linewidth=0.8, linestyle="--", label="target")
    axes.set(title=plot.title, xlabel=plot.x, ylabel=plot.y)
    axes.grid(True, which="major", alpha=0.3)
    axes.legend(fontsize=8)
    figure.savefig(file, dpi=150)


def draw_all(part: Part, folder: Path) -> list[Path]:
    """The part's plots in ``folder``."""
    files = [folder / f"{plot.name.replace(' ', '-')}.png" for plot in part.plots]
    for plot, file in zip(part.plots, files, strict=True):
        draw(plot, file)
    return files
