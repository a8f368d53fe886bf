"""Figures of captures and tunings; needs matplotlib, ``pip install jaxbuffer[plots]``."""

import math
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from .capture import Capture
from .errors import InputError
from .plot_style import (
    BLUE,
    COLOURS,
    COLUMNS,
    FLANK_COLOURS,
    GREEN,
    GREY,
    ITERATION,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    STYLES,
)
from .plot_style import label as _label
from .plot_style import panels as _figure
from .plot_style import png as png
from .plot_style import require_matplotlib as require_matplotlib
from .plot_style import styled as _styled
from .report import FLANKS, scenario_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .tune import Tuned


@_styled
def capture_figure(capture: Capture) -> "Figure":
    """Contact force with its peak enlarged, gap, energies, stroke and hinge angle over time.

    **Arguments:** ``capture``: one simulated with ``history=True``.
    """
    seen = _history(capture)
    figure, grid = _figure(9.0, 9.0, 3, 2)
    (force, zoom), (gap, energy), (stroke, angle) = grid
    time = np.asarray(seen.time)
    peak, at = float(capture.peak_force), float(capture.peak_time)
    figure.suptitle(
        f"{capture.outcome.name} after {float(capture.end_time):.4g} s, {int(capture.impact_count)} impacts, "
        f"approach at {scenario_label(capture.scenario)}"
    )
    for k, flank in enumerate(FLANKS):
        force.plot(time, seen.contact_force[:, k], color=FLANK_COLOURS[k], label=f"{flank} flank")
    force.plot(at, peak, "o", color=RED, markersize=4, label="peak")
    _label(force, "Contact force", "time [s]", "contact force [N]")

    for k in range(len(FLANKS)):
        _pulse(zoom, capture, k, FLANK_COLOURS[k], marker=".")
    zoom.plot(0.0, peak, "o", color=RED, markersize=4)
    _label(zoom, f"The peak, {peak:.4g} N at {at:.6g} s", "time from the peak [ms]", "contact force [N]", False)

    for k, flank in enumerate(FLANKS):
        gap.plot(time, 1e3 * seen.gap[:, k], color=FLANK_COLOURS[k], label=f"gap, {flank} flank")
    gap.plot(time, 1e3 * seen.throat_distance, color=GREEN, linestyle="--", label="to the capture plane")
    gap.axhline(0.0, color="black", linewidth=0.6)
    _label(gap, "Gap and distance to capture", "time [s]", "distance [mm]")

    ledger = {
        "kinetic": (seen.energy.kinetic, BLUE),
        "springs": (seen.energy.spring, GREEN),
        "lost in dampers": (seen.energy.axial_damper + seen.energy.torsional_damper, PURPLE),
        "lost in friction": (seen.energy.friction, ORANGE),
        "contact, stored and lost": (seen.energy.contact + seen.energy.hysteresis, SKY),
    }
    values, colours = zip(*ledger.values(), strict=True)
    energy.stackplot(time, *(1e3 * value for value in values), colors=colours, labels=ledger)
    energy.set_ylim(0.0, 1.45e3 * float(np.max(seen.energy.total)))  # room for the legend
    _label(energy, "Energy, adding up to the total", "time [s]", "energy [mJ]", columns=2)

    stroke.plot(time, 1e3 * seen.stroke, color=BLUE)
    stroke.axhline(1e3 * float(capture.stroke), color=GREY, linestyle="--", linewidth=0.8)
    _label(stroke, f"Buffer stroke, largest {1e3 * float(capture.stroke):.4g} mm", "time [s]", "stroke [mm]", False)

    angle.plot(time, np.degrees(seen.hinge_angle), color=BLUE)
    largest = math.degrees(float(capture.hinge_angle))
    _label(angle, f"Hinge angle, largest {largest:.3g}°", "time [s]", "hinge angle [deg]", False)
    return figure


@_styled
def tune_figure(tuned: "Tuned") -> "Figure":
    """Contact force around the peak before and after in each scenario, convergence, and variables in their bounds."""
    scenarios = tuned.problem.scenarios
    rows = math.ceil(len(scenarios) / COLUMNS)
    figure, grid = _figure(11.0, 3.2 * (rows + 1), rows + 1, COLUMNS)
    panels = [axes for row in grid[:rows] for axes in row]
    for axes in panels[len(scenarios) :]:
        axes.remove()
    for axes, scenario, *captures in zip(panels, scenarios, tuned.before, tuned.after, strict=False):
        peaks = [float(capture.peak_force) for capture in captures]
        for capture, colour, label, peak in zip(captures, (ORANGE, BLUE), ("before", "after"), peaks, strict=True):
            _pulse(axes, capture, int(capture.peak_flank), colour, f"{label}, {peak:.4g} N")
        change = 100.0 * (peaks[1] / peaks[0] - 1.0)
        axes.set_ylim(top=1.35 * max(peaks))
        title = f"{scenario_label(scenario, scenarios)}: {change:+.1f} %"
        _label(axes, title, "time from the run's peak [ms]", "contact force [N]")
    peak, objective, variables = grid[rows]
    _convergence(peak, objective, tuned)
    _variables(variables, tuned)
    figure.suptitle("Tuning the buffer: the largest contact force before and after")
    return figure


def _convergence(peak: "Axes", objective: "Axes", tuned: "Tuned") -> None:
    iterations = tuned.iterations
    numbers = [it.number for it in iterations]
    scenarios = tuned.problem.scenarios
    for k, scenario in enumerate(scenarios):
        peak.plot(numbers, [it.peaks[k] for it in iterations], label=scenario_label(scenario, scenarios), **_line(k))
    _label(peak, "Peak contact force", ITERATION, "peak force [N]")
    objective.plot(numbers, [it.objective for it in iterations], color=BLUE)
    lost = [it for it in iterations if not it.captured]
    if lost:
        points = [it.number for it in lost], [it.objective for it in lost]
        objective.plot(*points, "x", color=RED, label="not captured")
    _label(objective, "Objective", ITERATION, "objective, relative to the start [-]", bool(lost))


def _line(number: int) -> dict[str, Any]:
    return {"color": COLOURS[number % len(COLOURS)], "linestyle": STYLES[number % len(STYLES)]}


def _variables(axes: "Axes", tuned: "Tuned") -> None:
    numbers = [it.number for it in tuned.iterations]
    for k, variable in enumerate(tuned.problem.variables):
        values = np.array([it.values[variable.path] for it in tuned.iterations])
        place = np.log(values / variable.low) / math.log(variable.high / variable.low)
        axes.plot(numbers, place, label=variable.path, **_line(k))
    axes.set_ylim(-0.03, 1.5)  # room for the legend
    axes.set_yticks([0.0, 0.5, 1.0], ["low", "middle", "high"])
    _label(axes, "Variables within their bounds", ITERATION, "place between bounds, log scale [-]", columns=2)


def _pulse(axes: "Axes", capture: Capture, flank: int, colour: str, label: str = "", marker: str = "") -> None:
    """Contact force over time from the run's peak [ms], as wide as the impact that holds it, markers at the steps."""
    seen, at = _history(capture), float(capture.peak_time)
    time, force = np.asarray(seen.time), np.asarray(seen.contact_force)
    start, end = _around(time, force[:, int(capture.peak_flank)], at)
    room = 0.25 * (end - start)
    inside = (time > start - room) & (time < end + room)
    if np.any(force[inside, flank] > 0.0):
        pulse = 1e3 * (time[inside] - at), force[inside, flank]
        axes.plot(*pulse, color=colour, label=label, marker=marker, markersize=3)


def _around(time: np.ndarray, force: np.ndarray, at: float) -> tuple[float, float]:
    """When the impact with the largest force, at a given time, begins and ends [s]: above two per cent of the peak."""
    near = int(np.argmin(np.abs(time - at)))
    low = force < 0.02 * force[near]
    before, after = np.flatnonzero(low[:near]), np.flatnonzero(low[near:])
    start = before[-1] + 1 if before.size else 0
    end = near + after[0] - 1 if after.size else len(time) - 1
    return float(time[start]), float(time[end])


def _history(capture: Capture) -> Any:
    if capture.history is None:
        raise InputError("this capture has no history to plot; simulate it with history=True")
    return jax.tree.map(np.asarray, capture.history)
