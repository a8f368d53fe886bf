"""Tolerances: a tuned design holds in every corner, as runs of each one by itself say."""

import dataclasses
import itertools
import json

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.output.folder import load
from jaxbuffer.output.tuned_records import tuned_record
from jaxbuffer.pages.review import review
from jaxbuffer.tuning.tolerances.corners import Corners

MOST = 1800.0  # N, between the peaks in the lower and in the upper corners
BOUNDS = {"impact.damping": (900.0, 1100.0), "impact.stiffness": (1e11, 4e11), "impact.ramp_depth": (5e-6, 2e-5)}
SEVEN = {
    "scenario.height": 0.1,
    "impact.stiffness": 0.2,
    # The high end of all others and the low one of this: no corner of the fraction that is run in any case.
    "impact.ramp_depth": 0.3,
    "impact.damping": 0.1,
    "bar.length": 0.02,
    "bar.diameter": 0.05,
    "bar.density": 0.01,
}  # shares
SCENARIO = jb.BarDropScenario(height=0.17)


def stated(most=MOST, **tolerances):
    return jb.Problem(
        jb.BarDrop(),
        [SCENARIO],
        [jb.Variable(path, *ends) for path, ends in BOUNDS.items()],
        limits=jb.Limits(at_most={"peak_force": most}),
        duration=0.25,
        tolerances=tolerances,
    )


def seven(most=MOST):
    return stated(most, **{path: f"{100 * share:g} %" for path, share in SEVEN.items()})


@pytest.fixture(scope="module")
def tuned():
    problem = stated(**{"impact.stiffness": "20 %", "impact.ramp_depth": "3 µm", "impact.damping": "10 %"})
    return jb.tune(problem, starts=1, iterations=1)


@pytest.fixture(scope="module")
def peaks(tuned):
    """Of each corner, built by hand and simulated by itself [N]."""
    drawn = {path: jb.get(tuned.design, path) for path in BOUNDS}
    found = {}
    for signs in itertools.product((-1, 1), repeat=3):
        built = {
            "impact.stiffness": drawn["impact.stiffness"] * (1.0 + 0.2 * signs[0]),
            "impact.ramp_depth": drawn["impact.ramp_depth"] + 3e-6 * signs[1],
            "impact.damping": drawn["impact.damping"] * (1.0 + 0.1 * signs[2]),
        }
        run = jb.simulate(jb.replace(tuned.design, built), SCENARIO, 0.25, rtol=1e-9)
        found[signs] = float(run.peak_force)
    return found


@pytest.mark.slow
def test_each_corner_is_as_simulated_by_itself(tuned, peaks):
    assert sorted(tuned.corners.values) == pytest.approx(sorted(peaks.values()), rel=1e-7)
    holding = sum(peak <= MOST for peak in peaks.values())
    assert tuned.corners.holding == holding
    assert f"corners in which the design holds {holding} of 8" in " ".join(repr(tuned).split())
    # The tuning served them all, and its objective is the largest.
    assert tuned.objective[1] == pytest.approx(max(peaks.values()), rel=1e-7)


@pytest.mark.slow
def test_shares_are_those_of_the_corners(tuned, peaks, evidence):
    """Half the difference between both ends, averaged over all others: a main effect of the factorial design."""
    (spread,) = tuned.spreads
    main = [np.mean([0.5 * (1 if s[k] > 0 else -1) * 2 * p for s, p in peaks.items()]) for k in range(3)]
    error = np.max(np.abs(np.array(main) - spread.effects)) / np.max(np.abs(main))
    evidence("Tuning", "change by a tolerance, first order", error, spread.error + 0.02, "main effects of all corners")
    assert spread.drawn == pytest.approx(
        float(jb.simulate(tuned.design, SCENARIO, 0.25, rtol=1e-9).peak_force), rel=1e-7
    )
    assert (spread.low, spread.high) == pytest.approx((min(peaks.values()), max(peaks.values())), rel=1e-7)


@pytest.mark.slow
def test_half_of_a_tolerance_is_as_simulated_by_itself(tuned, peaks):
    worst = max(peaks, key=peaks.get)
    address, value = next(iter(tuned.tightening.after.items()))
    drawn, shares = jb.get(tuned.design, address), {"impact.stiffness": 0.2, "impact.damping": 0.1}
    number = list(tuned.problem.tolerances).index(address)
    built = {
        path: jb.get(tuned.design, path) * (1.0 + share * worst[list(tuned.problem.tolerances).index(path)])
        for path, share in shares.items()
    }
    built["impact.ramp_depth"] = jb.get(tuned.design, "impact.ramp_depth") + 3e-6 * worst[1]
    built[address] = 0.5 * (drawn + built[address])
    run = jb.simulate(jb.replace(tuned.design, built), SCENARIO, 0.25, rtol=1e-9)
    assert value == f"{float(run.peak_force):.5g} N" and number in (0, 1, 2)


def brute(design):
    """The peak force in all 128 corners, by a sweep [N]."""
    drawn = {path: SCENARIO.height if path == "scenario.height" else jb.get(design, path) for path in SEVEN}
    over = {path: [value * (1.0 - SEVEN[path]), value * (1.0 + SEVEN[path])] for path, value in drawn.items()}
    return jb.sweep(design, SCENARIO, over=over, duration=0.25, rtol=1e-9).columns["peak_force"]


@pytest.mark.slow
def test_the_worst_of_seven_tolerances_is_that_of_all_corners(tmp_path):
    """Also of a run that is interrupted and goes on."""
    problem, options = seven(2500.0), {"starts": 1, "iterations": 2}
    tuned = jb.tune(problem, **options)
    assert tuned.corners.largest == pytest.approx(brute(tuned.design).max(), rel=1e-7)
    assert tuned.feasible and tuned.corners.searched and not tuned.corners.whole
    assert tuned.objective[1] == pytest.approx(tuned.corners.largest, rel=1e-7)
    assert "no proof that no other corner is worse" in " ".join(repr(tuned).split())

    def stop(record):
        if record["evaluation"] == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        jb.tune(problem, folder=tmp_path, report=stop, **options)
    again = jb.tune(problem, folder=tmp_path, resume=True, **options)
    assert (
        again.design == tuned.design and again.captures == tuned.captures and again.problem.signs == tuned.problem.signs
    )


def made_up(holding):
    """A made-up tuning with tolerances that holds in some of two corners."""
    from made_up import made_up_tuning

    scenarios, variables = [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)]
    problem = jb.Problem(jb.table2(), scenarios, variables, tolerances={"buffer.k_A": "10 %"})
    broken = tuple(() if k < holding else ("stroke 26 mm is above 25 mm",) for k in range(2))
    corners = Corners(problem.corners, broken, np.array([200.0, 210.0]), 1, 1, True, 205.0, True, True, "tolerances")
    return dataclasses.replace(made_up_tuning(problem), corners=corners)


@pytest.mark.parametrize(("holding", "mark"), [(2, "good"), (1, "bad")])
def test_a_page_says_in_how_many_corners_a_design_holds(holding, mark, tmp_path):
    tuned = made_up(holding)
    assert tuned.feasible == (holding == 2)
    (tmp_path / "tuned.json").write_text(json.dumps(tuned_record(tuned)))
    page = review([load(tmp_path)])
    marks = {badge.text: badge.mark for badge in page.verdicts if "corners" in badge.text}
    assert list(marks.values()) == [mark] and f"{holding} of 2 corners" in next(iter(marks))
    (section,) = (it for it in page.sections if it.title == "Tolerances")
    said = [*section.warnings, *section.text]
    assert any(f"the design holds in {holding} of 2" in line for line in said)
    assert bool(section.warnings) == (holding == 1)
    asked = next(it for it in page.sections if it.title == "What is asked").tables[0].rows
    assert ["tolerance", "buffer.k_A", "±10 %"] in [list(row) for row in asked]
