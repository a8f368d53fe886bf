"""Fronts: which points are on them, and one that has a closed form."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.tuning.pareto import limits_between
from jaxbuffer.tuning.report.front import dominated

EXPONENT = 2.2
LIMITS = (2e-4, 1e-4, 5e-5)  # m
STUDY = """kind = "bar_drop"
[impact]
damping = 0.0
[options]
duration = 0.25
[problem.variables]
impact.stiffness = [1e9, 1e13]
[problem.constraints]
penetration = 1e-3
[tune]
starts = 1
iterations = 20
"""


def test_a_point_is_dominated_by_one_that_is_nowhere_worse():
    values = np.array([[1.0, 4.0], [2.0, 2.0], [2.0, 3.0], [4.0, 1.0], [2.0, 2.0], [0.5, 0.5]])
    feasible = np.array([True, True, True, True, True, False])
    assert dominated(values, feasible).tolist() == [False, False, True, False, True, False]


def test_points_that_differ_by_rounding_are_one():
    values = np.array([[149.174489, 0.017], [149.174489 * (1 + 1e-9), 0.017 * (1 - 1e-9)], [149.18, 0.0169]])
    assert dominated(values, np.ones(3, bool)).tolist() == [False, True, False]


def test_limits_reach_over_all_ends():
    """The stroke's least end has the largest angle: limits on the angle must reach up to it."""
    stroke, angle = limits_between(np.array([[17.0, 0.68], [1.0, 2.08], [16.0, 0.67]]), 3)
    np.testing.assert_allclose(stroke, [17.0, 9.0, 1.0], rtol=1e-3)
    np.testing.assert_allclose(angle, [2.08, 1.375, 0.67], rtol=1e-3)


@pytest.mark.parametrize(
    ("objectives", "points", "limits", "said"),
    [
        (["peak_force"], 3, None, "needs two at least; peak_force,penetration say; known: peak_force, "),
        (["peak_force", "penetratio"], 3, None, "did you mean penetration?"),
        (["peak_force", "penetration"], 1, None, "points"),
        (["peak_force", "penetration", "end_time"], 40, None, "at most 400"),
        (["peak_force", "penetration"], 3, {"end_time": [0.1]}, "needed: penetration"),
    ],
)
def test_what_makes_no_front_is_refused(objectives, points, limits, said):
    problem = jb.Problem(jb.BarDrop(), [jb.BarDropScenario()], [jb.Variable("impact.stiffness", 1e10, 1e12)])
    with pytest.raises(jb.InputError) as refused:
        jb.pareto(problem, objectives, points, limits=limits)
    assert said in str(refused.value)


@pytest.mark.slow
def test_the_front_of_force_and_depth_is_the_hyperbola_of_constant_energy(evidence, tmp_path):
    """Without damping F δ = (e + 1) m g (H + δ) / 2 whatever the stiffness."""
    design = jb.replace(jb.BarDrop(), {"impact.damping": 0.0})
    scenario, stiffness = jb.BarDropScenario(), jb.Variable("impact.stiffness", 1e9, 1e13)
    problem = jb.Problem(design, [scenario], [stiffness], duration=0.25)
    asked = {"limits": {"penetration": LIMITS}, "starts": 1, "iterations": 20, "folder": tmp_path}
    front = jb.pareto(problem, ["peak_force", "penetration"], **asked)
    assert front.non_dominated.all() and front.limits[:, 0].tolist() == list(LIMITS)
    force, depth = front.values.T
    bar = design.bar
    weight = 9.81 * bar.density * np.pi / 4 * bar.diameter**2 * bar.length
    error = np.max(np.abs(force * depth / ((EXPONENT + 1) * weight * (scenario.height + depth) / 2) - 1.0))
    source = "energy: F δ = (e + 1) m g (H + δ) / 2"
    evidence("Fronts", "peak force against penetration of a bar's impact", error, 1e-4, source, "-")
    below = np.max(np.abs(depth / np.array(LIMITS) - 1.0))
    evidence("Fronts", "distance of each point from its limit", below, 2e-3, "the limit itself is the best depth", "-")
    again = jb.pareto(problem, ["peak_force", "penetration"], **asked, resume=True)
    assert np.array_equal(again.values, front.values)


@pytest.mark.slow
def test_files_of_a_front(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY)
    command = ["pareto", "study.toml", "--objectives", "peak_force,penetration", "--points", "2", "--output", "out"]
    assert run(command) == 0
    names = {path.name for path in (tmp_path / "out").iterdir() if path.is_file()}
    written = {f"pareto.{kind}" for kind in ("csv", "png", "txt", "json")}
    assert names == {*written, "design-1.toml", "design-2.toml", "front.json"}
    assert "2 of 2 points are on the front" in capsys.readouterr().out
    assert run(command) == 2
    assert "--resume goes on" in capsys.readouterr().err
    assert run([*command, "--resume"]) == 0
    assert run(["pareto", "study.toml", "--objectives", "peak_force,penetratoin"]) == 2
    assert "did you mean penetration?" in capsys.readouterr().err
