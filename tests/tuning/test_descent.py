"""Any optax optimiser on the certified gradient: published minimax problems, bounds, limits and what is refused."""

import itertools

import diffrax
import numpy as np
import optax
import pytest

from jaxbuffer import (
    Diffrax,
    InputError,
    Limits,
    Objective,
    Problem,
    Scenario,
    SecondObjective,
    Variable,
    simulate,
    table2,
)
from jaxbuffer.tuning import tune
from tuning.analytic import Functions, problem, shifted
from tuning.test_search import PUBLISHED, SHIFT

SQUARES = [[lambda x: x[0] ** 2 + x[1] ** 2]]


@pytest.fixture
def solve(monkeypatch):
    """`tune` by an optimiser, on functions instead of captures."""

    def run(stated, peaks, rest=None, optimizer=None, dies_after=None, **settings):
        functions = Functions(stated, peaks, rest)
        functions.dies_after = dies_after
        monkeypatch.setattr(tune, "Evaluator", lambda *_: functions)
        monkeypatch.setattr("jaxbuffer.tuning.assessment.lower_bound", lambda *_: None)
        chosen = {"starts": 1, "searches": 1, "iterations": 300, **settings}
        schedule = optax.exponential_decay(0.02, 20, 0.7)
        return tune.tune(stated, optimizer=optimizer or optax.adam(schedule), **chosen)

    return run


@pytest.mark.parametrize("name", ["CB2", "CB3"])
def test_published_minimax_problems(solve, name):
    """A subgradient crawls along the kinks: within 1 % of the published optimum after 300 steps."""
    functions, start, optimum = PUBLISHED[name]
    start = np.array(start)
    stated = problem(SHIFT + start - 3.0, SHIFT + start + 3.0, SHIFT + start)
    tuned = solve(stated, [shifted(functions, SHIFT)])
    assert optimum <= tuned.objective[1] < 1.01 * optimum
    assert tuned.objective[1] < tuned.objective[0] and tuned.feasible


def test_bounds_and_limits_are_kept(solve):
    """min x² + y² from (3, 3), of which x ≥ 1 by its bound and 2 / y ≤ 1 by a limit: (1, 2)."""
    stated = problem([1.0, 0.5], [4.0, 4.0], [3.0, 3.0], limits=Limits(at_most={"stroke": 0.1}))
    tuned = solve(stated, [[lambda x: x[0] ** 2 + x[1] ** 2]], {"stroke": lambda x: 0.2 / x[1]})
    x = stated.values(tuned.after.scaled)
    assert tuned.feasible
    np.testing.assert_allclose(x, [1.0, 2.0], rtol=0.02)
    assert x[0] >= 1.0


def test_the_log_has_every_step(solve):
    stated = problem([1.0, 0.5], [4.0, 4.0], [3.0, 3.0])
    tuned = solve(stated, [[lambda x: x[0] ** 2 + x[1] ** 2]], iterations=5, tolerance=1e-9)
    assert [record["step"] for record in tuned.records] == [0, 1, 2, 3, 4, 5]
    assert "5 steps of the optimizer from each of 1 starts" in tuned.message


def test_a_descent_that_was_interrupted_is_resumed_to_the_same_bits(solve, tmp_path):
    """Named, as in a study; another optimiser, rate or solver is another run."""
    stated = problem([1.0, 0.5], [4.0, 4.0], [3.0, 3.0])
    options = {"optimizer": "adam", "learning_rate": 0.05, "starts": 3, "iterations": 20}
    whole = solve(stated, SQUARES, **options)
    folder = {"folder": tmp_path, "save": False}
    with pytest.raises(KeyboardInterrupt):
        solve(stated, SQUARES, dies_after=4, **options, **folder)
    named = {name: value for name, value in options.items() if name in ("optimizer", "learning_rate")}
    settings = {"searches": 1, "starts": 3, "iterations": 20, **named}
    best = tune.best_so_far(stated, tmp_path, **settings)
    assert best.evaluations == 4 and whole.objective[1] < best.objective < whole.objective[0]
    for other, message in (
        ({"optimizer": "sgd"}, "optimizer is 'adam' there, 'sgd' here"),
        ({"learning_rate": 0.2}, "learning_rate is 0.05 there, 0.2 here"),
        ({"solver": "explicit"}, "solver is automatic there, explicit here"),
    ):
        with pytest.raises(InputError, match=message):
            tune.best_so_far(stated, tmp_path, **settings | other)
    resumed = solve(stated, SQUARES, resume=True, **options, **folder)
    assert resumed.records == whole.records and resumed.captures == whole.captures
    np.testing.assert_array_equal(resumed.after.scaled, whole.after.scaled)


@pytest.mark.parametrize(
    "optimizer",
    [
        optax.lbfgs(0.5, linesearch=None),
        optax.polyak_sgd(0.2),
        optax.chain(optax.adam(0.1), optax.contrib.reduce_on_plateau(0.5, patience=3)),
    ],
    ids=["lbfgs", "polyak_sgd", "reduce_on_plateau"],
)
def test_optimizers_that_need_the_value_find_the_corner_of_the_bounds(solve, optimizer):
    """min x² + y² from (3, 3) with x ≥ 1, y ≥ 1/2: (1, 1/2)."""
    stated = problem([1.0, 0.5], [4.0, 4.0], [3.0, 3.0])
    tuned = solve(stated, SQUARES, optimizer=optimizer, iterations=60)
    np.testing.assert_allclose(stated.values(tuned.after.scaled), [1.0, 0.5], rtol=0.01)


def test_the_value_is_that_of_the_function_whose_slope_is_given(solve):
    """The augmented Lagrangian of x² + y² with 2 / y ≤ 1: differences of its values along a short step are its slope's
    share of the step."""
    seen = []

    def update(slope, state, at, *, value, **_):
        seen.append((np.array(at), np.array(slope), float(value)))
        return -1e-4 * np.sign(slope), state

    recorder = optax.GradientTransformationExtraArgs(lambda at: (), update)
    stated = problem([1.0, 0.5], [4.0, 4.0], [3.0, 1.5], limits=Limits(at_most={"stroke": 0.1}))
    solve(stated, SQUARES, {"stroke": lambda x: 0.2 / x[1]}, optimizer=recorder, iterations=9)
    first = seen[1:]  # the first call tries whether it takes a step at all
    assert len(first) == 9
    for (a, slope_a, value_a), (b, slope_b, value_b) in itertools.pairwise(first):
        np.testing.assert_allclose(value_b - value_a, 0.5 * (slope_a + slope_b) @ (b - a), rtol=1e-6)


def test_a_step_that_is_not_finite_ends_its_search_with_a_warning(solve):
    def update(slope, state, at, **_):
        return (np.full_like(at, np.nan) if state > 2 else -0.1 * slope), state + 1

    broken = optax.GradientTransformationExtraArgs(lambda at: 0, update)
    with pytest.warns(UserWarning, match="step 4 of the optimizer is not finite; its search ends there"):
        tuned = solve(problem([1.0, 0.5], [4.0, 4.0], [3.0, 3.0]), SQUARES, optimizer=broken, tolerance=1e-9)
    assert [record["step"] for record in tuned.records] == [0, 1, 2, 3] and np.isfinite(tuned.objective[1])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"optimizer": optax.lbfgs()}, r"in a line search; .* take optax\.adam\(0\.05\), .*linesearch=None"),
        ({"optimizer": optax.sgd}, "is not an optax optimizer; write"),
        (
            {"optimizer": optax.contrib.sam(optax.sgd(0.1), optax.sgd(0.1), opaque_mode=True)},
            "cannot take a step, .* take optax",
        ),
        ({"optimizer": optax.GradientTransformation(lambda at: (), lambda *_: (np.zeros(3), ()))}, r"shape \(3,\)"),
        ({"optimizer": 0.05}, "optimizer = 0.05 is not an optax optimizer; write"),
        ({"optimizer": "adan"}, "optimizer = 'adan' is unknown.*did you mean adam"),
        ({"learning_rate": 0.0}, r"tune\.learning_rate = 0 is out of range; allowed"),
    ],
)
def test_what_is_refused(options, message):
    stated = problem([1.0, 0.5], [4.0, 4.0], [3.0, 3.0])
    with pytest.raises(InputError, match=message):
        tune.tune(stated, **{"optimizer": optax.adam(0.1), **options})


@pytest.mark.long
def test_the_whole_of_it_by_diffrax(tmp_path):
    """Table 2 for two approaches: better, all captures solved at the check, and its forces are those of the exact law
    by the default solver, within the smooth law's bias."""
    asked = Problem(
        table2(),
        [Scenario(approach_speed=0.1), Scenario(approach_speed=0.2, misalignment=0.05)],
        [Variable("buffer.k_A", 100.0, 2000.0), Variable("probe.tip_mass", 0.02, 0.2)],
        limits=Limits(at_most={"stroke": 0.025}),
    )
    kvaerno = Diffrax(diffrax.Kvaerno5())
    tuned = tune.tune(
        asked, solver=kvaerno, optimizer=optax.adam(0.05), starts=1, searches=1, iterations=3, folder=tmp_path
    )
    assert tuned.feasible and tuned.tight == 1e-8
    assert tuned.objective[1] < 0.99 * tuned.objective[0]
    exact = [float(simulate(tuned.design, scenario).peak_force) for scenario in asked.scenarios]
    np.testing.assert_allclose(tuned.after.peak_force, exact, rtol=1e-4)


def test_a_second_objective_is_refused():
    stated = problem([1.0, 0.5], [4.0, 4.0], [3.0, 3.0], then=SecondObjective(Objective({"stroke": 1.0})))
    with pytest.raises(InputError, match="no second objective"):
        tune.tune(stated, optimizer=optax.adam(0.1))
