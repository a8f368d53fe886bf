"""Any optax optimiser on the certified gradient: published minimax problems, bounds, limits and what is refused."""

import numpy as np
import optax
import pytest

from jaxbuffer import InputError, Limits, Objective, Then
from jaxbuffer.tuning import tune
from tuning.analytic import Functions, problem, shifted
from tuning.test_search import PUBLISHED, SHIFT


@pytest.fixture
def solve(monkeypatch):
    """`tune` by an optimiser, on functions instead of captures."""

    def run(stated, peaks, rest=None, optimizer=None, **settings):
        functions = Functions(stated, peaks, rest)
        monkeypatch.setattr(tune, "Evaluator", lambda *_: functions)
        monkeypatch.setattr("jaxbuffer.tuning.tuned.floor", lambda *_: None)
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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"optimizer": "adam"}, "optimizer = 'adam' is not an optax optimizer; write"),
        ({"resume": True, "folder": "run"}, "cannot be resumed"),
    ],
)
def test_what_is_refused(options, message):
    stated = problem([1.0, 0.5], [4.0, 4.0], [3.0, 3.0])
    with pytest.raises(InputError, match=message):
        tune.tune(stated, **{"optimizer": optax.adam(0.1), **options})


def test_a_second_objective_is_refused():
    stated = problem([1.0, 0.5], [4.0, 4.0], [3.0, 3.0], then=Then(Objective({"stroke": 1.0})))
    with pytest.raises(InputError, match="no second objective"):
        tune.tune(stated, optimizer=optax.adam(0.1))
