"""A figure a study: the quantities the paper plotted, over the same axes as far as its text tells."""

import math
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from ...mechanisms.history import History
from ...output.style import png
from ..study import Studied

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STYLE: dict[Any, Any] = {
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": 9,
}
FORCE, TIME = "contact force [N]", "time [s]"
FIRST = 3.0  # of the longest first contact, on the time axis of impact forces


def figure(studied: Studied) -> bytes:
    """The study's figure as PNG."""
    with matplotlib.rc_context(STYLE):
        drawn = Figure(figsize=(9.0, 6.5), layout="constrained")
        axes = drawn.subplots(2, 2).ravel()
        _DRAW.get(studied.study.name, _captured)(studied, axes)
        drawn.suptitle(f"{studied.study.title} (the paper's fig. {studied.study.figures})")
        return png(drawn)


def _series(studied: Studied) -> list[tuple[str, History, Any]]:
    colours = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.85, len(studied.captures)))
    made = zip(studied.study.cases, studied.captures, colours, strict=True)
    return [(case.label, capture.history, colour) for case, capture, colour in made if capture.history is not None]


def _label(axis: "Axes", x: str, y: str, legend: bool = False) -> None:
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    if legend:
        axis.legend(frameon=False)


def _force(history: History) -> np.ndarray:
    return np.max(np.asarray(history.contact_force), axis=1)


def _captured(studied: Studied, axes: Any) -> None:
    """Distance sensor, forces of the first impact and of all, and the times over the varied number."""
    longest = max(float(row["first_contact"]) for row in studied.rows)
    for label, history, colour in _series(studied):
        time, force = np.asarray(history.time), _force(history)
        axes[0].plot(time, 1e3 * np.asarray(history.throat_distance), color=colour, label=label)
        early = time < FIRST * longest
        axes[1].plot(1e3 * time[early], force[early], color=colour, label=label)
        axes[2].plot(time, force, color=colour, linewidth=0.8)
    _label(axes[0], TIME, "distance sensor [mm]", legend=True)
    _label(axes[1], "time [ms]", f"{FORCE}, first impact")
    _label(axes[2], TIME, FORCE)
    numbers = [row for row in studied.rows if row["outcome"] == "captured"]
    for name, mark in (("capture_time", "o-"), ("contact_time", "s--")):
        at = [float(row["value"]) for row in numbers]
        axes[3].plot(at, [float(row[name]) for row in numbers], mark, label=name.replace("_", " "))
    _label(axes[3], studied.study.varied, "time [s]", legend=True)


def _rigid(studied: Studied, axes: Any) -> None:
    """First impacts together and apart, whole captures, distance."""
    for label, history, colour in _series(studied):
        time, force = np.asarray(history.time), _force(history)
        early = time < 3e-3
        axes[0].plot(1e3 * time[early], force[early], color=colour, label=label)
        axes[1].semilogy(time, np.maximum(force, 1e-1), color=colour, label=label, linewidth=0.8)
        axes[2].plot(time, 1e3 * np.asarray(history.throat_distance), color=colour, label=label)
        axes[3].plot(time, 1e3 * np.asarray(history.stroke), color=colour, label=label)
    _label(axes[0], "time [ms]", f"{FORCE}, first impact", legend=True)
    _label(axes[1], TIME, FORCE)
    _label(axes[2], TIME, "distance sensor [mm]")
    _label(axes[3], TIME, "stroke [mm]")


def _motion(studied: Studied, axes: Any) -> None:
    """Velocities of both vehicles, and both buffers."""
    ((_, history, _),) = _series(studied)
    time, velocity = np.asarray(history.time), np.asarray(history.velocity)
    for body, name in ((0, "active"), (3, "passive")):
        axes[0].plot(time, velocity[:, body, 0], label=f"{name}, x")
        axes[0].plot(time, velocity[:, body, 1], "--", label=f"{name}, y")
        axes[1].plot(time, np.degrees(velocity[:, body, 2]), label=name)
    _label(axes[0], TIME, "velocity [m/s]", legend=True)
    _label(axes[1], TIME, "angular velocity [°/s]", legend=True)
    axes[2].plot(time, 1e3 * np.asarray(history.stroke))
    _label(axes[2], TIME, "stroke of the axial buffer [mm]")
    axes[3].plot(time, np.asarray(history.hinge_angle) * 180.0 / math.pi)
    _label(axes[3], TIME, "angle of the torsional buffer [°]")


_DRAW = {"rigid": _rigid, "motion": _motion}
