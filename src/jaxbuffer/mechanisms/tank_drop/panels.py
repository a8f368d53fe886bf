"""What to draw of a drop onto a tank over time."""

from typing import Any

import numpy as np

from ..energy import energy_unit
from ..picture import Level, Panel, PanelCurve


def panels(run: Any) -> list[Panel]:
    """Return panels of motion, pressures, stress with the yield stress, plastic strain and energy, of a run with a
    history."""
    history, design = run.history, run.design
    composite = design.material.kind == "composite"
    others = {name: np.asarray(values) for name, values in history.others.items()}
    travel = np.asarray(history.position)[0, 0, 1] - np.asarray(history.position)[:, 0, 1]
    result = [
        Panel(
            f"Deflection of the top, largest {1e3 * float(run.deflection):.4g} mm",
            "downwards [mm]",
            (PanelCurve("top", 1e3 * others["deflection"]), PanelCurve("slider", 1e3 * travel, dashed=True)),
            whole=True,
        ),
        Panel(
            f"Stress after von Mises, largest {1e-6 * float(run.peak_stress):.4g} MPa",
            "stress [MPa]",
            (PanelCurve("largest in the wall", 1e-6 * others["peak_stress"]),),
            # A composite has no yield stress: its plies are judged one by one (`least_reserve`).
            () if composite else (Level("yield stress", 1e-6 * float(design.material.yield_stress)),),
            whole=True,
        ),
    ]
    if "highest_pressure" in others:
        result.append(
            Panel(
                "Pressure of the liquid on the wall",
                "over the atmosphere's [kPa]",
                (
                    PanelCurve("highest", 1e-3 * others["highest_pressure"]),
                    PanelCurve("lowest", 1e-3 * others["lowest_pressure"]),
                ),
                whole=True,
            )
        )
    if float(run.plastic_strain) > 0.0:
        result.append(
            Panel(
                f"Equivalent plastic strain, largest {float(run.plastic_strain):.4g}",
                "strain [-]",
                (PanelCurve("largest in the wall", others["peak_plastic_strain"]),),
                (Level("failure", float(design.material.failure_strain), limit=True),),
                whole=True,
            )
        )
    energy = {name: np.asarray(getattr(history.energy, name)) for name in history.energy.names if name != "total"}
    unit, many = energy_unit(max(np.max(np.abs(values)) for values in energy.values()))
    curves = tuple(PanelCurve(name, many * values) for name, values in energy.items() if np.any(values))
    return [*result, Panel("Energy", f"energy [{unit}]", curves, whole=True)]
