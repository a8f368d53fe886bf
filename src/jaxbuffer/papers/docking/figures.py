"""A figure a study: the quantities the paper plotted, over the same axes as far as its text tells."""

import math
from typing import Any

import numpy as np

from ..._types import Axes, Figure
from ...mechanisms.history import History
from ...output.style import drawing, line, panels
from ...run.instants import at_times
from ..study import Studied
from .published import SUFFIX

FORCE, TIME = "contact force [N]", "time [s]"
DENSE = 400  # instants of a first impact
FIRST = 1.3  # of the longest first contact, on the time axis of impact forces
BEYOND = 1.2  # of the latest capture's time; time axes of longer runs end there


def figure(studied: Studied) -> Figure:
    """Draw the study's figure."""
    with drawing():
        drawn, grid = panels(9.0, 6.5, 2, 2)
        axes = grid.ravel()
        # A study with the published equations has another name, and the figure of the same study without them.
        _DRAW.get(studied.study.name.removesuffix(SUFFIX), _captured)(studied, axes)
        drawn.suptitle(f"{studied.study.title} (the paper's fig. {studied.study.figures})")
        return drawn


def _series(studied: Studied) -> list[tuple[str, History, Any]]:
    made = zip(studied.study.cases, studied.captures, strict=True)
    return [
        (case.label, capture.history, line(k)) for k, (case, capture) in enumerate(made) if capture.history is not None
    ]


def _until(studied: Studied) -> float:
    """Return where time axes end [s]: at the longest run's end, or soon after the latest capture."""
    ends = [float(capture.end_time) for capture in studied.captures]
    captured = [end for end, row in zip(ends, studied.rows, strict=True) if row["outcome"] == "captured"]
    # A run that is not captured goes on until its time is up, which would press the others together.
    return min(BEYOND * max(captured, default=max(ends)), max(ends))


def _label(axis: Axes, x: str, y: str, legend: bool = False) -> None:
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    if legend:
        axis.legend(frameon=False)


def _force(history: History) -> np.ndarray:
    return np.max(np.asarray(history.contact_force), axis=1)


def _within(history: History, until: float) -> float:
    """Return the distance sensor's largest value up to a time [mm]."""
    return float(np.max(1e3 * np.asarray(history.throat_distance)[np.asarray(history.time) <= until]))


def _captured(studied: Studied, axes: Any) -> None:
    """Draw the distance sensor, the forces of the first impact and of all, and the times over the varied number."""
    longest = max(float(row["first_contact"]) for row in studied.rows)
    for (label, history, curve), capture in zip(_series(studied), studied.captures, strict=True):
        time, force = np.asarray(history.time), _force(history)
        thin = {**curve, "linewidth": 0.8}
        axes[0].plot(time, 1e3 * np.asarray(history.throat_distance), **curve, label=label)
        # Evenly and densely: a history has some ten steps an impact.
        early = np.linspace(0.0, FIRST * longest, DENSE)
        axes[1].plot(1e3 * early, _force(at_times(capture, early)), **curve, label=label)
        axes[2].plot(time, force, **thin)
    _label(axes[0], TIME, "distance sensor [mm]", legend=True)
    _label(axes[1], "time from the start [ms]", "contact force, first impact [N]")
    _label(axes[2], TIME, FORCE)
    until = _until(studied)
    for axis in (axes[0], axes[2]):
        axis.set_xlim(-0.02 * until, until)
    if until < max(float(capture.end_time) for capture in studied.captures):
        axes[0].set_title(f"time axes end soon after the latest capture, at {until:.2g} s", fontsize=8)
    axes[0].set_ylim(-2.0, 1.05 * max(_within(history, until) for _, history, _ in _series(studied)))
    numbers = [row for row in studied.rows if row["outcome"] == "captured"]
    named = "[" not in studied.study.varied  # "tip": its values are words
    places = [row["case"] if named else float(row["value"]) for row in numbers]
    for name, mark in (("capture_time", "o"), ("contact_time", "s")):
        dashes = {"linestyle": "none"} if named else {}
        axes[3].plot(places, [float(row[name]) for row in numbers], marker=mark, label=name.replace("_", " "), **dashes)
    if named:
        axes[3].set_xlim(-0.5, len(places) - 0.5)
        axes[3].set_ylim(bottom=0.0)
    _label(axes[3], f"{studied.study.varied} [-]" if named else studied.study.varied, "time [s]", legend=True)


def _rigid(studied: Studied, axes: Any) -> None:
    """Draw first impacts together and apart, whole captures and the distance."""
    for (label, history, curve), capture in zip(_series(studied), studied.captures, strict=True):
        time, force = np.asarray(history.time), _force(history)
        thin = {**curve, "linewidth": 0.8}
        early = np.linspace(0.0, 3e-3, DENSE)
        axes[0].plot(1e3 * early, _force(at_times(capture, early)), **curve, label=label)
        # A logarithmic axis has no place for the zeros between impacts.
        axes[1].semilogy(time, np.maximum(force, 1e-1), **thin, label=label)
        axes[2].plot(time, 1e3 * np.asarray(history.throat_distance), **curve, label=label)
        axes[3].plot(time, 1e3 * np.asarray(history.stroke), **curve, label=label)
    _label(axes[0], "time from the start [ms]", "contact force, first impact [N]", legend=True)
    _label(axes[1], TIME, FORCE)
    _label(axes[2], TIME, "distance sensor [mm]")
    _label(axes[3], TIME, "stroke [mm]")


def _motion(studied: Studied, axes: Any) -> None:
    """Draw the velocities of both vehicles, and both buffers."""
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
