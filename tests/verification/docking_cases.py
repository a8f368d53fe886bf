"""Reference runs of docking: inputs, values and elasticities from an independent solver at relative tolerance 1e-10."""

import dataclasses
import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from jaxbuffer import Capture, Design, Scenario, replace, table2

LAST_NAMES = {  # of the vehicles' fields and the tip's, which do not say whose they are
    "active_mass": "active.mass",
    "active_inertia": "active.inertia",
    "passive_mass": "passive.mass",
    "passive_inertia": "passive.inertia",
    "tip_mass": "probe.tip_mass",
    "rolling": "probe.free_tip",
}
SCENARIO = {field.name for field in dataclasses.fields(Scenario)}
QUANTITIES = {  # of a run, and their names in the reference
    "peak_force": "peak_force",
    "stroke": "stroke",
    "hinge_angle": "hinge_angle",
    "peak_hinge_force": "hinge_force",
    "peak_latch_force": "latch_force",
    "latch_time": "latch_time",
    "end_time": "end_time",
    "relative_energy": "relative_energy",
}
DIFFERENTIATED = ("peak_force", "stroke", "peak_latch_force")  # in the order of the reference's elasticities


class DockingCase(NamedTuple):
    """One reference run; ``values``: what the reference has of it."""

    design: Design
    scenario: Scenario
    values: dict

    @property
    def duration(self) -> float:
        """20 s, with which the reference was computed, latch or not [s]."""
        return 20.0

    def deviation(self, run: Capture, quantity: str) -> float:
        """Size of the relative deviation of a run from the reference; 0 where neither has such a thing."""
        reference = self.values.get(QUANTITIES[quantity])
        value = float(run.quantity(quantity))
        if quantity == "relative_energy" and run.outcome.name == "torn":
            value += self._of_half_closed_latches(run)
        if reference is None:  # no latch time without a crossing
            return 0.0 if np.isnan(value) else np.inf
        return abs(value - reference) / (abs(reference) or 1.0)

    def _of_half_closed_latches(self, run: Capture) -> float:
        """What latches would store if they were closed where they tear, beyond what they do, over the first energy: the
        reference counts that, while here only the share that they are closed is stored energy (M176)."""
        x = (float(run.end_time) - float(run.docking.latch_time)) / float(self.design.latch.closing_time)
        first = float(run.docking.energy_left) / float(run.docking.relative_energy)
        return (1.0 / (x * x * (3.0 - 2.0 * x)) - 1.0) * float(run.energy.stored["latch"]) / first


def path_of(name: str) -> str:
    """The path of one of the reference's shortened names; "latch_" and "buffer_" stand before those of both."""
    if name in LAST_NAMES:
        return LAST_NAMES[name]
    for section in ("latch", "buffer"):
        if name.startswith(f"{section}_"):
            return f"{section}.{name.removeprefix(f'{section}_')}"
    return f"scenario.{name}" if name in SCENARIO else f"buffer.{name}"


def _case(record: dict) -> DockingCase:
    values = {path_of(name): value for name, value in record["inputs"].items()}
    if "probe.free_tip" in values:
        values["probe.free_tip"] = bool(values["probe.free_tip"])
    scenario = {path.removeprefix("scenario."): value for path, value in values.items() if path.startswith("scenario.")}
    design = replace(table2(), {path: value for path, value in values.items() if not path.startswith("scenario.")})
    return DockingCase(design, Scenario(**scenario), record)


RECORDS = json.loads(Path(__file__).with_name("docking.json").read_text())
DOCKING = {record["name"]: _case(record) for record in RECORDS}
