"""A tuned design's file is a study from which a tuning goes on: the same problem and numbers, in the units typed."""

import dataclasses
import tomllib

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.fields import as_written
from jaxbuffer.fields.units import as_unit
from jaxbuffer.study.load import loads
from jaxbuffer.study.tuned_toml import tuned_toml

TYPED = """
[active]
mass = "8 t"
[buffer]
k_A = "3 kN/m"
c_A = 130.0
cylinder_length = "12.3 cm"
[probe]
tip_mass = "50 g"
"""
PROBLEM = """
[problem.variables]
buffer.k_A = ["1 kN/m", "5 kN/m"]
buffer.c_A = [1.0, 300.0, "linear"]
[problem.objective]
peak_force = 1.0
stroke = 100.0
over = "cvar"
level = 0.8
[problem.then]
peak_hinge_force = 1.0
tolerance = 0.02
[problem.constraints]
stroke = "25 mm"
hinge_angle = {min = "0.1 deg", max = "2 deg"}
end_time = {min = 0.1, max = 3.0}
impacts = 30
"""
CASES = {
    "listed": '[[scenarios]]\napproach_speed = "10 cm/s"\n[[scenarios]]\napproach_speed = "17.3 cm/s"\n',
    "a grid": '[problem.grid]\napproach_speed = ["10 cm/s", "17.3 cm/s"]\nmisalignment = ["-1 deg", "0.7 deg"]\n',
    "samples": '[scenario]\napproach_speed = "15 cm/s"\n[problem.sample]\ncount = 4\nseed = 3\n'
    "[problem.sample.scenario]\nmisalignment = {uniform = ['-1 deg', '1 deg']}\n"
    "[problem.sample.factors]\nbuffer.k_A = {normal = [1.0, 0.05]}\n",
    "samples at a grid": "[problem.grid]\napproach_speed = ['10 cm/s', '20 cm/s']\n[problem.sample]\ncount = 4\n"
    "[problem.sample.scenario]\nmisalignment = {uniform = ['-1 deg', '1 deg']}\n",
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_tuned_study_has_the_whole_problem(name):
    problem = loads((TYPED + CASES[name] + PROBLEM).encode(), "study.toml").problem()
    tuned = jb.replace(problem.design, {"buffer.k_A": 2999.999998870814, "buffer.c_A": 17.123456789012345})
    written = tuned_toml(tuned, problem, "Tuned.")
    again = loads(written.encode(), "design.toml")
    assert again.design == tuned, "the numbers that were evaluated, to the last bit"
    goes_on = again.problem()
    for part in ("variables", "objective", "limits", "then", "duration", "rtol", "scatter"):
        assert getattr(goes_on, part) == getattr(problem, part), part
    assert sorted(map(repr, goes_on.cases)) == sorted(map(repr, problem.cases))
    table = tomllib.loads(written)
    assert table["active"]["mass"] == "8 t" and table["buffer"]["cylinder_length"] == "12.3 cm"
    assert table["buffer"]["k_A"] == "2.999999998870814 kN/m"
    assert table["buffer"]["c_A"] == 17.123456789012345, "without a unit, as it was typed"
    assert table["problem"]["variables"]["buffer.k_A"] == ["1 kN/m", "5 kN/m", "log"]
    assert table["problem"]["constraints"]["stroke"] == {"max": "25 mm"}
    assert table["problem"]["constraints"]["hinge_angle"] == {"min": "0.1 deg", "max": "2 deg"}


def test_numbers_that_were_not_tuned_come_back_as_they_were_typed():
    problem = loads((TYPED + PROBLEM).encode(), "study.toml").problem()
    table = tomllib.loads(tuned_toml(problem.design, problem, ""))
    assert (table["buffer"]["k_A"], table["probe"]["tip_mass"]) == ("3 kN/m", "50 g")


def test_a_written_number_is_read_back_to_the_last_bit():
    rng = np.random.default_rng(1)
    for unit, typed in (("N/m", "kN/m"), ("m", "mm"), ("m", "in"), ("rad", "deg"), ("m/s", "km/h"), ("kg", "lb")):
        for value in np.exp(rng.uniform(-8.0, 8.0, 300)).tolist():
            assert as_unit(as_written(value, unit, typed), unit) == value
    assert as_written(0.025, "m", "mm") == "25 mm"
    assert as_written(0.025, "m", "") == 0.025
    assert as_written(0.025, "m", "kg") == 0.025, "a unit that does not fit"


def test_settings_that_are_not_the_default_go_with_it():
    problem = loads((TYPED + PROBLEM + "[tune]\nstarts = 4\n").encode(), "study.toml")
    written = tuned_toml(problem.design, problem.problem(), "", settings=problem.tuning)
    assert loads(written.encode(), "design.toml").tuning == problem.tuning
    assert tomllib.loads(written)["tune"] == {"starts": 4}


def test_an_objective_on_ones_own_quantity_is_left_as_a_comment(tmp_path):
    own = {"effort": jb.CustomQuantity(lambda peak_force, stroke: peak_force * stroke, "N m")}
    variables, objective = [jb.Variable("buffer.k_A", 100.0, 3000.0)], jb.Objective({"effort": 1.0, "stroke": 2.0})
    problem = jb.Problem(jb.table2(), [jb.Scenario()], variables, objective, quantities=own)
    written = tuned_toml(problem.design, problem, "")
    assert tomllib.loads(written)["problem"]["objective"] == {}
    assert "# of a quantity of your own, whose function is elsewhere: effort = 1.0" in written


def test_a_scenario_list_that_is_no_grid_is_written_as_it_is():
    problem = loads((TYPED + CASES["samples"] + PROBLEM).encode(), "study.toml").problem()
    speeds = [(0.1, 0.0), (0.2, 0.01), (0.1, 0.01)]
    scenarios = [jb.Scenario(approach_speed=speed, misalignment=angle) for speed, angle in speeds]
    listed = dataclasses.replace(problem, scenarios=scenarios, scatter=problem.scatter)
    table = tomllib.loads(tuned_toml(listed.design, listed, ""))
    assert len(table["scenarios"]) == 3 * 4 and "sample" not in table["problem"]


SPEEDS = (0.05, 0.2, 0.1)  # m/s, the second one with the largest force


def numbered_problem(**more):
    listed = [jb.Scenario(approach_speed=speed) for speed in SPEEDS]
    return jb.Problem(jb.table2(), listed, [jb.Variable("buffer.k_A", 100.0, 3000.0)], **more)


def test_scenarios_keep_their_numbers_in_the_tuned_study():
    """`--scenario-number` counts them, so that their order is the problem's; [scenario] is the one that commands of one
    run take."""
    problem = numbered_problem()
    written = tuned_toml(problem.design, problem, "", problem.drawn[1].scenario)
    study = loads(written.encode(), "design.toml")
    assert [case.scenario.approach_speed for case in study.cases] == list(SPEEDS)
    assert study.scenario.approach_speed == 0.2
    assert [f"[[scenarios]]  # {k}: {v:g} m/s" in written for k, v in enumerate(SPEEDS, 1)] == [True] * 3


def test_a_scenario_without_a_number_does_not_get_that_of_the_first_one_run():
    """[[scenarios]] begin with the fields of [scenario], and TOML has no word for a number that is not set."""
    listed = [jb.Scenario(start="free"), jb.Scenario(start="free", thrust=1.0, thrust_time=0.5)]
    problem = jb.Problem(jb.table2(), listed, [jb.Variable("buffer.k_A", 100.0, 3000.0)])
    study = loads(tuned_toml(problem.design, problem, "", listed[1]).encode(), "design.toml")
    assert [case.scenario for case in study.cases] == listed


def test_a_corner_has_its_scenarios_number():
    problem = numbered_problem(tolerances={"buffer.c_A": "20 %"})
    numbers = ["1", "1.1", "1.2", "2", "2.1", "2.2", "3", "3.1", "3.2"]
    assert [problem.number_text(k) for k in range(9)] == numbers
    assert problem.label(4).startswith("2.1: 0.2 m/s, 0°, ") and problem.number(4) == 2
    one = dataclasses.replace(problem, scenarios=problem.scenarios[:1])
    assert one.label(0) == "1: 0.05 m/s, 0°", "as figures have it beside 1.1 and 1.2"
    alone = numbered_problem()
    assert dataclasses.replace(alone, scenarios=alone.scenarios[:1]).label(0) == "0.05 m/s, 0°", "it needs no number"
