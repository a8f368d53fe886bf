"""[tolerances] and numbers that stand with their tolerance; values of the design's numbers in [problem.grid]."""

import math

import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.study.explained import explained
from jaxbuffer.study.load import loads
from jaxbuffer.study.overrides import apply_overrides
from jaxbuffer.study.schema import study_schema
from jaxbuffer.study.tuned_toml import tuned_toml

STUDY = """
buffer.k_A = {value = "0.5 kN/m", tolerance = "10 %"}
[scenario]
misalignment = {value = "2 deg", tolerance = ["-0.5 deg", "1 deg"]}
[problem.variables]
buffer.c_A = [1, 60]
[problem.grid]
approach_speed = ["10 cm/s", "20 cm/s"]
contact.friction = {from = 0.1, to = 0.2, count = 2}
[tolerances]
buffer.c_A = "20 %"
probe.tip_radius = "0.5 mm"
contact.friction = 0.05
"""


def problem_of(text):
    return loads(text.encode(), "s.toml").problem()


def test_every_corner_at_every_point_of_a_grid_is_built_as_by_hand():
    problem = problem_of(STUDY)
    assert len(problem.drawn) == 4 and len(problem.corners) == 4 * 32 and len(problem.cases) == 4 * 33
    tuned = jb.replace(problem.design, {"buffer.c_A": 7.0})
    built = set()
    for case in problem.corners:
        made, at = case.of(tuned), case.scenario
        built.add(
            (
                round(made.buffer.k_A, 9),
                round(made.buffer.c_A, 9),
                round(made.probe.tip_radius, 9),
                round(made.contact.friction, 9),
                round(math.degrees(at.misalignment), 9),
                at.approach_speed,
            )
        )
    radius = problem.design.probe.tip_radius
    by_hand = {
        (k, c, round(radius + r, 9), round(f + df, 9), m, v)
        for k in (450.0, 550.0)
        for c in (5.6, 8.4)  # 20 % of the tuned number, not of the study's
        for r in (-0.0005, 0.0005)
        for f in (0.1, 0.2)
        for df in (-0.05, 0.05)
        for m in (1.5, 3.0)
        for v in (0.1, 0.2)
    }
    assert built == by_hand


def test_the_cases_as_drawn_are_without_tolerances():
    problem = problem_of(STUDY)
    assert problem.cases[::33] == problem.drawn
    assert all(
        case.factors == case.shifts == () and case.scenario.misalignment == math.radians(2) for case in problem.drawn
    )


def test_a_tuned_study_says_the_same_problem():
    problem = problem_of(STUDY)
    assert problem_of(tuned_toml(problem.design, problem, "tuned")).fingerprint() == problem.fingerprint()


def test_a_value_typed_on_the_command_line_keeps_its_tolerance():
    study = apply_overrides(loads(STUDY.encode(), "s.toml"), {"buffer.k_A": "1 kN/m"})
    assert study.problem().corners[0].of(study.design).buffer.k_A in (900.0, 1100.0)


def test_check_and_schema_know_tolerances():
    text = explained(loads(STUDY.encode(), "s.toml"), "s.toml")
    assert "32 corners at each of 4 scenarios" in text and "scenario.misalignment -0.5 to +1 deg" in text
    schema = study_schema(problem_of("").mechanism)["properties"]
    (pair,) = [it for it in schema["buffer"]["properties"]["k_A"]["anyOf"] if it["type"] == "object"]
    assert set(pair["required"]) == {"value", "tolerance"}
    assert {"buffer", "scenario.misalignment"} < set(schema["tolerances"]["properties"])
    assert "buffer.k_A" in schema["problem"]["properties"]["grid"]["properties"]


WRONG = {
    '[tolerances]\nbuffer.k_B = "10 %"': "tolerances: buffer.k_B is unknown; did you mean buffer.k_A?",
    '[tolerances]\napproach_speed = "5 %"': "approach_speed is unknown; did you mean scenario.approach_speed?",
    "[tolerances]\nbuffer.k_A = 10": 'tolerances.buffer.k_A = 10 has no unit; write "10 N/m", or "10 %" of the number',
    '[tolerances]\nbuffer.k_A = "10 mm"': "tolerances.buffer.k_A = '10 mm': mm is a length, expected a number in N/m",
    "[tolerances]\nbuffer.k_A = nan": "tolerances.buffer.k_A = nan is no tolerance; write",
    '[tolerances]\nbuffer.k_A = "nan N/m"': "is no tolerance; write",
    "[tolerances]\nbuffer.k_A = true": "tolerances.buffer.k_A = True is no tolerance",
    '[tolerances]\nbuffer.k_A = "-10 %"': "a tolerance is above 0",
    '[tolerances]\nbuffer.k_A = "0 %"': "a tolerance is above 0",
    '[tolerances]\nbuffer.k_A = ["1 %", "2 %"]': "a pair goes from at most 0 to at least 0",
    '[tolerances]\nbuffer.k_A = ["-1 %", "2 N/m"]': "write both sides in per cent, or both in N/m",
    '[tolerances]\nbuffer.k_A = ["-1 %"]': "is no tolerance; write",
    '[tolerances]\nbuffer.k_A = "100 %"': "±100 % leads out of the allowed range: buffer.k_A = 0 N/m is out of range;"
    " allowed: (0, inf) N/m",
    '[tolerances]\nprobe.tip_radius = "1 m"': "leads out of the allowed range: probe.tip_radius = -0.985 m is out of",
    '[tolerances]\nbuffer.c_A = ["-2 N s/m", "0 N s/m"]\n[problem.variables]\nbuffer.c_A = [1, 60]': "-2 to +0 N s/m"
    " leads out of the allowed range: buffer.c_A = -1 N s/m is out of range; allowed: [0, inf) N s/m",
    '[tolerances]\ncontact.stiffness = "10 %"': "contact.stiffness is not set",
    '[tolerances]\ncontact.law = "10 %"': "contact.law is a choice; only numbers have tolerances",
    '[tolerances]\nbuffer.spring_curve = "10 %"': "is a measured curve, whose numbers are buffer.spring_curve.force[0]",
    '[tolerances]\nscenario.misalignment = "10 %"': "scenario.misalignment is 0, of which a share is nothing;"
    " give the tolerance in rad",
    '[tolerances]\nbuffer = "10 %"': "it is a section; name one of its fields",
    "buffer.k_A = {value = 500, tol = 1}": "buffer.k_A = {'value': 500, 'tol': 1}; write k_A = {value = …, tolerance",
    'buffer.k_A = {value = 500, tolerance = "1 %"}\n[tolerances]\nbuffer.k_A = "2 %"': "has a tolerance in its own"
    " table and in [tolerances]; keep one",
    'buffer.k_A = {value = "500 mm", tolerance = "1 %"}': "mm is a length, expected a number in N/m",
    "tolerances = 3": "tolerances = 3 is not a table",
    "[problem.grid]\nbuffer.k_A = [100, 200]": "buffer.k_A is tuned, and the scenarios list values of it",
    "[problem.grid]\nbuffer.k_B = [100, 200]": "problem.grid.buffer.k_B is unknown; did you mean buffer.k_A?",
    "[problem.grid]\nprobe.tip_radius = [-1]": "probe.tip_radius = -1",
}


@pytest.mark.parametrize(("text", "said"), WRONG.items(), ids=[it.partition("\n")[2] or it for it in WRONG])
def test_bad_tolerances_are_named_with_what_would_do(text, said):
    with pytest.raises(jb.InputError) as error:
        problem_of(text)
    assert said in str(error.value)


@pytest.mark.parametrize("text", [*WRONG][:8])
def test_bad_tolerances_end_commands_with_code_2(text, tmp_path, capsys):
    file = tmp_path / "s.toml"
    file.write_text(text)
    for command in ("check", "tune"):
        assert run([command, str(file)]) == 2
        shown, errors = capsys.readouterr()
        assert errors.count("\n") == 1 and "Traceback" not in errors and not shown
    assert [it.name for it in tmp_path.iterdir()] == ["s.toml"]


def test_python_takes_the_same_and_tolerance_objects():
    design, variables = jb.table2(), [jb.Variable("buffer.c_A", 1.0, 60.0)]
    by_text = jb.Problem(design, [jb.Scenario()], variables, tolerances={"buffer.k_A": "±10 %"})
    by_object = jb.Problem(design, [jb.Scenario()], variables, tolerances={"buffer.k_A": jb.Tolerance(-0.1, 0.1, True)})
    assert by_text.cases == by_object.cases and len(by_text.cases) == 3
    with pytest.raises(jb.InputError, match="must go from at most 0 to at least 0"):
        jb.Tolerance(0.1, 0.2)
    with pytest.raises(jb.InputError, match="tolerances"):
        jb.Problem(design, [jb.Scenario()], variables, tolerances=["buffer.k_A"])
