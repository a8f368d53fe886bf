"""The worst corner of many tolerances, and whose scatter matters: of functions whose corners can all be looked at."""

import itertools

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.tuning.search.evaluation import Evaluation
from jaxbuffer.tuning.search.measurement import PEAKS
from jaxbuffer.tuning.tolerances.corner_search import CornerSearch, with_corners, worse_corners
from jaxbuffer.tuning.tolerances.corners import corners, run_corners
from jaxbuffer.tuning.tolerances.spread import spread_lines, spreads, tightening
from jaxbuffer.tuning.tolerances.targets import targets
from tuning.analytic import gradient

NUMBERS = (
    *("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T", "probe.tip_radius", "probe.tip_mass", "probe.rod_mass"),
    "probe.length",
)
SHARE = 0.1


class Functions:
    """Stands in for an `Evaluator`: the peak force is ``force`` of each tolerance's place from -1 to 1, the stroke
    ``stroke`` of it."""

    tight = 1e-9

    def __init__(self, problem, force, stroke=lambda x: 0.01 + 0 * x[0]):
        self.problem, self.functions, self.runs = problem, {"peak_force": force, "stroke": stroke}, 0

    def __call__(self, points, rtol=None, slopes=None, cases=None):
        return [self.by_tolerances(point, self.problem.cases if cases is None else cases) for point in points]

    def by_tolerances(self, scaled, cases, rtol=None):
        problem, count, numbers = self.problem, len(cases), len(self.problem.tolerances)
        self.runs += count
        values = {name: np.zeros(count) for name in problem.names}
        slopes = {name: np.zeros((count, numbers)) for name in problem.names}
        for k, case in enumerate(cases):
            factors = dict(case.factors)
            at = np.array([(factors.get(path, 1.0) - 1.0) / SHARE for path in problem.tolerances])
            for name, function in self.functions.items():
                values[name][k], slopes[name][k] = gradient(function, at)
        peaks, peaks_slope = np.zeros((count, PEAKS)), np.zeros((count, PEAKS, numbers))
        peaks[:, 0], peaks_slope[:, 0] = values["peak_force"], slopes["peak_force"]
        others = problem.names[1:]
        return Evaluation(
            scaled=np.asarray(scaled),
            code=np.full(count, int(jb.Outcome.captured)),
            solved=np.ones(count, bool),
            succeeded=np.ones(count, bool),
            impacts=np.full(count, 5),
            peaks=peaks,
            slots=np.tile(np.arange(PEAKS), (count, 1)),
            rest=np.column_stack([values[name] for name in others]),
            margin=np.ones(count),
            first=peaks[:, 0],
            peaks_slope=peaks_slope,
            rest_slope=np.stack([slopes[name] for name in others], axis=1),
            margin_slope=np.zeros((count, numbers)),
            by_peak=np.zeros((count, len(others))),
        )


def stated(count, **fields):
    tolerances = dict.fromkeys(NUMBERS[:count], f"{100 * SHARE:g} %")
    variables = [jb.Variable("buffer.k_A", 100.0, 2000.0)]
    return jb.Problem(jb.table2(), [jb.Scenario()], variables, tolerances=tolerances, **fields)


def bent(seed, interaction):
    """A force with random slopes, and interactions that turn some of them round between the corners."""
    rng = np.random.default_rng(seed)
    slopes, pairs = rng.normal(size=8), np.triu(rng.normal(size=(8, 8)), 1)
    return lambda x: 200.0 + 10.0 * (slopes @ x + interaction * x @ pairs @ x)


EVERY = np.array(list(itertools.product((-1.0, 1.0), repeat=8)))


@pytest.mark.parametrize("interaction", [0.0, 0.2, 0.4])
def test_the_worst_corner_of_eight_is_the_worst_of_all_256(interaction, evidence):
    """Of ten forces each; more would be missed with interactions larger than the slopes."""
    problem, short = stated(8), 0.0
    for seed in range(10):
        force = bent(seed, interaction)
        row = np.array(worse_corners(problem, Functions(problem, force), problem.start())[0])
        every = [force(signs) for signs in EVERY]
        short = max(short, (max(every) - force(row)) / (max(every) - 200.0))
    claim = f"worst of 2⁸ corners found by search, interactions {interaction:g} of the slopes"
    evidence("Tuning", claim, short, 1e-12, "all 256 corners of ten random functions")


def test_a_worst_corner_far_from_what_slopes_name_is_reached_by_its_neighbours():
    """As drawn the slopes point to the low ends; only in the corners does the product turn them."""

    def force(x):
        return 200.0 - 0.1 * np.sum(x) + 5.0 * x[0] * x[1] + 7.0 * x[0]

    problem = stated(7)
    search = CornerSearch(problem, Functions(problem, force), problem.start())
    worst = search.worst()[0]
    assert worst == (0, (1.0, 1.0, -1.0, -1.0, -1.0, -1.0, -1.0))
    assert search.values[worst][0] == pytest.approx(200.0 + 0.3 + 12.0)


def test_the_search_ends_where_no_corner_is_worse():
    problem, force = stated(8), bent(4, 0.4)
    evaluator = Functions(problem, force)
    found = worse_corners(problem, evaluator, problem.start())
    more = with_corners(problem, found)
    assert len(more.cases) == 1 + len(found) and more.corners == more.cases[1:]
    assert worse_corners(more, Functions(more, force), more.start()) == ()


def test_a_limit_that_is_kept_in_its_worst_corner_asks_for_none():
    problem = stated(7, limits=jb.Limits(at_most={"stroke": 0.025}))
    loose = with_corners(problem, [[1.0] * 7])
    for most, asked in ((0.02, 0), (0.03, 1)):
        evaluator = Functions(loose, lambda x: 200.0 + x[0], lambda x, most=most: 0.01 - (most - 0.01) * x[1])
        assert len(worse_corners(loose, evaluator, loose.start())) == asked


def test_more_than_six_tolerances_alone_have_no_corners_among_the_cases():
    assert len(stated(6).cases) == 65 and len(stated(7).cases) == 1
    assert stated(7).needs_search and not stated(6).needs_search


def test_shares_of_a_linear_force_are_those_of_its_slopes():
    problem = stated(3, limits=jb.Limits(at_most={"stroke": 0.025}))
    force, stroke = (lambda x: 200.0 + 3.0 * x[0] - 4.0 * x[1]), (lambda x: 0.02 + 0.001 * x[2] ** 3)
    evaluator = Functions(problem, force, stroke)
    runs = run_corners(problem, evaluator, problem.start(), 1e-9)
    of_force, of_stroke = spreads(problem, evaluator, problem.start(), runs, 1e-9)
    assert of_force.shares == pytest.approx([9 / 25, 16 / 25, 0.0]) and of_force.error < 1e-12 and of_force.trusted
    assert (of_force.low, of_force.drawn, of_force.high) == pytest.approx((193.0, 200.0, 207.0))
    # A cube has no slope in the middle, and all of its change at the ends: the first order misses all of it.
    assert of_stroke.error == pytest.approx(1.0) and not of_stroke.trusted
    lines = spread_lines(problem, (of_force, of_stroke), None)
    assert len(lines) == 1 and "buffer stroke are no guide" in lines[0]


def test_the_tolerance_to_tighten_first_is_that_whose_half_helps_most():
    """In the worst corner, the stroke is 20 + 3 + 2 mm, and 23.5 mm with half of the third tolerance."""
    problem = stated(3, limits=jb.Limits(at_most={"stroke": 0.024}))
    evaluator = Functions(problem, lambda x: 200.0 + 50.0 * x[0], lambda x: 0.02 + 0.002 * x[1] + 0.003 * x[2])
    runs = run_corners(problem, evaluator, problem.start(), 1e-9)
    first = tightening(problem, evaluator, problem.start(), runs, 1e-9)
    assert first.before == "25 mm, limit ≤ 24 mm" and first.after == {"buffer.k_T": "23.5 mm", "buffer.c_A": "24 mm"}
    assert first.line().startswith("tighten first the tolerance of buffer.k_T: ")
    found = corners(problem, runs)
    assert (
        found.holding == 6
        and found.whole
        and found.verdict == "the design holds in 6 of 8 corners of the tolerances only"
    )


def test_where_no_limit_is_near_the_objective_says_what_to_tighten():
    problem = stated(2)
    evaluator = Functions(problem, lambda x: 200.0 + 5.0 * x[0] - 2.0 * x[1])
    runs = run_corners(problem, evaluator, problem.start(), 1e-9)
    first = tightening(problem, evaluator, problem.start(), runs, 1e-9)
    assert first.title == "objective" and list(first.after) == ["buffer.k_A", "buffer.c_A"]
    assert first.before == "207 N" and first.after["buffer.k_A"] == "204.5 N"


def test_targets_are_objective_limits_and_the_end():
    titles = [it.title for it in targets(stated(2, limits=jb.Limits(at_most={"stroke": 0.025}, impacts=30)))]
    assert titles[0] == "objective" and {"buffer stroke", "impacts", "capture share"} < set(titles)
