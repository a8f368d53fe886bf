"""A figure a study: fields of displacement, the test point over time, forces."""

from typing import Any

import numpy as np

from ..._types import Axes, Figure
from ...mechanisms.tank_drop.meshes import ACROSS, ALONG, displaced
from ...mechanisms.tank_drop.run import rows_of
from ...output.field_files import coloured, frame
from ...output.style import drawing, label, line, panels
from ..study import Studied


def figure(studied: Studied) -> Figure:
    """Draw the study's figure."""
    with drawing():
        draw = _fields if studied.study.name == "drop" else _curves
        drawn = draw(studied)
        number = studied.study.figures
        drawn.suptitle(studied.study.title + (f" (the paper's fig. {number})" if number != "-" else ""))
        return drawn


def _fields(studied: Studied) -> Figure:
    """Draw, a row for each case, the tank before, displacements across and along the impact at the largest force, and
    the test point over time."""
    drawn, grid = panels(16.0, 3.6 * len(studied.captures), len(studied.captures), 4)
    for axes, case, run in zip(grid, studied.study.cases, studied.captures, strict=True):
        before, after = displaced(run)
        # Where nothing has moved, as sideways may be, a colour scale still needs a width.
        most = {name: max(float(np.nanmax(np.abs(after.values[name]))), 1e-9) for name in (ACROSS, ALONG)}
        for place, mesh, name in ((0, before, ALONG), (1, after, ACROSS), (2, after, ALONG)):
            cells = coloured(axes[place], mesh, name, (-most[name], most[name]))
            cells.set_cmap("coolwarm")
            frame(axes[place], np.concatenate([before.nodes, after.nodes]))
            axes[place].set_title(f"{case.label}, {mesh.title}")
            if place:
                drawn.colorbar(cells, ax=axes[place], label=name, orientation="horizontal", shrink=0.7, aspect=40)
        _test_point(axes[3], run)
    return drawn


def _test_point(axes: Axes, run: Any) -> None:
    # Behind these rows a history repeats the last of them.
    rows = slice(rows_of(run))
    time, others = 1e3 * np.asarray(run.history.time)[rows], run.history.others
    side = np.asarray(others["wall_x"])[rows]
    widest = int(np.argmax(np.max(np.abs(side - side[:1]), axis=0)))
    travel = np.asarray(run.history.position)[rows, 0, 1]
    curves = {
        # The top has sagged under weight and liquid before the slider arrives.
        "middle of the top, downwards": np.asarray(others["deflection"])[rows] - float(others["deflection"][0]),
        "side, outwards": side[:, widest] - side[0, widest],
        "slider, downwards": travel[0] - travel,
    }
    for number, (name, values) in enumerate(curves.items()):
        axes.plot(time, 1e3 * values, **line(number), label=name)
    label(axes, "Test points", "time [ms]", "displacement [mm]")


def _curves(studied: Studied) -> Figure:
    """Draw force, deflection, speed and penetration over time, a curve for each case."""
    drawn, grid = panels(10.0, 7.0, 2, 2)
    for number, (case, run) in enumerate(zip(studied.study.cases, studied.captures, strict=True)):
        rows, curve = slice(rows_of(run)), {**line(number), "label": case.label}
        time, others = 1e3 * np.asarray(run.history.time)[rows], run.history.others
        grid[0, 0].plot(time, 1e-3 * np.asarray(run.history.contact_force)[rows, 0], **curve)
        grid[0, 1].plot(time, 1e3 * np.asarray(others["deflection"])[rows], **curve)
        grid[1, 0].plot(time, np.asarray(run.history.velocity)[rows, 0, 1], **curve)
        grid[1, 1].plot(time, 1e3 * np.maximum(-np.asarray(run.history.gap)[rows, 0], 0.0), **curve)
    bare = studied.study.name == "contact"
    for axes, title, y in (
        (grid[0, 0], "Force on the slider", "force [kN]"),
        (grid[0, 1], "Middle of the top, downwards", "deflection [mm]"),
        (grid[1, 0], "Speed of the slider, upwards", "speed [m/s]"),
        (grid[1, 1], "Wall inside the slider" if bare else "Cushion pressed together", "penetration [mm]"),
    ):
        label(axes, title, "time [ms]", y)
    return drawn
