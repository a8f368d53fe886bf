"""The levers of a choice: of the best combination's limits, by numbers that were chosen and by others."""

import dataclasses

import pytest

import jaxbuffer as jb
from jaxbuffer.choosing.choose import with_levers
from jaxbuffer.choosing.means import Means
from jaxbuffer.tuning import assessment
from jaxbuffer.tuning.report.levers import ASK, Lever
from made_up_choice import made_up_choice

LEVERS = {
    "stroke": [Lever("buffer.k_A", -0.4, True), Lever("active.mass", 0.3, False)],
    "objective": [Lever("cone.half_angle", 0.8, False)],
}


@pytest.fixture
def given(monkeypatch):
    """What the levers are asked for, whose answer is `LEVERS`."""
    asked = []

    def levers(goal, after, evaluator, chosen):
        asked.append((goal, after, set(chosen)))
        return LEVERS

    monkeypatch.setattr(assessment, "levers_by_numbers", levers)
    return asked


def test_levers_are_of_the_best_combination_and_of_what_parts_set(given):
    choice = made_up_choice()
    with_them = with_levers(choice, Means())
    ((goal, after, chosen),) = given
    assert goal.problem.design is choice.best.design and after is choice.best.evaluation
    assert chosen == {"buffer.k_A", "probe.tip_mass"}
    text = " ".join(repr(with_them).split())
    assert "buffer.k_A -0.4 [active.mass +0.3]" in text and "in brackets numbers that were not chosen" in text
    assert ASK in " ".join(repr(choice).split()) and ASK not in text
    assert text.index("Limits of the first") < text.index("Levers: change") < text.index("Ranking")


def test_an_objective_with_a_price_has_no_levers(given):
    choice = made_up_choice()
    objective = jb.Objective({"peak_force": 1.0, "price": 2.0})
    priced = dataclasses.replace(choice, criterion=dataclasses.replace(choice.criterion, objective=objective))
    assert [*with_levers(priced, Means()).levers] == ["stroke"]
    none = dataclasses.replace(choice, ranked=())
    assert with_levers(none, Means()) is none


def test_levers_that_cannot_be_found_are_a_remark(monkeypatch):
    def fails(*_):
        raise ValueError("no slopes")

    monkeypatch.setattr(assessment, "levers_by_numbers", fails)
    choice = with_levers(made_up_choice(), Means())
    why = "missing: levers among all numbers of the design, which could not be computed: no slopes"
    assert choice.levers == {} and why in " ".join(repr(choice).split()) and choice.feasible


@pytest.mark.long
def test_the_levers_of_a_choice_are_those_of_differences():
    """Of a limit and the objective, each by the central difference of runs at a tight tolerance."""
    parts = {
        "bar": {"thin": {"bar.diameter": "4 mm"}, "thick": {"bar.diameter": "5 mm"}},
        "plate": {"soft": {"impact.stiffness": 1e10}, "stiff": {"impact.stiffness": 1e11}},
    }
    scenarios = [jb.BarDropScenario(height=height) for height in (0.19, 0.2)]
    limits = jb.Limits(at_most={"penetration": 1e-3})
    problem = jb.Problem(jb.BarDrop(), scenarios, [], limits=limits, duration=0.25)
    choice = jb.choose(problem, parts, optimum=False, levers=True)
    assert choice.missing == () and [*choice.levers] == ["penetration", "objective"]

    def value(name, path, share):
        changed = jb.replace(choice.design, {path: share * float(jb.get(choice.design, path))})
        runs = [jb.simulate(changed, scenario, 0.25, rtol=1e-11) for scenario in scenarios]
        return max(float(run.quantity("peak_force" if name == "objective" else name)) for run in runs)

    for name, levers in choice.levers.items():
        assert {it.path for it in levers if it.variable} <= {"bar.diameter", "impact.stiffness"}
        assert sum(not it.variable for it in levers) == 3 and any(it.variable for it in levers)
        for it in levers:
            low, high, here = (value(name, it.path, share) for share in (1.0 - 1e-4, 1.0 + 1e-4, 1.0))
            assert it.elasticity == pytest.approx((high - low) / (2e-4 * here), rel=1e-3), (name, it.path)
