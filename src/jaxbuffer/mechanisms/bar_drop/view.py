"""What is told of a dropped bar and drawn of its runs."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..bending import mode_limits, mode_lines
from ..energy import energy_unit
from ..picture import Level, Panel, PanelCurve
from ..plain_summary import plain_summary
from ..validity import BEYOND_LAW, ValidityLimit
from ..view import Names, View
from .bending import bending_parts, rise_time
from .design import BarDrop, BarDropScenario
from .drawing import drawing
from .run import BarDropRun

DEEP = 0.1  # of the ball's radius: up to here the contact counts as small against the ball


def label(scenario: BarDropScenario, among: Any = ()) -> str:
    """Return what people call a drop: "from 194 mm"."""
    return f"from {1e3 * float(scenario.height):.4g} mm"


def validity(design: BarDrop, quantities: Mapping[str, Any]) -> list[ValidityLimit]:
    """Return how near the deepest penetrations come to the contact law's limit, and modes to being too few."""
    peak_force, penetration = quantities["peak_force"], quantities["penetration"]
    share = np.asarray(penetration) / (DEEP * np.asarray(design.bar.ball_radius))
    deep = ValidityLimit(f"{BEYOND_LAW}the ball goes deeper into the plate than a tenth of its radius", share)
    return [deep, *mode_limits(bending_parts(design), rise_time(design, peak_force, penetration))]


def warnings(run: BarDropRun) -> list[str]:
    """Return a line for each validity limit that the run exceeds."""
    deep, *few = validity(run.design, {"peak_force": run.peak_force, "penetration": run.maxima["penetration"]})
    lines = [deep.beyond] if deep.passed else []
    return lines + [f"{limit.beyond}, by a factor of {float(limit.share):.3g}" for limit in few if limit.passed]


def summary(run: BarDropRun) -> str:
    """Return the plain summary, with the number of modes that it was computed with below the peak."""
    lines = plain_summary(run).splitlines()
    below = next((k + 1 for k, line in enumerate(lines) if line.startswith("  time of the peak")), len(lines))
    time = rise_time(run.design, float(run.peak_force), float(run.maxima["penetration"]))
    return "\n".join([*lines[:below], *mode_lines(bending_parts(run.design), time), *lines[below:]])


def record(run: BarDropRun) -> dict[str, dict[str, Any]]:
    """Return the numbers of modes behind a peak."""
    return {"modes": {"plate": run.design.plate.modes, "bar": run.design.bar.modes}}


def panels(run: BarDropRun) -> list[Panel]:
    """Return panels of gap, penetration, energy and deflections, of a run with a history."""
    history = run.history
    assert history is not None
    energy = {name: np.asarray(getattr(history.energy, name)) for name in ("kinetic", "contact", "potential")}
    energy["lost"] = np.asarray(history.energy.dissipated)
    unit, many = energy_unit(max(np.max(np.abs(values)) for values in energy.values()))
    deepest = f"Penetration, largest {1e6 * float(run.maxima['penetration']):.4g} µm"
    return [
        Panel(
            "Gap below the ball end",
            "gap [mm]",
            (PanelCurve("", 1e3 * history.gap[:, 0]),),
            (Level("", 0.0),),
            whole=True,
        ),
        Panel(deepest, "penetration [µm]", (PanelCurve("", np.maximum(1e6 * np.asarray(history.penetration), 0.0)),)),
        Panel(
            "Energy",
            f"energy [{unit}]",
            tuple(PanelCurve(name, many * values) for name, values in energy.items()),
            whole=True,
        ),
        *(bent(run, body) for body in ("plate", "bar") if getattr(run.design, body).modes),
    ]


def bent(run: BarDropRun, body: str) -> Panel:
    """Return a panel of the deflection of one body, with its number of modes."""
    history, name = run.history, f"{body}_deflection"
    assert history is not None
    largest, modes = float(run.maxima[name]), getattr(run.design, body).modes
    unit, factor = ("mm", 1e3) if largest > 1e-3 else ("µm", 1e6)
    title = f"Deflection of the {body}, largest {factor * largest:.4g} {unit} ({modes} modes)"
    return Panel(title, f"deflection [{unit}]", (PanelCurve("", factor * np.asarray(history.others[name])),))


def names(design: BarDrop) -> Names:
    """Return what the parts of a design are called."""
    # The weld of a plate that bends comes behind the hinge, and so do its multipliers.
    supports = {"plate x": "N", "plate y": "N", "plate moment": "N m"} if design.plate.modes else {}
    return Names(
        bodies=("bar",),
        contacts=("plate",),
        multipliers={"hinge x": "N", "hinge y": "N", **supports},
        others={"penetration": "m", "plate_deflection": "m", "bar_deflection": "m"},
    )


VIEW = View(
    title="Bar drop",
    run_name="drop",
    contact="plate",
    names=names,
    label=label,
    approach=lambda scenario: f"dropped {label(scenario)}",
    summary=summary,
    record=record,
    limitations=(
        "The motion is planar: nothing moves or turns out of the plane.",
        "The forces have not been compared with a measurement: docs/verification.md.",
    ),
    warnings=warnings,
    validity=validity,
    panels=panels,
    drawing=drawing,
)
