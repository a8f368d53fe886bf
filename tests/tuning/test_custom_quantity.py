"""Own quantities: the chain rule, the model of a step, what is refused, and tunings by them."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import jaxbuffer as jb
from jaxbuffer import CustomQuantity, InputError, Limits, Objective, SecondObjective
from jaxbuffer.tuning import tune as module
from jaxbuffer.tuning.problem.custom_quantity import RESERVED
from jaxbuffer.tuning.search.evaluation import Evaluator
from jaxbuffer.tuning.search.goal import Goal, Tangent
from jaxbuffer.tuning.search.model_step import best_step
from jaxbuffer.tuning.search.store import record_of
from jaxbuffer.tuning.tune import tune
from tuning.analytic import Functions, problem, shifted
from tuning.test_model_step import CURVATURE, PEAKS, SCALE
from tuning.test_search import CB2, SHIFT

BOUNDS = ([SHIFT - 5] * 2, [SHIFT + 5] * 2)
TOPIC = "Own quantities"


def stated(function, start=(1.0, -0.1), unit="N", **fields):
    """A problem of two variables that lowers the own quantity ``own``."""
    fields = {"objective": Objective({"own": 1.0}), **fields}
    return problem(*BOUNDS, SHIFT + np.array(start), quantities={"own": CustomQuantity(function, unit)}, **fields)


@pytest.fixture
def solve(monkeypatch):
    """`tune` on functions instead of runs."""

    def run(asked, peaks, rest=None, dies_after=None, **settings):
        functions = Functions(asked, peaks, rest)
        functions.dies_after = dies_after
        monkeypatch.setattr(module, "Evaluator", lambda *_: functions)
        monkeypatch.setattr("jaxbuffer.tuning.assessment.lower_bound", lambda *_: None)
        return tune(asked, **{"starts": 1, "searches": 1, **settings})

    return run


def test_a_rising_function_of_the_peak_has_the_peaks_own_minimum(solve):
    """CB2, a published minimax problem: the square of the largest of three functions."""
    tuned = solve(stated(lambda peak_force: peak_force**2), [shifted(CB2, SHIFT)])
    assert tuned.converged and len(tuned.records) <= 41
    assert tuned.objective[1] == pytest.approx(1.9522245**2, rel=1e-3)


def test_a_falling_function_of_the_peak(solve):
    """The least of 100 / max(x, y) is at the highest bound."""
    tuned = solve(stated(lambda peak_force: 100.0 / peak_force), [[lambda x: x[0], lambda x: x[1]]])
    assert tuned.converged and tuned.objective[1] == pytest.approx(100.0 / (SHIFT + 5))


@pytest.mark.parametrize("side", ["at_most", "at_least"])
def test_limits_on_functions_of_the_peak(solve, side):
    """Minimise (x - 3)² + (y - 2)² + 1 where max(x, y) ≤ 0, as a limit on its square from above and on its inverse from
    below: 14 at (0, 0)."""
    bowl = lambda x: (x[0] - SHIFT - 3) ** 2 + (x[1] - SHIFT - 2) ** 2 + 1  # noqa: E731
    function, limit = {
        "at_most": (lambda peak_force: peak_force**2, SHIFT**2),
        "at_least": (lambda peak_force: 100.0 / peak_force, 100.0 / SHIFT),
    }[side]
    limits = Limits(**{side: {"own": limit}})
    asked = stated(function, (-3.0, -4.0), objective=Objective({"peak_hinge_force": 1.0}), limits=limits)
    tuned = solve(asked, [[lambda x: x[0], lambda x: x[1]]], {"peak_hinge_force": bowl})
    assert tuned.feasible and tuned.converged
    assert tuned.objective[1] == pytest.approx(14.0, rel=2e-3)


def test_an_objective_below_zero_and_a_second_one(solve):
    """CB2 less 1000, then the hinge force of the designs within 1 % of that."""
    then = SecondObjective(Objective({"peak_hinge_force": 1.0}), tolerance=0.005)
    asked = stated(lambda peak_force: peak_force - 1000.0, then=then)
    tuned = solve(asked, [shifted(CB2, SHIFT)], {"peak_hinge_force": lambda x: 1 + (x[1] - 12) ** 2})
    ceiling = -0.995 * (1000.0 - 1.9522245)
    assert tuned.goal.ceiling.value == pytest.approx(ceiling, rel=1e-5)
    assert tuned.feasible and tuned.objective[1] <= ceiling and tuned.goal.value(tuned.after) < 2.0
    assert "%" not in repr(tuned).splitlines()[5]


OWN = {
    "own": CustomQuantity(lambda peak_force, peak_hinge_force: 0.1 * peak_force**1.5 + peak_hinge_force**2 / 50.0, "N")
}


@pytest.mark.parametrize(("over", "limit"), [("worst", 9.0), ("mean", 100.0), ("mean", 9.3)])
def test_the_model_of_a_step_is_stationary_and_the_best_of_the_composite(over, limit):
    """Two cases of two impacts that cross within the step; the last limit holds it."""
    fields = {"objective": Objective({"own": 1.0}, over), "limits": Limits(at_most={"own": limit}), "quantities": OWN}
    asked = problem([SHIFT - 2] * 2, [SHIFT + 2] * 2, [SHIFT + 1, SHIFT - 0.5], 2, **fields)
    rest = {"peak_hinge_force": lambda x: 4.0 + x[0] + x[1] - SHIFT}
    goal, scaled = Goal(asked, asked.objective), asked.start()
    tangent = Tangent.of(Functions(asked, PEAKS, rest, lambda x: 0.2 + 0.1 * (x[1] - SHIFT)).one(scaled))
    found = best_step(goal, tangent, scaled, 1.0, SCALE, 10.0, curvature=CURVATURE)
    assert found.multipliers.slope(tangent) + CURVATURE @ found.step == pytest.approx(0.0, abs=1e-6)

    def merit(step):
        return goal.predicted_merit(tangent, step, SCALE, 10.0) + 0.5 * step @ CURVATURE @ step

    others = found.step + np.random.default_rng(0).uniform(-0.1, 0.1, (400, 2))
    inside = np.all(np.abs(others) <= 1.0, axis=1)
    assert merit(found.step) <= min(map(merit, others[inside])) + 1e-9
    assert found.predicted_reduction == pytest.approx(merit(np.zeros(2)) - merit(found.step))


def test_slopes_are_those_of_the_function():
    """Against complex steps through the whole."""
    asked = stated(lambda peak_force, stroke: peak_force**2 * jnp.sqrt(stroke))
    peak, stroke = (lambda x: x[0] ** 2 + x[1]), (lambda x: x[0] * x[1])
    point = Functions(asked, [[peak]], {"stroke": stroke}).one(asked.start())
    whole = lambda x: peak(x) ** 2 * stroke(x) ** 0.5  # noqa: E731
    x = asked.values(point.scaled)
    slope = [whole(x + step).imag / 1e-30 * 10.0 for step in np.eye(2) * 1e-30j]  # bounds 10 apart
    assert point.quantities[0, -1] == pytest.approx(whole(x), rel=1e-13)
    assert point.quantities_slope[0, -1] == pytest.approx(slope, rel=1e-12)


def resumed(solve, folder, function, then):
    """A tuning that is cut off after four steps by one function, and goes on by another."""
    rest = {"peak_hinge_force": lambda x: 1 + (x[1] - 12) ** 2}
    with pytest.raises(KeyboardInterrupt):
        solve(stated(function), [shifted(CB2, SHIFT)], rest, 4, folder=folder)
    return solve(stated(then), [shifted(CB2, SHIFT)], rest, folder=folder, resume=True)


def power(exponent):
    return lambda peak_force: peak_force**exponent


def mean(table):
    return lambda peak_force: jnp.mean(peak_force * table)


def test_a_tuning_resumes_with_the_same_function_only(solve, tmp_path):
    rest = {"peak_hinge_force": lambda x: 1 + (x[1] - 12) ** 2}
    whole = solve(stated(power(2)), [shifted(CB2, SHIFT)], rest)
    assert resumed(solve, tmp_path / "a", power(2), power(2)).records == whole.records
    with pytest.raises(InputError, match="another problem"):
        resumed(solve, tmp_path / "b", power(2), power(3))
    with pytest.raises(InputError, match="another problem"):
        resumed(solve, tmp_path / "c", power(2), lambda peak_force: peak_force * peak_force)
    written_otherwise = lambda peak_force: getattr(peak_force, "__pow__")(2)  # noqa: E731, B009
    with pytest.raises(InputError, match="another problem"):
        resumed(solve, tmp_path / "d", power(2), written_otherwise)
    with pytest.raises(InputError, match="another problem"):
        resumed(solve, tmp_path / "e", mean(np.array([1.0, 2.0])), mean(np.array([1.0, 3.0])))


def test_keys_of_a_record_are_no_names():
    asked = stated(lambda peak_force: peak_force**2)
    point = Functions(asked, [shifted(CB2, SHIFT)]).one(asked.start())
    keys = set(record_of(Goal(asked, asked.objective), point, 0, 0, 0, None))
    assert keys - set(asked.names) <= RESERVED


# Drops without damping: one variable, one impact, so that any minimiser of one variable is a peer

BAR = jb.replace(jb.BarDrop(), {"impact.damping": 0.0})
SCENARIO = jb.BarDropScenario(height=0.194)
SPAN = (1e10, 1e12)  # N/m^e
SUM = {"sum": CustomQuantity(lambda peak_force, penetration: peak_force + 1e7 * penetration, "N")}


def drop(objective, quantities=None, **fields):
    return jb.Problem(
        BAR,
        [SCENARIO],
        [jb.Variable("impact.stiffness", *SPAN)],
        objective,
        duration=0.25,
        quantities=quantities or {},
        **fields,
    )


def simulated(function, stiffness):
    """The function of a tight run's numbers."""
    run = jb.simulate(jb.replace(BAR, {"impact.stiffness": stiffness}), SCENARIO, 0.25, rtol=1e-10)
    return float(function(float(run.peak_force), float(run.quantity("penetration"))))


@pytest.mark.slow
def test_a_sum_as_a_function_is_the_built_in_sum(evidence, programs):
    weights = {"peak_force": 1.0, "penetration": 1e7}
    usual = tune(drop(Objective(weights)), starts=1, iterations=20)
    before = {path.name for path in programs.rglob("*.program")}
    own = tune(drop(Objective({"sum": 1.0}), SUM), starts=1, iterations=20)
    assert {path.name for path in programs.rglob("*.program")} == before, "no program is compiled for the function"
    assert own.captures == usual.captures
    source = "the same tuning by a weighted sum"
    evidence(TOPIC, "least sum of two quantities", abs(own.objective[1] / usual.objective[1] - 1), 1e-9, source, "-")
    slopes = [t.goal.slope(t.before, np.ones(1))[0] for t in (own, usual)]
    evidence(TOPIC, "slope of a sum of two quantities", abs(slopes[0] / slopes[1] - 1), 1e-12, source, "-")


@pytest.mark.slow
def test_the_slope_of_a_product_is_that_of_differences(evidence):
    function = lambda peak_force, penetration: peak_force**2 * penetration**0.5  # noqa: E731
    asked = drop(Objective({"own": 1.0}), {"own": CustomQuantity(function, "N")})
    with Evaluator(asked) as evaluate:
        (point,) = evaluate([asked.start()], rtol=1e-10)
    stiffness, step = BAR.impact.stiffness, 1e-3
    by_log = (simulated(function, stiffness * np.exp(step)) - simulated(function, stiffness * np.exp(-step))) / (
        2 * step
    )
    slope = point.quantities_slope[0, -1, 0] / np.log(SPAN[1] / SPAN[0])
    error = abs(slope / by_log - 1)
    evidence(TOPIC, "slope of force² √depth by a stiffness", error, 1e-5, "differences of tight runs", "-")


@pytest.mark.slow
def test_the_slope_of_a_captures_effort_is_that_of_differences(evidence):
    """Table 2's capture, with its many impacts and a peak that moves with the spring."""
    function = lambda peak_force, stroke: peak_force * stroke  # noqa: E731
    asked = jb.Problem(
        jb.table2(),
        [jb.Scenario()],
        [jb.Variable("buffer.k_A", 100.0, 2000.0)],
        Objective({"effort": 1.0}),
        quantities={"effort": CustomQuantity(function, "N m")},
    )
    with Evaluator(asked) as evaluate:
        (point,) = evaluate([asked.start()], rtol=1e-9)

    def effort(shift):
        design = jb.replace(jb.table2(), {"buffer.k_A": 500.0 * np.exp(shift)})
        run = jb.simulate(design, jb.Scenario(), rtol=1e-10)
        return float(function(run.peak_force, run.stroke))

    by_log = (effort(1e-4) - effort(-1e-4)) / 2e-4
    error = abs(point.quantities_slope[0, -1, 0] / np.log(20.0) / by_log - 1)
    evidence(TOPIC, "slope of force times stroke of a capture", error, 1e-4, "differences of tight runs", "-")


@pytest.mark.slow
@pytest.mark.parametrize("optimizer", [None, "adam"])
def test_the_least_of_a_nonlinear_function_is_that_of_a_search_without_slopes(evidence, optimizer):
    import optax

    def function(peak_force, penetration):
        return (peak_force / 700.0) ** 2 + (penetration / 1e-4) ** 3

    peer = minimize_scalar(
        lambda log: simulated(function, np.exp(log)), bounds=np.log(SPAN), method="bounded", options={"xatol": 1e-6}
    )
    adam = optax.adam(optax.exponential_decay(0.05, 20, 0.5))
    chosen = {"optimizer": adam, "iterations": 100} if optimizer else {"iterations": 20}
    tuned = tune(drop(Objective({"own": 1.0}), {"own": CustomQuantity(function, "-")}), starts=1, searches=1, **chosen)
    least = abs(tuned.objective[1] / peer.fun - 1)
    name = "an optax optimiser's" if optimizer else "a tuning's"
    source = "scipy's bounded minimisation of tight runs"
    evidence(TOPIC, f"{name} least value of a nonlinear function", least, 1e-4, source, "-")
    assert tuned.feasible and tuned.residual < 1e-3


@pytest.mark.slow
def test_what_is_not_finite_is_an_error_at_the_start_and_a_failure_elsewhere():
    peak = float(jb.simulate(BAR, SCENARIO, 0.25).peak_force)
    bad = {
        "is nan at the start": lambda peak_force: jnp.log(1.0 - peak_force),
        "its derivative by peak_force is nan at the start": lambda peak_force: jnp.sqrt(0.0 * peak_force),
    }
    for message, function in bad.items():
        with pytest.raises(InputError, match=message):
            tune(drop(Objective({"own": 1.0}), {"own": CustomQuantity(function, "-")}), starts=1, iterations=2)
    only_softer = {"own": CustomQuantity(lambda peak_force: jnp.sqrt(1.2 * peak - peak_force), "-")}
    asked = drop(Objective({"peak_force": 1.0}), only_softer)
    with Evaluator(asked) as evaluate:
        start, stiff = evaluate([asked.start(), np.ones(1)])
    assert start.solved[0] and not stiff.solved[0] and not np.any(stiff.quantities_slope)
    assert "own is not finite" in Goal(asked, asked.objective).broken(stiff)[0]


@pytest.mark.slow
def test_a_front_of_an_own_quantity():
    asked = drop(Objective(), SUM)
    front = jb.pareto(asked, ["sum", "penetration"], points=2, starts=1, iterations=10)
    assert (
        front.non_dominated.all()
        and front.values[0, 0] < front.values[1, 0]
        and front.values[0, 1] > front.values[1, 1]
    )
    assert "sum [N]" in repr(front)
