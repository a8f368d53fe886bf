"""The figure of a run: contact force with its peak enlarged, and what the mechanism draws besides."""

import math
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from ..errors import InputError
from ..mechanisms.picture import Panel
from ..mechanisms.run import Run
from ..run.instants import at_times
from .pulses import pulse_around
from .style import COLOURS, GREY, RED, label, panels, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 2
DENSE = 400  # instants of the peak's pulse
BEYOND, WORTH = 1.2, 0.4  # of the last contact's time; a longer run's time axes end there


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
    until = last_contact(run)
    title = f"{run.outcome.name} after {float(run.end_time):.4g} s, {impacts}, {mechanism.approach(run.scenario)}"
    if until < float(seen.time[-1]):
        title += f"\ntime axes end at {until:.3g} s: nothing touches from there to {float(seen.time[-1]):.4g} s"
    figure.suptitle(title)
    _forces(force, zoom, run, until)
    for axes, panel in zip(rest, others, strict=False):
        _draw(axes, np.asarray(seen.time), panel, until)
    for axes in rest[len(others) :]:
        axes.remove()
    return figure


def _forces(force: "Axes", zoom: "Axes", run: Run, until: float) -> None:
    """The contact force over the whole run, and around its peak."""
    seen, names = _history(run), run.mechanism.names(run.design)
    peak, at = float(run.peak_force), float(run.peak_time)
    for k, contact in enumerate(names.contacts):
        kind = run.mechanism.contact
        name = f"{contact} {kind}" if contact != kind else contact
        shown = np.asarray(seen.time) <= until
        force.plot(np.asarray(seen.time)[shown], seen.contact_force[shown, k], color=COLOURS[k], label=name)
    _pulse(zoom, run)
    force.plot(at, peak, "o", color=RED, markersize=4, label="peak")
    label(force, "Contact force", "time [s]", "contact force [N]")
    zoom.plot(0.0, peak, "o", color=RED, markersize=4)
    label(zoom, f"The peak, {peak:.4g} N at {at:.6g} s", "time from the peak [ms]", "contact force [N]", False)


def _draw(axes: "Axes", time: np.ndarray, panel: Panel, until: float) -> None:
    """One panel of the mechanism's own, over the time ``until`` [s]; paths are drawn whole."""
    seen = time <= until
    if panel.stacked:
        names, parts = (
            [curve.label for curve in panel.curves],
            [np.asarray(curve.values)[seen] for curve in panel.curves],
        )
        axes.stackplot(time[seen], *parts, colors=COLOURS, labels=names)
        axes.set_ylim(0.0, 1.45 * float(np.max(np.sum(parts, axis=0))))  # room for the legend
    else:
        for k, curve in enumerate(panel.curves):
            dashes = "--" if curve.dashed else "-"
            values = np.asarray(curve.values)
            along, values = (time[seen], values[seen]) if curve.along is None else (curve.along, values)
            axes.plot(along, values, color=COLOURS[k], linestyle=dashes, label=curve.label or None)
    for level in panel.levels:
        colour, dashes = (RED, "-") if level.limit else (GREY, "--") if level.label else ("black", "-")
        axes.axhline(level.value, color=colour, linestyle=dashes, linewidth=0.8, label=level.label or None)
    legend = bool(axes.get_legend_handles_labels()[0])
    if panel.path:
        axes.set_aspect("equal", "datalim")
    label(axes, panel.title, panel.path or "time [s]", panel.axis, legend, columns=2 if panel.stacked else 1)


def _pulse(axes: "Axes", run: Run) -> None:
    """Contact forces over time from the run's peak [ms], as wide as the impact that holds it."""
    seen, at = _history(run), float(run.peak_time)
    pulse = pulse_around(np.asarray(seen.time), np.asarray(seen.contact_force)[:, int(run.peak_contact)], at)
    room = 0.25 * (pulse.end - pulse.start)
    first, last = max(pulse.start - room, float(seen.time[0])), min(pulse.end + room, float(seen.time[-1]))
    time = np.union1d(np.linspace(first, last, DENSE), [at])
    force = np.asarray(at_times(run, time).contact_force)
    for k in np.flatnonzero(np.any(force > 0.0, axis=0)):
        axes.plot(1e3 * (time - at), force[:, k], color=COLOURS[k])


def last_contact(run: Run) -> float:
    """Until when time axes go [s]: a little beyond the last contact, or to the end if that is not much later."""
    seen = _history(run)
    touching = np.flatnonzero(np.any(np.asarray(seen.contact_force) > 0.0, axis=1))
    end = float(seen.time[-1])
    last = BEYOND * float(seen.time[touching[-1]]) if touching.size else end
    return last if last < WORTH * end else end


def _history(run: Run) -> Any:
    if run.history is None:
        raise InputError("this run has no history to plot; simulate it with history=True")
    return jax.tree.map(np.asarray, run.history)
