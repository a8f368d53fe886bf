"""Values that were typed in millimetres and degrees come back so: in tables, on pages and in messages."""

import dataclasses
import pickle

import jax
import pytest

import jaxbuffer as jb
from jaxbuffer.errors import OutOfRange
from jaxbuffer.fields import with_values
from jaxbuffer.output.folder import Results
from jaxbuffer.output.tuned_records import tuned_record
from jaxbuffer.pages.abstract import abstract
from jaxbuffer.pages.designs import requirements
from jaxbuffer.pages.runs import search
from jaxbuffer.study.explained import explained
from jaxbuffer.study.load import loads
from jaxbuffer.sweeps.grid import grid
from jaxbuffer.tuning.search.goal import Goal
from jaxbuffer.value_text import with_unit
from made_up import made_up_evaluation, made_up_tuning

STUDY = b"""
[cone]
half_angle = "44 deg"
[problem.variables]
buffer.free_length = ["100 mm", "200 mm"]
cone.half_angle = ["40 deg", "50 deg"]
buffer.k_A = [100, 900]
[problem.constraints]
stroke = "11 mm"
[sweep]
scenario.misalignment = {from = "-4 deg", to = "4 deg", count = 9}
buffer.free_length = ["120 mm", "130 mm"]
"""


def rows(text: str) -> dict[str, list[str]]:
    """A table's lines by their first words."""
    return {words[0]: words[1:] for line in text.splitlines() if (words := line.split())}


@pytest.fixture(scope="module")
def tuned():
    return made_up_tuning(loads(STUDY, "study.toml").problem())


def test_the_variables_of_a_tuning(tuned):
    """Every variable goes half of the way to its low bound."""
    table = rows(repr(tuned))
    assert table["buffer.free_length"] == ["136.5", "118.25", "100", "200", "mm"]
    assert table["cone.half_angle"] == ["44", "42", "40", "50", "deg"]
    assert table["buffer.k_A"] == ["500", "300", "100", "900", "N/m"]


def test_the_page_of_a_tuning(tuned, tmp_path):
    """Its record has SI units, and the units that people are shown."""
    record = tuned_record(tuned)
    assert [it["display_unit"] for it in record["variables"]] == ["mm", "N/m", "deg"]
    assert record["variables"][0]["low"] == pytest.approx(0.1)
    found = Results(tmp_path, records={"tuned": record})
    (variables,) = search(found).tables
    assert [row[:5] for row in variables.rows if row[1] != "N/m"] == [
        ["buffer.free_length", "mm", "100", "200", "136.5"],
        ["cone.half_angle", "deg", "40", "50", "44"],
    ]
    listed = {row[1]: row[2] for row in requirements(found, []).tables[0].rows if row[0] == "variable"}
    assert listed["cone.half_angle"] == "40 to 50 deg" and listed["buffer.free_length"] == "100 to 200 mm"
    assert "cone.half_angle from 44 to 42 deg" in abstract([found])[0]


def test_limits_that_are_kept_and_broken(tuned):
    problem = dataclasses.replace(tuned.problem, limits=jb.Limits(at_most={"stroke": 0.008}))
    assert problem.limits.lines(problem.catalogue) == ["stroke ≤ 8 mm"]
    broken = Goal(problem, problem.objective).broken(made_up_evaluation(problem, problem.start()))
    assert broken == ["0.1 m/s, 0°: stroke 10 mm is above 8 mm"]
    objective = jb.Objective({"stroke": 1.0})
    assert with_unit(*objective.shown(0.0071, problem.catalogue)) == "7.1 mm"


def test_a_study_in_words_and_the_axes_of_its_sweep():
    study = loads(STUDY, "study.toml")
    lines = explained(study, "study.toml")
    assert "buffer.free_length in [100, 200] mm, log, from 136.5 mm" in lines
    assert "scenario.misalignment -4 to 4 deg, 9 values, linear" in lines
    over = grid(study.sweep, study.design, study.scenario)
    assert over.point(1) == "misalignment -4 deg, free_length 130 mm"


ANGLE, LENGTH = "cone.half_angle = ['40 deg', '95 deg']", "buffer.free_length = ['{} mm', '{} mm']"
RANGES = [
    ("[cone]\nhalf_angle = '97 deg'", "cone.half_angle = 97 deg is out of range; allowed: (0, 90) deg"),
    ("[probe]\ntip_radius = '-5 mm'", "probe.tip_radius = -5 mm is out of range; allowed: (0, inf) mm"),
    (f"[problem.variables]\n{ANGLE}", "= 95 deg is out of range; allowed: (0, 90) deg"),
    (f"[problem.variables]\n{LENGTH.format(90, 80)}", "= [90, 80] mm: the low bound must be below"),
    (f"[problem.variables]\n{LENGTH.format(80, 90)}", "= 136.5 mm, is outside its bounds [80, 90] mm"),
    ("[problem.constraints]\nstroke = '-8 mm'", "problem.constraints.stroke = -8 mm is out of range"),
    ("[sweep]\nscenario.misalignment = ['95 deg']", "misalignment = 95 deg is out of range; allowed: (-90, 90) deg"),
    ("[sample.ranges]\nprobe.tip_radius = ['-2 mm', '1 mm']", "probe.tip_radius = -2 mm is out of range; allowed"),
    ("kind = 'bar_drop'\n[scenario]\nheight = '300 mm'", "height = 300 mm is out of range; allowed: (0, 240) mm"),
]


@pytest.mark.parametrize(("text", "said"), RANGES)
def test_ranges_in_messages(text, said):
    with pytest.raises(jb.InputError) as caught:
        loads(text.encode(), "study.toml").problem()
    assert said in str(caught.value)


def test_ranges_in_messages_of_python():
    with pytest.raises(jb.InputError, match=r"^scenario\.misalignment = 97 deg is out of range; .*\(-90, 90\) deg$"):
        jb.Scenario(misalignment="97 deg")
    with pytest.raises(jb.InputError, match=r"^probe\.tip_radius = -5 mm is out of range; allowed: \(0, inf\) mm$"):
        jb.replace(jb.table2(), {"probe.tip_radius": "-5 mm"})


def test_a_range_error_travels_between_processes():
    error = OutOfRange("buffer.k_A", -5.0, "kN/m", (0.0, 1.0, True, False), after=", says the test")
    again = pickle.loads(pickle.dumps(error))
    assert isinstance(again, jb.InputError) and str(again) == str(error)


def test_a_printed_gradient_has_the_units_of_one():
    """Also of a part of it; a design, of numbers or of arrays, has its own."""
    design, scenario = jb.table2(), jb.Scenario()

    def momentum(design):
        return design.active.mass * scenario.approach_speed - design.probe.length

    gradient = jax.grad(momentum)(design)
    assert "mass [per kg] = 0.1" in repr(gradient) and "length [per m] = -1" in repr(gradient)
    assert "length [per m] = -1" in repr(gradient.probe) and "[m]" not in repr(gradient.probe)
    many, _ = with_values(design, scenario, {"buffer.k_A": jax.numpy.asarray([100.0, 200.0])})
    assert "[per" not in repr(many) + repr(design) + repr(jax.tree.map(lambda leaf: 2 * leaf, scenario))
