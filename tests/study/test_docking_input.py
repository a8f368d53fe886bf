"""Latches, free starts and measured curves, as studies, command lines, files and pages take them."""

import json
import tomllib

import jsonschema
import numpy as np
import pytest

import jaxbuffer
from jaxbuffer import InputError, Problem, Scenario, Variable, get, load_design, replace, save_design, table2
from jaxbuffer.cli.entry import run
from jaxbuffer.labelled.record import part_from_json, part_json, part_record
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.pages.records import same
from jaxbuffer.study.explained import explained
from jaxbuffer.study.load import load, loads
from jaxbuffer.study.overrides import apply_overrides
from jaxbuffer.study.schema import study_schema
from jaxbuffer.study.tuned_toml import tuned_toml
from jaxbuffer.sweeps.grid import grid

SPRING, DAMPER = "buffer.spring_curve", "buffer.damper_curve"
STUDY = """
[buffer]
spring_curve = [["5 mm", "2 N"], ["10 mm", "6 N"]]
damper_curve = [[0.05, 0.2], [0.1, 0.6]]
[latch]
stiffness = "200 kN/m"
damping = 500
[scenario]
start = "free"
offset = "-5 mm"
[problem.variables]
buffer.k_T = [50, 1500]
buffer.spring_curve."force[1]" = ["3 N", "9 N"]
[problem.constraints]
peak_latch_force = "200 N"
[sweep]
"buffer.spring_curve.force[1]" = [5, 6, 7]
scenario.offset = ["-5 mm", "5 mm"]
[sample.ranges]
buffer.spring_curve."stroke[0]" = [0.004, 0.006]
scenario.lateral_speed = [-0.01, 0.01]
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    return load(tmp_path / "study.toml")


def points(design, path=SPRING):
    return np.array(get(design, path).points(), float).tolist()


def test_a_study_has_curves_in_any_unit_latches_and_free_starts(study):
    buffer = study.design.buffer
    assert points(study.design) == [[0.005, 2.0], [0.01, 6.0]] and points(study.design, DAMPER) == [
        [0.05, 0.2],
        [0.1, 0.6],
    ]
    assert buffer.k_A is None and buffer.c_A is None, "the curves stand for them"
    assert study.design.latch.stiffness == 2e5 and study.scenario == Scenario(start="free", offset=-0.005)
    assert study.options.duration == 20.0, "the latch runs on"
    problem = study.problem()
    assert problem.paths == ("buffer.k_T", f"{SPRING}.force[1]") and problem.limits.at_most["peak_latch_force"] == 200.0
    assert grid(study.sweep, study.design, study.scenario).shape == (3, 2)


def test_the_command_line_replaces_curves_and_their_numbers(study):
    typed = apply_overrides(study, {SPRING: '[["4 mm", 1], [0.01, 7]]'.replace("1]", '"1 N"]').replace("7]", '"7 N"]')})
    assert points(typed.design)[0] == [0.004, 1.0]
    assert points(apply_overrides(study, {f"{SPRING}.force[1]": "8 N"}).design) == [[0.005, 2.0], [0.01, 8.0]]
    plain = load(None)
    assert plain.options.duration == 8.0
    latched = apply_overrides(plain, {"latch.stiffness": "200 kN/m", SPRING: "[[0.01, 5]]"})
    assert latched.options.duration == 20.0 and latched.design.buffer.k_A is None


def test_a_duration_that_is_given_stays(tmp_path):
    (tmp_path / "study.toml").write_text("[options]\nduration = 8")
    latched = apply_overrides(load(tmp_path / "study.toml"), {"latch.stiffness": "2e5"})
    assert latched.options.duration == 8.0
    assert latched.varying(["latch.stiffness"]).options.duration == 8.0


def test_runs_that_get_a_latch_by_what_varies_last_as_long_as_others_with_one():
    assert load(None).varying(["latch.stiffness"]).options.duration == 20.0
    assert load(None).varying(["buffer.k_A"]).options.duration == 8.0
    assert PROBE_CONE.defaults_for(table2(), ["latch.stiffness"]) == PROBE_CONE.defaults_for(
        replace(table2(), {"latch.stiffness": 2e4})
    )


def test_a_tuned_design_has_its_curves_in_the_units_that_were_typed(study):
    written = tuned_toml(study.design, study.problem(), "")
    assert 'spring_curve = [["5 mm", "2 N"], ["10 mm", "6 N"]]  # stroke, force' in written
    assert "damper_curve = [[0.05, 0.2], [0.1, 0.6]]  # speed m/s, force N" in written
    assert loads(written.encode(), "tuned.toml").design == study.design


def test_designs_with_curves_are_written_and_read_again(study, tmp_path):
    save_design(tmp_path / "design.toml", study.design, [study.scenario])
    assert load_design(tmp_path / "design.toml") == (study.design, (study.scenario,))
    assert part_from_json(table2(), part_json(study.design)) == study.design
    assert part_from_json(study.design, part_json(table2())) == table2()
    as_record = json.loads(json.dumps(part_record(study.design)))
    assert same(as_record[SPRING], study.design.buffer.spring_curve) and not same(
        None, study.design.buffer.spring_curve
    )
    several = replace(study.design, {f"{SPRING}.force[1]": [6.0, 7.0]})
    with pytest.raises(InputError, match=r"force\[1\] has shape \(2,\)"):
        save_design(tmp_path / "two.toml", several)


def test_check_says_what_there_is(study, computed, capsys, tmp_path):
    words = explained(study, "study.toml")
    for part in (
        f'{SPRING} [["5 mm", "2 N"], ["10 mm", "6 N"]] (default not set)',
        "buffer.k_A not set (default 500 N/m)",
        f"{SPRING}.force[1] in [3, 9] N, log, from 6 N",
        "by buffer.k_T, buffer.c_T, probe.tip_mass",
        "duration 20 s",
    ):
        assert part in words
    assert run(["check", "study.toml"]) == 0
    assert "spring_curve=[[0.005, 2.0], [0.01, 6.0]]" in str(study.design)


def test_defaults_leave_out_what_a_curve_stands_for_and_depend_on_the_latch(study):
    assert PROBE_CONE.parameters(study.design) == ("buffer.k_T", "buffer.c_T", "probe.tip_mass")
    assert set(PROBE_CONE.variables(study.design)) == set(PROBE_CONE.parameters(study.design))
    assert PROBE_CONE.parameters(table2()) == PROBE_CONE.defaults.parameters
    assert "peak_latch_force" in PROBE_CONE.defaults_for(study.design).differentiated
    assert PROBE_CONE.defaults_for(table2()) == PROBE_CONE.defaults


def test_the_schema_takes_curves_and_their_numbers():
    schema = jsonschema.Draft7Validator(study_schema(PROBE_CONE))
    assert not list(schema.iter_errors(tomllib.loads(STUDY)))
    for bad in (
        "[buffer]\nspring_curve = [[0.01, -2]]",
        "[buffer]\nspring_curve = [0.01, 2]",
        "[sweep]\n'buffer.spring_curve.forces[1]' = [1]",
        "[sweep]\nbuffer.spring_curve = [1]",
    ):
        assert list(schema.iter_errors(tomllib.loads(bad))), bad


def test_bounds_of_a_curves_points_must_keep_it_rising(study):
    def problem(*bounds):
        variables = [Variable(f"{SPRING}.force[{k}]", *ends) for k, ends in enumerate(bounds)]
        return Problem(study.design, [study.scenario], variables)

    assert problem((1.0, 4.0), (4.5, 9.0)).paths == (f"{SPRING}.force[0]", f"{SPRING}.force[1]")
    with pytest.raises(
        InputError, match=r"force\[0\] in \[1, 5\] N and force\[1\] in \[4, 9\] N overlap: .* points rise"
    ):
        problem((1.0, 5.0), (4.0, 9.0))
    with pytest.raises(
        InputError, match=r"force\[0\] = 7 N must be above|force\[1\] = 6 N must be above force\[0\] = 7 N"
    ):
        problem((1.0, 7.0))


@pytest.mark.long
def test_folders_and_pages_have_the_curves(computed, capsys, tmp_path):
    """Of a run, of another one whose curve is another, and of a tuning by a point of the curve; the made-up runs have
    no latch."""
    without = STUDY.replace('[latch]\nstiffness = "200 kN/m"\ndamping = 500\n', "").replace(
        "peak_latch_force", "stroke"
    )
    (tmp_path / "study.toml").write_text(without.replace('"200 N"', '"25 mm"'))
    study = load(tmp_path / "study.toml")
    assert run(["simulate", "study.toml", "--output", "a"]) == 0
    assert run(["simulate", "study.toml", f"--{SPRING}.force[1]", "7 N", "--output", "b"]) == 0
    assert jaxbuffer.load("a").design == study.design
    assert run(["tune", "study.toml", "--output", "t"]) in (0, 1)
    tuned = load(tmp_path / "t" / "design.toml").design
    assert points(tuned)[0] == [0.005, 2.0] and points(tuned)[1] != [0.01, 6.0]
    assert run(["report", "a", "t"]) == 0
    assert run(["compare", "a", "b"]) == 0
    assert "[[0.005, 2.0], [0.01, 7.0]]" in (tmp_path / "a" / "compare.html").read_text()
    assert "[[0.005, 2.0], [0.01, 6.0]]" in (tmp_path / "a" / "report.html").read_text()


def test_a_sweep_takes_the_approach_and_a_curves_numbers(study, tmp_path):
    """Grids, samples and scatter: the fields of an approach, and the numbers of a curve, are fields like any."""
    (tmp_path / "more.toml").write_text(
        STUDY
        + "[problem.grid]\noffset = ['-5 mm', '5 mm']\nactive_angle = ['-1 deg', '1 deg']\n"
        + "[problem.sample]\ncount = 3\nscenario.active_rate = {uniform = [-0.01, 0.01]}\n"
        + 'factors.buffer.spring_curve."force[1]" = {uniform = [0.9, 1.1]}\n'
    )
    problem = load(tmp_path / "more.toml").problem()
    assert len(problem.cases) == 3 * 2 * 2
    design = problem.cases[0].of(problem.design)
    assert points(design)[1][1] == pytest.approx(6.0 * dict(problem.cases[0].factors)[f"{SPRING}.force[1]"])
    swept, scenarios = grid(study.sweep, study.design, study.scenario).applied(study.design, study.scenario)
    assert np.shape(swept.buffer.spring_curve.values[1]) == (6,) and np.shape(scenarios.offset) == (6,)
