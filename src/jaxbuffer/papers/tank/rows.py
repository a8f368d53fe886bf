"""One row of numbers a drop."""

import math

import numpy as np

from ...mechanisms.tank_drop.outcome import FORMS
from ...mechanisms.tank_drop.run import rows_of
from ...mechanisms.tank_drop.tank_run import TankRun
from ...mechanisms.tank_drop.view import in_order
from ..claims import Row
from ..study import StudyCase

COLUMNS = {
    "outcome": "",
    "peak_force": "N",
    "peak_time": "s",
    "contact_time": "s",
    "impulse": "N s",
    "deflection": "m",
    "sideways": "m",
    "peak_stress": "Pa",
    "plastic_strain": "-",
    "compression": "-",
    "penetration": "m",
    "highest_pressure": "Pa",
    "lowest_pressure": "Pa",
    **{f"{form}_time": "s" for form in FORMS},
    "order": "",
    "spring_force": "N",
    "rebound_speed": "m/s",
    "energy_error": "-",
    "steps": "-",
}
SHOWN = (
    *("outcome", "peak_force", "deflection", "sideways", "peak_stress", "plastic_strain", "compression"),
    *("penetration", "order", "energy_error", "steps"),
)


def row(case: StudyCase, run: TankRun) -> Row:
    """Return the numbers of one drop, with a history."""
    names = [name for name in COLUMNS if hasattr(run, name) and name != "outcome"]
    moved = np.asarray(run.history.others["displacement"])[: rows_of(run)] if run.history is not None else None
    assert moved is not None
    return {
        "outcome": run.outcome.name,
        **{name: float(getattr(run, name)) for name in names},
        "sideways": float(np.max(np.abs(moved[..., 0]))),
        "order": in_order(run) or "none",
        "spring_force": spring_force(run),
        "energy_error": float(run.balance.energy),
        "steps": int(run.accepted),
    }


def spring_force(run: TankRun) -> float:
    """Return the largest force [N] of the slider on the cushion alone, as a mass on a spring: mg + √((mg)² + 2 m g h
    k)."""
    design, scenario = run.design, run.scenario
    weight = float(design.slider.mass) * float(scenario.gravity)
    # The cushion lies on the flat part of the top.
    area = (float(design.tank.width) - 2.0 * float(design.tank.corner_radius)) * float(design.tank.length)
    stiffness = float(design.cushion.stiffness) * area
    return weight + math.sqrt(weight**2 + 2.0 * weight * float(scenario.height) * stiffness)
