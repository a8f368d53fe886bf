"""Reference runs of docking in space: inputs, values and elasticities from an independent solver in minimal coordinates
(Kane's method)."""

import dataclasses
import json
from pathlib import Path
from typing import NamedTuple

from jaxbuffer import Design3D, Scenario3D, docking3d, replace
from verification.docking_cases import QUANTITIES as PLANAR_QUANTITIES

SECTIONS = ("latch", "control", "active", "passive", "buffer")
SCENARIO = {field.name for field in dataclasses.fields(Scenario3D)}
SHORT = {  # names of the reference that are not the last ones of their paths
    "misalignment": "scenario.passive_yaw",
    "misalignment_y": "scenario.passive_pitch",
    "passive_rate": "scenario.passive_rate_z",
    "lateral_y": "scenario.lateral_speed_y",
    "lateral_z": "scenario.lateral_speed_z",
    "tip_mass": "probe.tip_mass",
    "rolling": "probe.free_tip",
}
QUANTITIES = {  # of a run, and their names in the reference
    **PLANAR_QUANTITIES,
    **{name: name for name in ("lateral_miss", "swing_miss", "attitude_miss")},
}


class Case(NamedTuple):
    """One reference run; ``values``: what the reference has of it."""

    design: Design3D
    scenario: Scenario3D
    duration: float
    values: dict


def path_of(name: str) -> str:
    """The path of one of the reference's shortened names."""
    if name in SHORT:
        return SHORT[name]
    if name in SCENARIO:
        return f"scenario.{name}"
    for section in SECTIONS:
        if name.startswith(f"{section}_"):
            return f"{section}.{name.removeprefix(f'{section}_')}"
    return f"buffer.{name}"


def _case(record: dict) -> Case:
    inputs = dict(record["inputs"])
    # 3 s, and with a latch 20 s, unless the inputs say it.
    duration = inputs.pop("T", 20.0 if "latch_stiffness" in inputs else 3.0)
    values = {path_of(name): value for name, value in inputs.items()}
    if "probe.free_tip" in values:
        values["probe.free_tip"] = bool(values["probe.free_tip"])
    scenario = {path.removeprefix("scenario."): value for path, value in values.items() if path.startswith("scenario.")}
    design = replace(docking3d(), {path: value for path, value in values.items() if not path.startswith("scenario.")})
    return Case(design, Scenario3D(**scenario), duration, record)


RECORDS = json.loads(Path(__file__).with_name("docking3d.json").read_text())
CASES = {record["name"]: _case(record) for record in RECORDS}
