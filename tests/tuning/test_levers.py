"""The levers of a limit: elasticities against differences of runs and against a derivative; where they are shown."""

import dataclasses

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cli.commands.levers import find_levers
from jaxbuffer.cli.entry import run
from jaxbuffer.output.run_files import run_text
from jaxbuffer.output.tuned_records import tuned_record
from jaxbuffer.tables import text
from jaxbuffer.tuning import assessment
from jaxbuffer.tuning.assessment import with_levers
from jaxbuffer.tuning.problem.objective import Constraints
from jaxbuffer.tuning.report.governing import governed_quantities
from jaxbuffer.tuning.report.levers import (
    ASK,
    Lever,
    lever_table,
    levers_by_numbers,
    run_levers,
    strongest,
    tuned_levers,
)
from jaxbuffer.tuning.search.goal import Goal
from jaxbuffer.tuning.search.measurement import Measurement
from made_up import made_up_capture, made_up_tuning


def stated(**limits):
    variables = [jb.Variable("buffer.k_A", 100.0, 2000.0), jb.Variable("buffer.c_A", 1.0, 60.0, "linear")]
    scenarios = [jb.Scenario(approach_speed=speed) for speed in (0.1, 0.15)]
    return jb.Problem(jb.table2(), scenarios, variables, limits=jb.Limits(at_most=limits))


def test_the_strongest_three_come_first_and_those_that_are_no_variables_stand_in_brackets():
    each = {"a.b": 0.1, "c.d": -0.8, "e.f": float("nan"), "g.h": 0.3, "i.j": -0.2, "k.l": 0.001}
    levers = strongest(each, {"c.d", "i.j"})
    assert [(it.path, it.variable) for it in levers] == [("c.d", True), ("g.h", False), ("i.j", True)]
    assert [str(it) for it in levers] == ["c.d -0.8", "[g.h +0.3]", "i.j -0.2"]
    assert strongest({"k.l": 0.001}, ()) == []


def test_elasticities_are_those_of_the_slopes_whatever_the_variable_s_scale():
    """A stroke that goes as k_A^-0.5 c_A^0.2."""
    tuned = made_up_tuning(stated(stroke=0.025))
    problem, point = tuned.problem, tuned.after
    column = problem.names.index("stroke") - 1
    values, rest, slopes = problem.values(point.scaled), point.rest.copy(), point.rest_slope.copy()
    rest[:, column] = (0.012, 0.016)
    for k, power in enumerate((-0.5, 0.2)):
        by_scaled = problem.variables[k].slope(float(values[k])) / float(values[k])
        slopes[:, column, k] = rest[:, column] * power * by_scaled
    point = point._replace(rest=rest, rest_slope=slopes)
    levers = tuned_levers(tuned.goal, point, None)["stroke"]
    assert [it.path for it in levers] == ["buffer.k_A", "buffer.c_A"] and all(it.variable for it in levers)
    assert [it.elasticity for it in levers] == pytest.approx([-0.5, 0.2], rel=1e-12)


def test_levers_stand_in_the_order_of_their_limits_and_last_the_first_impact():
    tuned = made_up_tuning(stated(stroke=0.025, hinge_angle=0.01))
    slopes = np.ones_like(tuned.after.rest_slope)
    bound = dataclasses.replace(tuned.lower_bound, elasticities={"cone.half_angle": 0.84, "probe.rod_mass": 0.31})
    tuned = dataclasses.replace(tuned, after=tuned.after._replace(rest_slope=slopes), lower_bound=bound)
    room = {it.limit.name: float(-it.numbers(tuned.after).max()) for it in tuned.goal.on_quantities}
    names = [name for name in tuned.levers if name != "first_impact"]
    assert names == sorted(names, key=lambda name: room[name]) and [*tuned.levers][-1] == "first_impact"
    text = repr(tuned)
    assert text.index("Limits: what") < text.index("Levers: change") < text.index("Objective") < text.index("Scenarios")
    assert str(tuned.levers["first_impact"][0]) == "[cone.half_angle +0.84]"
    assert "in brackets numbers that are no variables" in " ".join(text.split())


def test_the_limits_of_a_run_stand_behind_its_first_line():
    capture = made_up_capture()
    limits = Constraints(jb.Limits(at_most={"stroke": 0.025}), {})
    levers = {"stroke": [Lever("buffer.k_A", -0.4, True), Lever("active.mass", 0.3, False)]}
    first, second, *_ = run_text(capture, limits, "", levers).splitlines()
    assert first == repr(capture).splitlines()[0] and second.startswith("Limits: what stands in the way")
    text = run_text(capture, limits, "", levers)
    assert "buffer.k_A -0.4   [active.mass +0.3]" in text and text.endswith(repr(capture).splitlines()[-1])
    assert run_text(capture) == repr(capture)
    assert lever_table({}, capture.mechanism.quantities) is None


POWERS = {
    "stroke": {"buffer.k_A": -0.5, "active.mass": 0.4, "passive.mass": 0.3, "cone.length": 0.2, "probe.length": 0.1},
    "peak_force": {"buffer.k_A": 0.25, "cone.half_angle": 0.8},
}


class PowerLaws:
    """Stands in for an `Evaluator`: quantities are products of powers of the design's numbers."""

    tight = 1e-9

    def __init__(self, tuned):
        self.point, self.problem, self.runs = tuned.after, tuned.problem, []

    def by_numbers(self, scaled, cases, paths, rtol):
        places = [self.problem.cases.index(case) for case in cases]
        self.runs += [(place, rtol) for place in places]
        peaks, rest = self.point.peaks[places], self.point.rest[places]
        stroke = self.problem.names.index("stroke") - 1
        peaks_slope, rest_slope = np.zeros((*peaks.shape, len(paths))), np.zeros((*rest.shape, len(paths)))
        for k, path in enumerate(paths):
            peaks_slope[:, 0, k] = peaks[:, 0] * POWERS["peak_force"].get(path, 0.0)
            rest_slope[:, stroke, k] = rest[:, stroke] * POWERS["stroke"].get(path, 0.0)
        rows = {name: getattr(self.point, name)[places] for name in ("solved", "by_peak")}
        return self.point._replace(**rows, peaks=peaks, rest=rest, peaks_slope=peaks_slope, rest_slope=rest_slope)


def with_strokes(tuned, *strokes):
    """The tuning with these strokes [m] in its load cases."""
    rest = tuned.after.rest.copy()
    rest[:, tuned.problem.names.index("stroke") - 1] = strokes
    return dataclasses.replace(tuned, after=tuned.after._replace(rest=rest))


def test_levers_among_all_numbers_are_of_the_load_case_that_decides():
    """Of two captures the first has the larger stroke, the second the larger force."""
    tuned = with_strokes(made_up_tuning(stated(stroke=0.025)), 0.020, 0.010)
    evaluator = PowerLaws(tuned)
    levers = levers_by_numbers(tuned.goal, tuned.after, evaluator, tuned.problem.paths)
    assert evaluator.runs == [(0, 1e-9), (1, 1e-9)]
    assert [str(it) for it in levers["stroke"]] == [
        *("buffer.k_A -0.5", "[active.mass +0.4]", "[passive.mass +0.3]", "[cone.length +0.2]")
    ], "the strongest that is a variable, then three others"
    assert [str(it) for it in levers["objective"]] == ["buffer.k_A +0.25", "[cone.half_angle +0.8]"]
    assert [*levers] == ["stroke", "objective"]
    # one load case decides both: it alone is run again
    alone = PowerLaws(with_strokes(tuned, 0.010, 0.020))
    levers_by_numbers(tuned.goal, alone.point, alone, tuned.problem.paths)
    assert alone.runs == [(1, 1e-9)]


def test_levers_of_a_mean_are_those_of_all_load_cases():
    problem = dataclasses.replace(stated(stroke=0.025), objective=jb.Objective({"peak_force": 1.0}, over="mean"))
    tuned = made_up_tuning(problem)
    evaluator = PowerLaws(tuned)
    levers = levers_by_numbers(Goal(problem, problem.objective), tuned.after, evaluator, ())
    assert len(evaluator.runs) == 2
    assert levers["objective"][0] == pytest.approx(("cone.half_angle", 0.8, False))


def test_a_quantity_with_two_limits_is_at_the_nearer_one():
    """A stroke from 10 to 20 mm is farther below its upper limit than the smaller is above its lower one."""
    problem = dataclasses.replace(
        stated(), limits=jb.Limits(at_most={"stroke": 0.025}, at_least={"stroke": 0.0099}, require_success=False)
    )
    tuned = with_strokes(made_up_tuning(problem), 0.020, 0.010)
    stroke, objective = governed_quantities(tuned.goal, tuned.after)
    assert (stroke.name, stroke.weights, stroke.value) == ("stroke", {1: 1.0}, 0.010)
    assert stroke.room == pytest.approx(0.1 / 9.9) and objective.name == "objective"


LATCHED = jb.replace(jb.table2(), {"latch.stiffness": 2000.0, "latch.damping": 50.0, "latch.strength": 50.0})


@pytest.mark.parametrize(
    ("last", "name", "value"),
    [("held", "settling_time", 4.0), ("latched", "relative_energy", 0.02), ("escaped", "", 0)],
)
def test_an_end_is_decided_where_its_margin_is_least(last, name, value):
    """The second scenario is held last, or not at all: then what is left decides, and of one that escapes nothing."""
    problem = dataclasses.replace(stated(), design=LATCHED, limits=jb.Limits(ends=("held",)))
    tuned = made_up_tuning(problem)
    rest, names = tuned.after.rest.copy(), problem.names
    rest[:, names.index("settling_time") - 1], rest[:, names.index("relative_energy") - 1] = (3.0, 4.0), (0.001, 0.02)
    code = np.array([int(problem.mechanism.outcomes[it]) for it in ("held", last)])
    decided = governed_quantities(tuned.goal, tuned.after._replace(rest=rest, code=code, margin=np.array([0.5, 0.2])))
    shown = [(it.name, it.value, it.weights) for it in decided if it.name != "objective"]
    assert shown == ([(name, value, {1: 1.0})] if name else [])


def test_a_run_that_fails_with_derivatives_has_no_levers():
    tuned = made_up_tuning(stated(stroke=0.025))
    evaluator = PowerLaws(tuned)
    evaluator.point = tuned.after._replace(solved=np.zeros(2, bool))
    assert levers_by_numbers(tuned.goal, tuned.after, evaluator, ()) == {}


def test_a_slope_that_is_not_known_costs_no_other():
    stroke = Measurement.lost(stated())._replace(rest_slope=np.array([[np.nan, 2.0], [np.inf, -1.0]]))
    assert stroke.of_known_slopes().rest_slope.tolist() == [[0.0, 2.0], [0.0, -1.0]]


def test_other_levers_stand_below_the_variables_and_in_the_record():
    tuned = made_up_tuning(stated(stroke=0.025))
    levers = levers_by_numbers(tuned.goal, tuned.after, PowerLaws(tuned), tuned.problem.paths)
    shown = text(lever_table(levers, tuned.problem.catalogue)).splitlines()
    first = next(k for k, line in enumerate(shown) if "-0.5" in line)
    assert shown[first].split()[-3:] == ["stroke", "buffer.k_A", "-0.5"]
    assert shown[first + 1].split()[:2] == ["[active.mass", "+0.4]"] and len(shown[first + 1].split()) == 6
    assert ASK in " ".join(repr(tuned).split())
    others = {name: [it for it in each if not it.variable] for name, each in levers.items()}
    tuned = dataclasses.replace(tuned, others=others)
    assert ASK not in " ".join(repr(tuned).split()) and "[cone.half_angle +0.8]" in repr(tuned)
    record = tuned_record(tuned)["levers"]["stroke"]
    assert record[0] == {"path": "active.mass", "elasticity": pytest.approx(0.4), "variable": False}


def test_levers_that_cannot_be_found_are_a_remark(monkeypatch):
    tuned = made_up_tuning(stated(stroke=0.025))

    def fails(*_):
        raise MemoryError("no more\nat all")

    monkeypatch.setattr(assessment, "levers_by_numbers", fails)
    after = with_levers(tuned)
    why = "missing: levers among all numbers of the design, which could not be computed: no more"
    assert after.missing == (why,) and after.others == {} and why in " ".join(repr(after).split())
    assert after.design is tuned.design and after.levers == tuned.levers


def test_ctrl_c_leaves_levers_out_and_nothing_else(capsys):
    def stopped(_):
        raise KeyboardInterrupt

    assert find_levers("the result", stopped) == ("the result", True)
    assert find_levers("the result", lambda it: f"{it} with levers") == ("the result with levers", False)
    assert "levers took 0.0 s" in capsys.readouterr().err


def test_a_command_whose_levers_are_interrupted_saves_all_else(monkeypatch, tmp_path, capsys, no_figures):
    tuned = made_up_tuning(stated(stroke=0.025))

    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("jaxbuffer.cli.commands.tune.compute", lambda *_, **__: tuned)
    monkeypatch.setattr("jaxbuffer.cli.commands.tune.with_levers", stopped)
    assert run(["tune", "--levers", "on", "--output", str(tmp_path / "out")]) == 130
    assert "all but the levers is there; the same command with --resume goes on in" in capsys.readouterr().err
    assert jb.load(tmp_path / "out").tuned["message"] == tuned.message
    assert run(["tune", "--levers", "off"]) == 0 and "levers took" not in capsys.readouterr().err
    for command in ("tune", "choose"):
        assert run([command, "--levers", "often"]) == 2
        assert "levers = 'often' is unknown; choose one of on, off" in capsys.readouterr().err


@pytest.mark.slow
def test_the_levers_of_a_run_are_those_of_differences():
    """Among all numbers of a drop's design, by the central difference of runs at a tight tolerance."""
    design, scenario = jb.BarDrop(), jb.BarDropScenario(height=0.194)
    run = jb.simulate(design, scenario, 0.22, rtol=1e-9)
    levers = run_levers(run, ("peak_force",), (), 0.22, 1e-9, "automatic")["peak_force"]
    assert len(levers) == 3 and abs(levers[0].elasticity) >= abs(levers[1].elasticity)
    for it in levers:
        value = float(jb.get(design, it.path))
        low, high = (
            float(jb.simulate(jb.replace(design, {it.path: value * share}), scenario, 0.22, rtol=1e-11).peak_force)
            for share in (1.0 - 1e-4, 1.0 + 1e-4)
        )
        assert it.elasticity == pytest.approx((high - low) / (2e-4 * float(run.peak_force)), rel=1e-3)


def harm(peak_force, penetration):  # N, m
    return (peak_force / 700.0) ** 2 + (penetration / 1e-4) ** 3


@pytest.mark.slow
def test_the_levers_of_a_tuning_are_those_of_differences():
    """Of an own quantity and an objective, in the load case that decides each, one built otherwise than it is drawn."""
    cases = [
        jb.Case(jb.BarDropScenario(height=0.19), (("impact.stiffness", 0.8), ("bar.diameter", 1.1))),
        jb.Case(jb.BarDropScenario(height=0.2)),
    ]
    problem = jb.Problem(
        jb.replace(jb.BarDrop(), {"impact.damping": 0.0}),
        cases,
        [jb.Variable("impact.stiffness", 1e10, 1e12)],
        limits=jb.Limits(at_most={"harm": 30.0}),
        duration=0.25,
        quantities={"harm": jb.CustomQuantity(harm, "-", "how much force and depth hurt")},
    )
    tuned = jb.tune(problem, starts=1, iterations=1, levers=True)
    assert tuned.missing == () and [*tuned.levers] == ["harm", "objective"]

    def value(name, case, path, share):
        drawn = jb.replace(tuned.design, {path: share * float(jb.get(tuned.design, path))})
        run = jb.simulate(case.of(drawn), case.scenario, 0.25, rtol=1e-11)
        force = float(run.quantity("peak_force"))
        return force if name == "objective" else harm(force, float(run.quantity("penetration")))

    for name, levers in tuned.levers.items():
        deciding = max(cases, key=lambda case: value(name, case, "bar.length", 1.0))
        assert sum(not it.variable for it in levers) == 3 and any(it.variable for it in levers)
        for it in levers:
            low, high, here = (value(name, deciding, it.path, share) for share in (1.0 - 1e-4, 1.0 + 1e-4, 1.0))
            assert it.elasticity == pytest.approx((high - low) / (2e-4 * here), rel=1e-3), (name, it.path)
