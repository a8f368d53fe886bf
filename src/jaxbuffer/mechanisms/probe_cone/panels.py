"""What to draw of a capture over time."""

from typing import Any

import numpy as np

from ...value_text import with_unit
from ..energy import energy_unit
from ..picture import Level, Panel, PanelCurve
from .capture import Capture

NOT_ELASTIC = ("kinetic", "latch_closing", "thrust")  # of what a history calls stored


def panels(capture: Capture) -> list[Panel]:
    """Return panels of gap and distance to capture, energy, stroke, hinge angle and latch force of a capture with a
    history."""
    history = capture.history
    assert history is not None
    more = [panel for panel in (_latch(capture), _bending(capture), _play(capture)) if panel is not None]
    gaps = Panel(
        "Gap and distance to capture",
        "distance [mm]",
        (
            PanelCurve("gap, lower flank", 1e3 * history.gap[:, 0]),
            PanelCurve("gap, upper flank", 1e3 * history.gap[:, 1]),
            PanelCurve("to the capture plane", 1e3 * history.throat_distance, dashed=True),
        ),
        (Level("", 0.0),),
    )
    turned, most = np.degrees(np.asarray(history.hinge_angle)), float(np.degrees(capture.hinge_angle))
    angle = Panel(
        f"Hinge angle{_reach(turned, most, '°')}",
        "hinge angle [°]",
        (PanelCurve("", np.degrees(history.hinge_angle)),),
        (Level("", 0.0),),
    )
    rest = [_energy(capture), _stroke(capture), angle, *more]
    if capture.design.latch.stiffness is None:
        return [gaps, *rest]
    # Latched vehicles come to rest long after the last impact.
    return [gaps, *(panel._replace(whole=True, to_end=True) for panel in rest)]


def _reach(values: np.ndarray, largest: float, unit: str) -> str:
    """Return what a title says of a curve that can change sign: its ends with their signs, the larger one to be the
    run's ``largest`` size, which lies between two steps."""
    low, high = float(np.min(values, initial=0.0)), float(np.max(values, initial=0.0))
    low, high = (-largest, high) if -low > high else (low, largest)
    return f", from {low:.3g} to {with_unit(high, unit, 3)}"


def _latch(capture: Capture) -> Panel | None:
    latch, largest = capture.design.latch, float(capture.peak_latch_force)
    if latch.stiffness is None:
        return None
    levels = [Level(f"largest, {largest:.4g} N", largest)]
    if latch.strength is not None and largest > 0.5 * float(latch.strength):
        levels.append(Level(f"strength, {float(latch.strength):.4g} N", float(latch.strength), limit=True))
    force = PanelCurve("", capture.history.latch_force)  # type: ignore[union-attr]
    return Panel("Latch force", "latch force [N]", (force,), (*levels, Level("", 0.0)))


def _bending(capture: Capture) -> Panel | None:
    if capture.design.probe.bending_stiffness is None:
        return None
    off = 1e3 * np.asarray(capture.history.bending)  # type: ignore[union-attr]
    title = f"Bending of the probe{_reach(off, 1e3 * float(capture.bending), 'mm')}"
    return Panel(title, "tip off the axis [mm]", (PanelCurve("", 1e3 * capture.history.bending),))  # type: ignore[union-attr]


def _play(capture: Capture) -> Panel | None:
    if capture.design.hinge.play is None:
        return None
    gap = PanelCurve("", 1e6 * capture.history.hinge_gap)  # type: ignore[union-attr]
    return Panel("Hinge, from the pin to its bush", "gap [µm]", (gap,), (Level("", 0.0),))


def _energy(capture: Capture) -> Panel:
    """Return a panel of what each part has of the energy of relative motion (M177), and what each has taken of it."""
    design, history = capture.design, capture.history
    energy = history.energy  # type: ignore[union-attr]
    parts = {
        "relative motion": np.maximum(relative_motion(history), 0.0),
        "springs": energy.spring,
        "lost in dampers": energy.axial_damper + energy.torsional_damper,
        "lost in friction": energy.friction,
        "in contact": energy.contact + energy.hysteresis,
    }
    if design.buffer.stop_stiffness is not None:
        parts["in the end stop"] = energy.stop + energy.stop_damper
    if design.hinge.play is not None:
        parts["in the hinge's play"] = energy.hinge + energy.hinge_play
    if design.probe.bending_stiffness is not None:
        parts["lost in bending"] = energy.bending
    if design.buffer.friction is not None:
        parts["lost in the buffer's friction"] = energy.buffer_friction
    if design.buffer.rebound_stiffness is not None:
        parts["in the rebound stop"] = energy.rebound + energy.rebound_damper
    if design.latch.stiffness is not None:
        parts["in the latches"] = energy.latch + energy.latch_damper
    # The panel stacks them, so that the unit is that of their sum.
    largest = float(np.max(np.sum([np.asarray(values) for values in parts.values()], axis=0)))
    unit, many = energy_unit(largest)
    curves = tuple(PanelCurve(name, many * np.asarray(value)) for name, value in parts.items())
    closing = "" if design.latch.stiffness is None else ", latches put in some as they close"
    return Panel(f"Energy without that of the common motion{closing}", f"energy [{unit}]", curves, stacked=True)


def relative_motion(history: Any) -> np.ndarray:
    """Return the energy of relative motion less what springs, contacts and latches store of it [J], over a history."""
    stored = history.energy.stored
    elastic = sum(np.asarray(stored[name]) for name in stored if name not in NOT_ELASTIC)
    return np.asarray(history.relative_energy) - elastic


def _stroke(capture: Capture) -> Panel:
    buffer, largest = capture.design.buffer, 1e3 * float(capture.stroke)
    end = 1e3 * float(buffer.end)
    what = "the buffer's end" if buffer.stop_stiffness is None else "the end stop"
    levels = [Level(f"largest, {largest:.4g} mm", largest)]
    if largest > 0.5 * end:
        levels.append(Level(f"{what}, {end:.4g} mm", end, limit=True))
    stroke = PanelCurve("", 1e3 * capture.history.stroke)  # type: ignore[union-attr]
    return Panel("Buffer stroke", "stroke [mm]", (stroke,), (*levels, Level("", 0.0)))
