"""What the tuner sees of real captures, against the independent reference, closed forms and differences."""

import itertools

import numpy as np
import pytest

from jaxbuffer import Case, Limits, Outcome, Problem, Scenario, Variable, get, replace, simulate, table2, tune
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.mechanisms.probe_cone.closed_form import first_impact_elasticities
from jaxbuffer.tuning.search.checks import lower_bound
from jaxbuffer.tuning.search.evaluation import Evaluator
from verification.cases import CASES, PARAMETERS
from verification.cases import PATHS as NAMES
from verification.test_first_impact import closed_form
from verification.test_first_impact import design as lossless

VARIABLES = PROBE_CONE.defaults.variables
REFERENCE = CASES["table2"]


def stated(scenarios, design=None, **fields):
    variables = [Variable(path, *bounds) for path, bounds in VARIABLES.items()]
    return Problem(design or table2(), scenarios, variables, **fields)


def coasting_share(duration):
    """Of Table 2: how far beyond the capture plane the tip would be at ``duration``, going on as fast as it crosses
    that plane, over its distance from it at the start; from a tight history and the reference's time of capture."""
    seen = simulate(table2(), Scenario(), rtol=1e-9, history=True).history
    last = seen.time[-4:] - seen.time[-1]
    receding = np.polynomial.Polynomial.fit(last, seen.throat_distance[-4:], 3).deriv()(0.0)
    return -receding * (duration - REFERENCE.values["end_time"]) / seen.throat_distance[0]


@pytest.mark.slow
def test_an_evaluation_agrees_with_the_independent_reference():
    """Values and elasticities of Table 2; a factor of a built mechanism moves both as the chain rule says."""
    spread = Case(Scenario(), (("buffer.k_A", 1.25),))
    softer = replace(table2(), {"buffer.k_A": 400.0})  # times 1.25 is Table 2
    with Evaluator(stated([Scenario()])) as nominal, Evaluator(stated([spread], softer)) as built:
        (point,) = nominal([nominal.problem.start()])
        (drawn,), (scattered,) = (e([e.problem.start()], rtol=1e-9) for e in (nominal, built))
    expected = REFERENCE.values
    names = nominal.problem.names
    assert point.code[0] == Outcome.captured and point.impacts[0] == expected["impacts"]
    assert point.quantities[0, 0] == pytest.approx(expected["peak_force"], rel=1e-4)
    assert point.quantities[0, names.index("stroke")] == pytest.approx(expected["stroke"], rel=1e-4)
    assert point.quantities[0, names.index("end_time")] == pytest.approx(expected["end_time"], rel=1e-3)
    assert point.margin[0] == pytest.approx(coasting_share(8.0), rel=1e-3)
    width = {path: np.log(high / low) for path, (low, high) in VARIABLES.items()}
    for k, path in enumerate(VARIABLES):
        (name,) = (short for short in PARAMETERS if NAMES[short] == path)
        elasticity = point.peaks_slope[0, 0, k] / width[path] / point.peaks[0, 0]
        assert elasticity == pytest.approx(expected["elasticity"][name], rel=1e-3, abs=1e-6)
    # the spring differs in its last digit, and every impact passes on more of that than it got
    np.testing.assert_allclose(scattered.peaks, drawn.peaks, rtol=1e-7)
    np.testing.assert_allclose(scattered.peaks_slope, drawn.peaks_slope, rtol=1e-4, atol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("duration", "outcome"),
    [(8.0, Outcome.captured), (0.6, Outcome.timeout)],
)
def test_the_margin_has_the_right_slope_and_no_jump_between_outcomes(duration, outcome):
    """Table 2 is captured after 0.719 s. Against central differences of tight solves, step 1e-5 of each range."""
    problem = stated([Scenario()], duration=duration)
    start, step = problem.start(), 1e-5 * np.eye(5)
    with Evaluator(problem) as evaluate:
        (point,) = evaluate([start], rtol=1e-9)
        around = evaluate([*(start + step), *(start - step)], rtol=1e-9)
    assert point.code[0] == outcome
    margins = np.array([other.margin[0] for other in around])
    differences = (margins[:5] - margins[5:]) / 2e-5
    np.testing.assert_allclose(point.margin_slope[0], differences, rtol=2e-3, atol=1e-4 * np.max(np.abs(differences)))


@pytest.mark.slow
def test_the_margin_is_continuous_where_time_runs_out():
    time = REFERENCE.values["end_time"]
    margins = []
    for duration in (time * (1 - 1e-4), time * (1 + 1e-4)):
        problem = stated([Scenario()], duration=duration)
        with Evaluator(problem) as evaluate:
            (point,) = evaluate([problem.start()])
        margins.append((int(point.code[0]), float(point.margin[0])))
    (before, below), (after, above) = margins
    assert (before, after) == (Outcome.timeout, Outcome.captured)
    assert -1e-3 < below < 0.0 < above < 1e-3


@pytest.mark.slow
def test_the_floor_without_loss_is_the_closed_form():
    """Without friction and loss the simulated bound is Hertz with T_c⁻; the lowest is that of the lightest tip."""
    problem = stated([Scenario(), Scenario(approach_speed=0.2)], lossless(1.0))
    found = lower_bound(problem, problem.start())
    np.testing.assert_allclose(found.simulated, found.closed_form, rtol=5e-6)
    lightest, _ = closed_form(replace(lossless(1.0), {"probe.tip_mass": 0.02}), Scenario(approach_speed=0.2))
    assert found.lowest == pytest.approx(lightest, rel=5e-6)
    assert found.at == {"probe.tip_mass": pytest.approx(0.02)}


@pytest.mark.long
def test_a_free_start_has_the_first_impacts_elasticities_too():
    """Without friction and loss, flown to where a contact start begins, the first impact is that of the closed form:
    its elasticities by masses and inertias, which do not move the touch, are the closed form's."""
    design, touching = lossless(1.0), Scenario(approach_speed=0.2)
    angle, slant = float(design.cone.half_angle), float(touching.contact_distance)
    off = -(design.cone.throat_radius + slant * np.sin(angle)) + design.probe.tip_radius * np.cos(angle)
    problem = stated([Scenario(start="free", offset=float(off), approach_speed=0.2)], design)
    found = lower_bound(problem, problem.start())
    peak, _ = closed_form(design, touching)
    assert found.simulated[0] == pytest.approx(peak, rel=1e-5) and np.isnan(found.closed_form[0])
    expected = first_impact_elasticities(design, touching)
    heavy = [path for path in expected if path.endswith("mass") or path.endswith("inertia")]
    assert expected["probe.tip_mass"] > 0.01 and expected["probe.rod_mass"] > 0.01
    for path in heavy:
        assert found.elasticities[path] == pytest.approx(expected[path], abs=1e-4), path
    assert abs(found.elasticities["cone.half_angle"]) > 0.1


@pytest.mark.slow
def test_the_lower_bound_of_a_limited_hinge_force_is_the_first_impacts():
    """The first impact is over before 1 ms. Its hinge force at the least is no more than that of a grid of designs, and
    the slope that leads there is that of differences; without a limit on it, it is not computed."""
    problem = stated([Scenario(approach_speed=0.2)], limits=Limits(at_most={"peak_hinge_force": 50.0}))
    least = lower_bound(problem, problem.start()).least["peak_hinge_force"]

    def hinge_force(scaled):
        design = problem.built(scaled)
        return float(simulate(design, Scenario(approach_speed=0.2), duration=1e-3, rtol=1e-9).peak_hinge_force)

    assert hinge_force(least.scaled) == pytest.approx(least.value, rel=1e-5)
    corners = np.array(list(itertools.product([0.0, 1.0], repeat=5)))
    forces = [hinge_force(corner) for corner in corners]
    assert least.value < min(forces) * (1.0 + 1e-5) and min(forces) < 0.9 * hinge_force(problem.start())
    assert corners[int(np.argmin(forces))][4] == least.scaled[4] == 1.0, "the heaviest tip"
    # Of numbers that are no variables, by differences of other steps and a tighter tolerance.
    for path in ("cone.half_angle", "probe.rod_mass"):
        built = problem.built(least.scaled)
        up, down = (
            simulate(replace(built, {path: factor * get(built, path)}), Scenario(approach_speed=0.2), 1e-3, rtol=1e-9)
            for factor in (1.003, 0.997)
        )
        slope = float(np.log(up.peak_hinge_force / down.peak_hinge_force)) / np.log(1.003 / 0.997)
        assert least.elasticities[path] == pytest.approx(slope, abs=1e-4) and abs(slope) > 0.02
    assert lower_bound(stated([Scenario()]), problem.start()).least == {}


@pytest.mark.slow
def test_a_short_tuning_of_captures(tmp_path):
    """Three steps lower the peak at 0.2 m/s; what is reported is what the result's own captures have."""
    problem = stated([Scenario(approach_speed=0.2)])
    tuned = tune(problem, iterations=3, starts=1, searches=1, folder=tmp_path)
    before, after = tuned.objective
    assert tuned.feasible and after < 0.97 * before
    assert 0.0 <= tuned.above_lower_bound < 0.05 and tuned.lower_bound.lowest <= tuned.lower_bound.simulated[0]
    assert tuned.gradient_error < 1e-3
    with Evaluator(problem) as evaluate:
        (again,) = evaluate([[v.scaled(float(get(tuned.design, v.path))) for v in problem.variables]], rtol=1e-9)
    assert again.quantities[0, 0] == pytest.approx(after, rel=1e-7)
    assert "peak_force, worst over the cases" in repr(tuned) and len((tmp_path / "log.jsonl").read_text()) > 0
    assert tuned.captures == len(tuned.records) + 2
