"""Why a tuning is infeasible: broken limits by their number, the worst first, and what holds each back."""

import numpy as np

from jaxbuffer import Outcome
from jaxbuffer.tuning.report.broken_limits import broken_limits
from jaxbuffer.tuning.search.evaluation import Evaluation
from jaxbuffer.tuning.search.goal import Goal
from tuning.analytic import Functions, Limits, problem

LOW, HIGH = [1.0, 1.0], [10.0, 4.0]


def broken(limits, hinge, at, peak=lambda x: x[0], margin=None, cases=3):
    stated = problem(LOW, HIGH, [2.0, 2.0], cases, limits=limits)
    goal = Goal(stated, stated.objective)
    evaluate = Functions(
        stated, [[lambda x, k=k: peak(x) + k] for k in range(cases)], {"peak_hinge_force": hinge}, margin
    )
    point: Evaluation = evaluate.one(np.array([v.scaled(x) for v, x in zip(stated.variables, at, strict=True)]))
    return goal, point, broken_limits(goal, point)


def test_a_variable_at_its_bound_holds_a_limit_back():
    """h = 100 - 20 y at y = 4, its high bound: 20 N, 10 N above 10 N; 1 % of 4 brings -0.8 N, or -4 % of h; as a power
    of y, h = 20 (y / 4)^-4 is 10 at y = 4 · 2^(1/4) = 4.76."""
    _, _, (limit,) = broken(Limits(at_most={"peak_hinge_force": 10.0}), lambda x: 100.0 - 20.0 * x[1], [5.0, 4.0])
    assert limit.excess == 1.0
    where = "scenario 1 (0.1 m/s, 0°)"
    assert limit.heading == f"peak_hinge_force ≤ 10 N: broken in 3 of 3 scenarios, worst 20 N at {where}"
    assert (
        limit.reason == "it would fall with buffer.c_A above its bound of 4 N s/m, to about 4.8 N s/m (-0.8 N per 1 %)"
    )


def test_a_lower_limit_and_a_low_bound():
    """h = 1/x at x = 1, the low bound, must be at least 2: 1 % less brings +0.01."""
    _, _, (limit,) = broken(Limits(at_least={"peak_hinge_force": 2.0}), lambda x: 1.0 / x[0], [1.0, 2.0])
    assert "peak_hinge_force ≥ 2 N: broken in 3 of 3 scenarios, worst 1 N" in limit.heading
    assert (
        limit.reason
        == "it would rise with buffer.k_A below its bound of 1 N/m, down to about 0.5 N/m (+0.01 N per 1 %)"
    )


def test_a_weak_variable_at_its_bound_is_named_if_no_other_is_strong():
    """h = 15 (y/4)^-0.09 at y = 4: 1 % of y brings -0.09 % only, and 10 N are reached at 4 · 1.5^(1/0.09) = 362, which
    is beyond guessing: ten times the bound has 15 · 10^-0.09 = 12.2 N; from 11 N on it is 4 · 1.1^(1/0.09) = 11.5."""
    at = lambda least: broken(  # noqa: E731
        Limits(at_most={"peak_hinge_force": 10.0}), lambda x: least * (x[1] / 4.0) ** -0.09, [5.0, 4.0]
    )
    _, _, (limit,) = at(15.0)
    assert limit.reason == (
        "it would fall with buffer.c_A above its bound of 4 N s/m (-0.013 N per 1 %); bounds 10 times as far would"
        " leave it at about 12 N: numbers that are no variables decide it"
    )
    assert limit.at_bounds == ()
    _, _, (limit,) = at(11.0)
    assert limit.at_bounds == ("buffer.c_A",) and ", to about 12 N s/m (-0.0099 N per 1 %)" in limit.reason


def test_a_limit_that_no_variable_moves():
    _, _, (limit,) = broken(Limits(at_most={"peak_hinge_force": 10.0}), lambda x: 15.0 + 0.0 * x[0], [5.0, 4.0])
    assert "no variable changes it: the limit can't be kept" in limit.reason and limit.at_bounds == ()


def test_rounding_at_a_bound_holds_nothing_back():
    """A slope of 1e-12 N per unit of y, at its bound, is none."""
    flat = lambda x: 15.0 - 1e-12 * x[1]  # noqa: E731
    _, _, (limit,) = broken(Limits(at_most={"peak_hinge_force": 10.0}), flat, [5.0, 4.0])
    assert "no variable changes it" in limit.reason and limit.at_bounds == ()


def test_a_variable_inside_its_bounds_is_said_apart():
    _, _, (limit,) = broken(Limits(at_most={"peak_hinge_force": 10.0}), lambda x: 4.0 * x[0], [5.0, 4.0])
    assert "within the bounds it would fall with less buffer.k_A (-0.2 N per 1 %)" in limit.reason


def test_limits_and_cases_are_told_the_worst_first():
    """Peaks of 5, 6 and 7 N over 5.5 N, hinge forces of 20 N over 10 N, margins of -3."""
    limits = Limits(at_most={"peak_force": 5.5, "peak_hinge_force": 10.0})
    goal, point, found = broken(limits, lambda x: 4.0 * x[0], [5.0, 4.0], margin=lambda x: x[0] - 8.0)
    assert [limit.heading.split(":")[0] for limit in found] == [
        "captured",
        "peak_hinge_force ≤ 10 N",
        "peak_force ≤ 5.5 N",
    ]
    assert "captured: broken in 3 of 3 scenarios, worst capture_share -3 at" in found[0].heading
    assert "over its distance at the start" in found[0].heading
    assert "broken in 2 of 3 scenarios, worst 7 N at scenario 3 (0.12 m/s, 0°)" in found[2].heading
    assert goal.broken(point)[0].startswith("scenario 3 (0.12 m/s, 0°): ")


def test_a_margin_that_rounding_leaves_below_zero_is_kept():
    goal, point, _ = broken(Limits(), lambda x: x[0], [5.0, 4.0], margin=lambda x: 0.0 * x[0] - 1e-12)
    point = point._replace(code=np.full(3, int(Outcome.captured)), succeeded=np.ones(3, bool))
    assert goal.feasible(point) and goal.broken(point) == []
    assert broken_limits(goal, point) == [] and goal.obstacle(point) == ""
