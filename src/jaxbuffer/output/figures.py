"""The figure of a run: contact force with its peak enlarged, and what the mechanism draws besides."""

import math
from typing import Any, NamedTuple

import equinox as eqx
import jax
import numpy as np

from .._types import Axes, Figure
from ..errors import InputError
from ..mechanisms.picture import Level, Panel
from ..mechanisms.run import Run
from ..run.instants import at_times
from ..value_text import unit_by_size, with_unit
from .pulses import BEYOND, EVEN, WORTH, fine_times, last_contact, pulse_around, touching
from .style import GREY, RED, curve, hatch, label, panels, styled
from .words import TIME_UNITS, force_text, newtons, seconds, time_text

COLUMNS = 2
DENSE = 400  # instants of the peak's pulse
INK = "#555555"


class Window(NamedTuple):
    """Time axes: from ``start`` to ``end`` [s] of a run, in a ``unit`` of which ``factor`` make a second."""

    start: float
    end: float
    unit: str
    factor: float

    def inside(self, time: np.ndarray) -> np.ndarray:
        """Return which times [s] are in it."""
        return (time >= self.start) & (time <= self.end)


@styled
def run_figure(run: Run, margin: str = "") -> Figure:
    """Draw the contact force with its peak enlarged, and the mechanism's own panels over time.

    **Arguments:** ``run``: one simulated with ``history=True``; ``margin``: the limit that stands in the way most, in
    words, "" where nothing is limited.
    """
    mechanism, end = run.mechanism, float(_history(run).time[-1])
    to_end = any(panel.to_end for panel in mechanism.view.panels(run))
    # Steps are long in flight and few in an impact: lines through them alone would have corners.
    run = between_steps(run, to_end)
    # Asked again, so that their curves go through the instants between the steps too.
    others = mechanism.view.panels(run)
    touched = float(run.peak_force) > 0.0  # else there is no peak to look at
    # Without a contact there is no force to draw, unless nothing else is.
    forced = np.shape(_history(run).contact_force)[1] > 0 or not others
    rows = math.ceil((forced + touched + len(others)) / COLUMNS)
    figure, grid = panels(9.0, 3.0 * rows, rows, COLUMNS)
    rest = [*grid.flat]
    force = rest.pop(0) if forced else None
    zoom = rest.pop(0) if touched else None
    count = int(run.impact_count)
    impacts = ("1 impact, " if count == 1 else f"{count} impacts, ") if forced else ""
    start, until = first_contact(run), last_contact(run)
    title = (
        f"{run.outcome.name} after {time_text(float(run.end_time))}, {impacts}{mechanism.view.approach(run.scenario)}"
    )
    cut = []
    if start > 0.0:
        whole = "" if to_end else ", gap and energy excepted"
        cut.append(f"begin at {time_text(start)}{whole}: nothing touches before")
    if until < end:
        cut.append(f"end at {time_text(until)}: nothing touches from there to {time_text(end)}")
    axes_cut = f"{'some ' if to_end else ''}time axes {' and '.join(cut)}" if cut else ""
    figure.suptitle("\n".join(filter(None, (title, margin, axes_cut))))
    window = Window(start, until, *seconds(until))
    if force is not None:
        _forces(force, zoom, run, window)
    for axes, panel in zip(rest, others, strict=False):
        # Some panels tell of the time before or after the contacts, too; the others end with these.
        shown = window if not panel.to_end else Window(start, end, *seconds(end))
        _draw(axes, np.asarray(_history(run).time), panel, shown._replace(start=0.0) if panel.whole else shown)
    for axes in rest[len(others) :]:
        axes.remove()
    return figure


def between_steps(run: Run, to_end: bool = False) -> Run:
    """Return the run with a history at many instants between its steps too, where steps are long or a contact is
    closed.

    ``to_end``: whether curves go on to the end of the run, also where the contacts end early.
    """
    until = last_contact(run)
    times = fine_times(run, until=until)
    if to_end:
        times = np.union1d(times, np.linspace(until, float(_history(run).time[-1]), 2 * EVEN))
    return eqx.tree_at(lambda it: it.history, run, at_times(run, times))


def _forces(force: Axes, zoom: Axes | None, run: Run, window: Window) -> None:
    """Draw the contact force over the run, and around its peak if there is one."""
    history, names = _history(run), run.mechanism.view.names(run.design)
    peak, at = float(run.peak_force), float(run.peak_time)
    (unit, factor), time = newtons(peak), np.asarray(history.time)
    shown = window.inside(time)
    for k, contact in enumerate(names.of_contacts(history.contact_force.shape[1])):
        name = run.mechanism.view.contact_in_words(contact)
        force.plot(window.factor * time[shown], factor * history.contact_force[shown, k], **curve(k), label=name)
    force.locator_params(axis="x", nbins=6)
    if zoom is None:
        named = history.contact_force.shape[1] > 0  # a mechanism may have no contact, and then no legend of them
        label(force, "Contact force: nothing touches", f"time [{window.unit}]", f"contact force [{unit}]", named)
        return
    force.plot(window.factor * at, factor * peak, "o", color=RED, markersize=4, label="peak")
    label(force, "Contact force", f"time [{window.unit}]", f"contact force [{unit}]")
    _pulse(zoom, run, factor)
    zoom.plot(0.0, factor * peak, "o", color=RED, markersize=4)
    moment, many = seconds(at)
    title = f"The peak, {force_text(peak)} at {with_unit(many * at, moment)}"
    label(zoom, title, zoom.get_xlabel(), f"contact force [{unit}]", False)


def _draw(axes: Axes, time: np.ndarray, panel: Panel, window: Window) -> None:
    """Draw one panel of the mechanism's own; paths are drawn whole."""
    inside = window.inside(time)
    over = window.factor * time[inside]
    if panel.stacked:
        names, parts = (
            [drawn.label for drawn in panel.curves],
            [np.asarray(drawn.values)[inside] for drawn in panel.curves],
        )
        colours = [curve(k)["color"] for k in range(len(parts))]
        for k, area in enumerate(axes.stackplot(over, *parts, colors=colours, labels=names)):
            # matplotlib draws hatching in the colour of the edge, which itself has no width here.
            area.set(hatch=hatch(k), edgecolor="white" if hatch(k) else "none", linewidth=0.0)
        room = 1.0 + 0.15 * math.ceil(len(parts) / COLUMNS)  # for the legend
        axes.set_ylim(0.0, room * float(np.max(np.sum(parts, axis=0))))
    else:
        for k, drawn in enumerate(panel.curves):
            style = {**curve(k), "linestyle": "--"} if drawn.dashed else curve(k)
            values = np.asarray(drawn.values)
            along, values = (over, values[inside]) if drawn.along is None else (drawn.along, values)
            axes.plot(along, values, label=drawn.label or None, **style)
    for level in panel.levels:
        _level(axes, level)
    if panel.path:
        axes.set_aspect("equal", "datalim")
    legend = bool(axes.get_legend_handles_labels()[0])
    across = panel.path or f"time [{window.unit}]"
    if not panel.path:
        axes.locator_params(axis="x", nbins=6)
    label(axes, panel.title, across, panel.axis, legend, columns=COLUMNS if panel.stacked else 1)


def _level(axes: Axes, level: Level) -> None:
    """Draw a horizontal line, its name on it at the right end."""
    colour, dashes = (RED, "-") if level.limit else (GREY, "--") if level.label else ("black", "-")
    axes.axhline(level.value, color=colour, linestyle=dashes, linewidth=0.8)
    if level.label:
        # Outside of what is drawn: below a level that is the lowest, which has a value below zero.
        place, below = (1.0, level.value), level.value < 0.0
        axes.annotate(
            level.label, place, (0, -2 if below else 2), axes.get_yaxis_transform(), "offset points",
            color=RED if level.limit else INK, ha="right", va="top" if below else "bottom", fontsize=8,
        )  # fmt: skip
        # A level may be the highest or lowest of all that is drawn, with its name beyond it.
        axes.margins(y=0.12)


def _pulse(axes: Axes, run: Run, factor: float) -> None:
    """Draw contact forces over time from the run's peak, as wide as the impact that holds it.

    ``factor``: how many of the unit in which they are drawn a newton has.
    """
    history, at = _history(run), float(run.peak_time)
    # The contact of the peak tells how wide the impact is; others may be closed for longer.
    pulse = pulse_around(
        np.asarray(history.time), np.asarray(history.contact_force)[:, max(int(run.peak_contact), 0)], at
    )
    room = 0.25 * (pulse.end - pulse.start)
    first, last = max(pulse.start - room, float(history.time[0])), min(pulse.end + room, float(history.time[-1]))
    # With the peak itself, which evenly spaced instants would miss.
    time = np.union1d(np.linspace(first, last, DENSE), [at])
    force = np.asarray(at_times(run, time).contact_force)
    unit, many = unit_by_size(last - first, TIME_UNITS[1:], 0.1)
    for k in np.flatnonzero(np.any(force > 0.0, axis=0)):
        axes.plot(many * (time - at), factor * force[:, k], **curve(int(k)))
    axes.set_xlabel(f"time from the peak [{unit}]")


def first_contact(run: Run) -> float:
    """Return from when time axes go [s]: a little before the first contact, or from the start if that is not much
    earlier."""
    times = touching(run)
    if not times.size:
        return 0.0
    first, last = times[0], last_contact(run)
    start = first - (BEYOND - 1.0) * (times[-1] - first)
    return start if start > (1.0 - WORTH) * last else 0.0


def _history(run: Run) -> Any:
    if run.history is None:
        raise InputError("this run has no history to plot; simulate it with history=True")
    return jax.tree.map(np.asarray, run.history)
