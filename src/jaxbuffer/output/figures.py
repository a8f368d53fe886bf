"""The figure of a run: contact force with its peak enlarged, and what the mechanism draws besides."""

import math
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from ..errors import InputError
from ..mechanisms.picture import Panel
from ..mechanisms.run import Run
from .style import COLOURS, GREY, RED, label, panels, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 2


@styled
def run_figure(run: Run) -> "Figure":
    """Contact force with its peak enlarged, and the mechanism's own panels over time.

    **Arguments:** ``run``: one simulated with ``history=True``.
    """
    seen, mechanism = _history(run), run.mechanism
    others = mechanism.panels(run)
    rows = math.ceil((2 + len(others)) / COLUMNS)
    figure, grid = panels(9.0, 3.0 * rows, rows, COLUMNS)
    force, zoom, *rest = grid.flat
    count = int(run.impact_count)
    impacts = "1 impact" if count == 1 else f"{count} impacts"
    figure.suptitle(
        f"{run.outcome.name} after {float(run.end_time):.4g} s, {impacts}, {mechanism.approach(run.scenario)}"
    )
    _forces(force, zoom, run)
    for axes, panel in zip(rest, others, strict=False):
        _draw(axes, np.asarray(seen.time), panel)
    for axes in rest[len(others) :]:
        axes.remove()
    return figure


def _forces(force: "Axes", zoom: "Axes", run: Run) -> None:
    """The contact force over the whole run, and around its peak."""
    seen, names = _history(run), run.mechanism.names(run.design)
    peak, at = float(run.peak_force), float(run.peak_time)
    for k, contact in enumerate(names.contacts):
        kind = run.mechanism.contact
        name = f"{contact} {kind}" if contact != kind else contact
        force.plot(np.asarray(seen.time), seen.contact_force[:, k], color=COLOURS[k], label=name)
        _pulse(zoom, run, k, COLOURS[k], marker=".")
    force.plot(at, peak, "o", color=RED, markersize=4, label="peak")
    label(force, "Contact force", "time [s]", "contact force [N]")
    zoom.plot(0.0, peak, "o", color=RED, markersize=4)
    label(zoom, f"The peak, {peak:.4g} N at {at:.6g} s", "time from the peak [ms]", "contact force [N]", False)


def _draw(axes: "Axes", time: np.ndarray, panel: Panel) -> None:
    if panel.stacked:
        names = [curve.label for curve in panel.curves]
        axes.stackplot(time, *(curve.values for curve in panel.curves), colors=COLOURS, labels=names)
        axes.set_ylim(0.0, 1.45 * float(np.max(sum(curve.values for curve in panel.curves))))  # room for the legend
    else:
        for k, curve in enumerate(panel.curves):
            dashes = "--" if curve.dashed else "-"
            along = time if curve.along is None else curve.along
            axes.plot(along, curve.values, color=COLOURS[k], linestyle=dashes, label=curve.label or None)
    for level in panel.levels:
        colour, dashes = (RED, "-") if level.limit else (GREY, "--") if level.label else ("black", "-")
        axes.axhline(level.value, color=colour, linestyle=dashes, linewidth=0.8, label=level.label or None)
    legend = bool(axes.get_legend_handles_labels()[0])
    if panel.path:
        axes.set_aspect("equal", "datalim")
    label(axes, panel.title, panel.path or "time [s]", panel.axis, legend, columns=2 if panel.stacked else 1)


def _pulse(axes: "Axes", run: Run, contact: int, colour: str, label: str = "", marker: str = "") -> None:
    """Contact force over time from the run's peak [ms], as wide as the impact that holds it, markers at the steps."""
    seen, at = _history(run), float(run.peak_time)
    time, force = np.asarray(seen.time), np.asarray(seen.contact_force)
    start, end = _around(time, force[:, int(run.peak_contact)], at)
    room = 0.25 * (end - start)
    inside = (time > start - room) & (time < end + room)
    if np.any(force[inside, contact] > 0.0):
        pulse = 1e3 * (time[inside] - at), force[inside, contact]
        axes.plot(*pulse, color=colour, label=label, marker=marker, markersize=3)


def _around(time: np.ndarray, force: np.ndarray, at: float) -> tuple[float, float]:
    """When the impact with the largest force, at a given time, begins and ends [s]: above two per cent of the peak."""
    near = int(np.argmin(np.abs(time - at)))
    low = force < 0.02 * force[near]
    before, after = np.flatnonzero(low[:near]), np.flatnonzero(low[near:])
    start = before[-1] + 1 if before.size else 0
    end = near + after[0] - 1 if after.size else len(time) - 1
    return float(time[start]), float(time[end])


def _history(run: Run) -> Any:
    if run.history is None:
        raise InputError("this run has no history to plot; simulate it with history=True")
    return jax.tree.map(np.asarray, run.history)
