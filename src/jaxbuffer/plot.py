"""Figures of captures and tunings."""

import math
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from .capture import Capture
from .errors import InputError
from .plot_style import (
    BLUE,
    FLANK_COLOURS,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    RED,
    SKY,
)
from .plot_style import label as _label
from .plot_style import line as _line
from .plot_style import panels as _figure
from .plot_style import png as png
from .plot_style import require_matplotlib as require_matplotlib
from .plot_style import styled as _styled
from .report import FLANKS, scenario_label
from .tuning.problem import QUANTITIES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .tuning import Tuned


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
    if capture.design.buffer.stop_stiffness is not None:
        ledger["end stop, stored and lost"] = (seen.energy.stop + seen.energy.stop_damper, RED)
    values, colours = zip(*ledger.values(), strict=True)
    energy.stackplot(time, *(1e3 * value for value in values), colors=colours, labels=ledger)
    energy.set_ylim(0.0, 1.45e3 * float(np.max(seen.energy.total)))  # room for the legend
    _label(energy, "Energy, adding up to the total", "time [s]", "energy [mJ]", columns=2)

    stroke.plot(time, 1e3 * seen.stroke, color=BLUE, label="stroke")
    largest = 1e3 * float(capture.stroke)
    stroke.axhline(largest, color=GREY, linestyle="--", linewidth=0.8, label="largest")
    end = 1e3 * float(capture.design.buffer.end)
    what = "the buffer's end" if capture.design.buffer.stop_stiffness is None else "the end stop"
    if largest > 0.5 * end:
        stroke.axhline(end, color=RED, linewidth=0.8, label=f"{what}, {end:.4g} mm")
    _label(stroke, f"Buffer stroke, largest {largest:.4g} mm", "time [s]", "stroke [mm]")

    angle.plot(time, np.degrees(seen.hinge_angle), color=BLUE)
    largest = math.degrees(float(capture.hinge_angle))
    _label(angle, f"Hinge angle, largest {largest:.3g}°", "time [s]", "hinge angle [deg]", False)
    return figure


@_styled
def tune_figure(tuned: "Tuned") -> "Figure":
    """Peak force in every scenario before and after, objective, variables in their bounds, worst values."""
    figure, ((cases, objective), (variables, trade)) = _figure(10.0, 7.0, 2, 2)
    problem, floor = tuned.problem, tuned.floor.simulated
    number = np.arange(1, len(problem.cases) + 1)
    for point, colour, label in ((tuned.before, ORANGE, "before"), (tuned.after, BLUE, "after")):
        peaks, captured = point.quantities[:, 0], point.captured
        cases.plot(number[captured], peaks[captured], "o", color=colour, markersize=4, label=label)
        if not np.all(captured):
            cases.plot(number[~captured], peaks[~captured], "x", color=colour, label=f"{label}, not captured")
    cases.plot(number, floor, "_", color=GREY, markersize=12, label="floor: first impact, no buffer")
    _integer_axis(cases)
    _label(cases, "Peak contact force", "scenario [-]", "peak force [N]")
    _convergence(objective, tuned)
    _variables(variables, tuned)
    _limits(trade, tuned)
    before, after = tuned.objective
    figure.suptitle(f"{problem.objective}: {before:.5g} N before, {after:.5g} N after")
    return figure


def _convergence(axes: "Axes", tuned: "Tuned") -> None:
    """Objective of every evaluated design; a line through each search's accepted ones."""
    records = tuned.records
    searches = sorted({(it["stage"], it["search"]) for it in records if it["status"] != "start"})
    starts = [it for it in records if it["status"] == "start"]
    axes.plot([it["evaluation"] for it in starts], [it["objective"] for it in starts], ".", color=GREY, label="starts")
    for k, key in enumerate(searches):
        mine = [it for it in records if (it["stage"], it["search"]) == key and it["status"] != "start"]
        taken = [it for it in mine if it["accepted"]]
        name = f"search {key[1] + 1}" if key[0] == 0 else "then"
        axes.plot([it["evaluation"] for it in taken], [it["objective"] for it in taken], label=name, **_line(k))
    lost = [it for it in records if not it["feasible"]]
    if lost:
        axes.plot(
            [it["evaluation"] for it in lost], [it["objective"] for it in lost], "x", color=RED, label="infeasible"
        )
    _label(axes, "Objective of every design tried", "evaluation [-]", "objective [N]")


def _variables(axes: "Axes", tuned: "Tuned") -> None:
    """Where accepted designs of all searches stand between the bounds."""
    taken = [it for it in tuned.records if it["accepted"] and it["status"] != "start"] or list(tuned.records)
    for k, variable in enumerate(tuned.problem.variables):
        place = [variable.place(it["values"][variable.path]) for it in taken]
        axes.plot([it["evaluation"] for it in taken], place, label=variable.path, marker=".", **_line(k))
        axes.plot(
            taken[-1]["evaluation"] + 1, variable.place(_value(tuned, variable.path)), "D", color=_line(k)["color"]
        )
    axes.set_ylim(-0.03, 1.5)  # room for the legend
    axes.set_yticks([0.0, 0.5, 1.0], ["low", "middle", "high"])
    _label(axes, "Accepted designs, and the result (◆)", "evaluation [-]", "place between bounds [-]", columns=2)


def _value(tuned: "Tuned", path: str) -> float:
    value: Any = tuned.design
    for name in path.split("."):
        value = getattr(value, name)
    return float(value)


def _limits(axes: "Axes", tuned: "Tuned") -> None:
    """The largest stroke, hinge angle, end time and hinge force over the scenarios, relative to before."""
    before, after = (np.max(point.quantities, axis=0) for point in (tuned.before, tuned.after))
    names = list(QUANTITIES)
    share = 100.0 * (np.divide(after, before, out=np.ones_like(after), where=before != 0.0) - 1.0)
    axes.barh(range(len(names)), share, color=[BLUE if x <= 0.0 else ORANGE for x in share])
    axes.axvline(0.0, color="black", linewidth=0.6)
    axes.set_yticks(
        range(len(names)),
        [f"{n}: {b:.3g} → {a:.3g} {QUANTITIES[n]}" for n, b, a in zip(names, before, after, strict=True)],
    )
    axes.invert_yaxis()
    _label(axes, "Worst over the scenarios, before → after", "change [%]", "quantity [-]", False)


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


def _integer_axis(axes: "Axes") -> None:
    from matplotlib.ticker import MaxNLocator

    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
