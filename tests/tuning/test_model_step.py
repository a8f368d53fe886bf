"""The model's best step and its multipliers satisfy the conditions of optimality (Karush, Kuhn and Tucker)."""

import numpy as np
import pytest
import qpsolvers

from jaxbuffer import Limits, Objective
from jaxbuffer.tuning.problem.settings import Settings
from jaxbuffer.tuning.search import search
from jaxbuffer.tuning.search.goal import Goal, Tangent
from jaxbuffer.tuning.search.model_step import Cuts, Programme, best_step
from tuning.analytic import Functions, problem, shifted

SHIFT = 10.0
CURVATURE = np.array([[3.0, 1.0], [1.0, 2.0]])
SCALE = 20.0
PEAKS = [
    shifted([lambda x: 12 + x[0] ** 2 + x[1] ** 4, lambda x: 10 + (2 - x[0]) ** 2 + (2 - x[1]) ** 2], SHIFT),
    shifted([lambda x: 11 + 2 * np.exp(x[1] - x[0]), lambda x: 9 - x[0]], SHIFT),
]
OBJECTIVES = {
    "worst": Objective({"peak_force": 1.0, "peak_hinge_force": 0.1}),
    "mean": Objective({"peak_force": 1.0}, "mean"),
    "cvar": Objective({"peak_force": 1.0, "peak_hinge_force": 0.1}, "cvar", 0.2),
}


def model(over="worst", limit=15.0):
    """A goal of two cases with a limit on the hinge force, and its model at a design."""
    stated = problem(
        [SHIFT - 2] * 2,
        [SHIFT + 2] * 2,
        [SHIFT + 1, SHIFT - 0.5],
        2,
        objective=OBJECTIVES[over],
        limits=Limits(at_most={"peak_hinge_force": limit}),
    )
    rest = {"peak_hinge_force": lambda x: 4.0 + x[0] + x[1] - SHIFT}
    functions = Functions(stated, PEAKS, rest, lambda x: 0.2 + 0.1 * (x[1] - SHIFT))
    start = stated.start()
    return Goal(stated, stated.objective), Tangent.of(functions.one(start)), start


@pytest.mark.parametrize("limit", [15.0, 14.3], ids=["free", "limited"])
@pytest.mark.parametrize("over", OBJECTIVES)
def test_the_lagrangian_is_stationary(over, limit):
    goal, tangent, scaled = model(over, limit)
    found = best_step(goal, tangent, scaled, 1.0, SCALE, 10.0, curvature=CURVATURE)
    assert found.predicted_reduction > 0.0
    assert found.multipliers.slope(tangent) + CURVATURE @ found.step == pytest.approx(0.0, abs=1e-6)
    objective = goal.weights[0] * np.sum(found.multipliers.peaks)
    assert objective == pytest.approx(1.0 / SCALE, abs=1e-8), "the cases' weights sum to one"
    margins = tangent.margin + tangent.margin_slope @ found.step
    assert found.multipliers.margin @ margins == pytest.approx(0.0, abs=1e-6), "only what is met exactly has a weight"


@pytest.mark.parametrize("over", OBJECTIVES)
def test_no_other_step_is_better(over):
    goal, tangent, scaled = model(over, 14.3)
    found = best_step(goal, tangent, scaled, 0.1, SCALE, 10.0, curvature=CURVATURE)

    def merit(step):
        return goal.predicted_merit(tangent, step, SCALE, 10.0) + 0.5 * step @ CURVATURE @ step

    others = np.random.default_rng(0).uniform(-0.1, 0.1, (200, 2))
    assert merit(found.step) < min(map(merit, others))
    assert found.predicted_reduction == pytest.approx(merit(np.zeros(2)) - merit(found.step))


def test_a_step_keeps_to_bounds_and_cuts():
    goal, tangent, scaled = model()
    cuts = Cuts(np.array([[1.0, 0.0]]), np.array([0.01]))
    found = best_step(goal, tangent, scaled, 0.1, SCALE, 10.0, cuts, curvature=1e-3 * CURVATURE)
    assert found.step[0] == pytest.approx(0.01, abs=1e-6) and np.max(np.abs(found.step)) <= 0.1


def test_without_curvature_and_where_the_solver_gives_up_the_model_is_linear(monkeypatch):
    goal, tangent, scaled = model()
    linear = best_step(goal, tangent, scaled, 0.1, SCALE, 10.0)
    assert np.max(np.abs(linear.step)) == pytest.approx(0.1)
    tiny = best_step(goal, tangent, scaled, 0.1, SCALE, 10.0, curvature=1e-9 * CURVATURE)
    assert tiny.step == pytest.approx(linear.step, abs=1e-4)
    assert tiny.multipliers.slope(tangent) == pytest.approx(linear.multipliers.slope(tangent), abs=1e-5)
    monkeypatch.setattr(qpsolvers, "solve_problem", lambda stated, **_: qpsolvers.Solution(stated, found=False))
    given_up = best_step(goal, tangent, scaled, 0.1, SCALE, 10.0, curvature=CURVATURE)
    assert np.array_equal(given_up.step, linear.step)


def test_a_model_that_no_solver_solves_is_not_converged(monkeypatch):
    goal, _, scaled = model()
    point = Functions(goal.problem, PEAKS, {"peak_hinge_force": lambda x: 1.0 + x[0] - SHIFT}).one(scaled)
    monkeypatch.setattr(Programme, "solve", lambda *_: None)
    rules = search.Search(goal, SCALE, Settings())
    start = rules.begin(point)
    assert np.isnan(start.residual) and start.status == search.RUNNING
    move = rules.plan(start)
    assert rules.judge(start, move, point).status == search.STALLED
