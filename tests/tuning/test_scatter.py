"""Samples of what scatters, and a result in the corners of the ranges."""

import itertools
import json

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.output.folder import load
from jaxbuffer.output.tuned_records import tuned_record
from jaxbuffer.pages.review import review
from jaxbuffer.study.load import loads
from jaxbuffer.tuning import Case, Distribution, Scatter

HEIGHT = Distribution("uniform", 0.15, 0.2)  # m
STIFFNESS = Distribution("uniform", 0.8, 1.2)
MOST = 1800.0  # N, between the peaks in the lower and in the upper corners


def scattered(count: int) -> Scatter:
    return Scatter(3, {}, {f"number_{k}": Distribution("uniform", -1.0, 1.0) for k in range(count)})


def signs(count: int) -> np.ndarray:
    """The corners as rows of -1 and 1."""
    return np.array([[value for _, value in case.factors] for case in scattered(count).corners([Case(jb.Scenario())])])


@pytest.mark.parametrize("count", range(1, 7))
def test_each_corner_of_few_ranges_is_run_once(count):
    assert sorted(map(tuple, signs(count))) == sorted(itertools.product((-1.0, 1.0), repeat=count))


@pytest.mark.parametrize("count", [7, 12, 32, 40, 70])
def test_of_many_ranges_each_two_take_all_combinations_equally_often(count):
    """Also each three of up to 32: products of two or three columns of a fraction sum to zero."""
    rows = signs(count)
    assert len(rows) == (64 if count < 64 else 128) and len(set(map(tuple, rows))) == len(rows)
    assert not rows.sum(axis=0).any()
    assert np.array_equal(rows.T @ rows, len(rows) * np.eye(count))
    if count <= 32:
        assert not np.einsum("ra,rb,rc->abc", rows, rows, rows).any()


def test_a_normal_range_ends_two_deviations_from_the_mean():
    scatter = Scatter(4, {"misalignment": Distribution("normal", 0.01, 0.02)})
    ends = [case.scenario.misalignment for case in scatter.corners([Case(jb.Scenario())])]
    assert sorted(ends) == pytest.approx([-0.03, 0.05], abs=1e-15)
    assert [case.scenario.misalignment for case in scatter.middle([Case(jb.Scenario())])] == pytest.approx([0.01])


def test_every_sample_is_taken_at_every_point_of_a_grid():
    text = """[problem.grid]
    approach_speed = ["10 cm/s", "20 cm/s", "30 cm/s"]
    [problem.sample]
    count = 5
    scenario.misalignment = {uniform = ["-2 deg", "2 deg"]}
    factors.buffer.k_A = {uniform = [0.9, 1.1]}"""
    problem = loads(text.encode(), "robust.toml").problem()
    met = [(case.scenario.approach_speed, case.scenario.misalignment, case.factors) for case in problem.cases]
    assert len(met) == 15 and met[5:10] == [(0.2, *sample) for _, *sample in met[:5]]
    assert len({(angle, factors) for _, angle, factors in met}) == 5
    assert problem.format(problem.objective) == "peak_force, largest of 5 samples at each of 3 scenarios, no bound"


@pytest.fixture(scope="module")
def tuned():
    problem = jb.Problem(
        jb.BarDrop(),
        [jb.BarDropScenario()],
        [jb.Variable("impact.damping", 900.0, 1100.0)],
        limits=jb.Limits(at_most={"peak_force": MOST}),
        duration=0.25,
        scatter=Scatter(3, {"height": HEIGHT}, {"impact.stiffness": STIFFNESS}, seed=2),
    )
    return jb.tune(problem, starts=1, iterations=1)


def test_the_result_is_run_in_the_corners(tuned):
    """As `simulate` finds it there; the samples' worst is below."""
    design, peaks = tuned.design, {}
    for height, factor in itertools.product(HEIGHT.range, STIFFNESS.range):
        built = jb.replace(design, {"impact.stiffness": factor * jb.get(design, "impact.stiffness")})
        run = jb.simulate(built, jb.BarDropScenario(height=height), 0.25, rtol=1e-9)
        peaks[height, factor] = float(run.peak_force)
    corners = tuned.corners
    found = {(it.scenario.height, it.factors[0][1]): x for it, x in zip(corners.cases, corners.values, strict=True)}
    assert found == pytest.approx(peaks, rel=1e-7)
    assert corners.largest == max(corners.values) > tuned.objective[1]
    kept = [peak <= MOST for peak in peaks.values()]
    assert 0 < sum(kept) < 4 and corners.holding == sum(kept)


def test_a_design_that_fails_in_a_corner_is_not_feasible(tuned, tmp_path):
    """One verdict: the samples keep the limit, some corners do not."""
    holding = f"the design holds in {tuned.corners.holding} of 4 corners of the sampled ranges only"
    assert tuned.goal.feasible(tuned.after) and not tuned.feasible
    assert tuned.broken_limits == [holding] and tuned.message.startswith(holding)
    (tmp_path / "tuned.json").write_text(json.dumps(tuned_record(tuned)))
    page = review([load(tmp_path)])
    badges = {badge.text: badge.mark for badge in page.verdicts}
    assert badges[f"the design holds in {tuned.corners.holding} of 4 corners only"] == "bad"
    assert not any("all limits kept" in text for text in badges)


def test_the_worst_of_samples_is_said_to_be_no_bound(tuned):
    text, record = " ".join(repr(tuned).split()), json.loads(json.dumps(tuned_record(tuned)))
    holding, largest = tuned.corners.holding, f"{tuned.corners.largest:.5g} N"
    for said in (text, record["corners"]["lines"][0]):
        assert f"all 4 corners of the 2 sampled ranges: the design holds in {holding} of 4" in said
        assert f"the largest objective there is {largest}" in said
    assert "peak_force, largest of 3 samples, no bound" in text
    assert record["objective"] == "peak_force, largest of 3 samples, no bound"
    assert record["corners"]["largest_objective"] == tuned.corners.largest
    assert sum(not it["broken"] for it in record["corners"]["each"]) == holding
