"""A run moving, and forces over time, as records: what a page needs to draw them and to tell their values."""

from collections.abc import Mapping, Sequence
from typing import Any

import equinox as eqx
import numpy as np

from ..labelled.record import heading
from ..mechanisms.drawing import Band, RodShape, Spot, Spring
from ..mechanisms.run import Run
from ..run.instants import at_times
from .animation import frames_of, speed_in_words
from .motion import contact_names, scene
from .pulses import TIMES, force_over_time, largest_times, last_contact
from .sketch import INK, fills, is_filled, outline

FORCE = heading("force", "N")  # what curves of contact forces are drawn against
DIGITS = 7  # of lengths [m], angles [rad] and times [s] after the point: a tenth of a micrometre or a microsecond
SIGNIFICANT = 6  # digits of a force or a stroke


def force_record(runs: Mapping[str, Run], scenario: str) -> dict[str, Any]:
    """Return the forces of some runs by name: "before" and "after" say. ``scenario``: theirs, in words.

    Of one run alone also ``more``: what its mechanism draws to the end of it, long after the last contact.
    """
    # Without a contact there is no force to draw.
    touching = {name: run for name, run in runs.items() if contact_names(run)}
    curves = []
    for name, run in touching.items():
        time, force = force_over_time(run)
        # Times that lie between two others without any force are left out.
        idle = np.concatenate([[False], (force[:-2] == 0.0) & (force[1:-1] == 0.0) & (force[2:] == 0.0), [False]])
        shown = np.round(time[~idle], DIGITS).tolist()
        curves.append({"name": name, "time": shown, "values": _significant(force[~idle])})
    more = [chart for name, run in runs.items() for chart in _to_end(name, run)] if len(runs) == 1 else []
    return {"scenario": scenario, "curves": curves, "more": more}


def chart(caption: str, axis: str, curves: Sequence[Any]) -> dict[str, Any]:
    """Return curves over the time in seconds, to be drawn against an ``axis`` with its unit, "stroke [mm]"."""
    return {"caption": caption, "axis": axis, "unit": axis.rpartition(" [")[2].removesuffix("]"), "curves": curves}


def _to_end(name: str, run: Run) -> list[dict[str, Any]]:
    """Return a chart for each curve of the mechanism's own over the whole run."""
    panels = run.mechanism.view.panels
    if not any(panel.to_end for panel in panels(run)):
        return []
    end = float(np.asarray(run.history.time)[-1])  # type: ignore[union-attr]
    # Even times over the whole run, and as many again up to the last contact, where all impacts are.
    spread = np.linspace(0.0, end, TIMES), np.linspace(0.0, last_contact(run), TIMES)
    time = np.unique(np.concatenate([*spread, largest_times(run)]))
    whole = eqx.tree_at(lambda it: it.history, run, at_times(run, time))
    return [
        chart(
            f"{panel.title}, to the end of the run",
            panel.axis,
            [{"name": name, "time": _rounded(time), "values": _significant(panel.curves[0].values)}],
        )
        for panel in panels(whole)
        if panel.to_end and not panel.stacked
    ]


def _significant(values: Any) -> list[float]:
    return [float(f"{value:.{SIGNIFICANT}g}") for value in np.asarray(values)]


def motion_record(run: Run) -> dict[str, Any]:
    """Return times in slow motion around impacts, the frames and forces then, and the shapes that go with the frames.

    **Arguments:** ``run``: one simulated with ``history=True``.
    """
    paced = frames_of(run)
    at = scene(run, paced.times)
    corners = at.views
    return {
        "times": _rounded(paced.times),
        "paces": [speed_in_words(float(slower)) for slower in paced.slower],
        "frames": _rounded(at.frames),
        "forces": _rounded(at.arrows[:, 0]),
        # Of a force in space a picture shows two components, and tells its size all the same.
        "acting": _rounded(np.hypot(at.instants.contact_force, at.instants.friction_force)),
        # The page's script divides by it, also where nothing touches.
        "largest": max(at.peak, 1e-12),
        "contacts": contact_names(run),
        "bounds": _rounded([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)]),
        "shapes": _shapes(at.drawing.shapes, at.frames.shape[1]),
        "detail": None
        if (detail := at.drawing.detail) is None
        else {
            **_spot(detail.centre),
            "half": detail.half,
            "title": detail.title,
            "path": detail.path,
            # From another side a force has other components.
            "forces": None if at.drawing.arrows is None else _rounded(at.arrows[:, 1]),
            "shapes": _shapes(detail.shapes, at.frames.shape[1]),  # what is drawn there instead, if anything
        },
    }


def _shapes(shapes: Sequence[Any], bodies: int) -> list[dict[str, Any]]:
    """Return the shapes: corners in the axes of the one frame that a shape goes with, or the two spots between which it
    lies."""
    made: list[dict[str, Any]] = []
    colour, rest, order = 0, np.zeros((bodies, 3)), [*fills(shapes)]
    strokes = {part: it for part, it in fills(shapes).items() if isinstance(it, str)}
    stroke = INK
    for shape in shapes:
        filled = is_filled(shape)
        colour = order.index(shape.part) if filled and shape.part in order else colour
        stroke = INK if filled else strokes.get(shape.part, INK if shape.part else stroke)
        dashed = getattr(shape, "dashed", False)
        look = {"filled": filled, "part": shape.part, "colour": colour, "dashed": dashed, "stroke": stroke}
        if isinstance(shape, Band):
            made.append({**look, "stations": [*shape.stations], "width": shape.width})
        elif isinstance(shape, (Spring, RodShape)):
            ends = {name: _spot(spot) for name, spot in (("first", shape.first), ("second", shape.second))}
            made.append({**look, **ends, "width": shape.width, "spring": isinstance(shape, Spring)})
        else:
            # Corners are given for frames at zero, in the axes of the body, with which the page moves them.
            body = shape.body if hasattr(shape, "body") else shape.centre.body
            made.append({**look, "body": body, "corners": _rounded(outline(shape, rest))})
    return made


def _spot(spot: Spot) -> dict[str, Any]:
    return {"body": int(spot.body), "x": float(spot.x), "y": float(spot.y)}


def _rounded(values: Any) -> Any:
    return np.round(np.asarray(values, float), DIGITS).tolist()
