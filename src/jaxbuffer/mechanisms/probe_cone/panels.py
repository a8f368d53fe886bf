"""What to draw of a capture over time."""

import numpy as np

from ..energy import energy_unit
from ..picture import Curve, Level, Panel
from .assembly import probe_masses
from .capture import Capture


def panels(capture: Capture) -> list[Panel]:
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


def _bending(capture: Capture) -> Panel | None:
    if capture.design.probe.bending_stiffness is None:  # type: ignore[attr-defined]
        return None
    title = f"Bending of the probe, largest {1e3 * float(capture.bending):.3g} mm"
    return Panel(title, "tip off the axis [mm]", (Curve("", 1e3 * capture.history.bending),))  # type: ignore[union-attr]


def _play(capture: Capture) -> Panel | None:
    if capture.design.hinge.play is None:  # type: ignore[attr-defined]
        return None
    gap = Curve("", 1e6 * capture.history.hinge_gap)  # type: ignore[union-attr]
    return Panel("Hinge, from the pin to its bush", "gap [µm]", (gap,), (Level("", 0.0),))


def _energy(capture: Capture) -> Panel:
    """What each part has of the energy that the mechanism can take up: all but that of the common motion."""
    energy, common = capture.history.energy, common_energy(capture)  # type: ignore[union-attr]
    parts = {
        "relative motion": np.maximum(np.asarray(energy.kinetic) - common, 0.0),
        "springs": energy.spring,
        "lost in dampers": energy.axial_damper + energy.torsional_damper,
        "lost in friction": energy.friction,
        "in contact": energy.contact + energy.hysteresis,
    }
    if capture.design.buffer.stop_stiffness is not None:  # type: ignore[attr-defined]
        parts["in the end stop"] = energy.stop + energy.stop_damper
    if capture.design.hinge.play is not None:  # type: ignore[attr-defined]
        parts["in the hinge's play"] = energy.hinge + energy.hinge_play
    if capture.design.probe.bending_stiffness is not None:  # type: ignore[attr-defined]
        parts["lost in bending"] = energy.bending
    unit, many = energy_unit(np.max(np.asarray(energy.total)) - common)
    curves = tuple(Curve(name, many * np.asarray(value)) for name, value in parts.items())
    return Panel("Energy without that of the common motion", f"energy [{unit}]", curves, stacked=True)


def common_energy(capture: Capture) -> float:
    """Kinetic energy [J] of both vehicles' common motion, that of their centre of mass: no force between them changes
    it, and no buffer takes it up (König's theorem). It is read off the start, when nothing bends yet."""
    design, history = capture.design, capture.history
    probe = probe_masses(design).mass  # type: ignore[arg-type]
    masses = np.array([float(m) for m in (design.active.mass, design.buffer.cylinder_mass, probe, design.passive.mass)])  # type: ignore[attr-defined]
    momentum = masses @ np.asarray(history.velocity)[0, :, :2]  # type: ignore[union-attr]
    return 0.5 * float(momentum @ momentum) / float(masses.sum())


def _stroke(capture: Capture) -> Panel:
    buffer, largest = capture.design.buffer, 1e3 * float(capture.stroke)  # type: ignore[attr-defined]
    end = 1e3 * float(buffer.end)
    what = "the buffer's end" if buffer.stop_stiffness is None else "the end stop"
    levels = [Level(f"largest, {largest:.4g} mm", largest)]
    if largest > 0.5 * end:
        levels.append(Level(f"{what}, {end:.4g} mm", end, limit=True))
    stroke = Curve("", 1e3 * capture.history.stroke)  # type: ignore[union-attr]
    return Panel("Buffer stroke", "stroke [mm]", (stroke,), (*levels, Level("", 0.0)))
