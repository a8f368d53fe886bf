"""A choice among real captures: against a sweep of every combination, interrupted, resumed, at tight tolerance."""

import dataclasses
import itertools
import re

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.choosing.store import FOLDER

PARTS = {
    "spring": {"S1": {"k_A": 200.0, "price": 9}, "S2": {"k_A": 450.0, "price": 12}, "S3": {"k_A": 1100.0, "price": 8}},
    "damper": {"D1": {"c_A": 4.0, "price": 20}, "D2": {"c_A": 14.0, "price": 26}, "D3": {"c_A": 45.0, "price": 31}},
    "tip": {"light": {"tip_mass": "25 g", "mass": "25 g"}, "heavy": {"tip_mass": "70 g", "mass": "70 g"}},
}
SPEEDS, ANGLES, STROKE = (0.06, 0.14), (-0.04, 0.03), 0.025  # m/s, rad, m
RANKING = 6


@pytest.fixture(scope="module")
def problem():
    scenarios = [jb.Scenario(approach_speed=v, misalignment=a) for v, a in itertools.product(SPEEDS, ANGLES)]
    return jb.Problem(jb.table2(), scenarios, [], limits=jb.Limits(at_most={"stroke": STROKE}))


@pytest.fixture(scope="module")
def chosen(problem):
    return jb.choose(problem, PARTS, ranking=RANKING, optimum=False)


@pytest.fixture(scope="module")
def swept():
    """Every combination at every scenario, by the sweep's own program; runs in the order of the catalogues."""
    over = {
        "buffer.k_A": [it["k_A"] for it in PARTS["spring"].values()],
        "buffer.c_A": [it["c_A"] for it in PARTS["damper"].values()],
        "probe.tip_mass": [0.025, 0.07],
        "scenario.approach_speed": list(SPEEDS),
        "scenario.misalignment": list(ANGLES),
    }
    return jb.sweep(jb.table2(), jb.Scenario(), 8.0, over=over)


def names_of(number):
    return tuple(list(it)[place] for it, place in zip(PARTS.values(), np.unravel_index(number, (3, 3, 2)), strict=True))


@pytest.mark.slow
def test_the_ranking_is_that_of_a_sweep_of_everything(chosen, swept, evidence):
    captured = np.array([outcome.name == "captured" for outcome in swept.outcomes])
    keeps = np.all((captured & (swept.stroke <= STROKE)).reshape(18, 4), axis=1)
    worst = np.where(keeps, np.max(swept.peak_force.reshape(18, 4), axis=1), np.inf)
    order = [int(k) for k in np.argsort(worst, kind="stable")[: min(RANKING, keeps.sum())]]
    assert 2 < keeps.sum() < 18, "some combinations keep the limits and some do not"
    assert [it.names for it in chosen.ranked] == [names_of(k) for k in order]
    assert chosen.tally.complete >= len(order) and chosen.tally.runs < 72
    # The sweep's runs have rtol 1e-6, those that are told 1e-9.
    error = max(abs(it.value / worst[k] - 1.0) for it, k in zip(chosen.ranked, order, strict=True))
    evidence("choices", "the best combinations have the numbers of a sweep", error, 1e-5, "jb.sweep of all of them")
    for it, k in zip(chosen.ranked, order, strict=True):
        margin = next(one for one in it.margins if one.limit.name == "stroke")
        stroke = swept.stroke.reshape(18, 4)[k]
        assert margin.case == int(np.argmax(stroke)) and margin.share == pytest.approx(
            1.0 - max(stroke) / STROKE, abs=1e-5
        )
        assert it.deciding == int(np.argmax(swept.peak_force.reshape(18, 4)[k]))


@pytest.mark.slow
def test_the_cheapest_and_a_limit_on_the_mass(problem, swept):
    """Objective and limit are sums over the parts: the light tip alone keeps the limit on the mass."""
    choice = jb.choose(
        problem, PARTS, objective=jb.Objective({"price": 1.0}), at_most={"mass": "30 g"}, ranking=2, optimum=False
    )
    captured = np.array([outcome.name == "captured" for outcome in swept.outcomes])
    keeps = np.all((captured & (swept.stroke <= STROKE)).reshape(18, 4), axis=1)
    prices = {
        names_of(k): PARTS["spring"][names_of(k)[0]]["price"] + PARTS["damper"][names_of(k)[1]]["price"]
        for k in np.flatnonzero(keeps)
        if names_of(k)[2] == "light"
    }
    assert [it.value for it in choice.ranked] == sorted(prices.values())[:2]
    assert choice.best.value == prices[choice.best.names] and choice.tally.priced_out == 9
    assert re.search(r"^ *mass +[\d.]+ g +(≤|at most) 30 g", str(choice), re.MULTILINE)


@pytest.mark.slow
def test_a_choice_that_was_interrupted_ends_with_the_same_bits(problem, chosen, tmp_path):
    def interrupting(done, total):
        if done > 25:
            raise KeyboardInterrupt

    arguments = {"ranking": RANKING, "optimum": False, "folder": tmp_path, "save": False}
    with pytest.raises(KeyboardInterrupt):
        jb.choose(problem, PARTS, progress=interrupting, **arguments)
    files = sorted((tmp_path / FOLDER).glob("[0-9]*.npz"))
    assert files
    content = bytearray(files[0].read_bytes())
    content[100] ^= 1
    files[0].write_bytes(content)  # damaged: its runs are made again
    resumed = jb.choose(problem, PARTS, resume=True, **arguments)
    assert str(resumed) == str(chosen) and resumed.tally == chosen.tally
    for one, other in zip(resumed.ranked, chosen.ranked, strict=True):
        assert one.value == other.value and np.array_equal(one.evaluation.quantities, other.evaluation.quantities)
    with pytest.raises(jb.InputError, match="holds another choice, differing in ranking"):
        jb.choose(problem, PARTS, resume=True, **arguments | {"ranking": 2})
    other = dataclasses.replace(problem, limits=jb.Limits(at_most={"stroke": 0.02}))
    with pytest.raises(jb.InputError, match="differing in study"):
        jb.choose(other, PARTS, resume=True, **arguments)


@pytest.mark.slow
def test_roundings_are_judged_over_all_cases_and_say_their_cost(problem):
    design = jb.replace(jb.table2(), {"buffer.k_A": 290.0, "buffer.c_A": 21.3})
    choice = jb.buildable(problem, {"buffer.k_A": "E12", "buffer.c_A": "5 N s/m"}, design, ranking=16)
    assert choice.tally.combinations == 16 and choice.nearest.names == ("270 N/m", "20 N s/m")
    runs = [[jb.simulate(it.design, case.scenario) for case in problem.cases] for it in (choice.best, choice.nearest)]
    worst = [max(float(run.peak_force) for run in each) for each in runs]
    assert [choice.best.value, choice.nearest.value] == pytest.approx(worst, rel=1e-5)
    exact = max(float(jb.simulate(design, case.scenario).peak_force) for case in problem.cases)
    assert choice.continuous.value == pytest.approx(exact, rel=1e-5)
    assert f"{100.0 * (choice.best.value / exact - 1.0):+.2g} %" in str(choice)


@pytest.mark.slow
@pytest.mark.parametrize(
    "varied",
    [
        {"scenarios": [jb.Case(jb.Scenario(), values=(("probe.tip_mass", mass),)) for mass in (0.03, 0.2)]},
        {"scenarios": [jb.Case(jb.Scenario(), shifts=(("probe.tip_mass", 0.02),))]},
        {"scenarios": [jb.Case(jb.Scenario(), factors=(("probe.tip_mass", 1.4),))]},
        {"scenarios": [jb.Scenario()], "tolerances": {"probe.tip_mass": "20 g"}},
        {"scenarios": [jb.Scenario()], "tolerances": {"probe.tip_mass": "40 %"}},
    ],
    ids=["grid", "shift", "factor", "absolute tolerance", "relative tolerance"],
)
def test_choices_run_each_load_case_with_the_design_as_built(varied):
    """Brute force: each load case simulated with `Case.of` of the design."""
    problem = jb.Problem(jb.table2(), variables=[], **varied)
    choices = (
        jb.choose(problem, {"spring": {"S2": {"k_A": 200.0}, "S4": {"k_A": 400.0}}}, optimum=False),
        jb.buildable(problem, {"buffer.k_A": "E3"}, jb.replace(jb.table2(), {"buffer.k_A": 300.0})),
    )
    for choice in choices:
        runs = [jb.simulate(case.of(choice.design), case.scenario, rtol=1e-9) for case in choice.problem.cases]
        assert choice.best.value == pytest.approx(max(float(run.peak_force) for run in runs), rel=1e-5)


def test_a_number_that_scenarios_list_is_neither_chosen_nor_rounded():
    cases = [jb.Case(jb.Scenario(), values=(("buffer.k_A", k),)) for k in (300.0, 900.0)]
    listed = jb.Problem(jb.table2(), cases, [])
    springs = {"spring": {"A": {"k_A": 300.0}, "B": {"k_A": 500.0}}}
    with pytest.raises(jb.InputError, match=r"parts\.spring sets buffer\.k_A, and the scenarios list values"):
        jb.choose(listed, springs)
    with pytest.raises(jb.InputError, match=r"roundings\.buffer\.k_A sets buffer\.k_A, and the scenarios list values"):
        jb.buildable(listed, {"buffer.k_A": "E12"})


@pytest.mark.slow
@pytest.mark.parametrize("second", ["stroke", "price"])
@pytest.mark.parametrize("ranking", [1, 6])
def test_a_second_objective_decides_among_those_about_as_good(problem, swept, second, ranking):
    """Brute force by a sweep: of the combinations within 40 % of the least force the one with the least stroke, or the
    cheapest one."""
    then = jb.SecondObjective(jb.Objective({second: 1.0}), tolerance=0.4)
    priced = {**PARTS, "tip": {"light": {"tip_mass": "25 g", "price": 9}, "heavy": {"tip_mass": "70 g", "price": 5}}}
    if second == "price":
        choice = jb.choose(problem, priced, then=then, ranking=ranking, optimum=False)
    else:
        choice = jb.choose(dataclasses.replace(problem, then=then), priced, ranking=ranking, optimum=False)
    captured = np.array([outcome.name == "captured" for outcome in swept.outcomes])
    keeps = np.flatnonzero(np.all((captured & (swept.stroke <= STROKE)).reshape(18, 4), axis=1))
    force, stroke = (np.max(it.reshape(18, 4), axis=1) for it in (swept.peak_force, swept.stroke))
    parts = [[priced[role][name] for role, name in zip(priced, names_of(k), strict=True)] for k in range(18)]
    price = np.array([sum(it["price"] for it in each) for each in parts])
    about_best = [int(k) for k in keeps if force[k] <= 1.4 * min(force[keeps])]
    other = stroke if second == "stroke" else price
    expected = sorted(about_best, key=lambda k: (other[k], k))
    expected += [int(k) for k in sorted(keeps, key=lambda k: force[k]) if k not in about_best]
    assert 1 < len(about_best) < len(keeps) and np.argmin(other[about_best]) != np.argmin(force[about_best])
    assert [it.names for it in choice.ranked] == [names_of(k) for k in expected[:ranking]]
    assert choice.best.second == pytest.approx(other[expected[0]], rel=1e-5)
    assert choice.ceiling == pytest.approx(1.4 * min(force[keeps]), rel=1e-5)
    assert choice.least.names == names_of(min(keeps, key=lambda k: force[k]))
    assert f"then {second}" in str(choice) and "all within 40 % of the least objective" in str(choice)


@pytest.mark.slow
def test_a_second_objective_decides_among_roundings(problem):
    """Brute force: each rounding is simulated in every load case."""
    then = jb.SecondObjective(jb.Objective({"stroke": 1.0}), tolerance=0.1)
    design, steps = jb.replace(jb.table2(), {"buffer.k_A": 290.0}), (220.0, 270.0, 330.0, 390.0)
    fast = [case.scenario for case in problem.cases if case.scenario.approach_speed == max(SPEEDS)]
    problem = dataclasses.replace(problem, scenarios=fast, then=then)
    choice = jb.buildable(problem, {"buffer.k_A": "E12"}, design)
    built = [jb.replace(design, {"buffer.k_A": k}) for k in steps]
    runs = [[jb.simulate(it, case.scenario, rtol=1e-9) for case in problem.cases] for it in built]
    force, stroke = ([max(float(getattr(run, it)) for run in each) for each in runs] for it in ("peak_force", "stroke"))
    keeps = [k for k in range(4) if stroke[k] <= STROKE]
    least = min(force[k] for k in keeps)
    best = min((k for k in keeps if force[k] <= 1.1 * least), key=lambda k: stroke[k])
    assert best != min(keeps, key=lambda k: force[k]) and choice.best.names == (f"{steps[best]:g} N/m",)


def test_what_cannot_be_chosen_is_said(problem):
    with pytest.raises(jb.InputError, match=r"parts\.spring sets buffer\.k_A, which is among the variables too"):
        tunable = dataclasses.replace(problem, variables=[jb.Variable("buffer.k_A", 100.0, 2000.0)])
        jb.choose(tunable, PARTS)
    with pytest.raises(jb.InputError, match="variables is empty"):
        jb.choose(problem, PARTS, tuned=1)
    with pytest.raises(jb.InputError, match="variables is empty"):
        jb.tune(problem)
    with pytest.raises(jb.InputError, match=r"at_most\.weight is unknown"):
        jb.choose(problem, PARTS, at_most={"weight": 3.0})
    with pytest.raises(jb.InputError, match="no part has a price"):
        jb.choose(problem, {"tip": {"T": {"tip_mass": 0.03}}}, objective=jb.Objective({"price": 1.0}))
    with pytest.raises(jb.InputError, match="resume needs the folder"):
        jb.choose(problem, PARTS, resume=True)
    with pytest.raises(jb.InputError, match="combinations, above 1e"):
        many = {
            role: {f"P{k}": {path: 0.01 + 1e-4 * k} for k in range(1200)} for role, path in (("a", "k_A"), ("b", "c_A"))
        }
        jb.choose(problem, many)


@pytest.mark.slow
def test_one_that_meets_a_limit_exactly_is_counted_where_it_is_ranked(problem, chosen):
    """The limit is the first one's largest stroke at the tolerance of the ranking, so that it is kept there exactly; at
    the search's tolerance it may be broken."""
    exact = max(float(jb.simulate(chosen.design, case.scenario, rtol=1e-9).stroke) for case in problem.cases)
    limited = dataclasses.replace(problem, limits=jb.Limits(at_most={"stroke": exact}))
    parts = {role: {name: PARTS[role][name]} for role, name in zip(PARTS, chosen.best.names, strict=True)}
    choice = jb.choose(limited, parts, optimum=False)
    assert choice.feasible and choice.tally.complete == choice.tally.combinations == 1 and not choice.tally.infeasible
