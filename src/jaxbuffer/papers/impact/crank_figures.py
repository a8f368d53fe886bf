"""A figure a study of the slider-crank: the drive's torque, the force by components, the pin's path, the rod."""

from typing import Any

import numpy as np

from ..._types import Figure
from ...mechanisms.slider_crank import journal_path
from ...output.style import COLOURS, drawing, label, panels
from ..study import Studied
from .crank_rows import STARTED, components, end_off, torque_of

START = 4.0  # times what the torque takes to a tenth: the view of the start
DETAIL = 0.1  # s: the first impacts
TIME = "time [s]"


def figure(studied: Studied) -> Figure:
    """Draw the study's figure."""
    bends = any(run.design.rod.modes for run in studied.captures)
    with drawing():
        drawn, grid = panels(10.0, 15.0, 5, 2) if bends else panels(10.0, 9.0, 3, 2)
        for number, (case, run) in enumerate(zip(studied.study.cases, studied.captures, strict=True)):
            _one(grid, case.label, COLOURS[number], run, bends)
        longest = max(float(row["start_takes"]) for row in studied.rows)
        grid[0, 0].set_xlim(0.0, 1e3 * START * longest)
        for axes, title, x, y in (
            (grid[0, 0], "Torque of the drive at the start, share of M₀", "time [ms]", "torque [-]"),
            (grid[0, 1], f"Torque of the drive after {1e3 * STARTED:g} ms", TIME, "torque [N m]"),
            (grid[1, 0], "Contact force across (y)", TIME, "force [N]"),
            (grid[1, 1], "Contact force along (z)", TIME, "force [N]"),
            (grid[2, 0], f"Path of the pin in its bush, first {1e3 * DETAIL:g} ms", "along [mm]", "across [mm]"),
            (grid[2, 1], "Deflection of the rod's middle", TIME, "deflection [µm]")
            if bends
            else (grid[2, 1], "Speed of the crank", TIME, "speed [rad/s]"),
        ):
            label(axes, title, x, y, legend=axes is grid[0, 0])
        if bends:
            # What the paper shows of the end of a rod that bends, and of its crank.
            label(grid[3, 0], "Speed of the crank (fig. 36)", TIME, "speed [rad/s]", legend=False)
            across = "across the rod [µm]"
            label(grid[3, 1], "Rod's end off the line of its mean rotation (fig. 37)", TIME, across, legend=False)
            label(grid[4, 0], "Rod's end across the slider's line (fig. 38)", TIME, "displacement [mm]", legend=False)
            label(grid[4, 1], "Its speed (fig. 38)", TIME, "speed [m/s]", legend=False)
        if "k = " in studied.study.cases[0].label:
            grid[0, 0].legend(title="k in N/mm^e, M₀ in N mm", title_fontsize=8)
        clearance = 1e3 * float(studied.captures[0].design.piston_pin.clearance)
        corners = clearance * np.array([-1.0, 1.0])
        grid[2, 0].plot(corners[[0, 1, 1, 0, 0]], corners[[0, 0, 1, 1, 0]], "k:", linewidth=0.8)
        grid[2, 0].set_aspect("equal")
        drawn.suptitle(f"{studied.study.title} (the paper's fig. {studied.study.figures})")
        return drawn


def _one(grid: Any, name: str, colour: str, run: Any, bends: bool) -> None:
    history, drawn = run.history, {"color": colour, "label": name, "linewidth": 0.8}
    time, torque = np.asarray(history.time), torque_of(run)
    along, across = components(run)
    path = 1e3 * np.asarray(journal_path(run))
    later, early = time >= STARTED, time <= DETAIL
    # Torques at rest differ by a factor of ten between the sets, and so are compared as shares of M₀.
    grid[0, 0].plot(1e3 * time, torque / torque[0], **drawn)
    grid[0, 1].plot(time[later], torque[later], **drawn)
    grid[1, 0].plot(time, across, **drawn)
    grid[1, 1].plot(time, along, **drawn)
    grid[2, 0].plot(*path[early].T, **drawn)
    (grid[3, 0] if bends else grid[2, 1]).plot(time, np.asarray(history.velocity)[:, 0, 2], **drawn)
    if not bends:
        return
    if run.design.rod.modes:
        grid[2, 1].plot(time, 1e6 * np.asarray(history.rod_deflection), **drawn)
        grid[3, 1].plot(time, 1e6 * end_off(run), **drawn)
    grid[4, 0].plot(time, -path[:, 1], **drawn)  # the path is of the slider, seen from the rod's end
    grid[4, 1].plot(time, np.asarray(history.approach_speed)[:, 2], **drawn)  # towards the side above
