"""Tuning with a latch: until held, by the points of a measured curve."""

import numpy as np
import pytest

from jaxbuffer import Limits, Objective, Problem, Scenario, Variable, replace, sensitivity, simulate, table2, tune

FORCE = "buffer.spring_curve.force"
LATCHED = {
    "buffer.spring_curve": [[0.005, 2.0], [0.01, 6.0], [0.02, 14.0]],  # m, N
    "latch.stiffness": 2e4,  # N/m
    "latch.damping": 100.0,  # N s/m
}


@pytest.mark.long
def test_a_curve_is_tuned_until_the_vehicles_are_nearly_at_rest():
    """Two free starts, either flank first; the energy left after 4 s falls, every limit holds, the curve rises."""
    design = replace(table2(), LATCHED)
    problem = Problem(
        design,
        [Scenario(start="free", offset=-0.005), Scenario(start="free", offset=0.005, approach_speed=0.12)],
        [
            Variable("buffer.c_A", 2.0, 30.0),
            Variable(f"{FORCE}[1]", 3.0, 9.0),
            Variable(f"{FORCE}[2]", 10.0, 25.0),
        ],
        Objective({"relative_energy": 1.0}),
        Limits(at_most={"stroke": 0.025, "hinge_angle": np.radians(3.0), "peak_latch_force": 100.0}),
        duration=4.0,
    )
    tuned = tune(problem, iterations=3, starts=1, searches=1)
    column = problem.names.index("relative_energy")
    before, after = (evaluation.quantities[:, column].max() for evaluation in (tuned.before, tuned.after))
    assert after < 0.7 * before
    assert not tuned.goal.broken(tuned.after)
    forces = tuned.design.buffer.spring_curve.values
    assert forces[0] == 2.0 and np.all(np.diff(forces) > 0.0)


@pytest.mark.long
def test_derivatives_by_a_curves_points_are_those_of_differences():
    """Central differences at rtol 1e-9, of the largest stroke and latch force."""
    design, scenario = replace(table2(), LATCHED), Scenario(start="free", offset=-0.005)
    names = ("stroke", "peak_latch_force")
    found = sensitivity(design, scenario, (f"{FORCE}[1]",), 1.5, quantities=names, certify="none", rtol=1e-8)

    def values(force):
        run = simulate(replace(design, {f"{FORCE}[1]": force}), scenario, 1.5, rtol=1e-9)
        return np.array([float(run.quantity(name)) for name in names])

    step = 1e-3  # N
    differences = (values(6.0 + step) - values(6.0 - step)) / (2.0 * step)
    np.testing.assert_allclose(found.gradients[:, 0], differences, rtol=1e-3)


@pytest.mark.long
@pytest.mark.parametrize(
    "limits", [Limits(held=True, at_most={"stroke": 0.025}), Limits(at_most={"settling_time": 1.8})]
)
def test_a_design_that_is_not_held_is_led_back_to_it(limits):
    """Latched and not held within 3 s to begin with; slopes through the energy left lead on, and the first impact of a
    free start is known: with the buffer it can only be higher."""
    parts = {"latch.stiffness": 2e3, "latch.damping": 50.0, "latch.quiet": 1e-2, "buffer.c_A": 10.0}
    scenarios = [Scenario(start="free", offset=0.01, approach_speed=speed) for speed in (0.1, 0.15)]
    variables = [Variable("buffer.k_A", 200.0, 2000.0), Variable("buffer.c_A", 1.0, 60.0)]
    problem = Problem(replace(table2(), parts), scenarios, variables, limits=limits, duration=3.0)
    tuned = tune(problem, iterations=8, starts=1)
    assert str(tuned.end_count(tuned.before)) == "held in 0 of 2"
    assert tuned.feasible and str(tuned.end_count(tuned.after)) == "held in 2 of 2"
    settling = tuned.reported(tuned.after)[:, problem.names.index("settling_time")]
    assert np.all(settling <= limits.at_most.get("settling_time", 3.0))
    for scenario in scenarios:
        assert simulate(tuned.design, scenario, 3.0).outcome.name == "held"
    assert tuned.lower_bound.unknown == 0 and 0.0 < tuned.above_lower_bound < 0.02
