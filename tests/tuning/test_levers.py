"""The levers of a limit: elasticities against differences of runs and against a derivative; where they are shown."""

import dataclasses

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.output.run_files import run_text
from jaxbuffer.tuning.problem.objective import Constraints
from jaxbuffer.tuning.report.levers import Lever, lever_table, run_levers, strongest, tuned_levers
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
    assert str(tuned.levers["first_impact"][0]) == "[cone.half_angle +0.84]" and "in brackets" in text


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
