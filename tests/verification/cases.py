"""The reference captures: inputs, values and elasticities from an independent solver at relative tolerance 1e-10."""

import json
from pathlib import Path
from typing import NamedTuple

from jaxbuffer import Design, Scenario, replace, table2

PATHS = {
    "k_A": "buffer.k_A",
    "c_A": "buffer.c_A",
    "k_T": "buffer.k_T",
    "c_T": "buffer.c_T",
    "tip_mass": "probe.tip_mass",
    "restitution": "contact.restitution",
    "friction": "contact.friction",
}
PARAMETERS = ("k_A", "c_A", "k_T", "c_T", "tip_mass")


class Case(NamedTuple):
    """One reference capture."""

    design: Design
    scenario: Scenario
    values: dict


def _case(record) -> Case:
    inputs = dict(record["inputs"])
    free = bool(inputs.pop("rolling", 0))
    values = {PATHS[name]: value for name, value in inputs.items() if name in PATHS}
    scenario = Scenario(**{name: value for name, value in inputs.items() if name not in PATHS})
    return Case(replace(table2(), values | {"probe.free_tip": free}), scenario, record)


CASES = {record["name"]: _case(record) for record in json.loads(Path(__file__).with_name("captures.json").read_text())}
WELDED = [name for name, case in CASES.items() if not case.design.probe.free_tip]
FREE = [name for name, case in CASES.items() if case.design.probe.free_tip]
