"""Numbers with their units, as records have them, written and read back."""

import json
from pathlib import Path

import pytest

import jaxbuffer as jb
from jaxbuffer.errors import InputError
from jaxbuffer.labelled.arrays import Labelled
from jaxbuffer.labelled.record import Record, amount, amounts, numbers, part_from_json, part_json, part_record, rows

STORED = {"outcome": "captured", "stroke": amount(0.02, "m"), "worst stroke": amount(0.03, "m"), "limits": {"value": 1}}


def test_a_number_is_under_its_name_and_its_unit_beside_it():
    record = Record(STORED)
    assert record["stroke"] == record.get("stroke") == 0.02 and record["limits"] == {"value": 1}
    assert record.units == {"stroke": "m", "worst stroke": "m"}
    assert "end_time" not in record and record.get("end_time", 3.0) == 3.0 and list(record) == list(STORED)


def test_records_inside_a_record_are_read_alike():
    force, plain = amount(5.0, "N"), {"impacts": [{"time": amount(0.1, "s")}]}
    plain |= {"certificate": {"runner_up": {"force": force}}}
    for record in (Record.of(plain), Record.from_json(json.dumps(plain))):
        assert record["impacts"][0]["time"] == 0.1 and record["certificate"]["runner_up"]["force"] == 5.0
        assert record["impacts"][0].units == {"time": "s"}
    results = jb.Results(Path("results"), records={"tuned": {"gradient_error": amount(1e-6, "-")}})
    assert results.tuned["gradient_error"] == 1e-6


def test_tables_become_records_without_what_json_lacks():
    assert numbers({"stroke": Labelled((), 0.02, "m"), "margin": Labelled((), float("nan"), "-")}) == {
        "stroke": {"value": 0.02, "unit": "m"},
        "margin": {"value": None, "unit": "-"},
    }
    table = {"time": Labelled(("impact",), [0.1, 0.2], "s"), "force": Labelled(("impact",), [1.0, float("inf")], "N")}
    units = {"time": "s", "force": "N"}
    assert rows(table) == [amounts(units, (0.1, 1.0)), amounts(units, (0.2, None))]


def test_a_design_is_read_by_its_paths():
    design = Record.of(part_record(jb.BarDrop()))
    assert design["impact.stiffness"] == jb.BarDrop().impact.stiffness and design["impact.law"] == "adams"
    assert design.units["impact.stiffness"] == "N/m^e" and "impact.law" not in design.units
    given = jb.BarDropScenario(height=0.1)
    assert part_from_json(jb.BarDropScenario(height=0.2), part_json(given)) == given


def test_a_design_with_units_in_its_names_is_refused():
    with pytest.raises(InputError, match="written by an earlier version of jaxbuffer; make it again"):
        part_from_json(jb.BarDropScenario(height=0.2), '{"height [m]": 0.1}')
