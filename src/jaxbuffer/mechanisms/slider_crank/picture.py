"""What to draw of a slider-crank's run."""

import numpy as np

from ..energy import energy_unit
from ..picture import Level, Panel, PanelCurve
from ..run import Run
from .journal import PINS, journal_path


def panels(run: Run) -> list[Panel]:
    """Return panels of the path of each pin with play, the drive's torque, the slider's acceleration and energy, of a
    run with a history."""
    history = run.history
    assert history is not None
    paths = [_path(run, pin) for pin in PINS if getattr(run.design, pin).joint == "clearance"]
    stored = {name: np.asarray(values) for name, values in history.energy.stored.items() if np.any(values)}
    stored["lost"] = np.asarray(history.energy.dissipated)
    unit, many = energy_unit(max(np.max(np.abs(values)) for values in stored.values()))
    torque, acceleration = (np.asarray(history.others[name]) for name in ("drive_torque", "slider_acceleration"))
    return [
        *paths,
        Panel(
            f"Torque of the drive, {torque.min():.4g} to {torque.max():.4g} N m",
            "torque [N m]",
            (PanelCurve("", torque),),
            (Level("", 0.0),),
        ),
        Panel(
            f"Slider, at most {1e-3 * float(run.maxima['slider_acceleration']):.4g} km/s²",
            "size of acceleration [km/s²]",
            (PanelCurve("", 1e-3 * acceleration),),
        ),
        Panel("Energy", f"energy [{unit}]", tuple(PanelCurve(name, many * values) for name, values in stored.items())),
    ]


def _path(run: Run, pin: str) -> Panel:
    """Return a panel of the pin's centre relative to the bush's, and of how far it can go before it touches."""
    part = getattr(run.design, pin)
    along, across = 1e3 * journal_path(run, pin).T
    # A circle, or the square that contact by components leaves.
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    outline = np.stack([np.cos(angle), np.sin(angle)])
    if part.by_components:
        outline = np.array([[1.0, -1.0, -1.0, 1.0, 1.0], [1.0, 1.0, -1.0, -1.0, 1.0]])
    edge = 1e3 * float(part.clearance) * outline
    title = f"{pin.replace('_', ' ').capitalize()} in its bush"
    curves = (
        PanelCurve("path", across, along=along),
        PanelCurve("play", edge[1], dashed=True, along=edge[0]),
    )
    return Panel(title, "across [mm]", curves, path="along the slider's line [mm]")
