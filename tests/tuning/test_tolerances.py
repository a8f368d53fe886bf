"""Tolerances: a tuned design holds in every corner, as runs of each one by itself say."""

import itertools

import pytest

import jaxbuffer as jb

HEIGHT, STIFFNESS, DAMPING = 0.02, 0.2, 0.1  # m, shares
MOST = 1800.0  # N, between the peaks in the lower and in the upper corners


def stated(**tolerances):
    return jb.Problem(
        jb.BarDrop(),
        [jb.BarDropScenario(height=0.17)],
        [jb.Variable("impact.damping", 900.0, 1100.0)],
        limits=jb.Limits(at_most={"peak_force": MOST}),
        duration=0.25,
        tolerances=tolerances,
    )


@pytest.fixture(scope="module")
def tuned():
    problem = stated(**{"scenario.height": "2 cm", "impact.stiffness": "20 %", "impact.damping": "10 %"})
    return jb.tune(problem, starts=1, iterations=1)


@pytest.fixture(scope="module")
def peaks(tuned):
    """Of each corner, built by hand and simulated by itself [N]."""
    found = {}
    for signs in itertools.product((-1, 1), repeat=3):
        built = {
            "impact.stiffness": jb.get(tuned.design, "impact.stiffness") * (1.0 + signs[1] * STIFFNESS),
            "impact.damping": jb.get(tuned.design, "impact.damping") * (1.0 + signs[2] * DAMPING),
        }
        scenario = jb.BarDropScenario(height=0.17 + signs[0] * HEIGHT)
        found[signs] = float(jb.simulate(jb.replace(tuned.design, built), scenario, 0.25, rtol=1e-9).peak_force)
    return found


def test_each_corner_is_as_simulated_by_itself(tuned, peaks):
    values = sorted(tuned.corners.values)
    assert values == pytest.approx(sorted(peaks.values()), rel=1e-7)
    holding = sum(peak <= MOST for peak in peaks.values())
    assert 0 < holding < 8 and tuned.corners.holding == holding and not tuned.feasible
    assert f"the design holds in {holding} of 8" in " ".join(repr(tuned).split())
    print(tuned)


SEVEN = {
    "scenario.height": 0.1,
    "impact.stiffness": 0.2,
    "impact.damping": 0.1,
    "impact.ramp_depth": 0.3,
    "bar.length": 0.02,
    "bar.diameter": 0.05,
    "bar.density": 0.01,
}  # shares


def test_the_worst_of_seven_tolerances_is_that_of_all_corners():
    """All 128, by a sweep."""
    tuned = jb.tune(stated(**{path: f"{100 * share} %" for path, share in SEVEN.items()}), starts=1, iterations=1)
    problem, design = tuned.problem, tuned.design
    drawn = {path: 0.17 if path == "scenario.height" else jb.get(design, path) for path in SEVEN}
    over = {path: [value * (1.0 - SEVEN[path]), value * (1.0 + SEVEN[path])] for path, value in drawn.items()}
    every = jb.sweep(design, jb.BarDropScenario(height=0.17), over=over, duration=0.25, rtol=1e-9)
    peaks = every.columns["peak_force"]
    print(tuned, peaks.max(), tuned.corners.largest, problem.signs)
    assert tuned.corners.largest == pytest.approx(peaks.max(), rel=1e-7)
