"""Units as text where numbers come in, held against the definitions of the units."""

import math
import subprocess
import sys

import numpy as np
import pytest

from jaxbuffer import InputError, Scenario, replace, table2
from jaxbuffer.cli.entry import run
from jaxbuffer.fields import paths, unit
from jaxbuffer.fields.unit_symbols import KINDS, SYMBOLS
from jaxbuffer.fields.units import as_unit, in_unit
from jaxbuffer.mechanisms import all_mechanisms
from jaxbuffer.study.load import loads

# SI brochure, 9th edition (2019); inch, pound and pound-force by the international agreement of 1959 and g_n.
SAME = [
    ("0.5 kN/m", "N/m", 500.0),
    ("20 cm/s", "m/s", 0.2),
    ("3 deg", "rad", math.pi / 60.0),
    ("-3°", "rad", -math.pi / 60.0),
    ("60 rpm", "rad/s", 2.0 * math.pi),
    ("2 turn/s", "rad/s", 4.0 * math.pi),
    ("5 N m/deg", "N m/rad", 900.0 / math.pi),
    ("5 N·m·s/rad", "N m s/rad", 5.0),
    ("2 kg cm²", "kg m²", 2e-4),
    ("7 g/cm^3", "kg/m³", 7e3),
    ("4 N/mm^1.5", "N/m^1.5", 4.0 * 1000.0**1.5),
    ("210 GPa", "Pa", 2.1e11),
    ("12 %", "-", 0.12),
    ("1.5e3ms", "s", 1.5),
    ("10 1/min", "1/s", 1.0 / 6.0),
    ("1 lbf/in", "N/m", 0.45359237 * 9.80665 / 0.0254),
    ("25 µm", "m", 25e-6),
    ("25 um", "m", 25e-6),
]


@pytest.mark.parametrize(("text", "symbol", "value"), SAME, ids=[text for text, *_ in SAME])
def test_text_with_a_unit_becomes_a_number_in_the_fields_unit(text, symbol, value, evidence):
    error = abs(in_unit("field", text, symbol) / value - 1.0)
    evidence("Front", "a text with a unit, converted", error, 4e-15, "SI brochure, 9th edition", "-")


def test_all_units_that_fields_and_quantities_have_can_be_read():
    units = {quantity.unit for mechanism in all_mechanisms() for quantity in mechanism.quantities.values()}
    for mechanism in all_mechanisms():
        for part in (mechanism.design(), mechanism.scenario()):
            units |= {unit(part, path) for path in paths(part)}
    for symbol in {*units, *SYMBOLS, *KINDS} - {"", "-", "N/m^e"}:
        assert in_unit("field", f"2 {symbol}", symbol) == 2.0
    with pytest.raises(InputError, match="depends on the exponent; write a number in N/m\\^e without one"):
        in_unit("impact.stiffness", "2 N/m", "N/m^e")


def test_designs_and_scenarios_take_text():
    design = replace(table2(), {"buffer.k_A": "0.5 kN/m", "probe.tip_mass": ["40 g", "0.05 kg"]})
    assert design.buffer.k_A == 500.0 and design.probe.tip_mass.tolist() == [0.04, 0.05]
    assert Scenario(approach_speed="20 cm/s").approach_speed == 0.2
    assert as_unit("stiff", "N/m") == "stiff"


def test_a_study_takes_text_everywhere():
    study = loads(
        b"""
        buffer.k_A = "0.5 kN/m"
        scenario.misalignment = "3 deg"
        options.duration = "4000 ms"
        problem.variables.buffer.k_A = ["0.1 kN/m", "2 kN/m"]
        problem.variables.buffer.c_A = ["1 N s/m", "60 N s/m", "linear"]
        problem.constraints.stroke = "25 mm"
        problem.constraints.end_time = {min = "500 ms", max = "5 s"}
        problem.grid.approach_speed = ["10 cm/s", "0.2 m/s"]
        sweep.buffer.k_A = {from = "0.1 kN/m", to = "2 kN/m", count = 3}
        sweep.buffer.c_A = ["2 N s/m", "5 N s/m"]
        """,
        "study.toml",
    )
    problem = study.problem()
    assert study.design.buffer.k_A == 500.0 and study.scenario.misalignment == pytest.approx(math.pi / 60.0)
    assert study.options.duration == 4.0
    assert [(v.low, v.high, v.scale) for v in problem.variables] == [(100.0, 2000.0, "log"), (1.0, 60.0, "linear")]
    assert problem.limits.at_most == {"stroke": 0.025, "end_time": 5.0} and problem.limits.at_least == {"end_time": 0.5}
    assert [case.scenario.approach_speed for case in problem.cases] == [0.1, 0.2]


def test_a_grid_of_a_tuning_takes_a_span():
    """Equal steps between ends with their units, and equal ratios: 0.05, 0.1, 0.2."""
    study = loads(
        b"""
        problem.grid.approach_speed = {from = "5 cm/s", to = "20 cm/s", count = 3, scale = "log"}
        problem.grid.misalignment = {from = "-1 deg", to = "1 deg", count = 2}
        """,
        "study.toml",
    )
    met = [(case.scenario.approach_speed, case.scenario.misalignment) for case in study.problem().cases]
    degree = math.pi / 180.0
    expected = [(speed, side * degree) for speed in (0.05, 0.1, 0.2) for side in (-1.0, 1.0)]
    assert np.array(met) == pytest.approx(np.array(expected), rel=1e-14)


def test_the_command_line_takes_text(computed):
    words = ["--scenario.approach_speed", "20 cm/s", "--buffer.k_A=0.8kN/m", "--duration", "500 ms"]
    assert run(["simulate", *words]) == 0
    asked = computed.calls[-1][1]
    assert (asked["scenario"].approach_speed, asked["design"].buffer.k_A, asked["duration"]) == (0.2, 800.0, 0.5)
    assert (
        run(["sweep", "--over", "scenario.approach_speed=5cm/s:0.3m/s:6", "--over", "buffer.k_A=0.1 kN/m,200 N/m"]) == 0
    )
    assert computed.calls[-1][1]["scenarios"].approach_speed.max() == pytest.approx(0.3)


@pytest.mark.parametrize("values", [["5 cm/s", 10], [0, 5, "20 cm/s"]])
def test_a_list_has_units_at_all_values_or_none(values):
    with pytest.raises(InputError, match="has no unit; give each value one, or none"):
        Scenario(approach_speed=values)
    assert Scenario(misalignment=["3 deg", 0]).misalignment.tolist() == pytest.approx([math.pi / 60.0, 0.0])


def test_hertz_is_no_rate_of_turning():
    with pytest.raises(InputError, match="for turns a second write turn/s or rpm"):
        Scenario(passive_rate="1 Hz")


@pytest.mark.slow
def test_pint_is_imported_only_for_text_with_a_unit():
    code = "import sys, jaxbuffer as jb; jb.Scenario({}); print('pint' in sys.modules)"
    for value, imported in (("0.2", "False"), ("'20 cm/s'", "True")):
        shown = subprocess.run([sys.executable, "-c", code.format(value)], capture_output=True, text=True, check=True)
        assert shown.stdout.strip() == imported
