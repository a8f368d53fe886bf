"""Scenarios have one numbering: what names a scenario that breaks a limit says the number that the study's list, tables
and `--scenario-number` have for it."""

import dataclasses
import json

import numpy as np
import pytest
from made_what_if import made_what_if

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.files import write
from jaxbuffer.output.folder import load
from jaxbuffer.output.tuned_files import tuned_files
from jaxbuffer.pages.compare import comparison
from jaxbuffer.pages.review import review
from jaxbuffer.tuning.problem.cases import Distribution, Scatter
from jaxbuffer.tuning.problem.own_quantities import check_start
from jaxbuffer.tuning.tolerances.corners import Corners, corner_in_sentence
from made_up import made_up_evaluation, made_up_tuning

SPEEDS = (0.1, 0.2, 0.15)  # m/s: the worst is no last one
STUDY = "[problem.constraints]\npeak_force = 240\n" + "\n".join(
    f"[[scenarios]]\napproach_speed = {speed}" for speed in SPEEDS
)


def tuning(speeds=SPEEDS, **limits):
    """A made-up tuning, whose peaks are 200 N and 40 N more from each scenario to the next."""
    variables = [jb.Variable("buffer.k_A", 100.0, 2000.0)]
    scenarios = [jb.Scenario(approach_speed=speed) for speed in speeds]
    stated = jb.Problem(jb.table2(), scenarios, variables, limits=jb.Limits(at_most=limits or {"peak_force": 210.0}))
    return made_up_tuning(stated)


def results_of(place, tuned):
    place.mkdir(exist_ok=True)
    for name, content in tuned_files(tuned).items():
        if name in ("tuned.json", "design.toml"):
            write(place / name, content())
    return load(place)


def test_sentences_of_a_tuning_name_a_scenario_with_its_number():
    """Peaks of 200, 240 and 280 N over a limit of 210 N."""
    tuned = tuning()
    (limit,) = tuned.broken_limits
    assert "peak_force ≤ 210 N: broken in 2 of 3 scenarios, worst 280 N at scenario 3 (0.15 m/s, 0°)" in limit
    starts = [line.split(": ")[0] for line in tuned.goal.broken(tuned.after)]
    assert starts == ["scenario 3 (0.15 m/s, 0°)", "scenario 2 (0.2 m/s, 0°)"]
    assert "by 33.3 % at scenario 3 (0.15 m/s, 0°)" in tuned.goal.obstacle(tuned.after)
    assert "of room to peak_force ≤ 281 N at scenario 3 (0.15 m/s, 0°)" in _nearest(281.0)
    (row,) = (line for line in repr(tuned).splitlines() if "≤ 210 N" in line and line.strip().startswith("peak"))
    assert "3: 0.15 m/s, 0°" in row and row.rstrip().endswith("broken")


def _nearest(limit):
    tuned = tuning(peak_force=limit)
    return tuned.goal.nearest_limit(tuned.after)


def test_a_single_scenario_needs_no_number():
    tuned = tuning((0.1,), peak_force=150.0)
    assert "worst 200 N at 0.1 m/s, 0°" in tuned.broken_limits[0]
    assert tuned.goal.broken(tuned.after)[0].startswith("0.1 m/s, 0°: ")


def test_a_corner_of_tolerances_has_its_scenarios_number():
    """Two scenarios in the two corners of one tolerance: the third and fourth corner are the second scenario's."""
    scenarios = [jb.Scenario(approach_speed=speed) for speed in (0.1, 0.2)]
    variables, tolerances = [jb.Variable("buffer.k_A", 100.0, 2000.0)], {"buffer.c_A": "10 %"}
    problem = jb.Problem(jb.table2(), scenarios, variables, tolerances=tolerances)
    broken, forces = ((), (), (), ("stroke 26 mm is above 25 mm",)), np.array([1.0, 2.0, 4.0, 3.0])
    corners = Corners(problem.corners, broken, forces, 3, 1, True, 205.0, True, True, "tolerances")
    first, worst, _ = corners.lines(problem)
    assert "the largest objective there is 4 N, at scenario 2 (0.2 m/s, 0°, 0.9 buffer.c_A)" in first
    assert worst.startswith(
        "the corner farthest beyond a limit, scenario 2 (0.2 m/s, 0°, 1.1 buffer.c_A): stroke 26 mm"
    )
    # In a tuning's sentences a corner has its own number behind that of its scenario.
    assert [problem.in_sentence(k).split(" (")[0] for k in range(6)] == [
        f"scenario {number}" for number in ("1", "1.1", "1.2", "2", "2.1", "2.2")
    ]
    sampled = dataclasses.replace(problem, scatter=Scatter(4, {"approach_speed": Distribution("uniform", 0.1, 0.3)}))
    assert corner_in_sentence(sampled, "0.2 m/s", 3, 4) == "0.2 m/s", "a corner is of no sample"


def test_an_error_at_the_start_names_the_scenario_with_its_number():
    own = {"ratio": jb.CustomQuantity(lambda peak_force: peak_force / 0.0, "N")}
    scenarios = [jb.Scenario(approach_speed=speed) for speed in SPEEDS]
    problem = jb.Problem(jb.table2(), scenarios, [jb.Variable("buffer.k_A", 100.0, 2000.0)], quantities=own)
    measured = np.full((3, len(problem.measured)), 200.0)
    with pytest.raises(
        jb.InputError, match=r"is inf at the start, scenario 2 \(0\.2 m/s, 0°\), where peak_force = 200 N"
    ):
        check_start(problem, measured, 1)


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_a_run_of_one_scenario_of_a_study_has_its_number(computed, capsys, tmp_path):
    """A made-up capture has 250 N, above 240 N; [scenario] that is none of the list has no number."""
    (tmp_path / "study.toml").write_text(STUDY)
    for number, options in (("1", []), ("2", ["--scenario-number", "2"])):
        assert run(["simulate", "study.toml", "--output", f"run{number}", *options]) == 1
        label = f"{SPEEDS[int(number) - 1]} m/s, 0°"
        heading = f"what stands in the way in scenario {number} ({label})"
        assert heading in capsys.readouterr().out
        assert heading in (tmp_path / f"run{number}" / "capture.txt").read_text()
        page = review([load(tmp_path / f"run{number}")])
        assert page.abstract[0].startswith(f"At scenario {number} ({label}) the capture ends")
        (section,) = (part for part in page.sections if part.title == "Limits")
        assert all(line[3] == f"{number}: {label}" for line in section.tables[0].rows if line[6].text == "broken")
    page = comparison([load(tmp_path / "run1"), load(tmp_path / "run2")])
    (ends,) = (table for part in page.sections for table in part.tables if table.caption == "How they ended")
    assert [cell.text for cell in ends.rows[0][1:]] == ["1: 0.1 m/s, 0°", "2: 0.2 m/s, 0°"]
    (tmp_path / "study.toml").write_text(f"[scenario]\napproach_speed = 0.3\n{STUDY}")
    run(["simulate", "study.toml", "--output", "own"])
    assert json.loads((tmp_path / "own" / "capture.json").read_text())["scenario_number"] == ""
    assert "At 0.3 m/s, 0° the capture ends" in review([load(tmp_path / "own")]).abstract[0]


def by_scenario(every):
    """The headings of rows of the forces of compared tunings."""
    page = comparison(every)
    (section,) = (part for part in page.sections if "by scenario" in part.title)
    return [row[0] for row in section.tables[0].rows]


def test_a_page_of_a_tuning_has_the_numbers(tmp_path):
    page = review([results_of(tmp_path, tuning())])
    (section,) = (part for part in page.sections if part.title == "Limits")
    assert any("worst 280 N at scenario 3 (0.15 m/s, 0°)" in line for line in section.warnings)
    beyond = next(table for table in section.tables if "the worst first" in table.caption)
    assert [row[0] for row in beyond.rows] == ["3: 0.15 m/s, 0°", "2: 0.2 m/s, 0°"]


def test_compared_tunings_of_one_list_have_one_number_a_scenario(tmp_path):
    every = [results_of(tmp_path / "a", tuning()), results_of(tmp_path / "b", tuning(SPEEDS[:2]))]
    assert by_scenario(every) == ["1: 0.1 m/s, 0°", "2: 0.2 m/s, 0°", "3: 0.15 m/s, 0°"]


def test_compared_tunings_that_number_scenarios_differently_say_whose_number_it_is(tmp_path):
    a, b = tmp_path / "a", tmp_path / "b"
    every = [results_of(a, tuning((0.1, 0.2))), results_of(b, tuning((0.2, 0.15)))]
    assert by_scenario(every) == [
        f"1 in {a}: 0.1 m/s, 0°",
        f"2 in {a}, 1 in {b}: 0.2 m/s, 0°",
        f"2 in {b}: 0.15 m/s, 0°",
    ]


def test_models_of_what_if_name_the_scenarios_with_their_numbers():
    what_if = made_what_if()
    assert [case["label"].split(":")[0] for case in what_if.record()["cases"]] == ["1", "2", "3"]
    # Where others decide nothing and are left out, numbers stay those of the study.
    fewer = dataclasses.replace(
        what_if, cases=what_if.cases[1:], models=what_if.models[1:], succeeded=what_if.succeeded[:, 1:],
        endings=what_if.endings[1:], left_out=1,
    )  # fmt: skip
    assert [case["label"].split(":")[0] for case in fewer.record()["cases"]] == ["2", "3"]


def test_numbers_are_those_of_the_written_study(tmp_path):
    tuned = tuning()
    results_of(tmp_path, tuned)
    text = (tmp_path / "design.toml").read_text()
    for k in range(3):
        assert f"[[scenarios]]  # {tuned.problem.label(k)}" in text
    point = made_up_evaluation(tuned.problem, tuned.problem.start())
    assert tuned.goal.broken(point)[0].startswith(f"scenario {tuned.problem.label(2)[0]} (")


def test_corners_of_compared_tunings_have_a_row_each(tmp_path):
    scenarios = [jb.Scenario(approach_speed=speed) for speed in (0.1, 0.2)]
    variables, tolerances = [jb.Variable("buffer.k_A", 100.0, 2000.0)], {"buffer.c_A": "10 %"}
    problem = jb.Problem(jb.table2(), scenarios, variables, tolerances=tolerances)
    rows = by_scenario([results_of(tmp_path / name, made_up_tuning(problem)) for name in ("a", "b")])
    assert [row.split(":")[0] for row in rows] == ["1", "1.1", "1.2", "2", "2.1", "2.2"]
    assert rows[2] == "1.2: 0.1 m/s, 0°, 1.1 buffer.c_A"
