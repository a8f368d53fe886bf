"""What to draw of a capture over time."""

from typing import TYPE_CHECKING

import numpy as np

from ..picture import Curve, Level, Panel

if TYPE_CHECKING:
    from .capture import Capture


def panels(capture: "Capture") -> list[Panel]:
    """Gap and distance to capture, energy, stroke and hinge angle, of a capture with a history."""
    seen = capture.history
    assert seen is not None
    more = [panel for panel in (_bending(capture), _play(capture)) if panel is not None]
    return [
        Panel(
            "Gap and distance to capture",
            "distance [mm]",
            (
                Curve("gap, lower flank", 1e3 * seen.gap[:, 0]),
                Curve("gap, upper flank", 1e3 * seen.gap[:, 1]),
                Curve("to the capture plane", 1e3 * seen.throat_distance, dashed=True),
            ),
            (Level("", 0.0),),
        ),
        _energy(capture),
        _stroke(capture),
        Panel(
            f"Hinge angle, largest {np.degrees(float(capture.hinge_angle)):.3g}°",
            "hinge angle [°]",
            (Curve("", np.degrees(seen.hinge_angle)),),
            (Level("", 0.0),),
        ),
        *more,
    ]


def _bending(capture: "Capture") -> Panel | None:
    if capture.design.probe.bending_stiffness is None:  # type: ignore[attr-defined]
        return None
    title = f"Bending of the probe, largest {1e3 * float(capture.bending):.3g} mm"
    return Panel(title, "tip off the axis [mm]", (Curve("", 1e3 * capture.history.bending),))  # type: ignore[union-attr]


def _play(capture: "Capture") -> Panel | None:
    if capture.design.hinge.play is None:  # type: ignore[attr-defined]
        return None
    gap = Curve("", 1e6 * capture.history.hinge_gap)  # type: ignore[union-attr]
    return Panel("Hinge, from the pin to its bush", "gap [µm]", (gap,), (Level("", 0.0),))


def _energy(capture: "Capture") -> Panel:
    energy = capture.history.energy  # type: ignore[union-attr]
    parts = {
        "kinetic": energy.kinetic,
        "springs": energy.spring,
        "lost in dampers": energy.axial_damper + energy.torsional_damper,
        "lost in friction": energy.friction,
        "contact, stored and lost": energy.contact + energy.hysteresis,
    }
    if capture.design.buffer.stop_stiffness is not None:  # type: ignore[attr-defined]
        parts["end stop, stored and lost"] = energy.stop + energy.stop_damper
    if capture.design.hinge.play is not None:  # type: ignore[attr-defined]
        parts["hinge's play, stored and lost"] = energy.hinge + energy.hinge_play
    if capture.design.probe.bending_stiffness is not None:  # type: ignore[attr-defined]
        parts["lost in bending"] = energy.bending
    curves = tuple(Curve(name, 1e3 * np.asarray(value)) for name, value in parts.items())
    return Panel("Energy, adding up to the total", "energy [mJ]", curves, stacked=True)


def _stroke(capture: "Capture") -> Panel:
    buffer, largest = capture.design.buffer, 1e3 * float(capture.stroke)  # type: ignore[attr-defined]
    end = 1e3 * float(buffer.end)
    what = "the buffer's end" if buffer.stop_stiffness is None else "the end stop"
    levels = [Level(f"largest, {largest:.4g} mm", largest)]
    if largest > 0.5 * end:
        levels.append(Level(f"{what}, {end:.4g} mm", end, limit=True))
    stroke = Curve("", 1e3 * capture.history.stroke)  # type: ignore[union-attr]
    return Panel("Buffer stroke", "stroke [mm]", (stroke,), (*levels, Level("", 0.0)))
