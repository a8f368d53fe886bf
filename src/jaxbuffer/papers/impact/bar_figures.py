"""A figure a study of the dropped bar: force, displacement and speed of the bar's end, and detailed views."""

from typing import Any

import numpy as np

from ..._types import Figure
from ...output.style import COLOURS, drawing, label, line, panels
from ..study import Studied
from .bar_rows import STEPS, WINDOW, sampled_at

EARLY = 60e-6  # s from the first contact: the first peaks of damped contacts
FORCE, SINCE = "contact force [N]", "time from the first contact [ms]"
OFFSETS = "share of the offsets of the grid of times [-]"


def figure(studied: Studied) -> Figure:
    """Draw the study's figure."""
    with drawing():
        drawn, grid = panels(10.0, 12.0, 4, 2)
        for number, (case, run) in enumerate(zip(studied.study.cases, studied.captures, strict=True)):
            _whole(grid, _named(case.label), line(number), run)
        bends = bool(studied.captures[0].design.plate.modes)
        for axes, title, x, y in (
            (grid[0, 0], "Height of the bar's end above the plate", "time [s]", "height [mm]"),
            (grid[0, 1], "Speed of the bar's end, downwards", "time [s]", "speed [m/s]"),
            (grid[1, 0], "Contact force, first milliseconds", SINCE, FORCE),
            (grid[1, 1], f"Contact force, first {1e6 * EARLY:g} µs", "time from the first contact [µs]", FORCE),
            (grid[2, 0], "Deflection of the plate", SINCE, "deflection [µm]")
            if bends
            else (grid[2, 0], "Penetration", SINCE, "penetration [µm]"),
            (grid[3, 0], "Contact force, to the end", "time [s]", FORCE),
            (grid[3, 1], "Deflection of the plate, to the end", "time [s]", "deflection [µm]")
            if bends
            else (grid[3, 1], "Penetration, to the end", "time [s]", "penetration [µm]"),
        ):
            label(axes, title, x, y, legend=axes is grid[0, 0])
        if any(float(run.design.impact.friction) for run in studied.captures):
            label(grid[2, 1], "Friction force, first milliseconds", SINCE, "friction force [N]", legend=False)
        else:
            _steps(grid[2, 1], studied)
        drawn.suptitle(f"{studied.study.title} (the paper's fig. {studied.study.figures})")
        return drawn


def _named(case: str) -> str:
    """Name a case with the unit of its damping."""
    return f"{case} N s/mm" if case.startswith("c = ") else case


def _whole(grid: Any, name: str, curve: dict[str, Any], run: Any) -> None:
    history = run.history
    time, first = np.asarray(history.time), float(run.impacts.time[0])
    force, drawn = np.asarray(history.contact_force)[:, 0], {**curve, "label": name}
    grid[0, 0].plot(time, 1e3 * np.asarray(history.gap)[:, 0], **drawn)
    grid[0, 1].plot(time, np.asarray(history.approach_speed)[:, 0], **drawn)
    near = (time > first - 0.05 * WINDOW) & (time < first + WINDOW)
    grid[1, 0].plot(1e3 * (time - first)[near], force[near], **drawn)
    close = (time > first - 0.05 * EARLY) & (time < first + EARLY)
    grid[1, 1].plot(1e6 * (time - first)[close], force[close], **drawn)
    below = history.plate_deflection if run.design.plate.modes else np.maximum(np.asarray(history.penetration), 0.0)
    grid[2, 0].plot(1e3 * (time - first)[near], 1e6 * np.asarray(below)[near], **drawn)
    grid[3, 0].plot(time, force, **drawn)
    grid[3, 1].plot(time, 1e6 * np.asarray(below), **drawn)
    if float(run.design.impact.friction):
        friction = np.asarray(history.friction_force)[:, 0]
        grid[2, 1].plot(1e3 * (time - first)[near], friction[near], **drawn)


def _steps(axes: Any, studied: Studied) -> None:
    """Draw the largest force that fixed steps see, over the share of the grid's offsets that see less."""
    for number, (case, run) in enumerate(zip(studied.study.cases, studied.captures, strict=True)):
        time, force = np.asarray(run.history.time), np.asarray(run.history.contact_force)[:, 0]
        for step, dashes in zip(STEPS, (":", "-"), strict=True):
            sampled = np.sort(sampled_at(step, time, force))
            name = f"{_named(case.label)}, steps of {1e3 * step:g} ms"
            axes.plot(np.linspace(0.0, 1.0, len(sampled)), sampled, dashes, color=COLOURS[number], label=name)
    label(axes, "What fixed steps see of the largest force", OFFSETS, FORCE)
