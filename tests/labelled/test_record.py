"""Names with units, as records and tables have them, written and read back."""

import json
from pathlib import Path

import pytest

import jaxbuffer as jb
from jaxbuffer.labelled.arrays import Labelled
from jaxbuffer.labelled.record import Record, heading, numbers, part_record, parts, rows

STORED = {"outcome": "captured", "stroke [m]": 0.02, "floor": 1.0, "floor [N]": 2.0, "worst stroke [m]": 0.03}


@pytest.mark.parametrize(("name", "unit"), [("stroke", "m"), ("margin", "-"), ("contact.law", ""), ("force[2]", "N m")])
def test_a_heading_is_read_back(name, unit):
    assert parts(heading(name, unit)) == (name, unit)


def test_a_record_is_asked_with_or_without_units():
    record = Record(STORED)
    assert record["stroke"] == record["stroke [m]"] == record.get("stroke") == 0.02
    assert record["floor"] == 1.0, "a name of its own comes first"
    assert "worst stroke" in record and "end_time" not in record and record.get("end_time", 3.0) == 3.0
    with pytest.raises(KeyError, match="end_time"):
        record["end_time"]
    assert json.loads(json.dumps(record)) == STORED == record and list(record) == list(STORED)


def test_records_inside_a_record_are_asked_alike():
    plain = {"impacts": [{"time [s]": 0.1}], "certificate": {"runner_up": {"force [N]": 5.0}}}
    for record in (Record.of(plain), Record.from_json(json.dumps(plain))):
        assert record["impacts"][0]["time"] == 0.1 and record["certificate"]["runner_up"]["force"] == 5.0
    results = jb.Results(Path("results"), records={"tuned": {"gradient_error [-]": 1e-6}})
    assert results.tuned["gradient_error"] == 1e-6


def test_tables_become_records_without_what_json_lacks():
    assert numbers({"stroke": Labelled((), 0.02, "m"), "margin": Labelled((), float("nan"), "-")}) == {
        "stroke [m]": 0.02,
        "margin [-]": None,
    }
    table = {"time": Labelled(("impact",), [0.1, 0.2], "s"), "force": Labelled(("impact",), [1.0, float("inf")], "N")}
    assert rows(table) == [{"time [s]": 0.1, "force [N]": 1.0}, {"time [s]": 0.2, "force [N]": None}]


def test_a_design_is_asked_by_its_paths():
    design = Record(part_record(jb.BarDrop()))
    assert design["impact.stiffness"] == jb.BarDrop().impact.stiffness and design["impact.law"] == "adams"
