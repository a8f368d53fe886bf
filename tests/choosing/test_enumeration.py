"""The enumeration against a look at every number of a made-up table: same winner, same ranking, fewer runs."""

import dataclasses

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer import Limits, Objective, Problem, Scenario, table2
from jaxbuffer.choosing.enumeration import Enumeration
from jaxbuffer.choosing.order import Second
from jaxbuffer.choosing.runs import Ended
from jaxbuffer.tuning.search.measurement import Measurement

CASES, STROKE = 5, 0.025  # load cases; limit [m]


class MadeUpRuns:
    """Runs whose peak force [N], stroke [m] and outcome stand in tables (combinations, cases)."""

    def __init__(self, force, stroke, captured, objective):
        scenarios = [Scenario(approach_speed=0.1 + 0.01 * k) for k in range(force.shape[1])]
        self.problem = Problem(table2(), scenarios, [], objective, Limits(at_most={"stroke": STROKE}))
        self.force, self.stroke, self.captured = force, stroke, captured
        self.misfits, self.wanted = {}, []

    def each(self, wanted, rtol=None, done=None):
        self.wanted += wanted
        return [self.measurement(*key) for key in wanted]

    def measurement(self, number, case):
        outcomes = self.problem.mechanism.outcomes
        outcome = outcomes["captured"] if self.captured[number, case] else outcomes["escaped"]
        numbers = dict.fromkeys(self.problem.measured, 0.1)
        numbers |= {"peak_force": self.force[number, case], "stroke": self.stroke[number, case], "stroke_share": 0.5}
        numbers["capture_share"] = 0.2 if self.captured[number, case] else -0.2
        return Measurement.of_numbers(
            self.problem, Ended(self.problem.mechanism, outcome, self.problem.design), 1, numbers
        )


def made_up(seed, objective, count=400):
    """A table in which some cases are harder than others, as for designs."""
    random = np.random.default_rng(seed)
    soft, hard = random.uniform(0.0, 1.0, (count, 1)), np.linspace(0.7, 1.0, CASES)[random.permutation(CASES)]
    force = (200.0 + 300.0 * soft) * hard * random.uniform(0.9, 1.0, (count, CASES))
    stroke = (0.03 - 0.02 * soft) * hard * random.uniform(0.9, 1.0, (count, CASES))
    return MadeUpRuns(force, stroke, random.uniform(size=(count, CASES)) > 0.02, objective)


def brute_force(runs, aggregate, constant, allowed, ranking):
    """The best combinations by looking at all numbers."""
    keeps = np.all((runs.stroke <= STROKE) & runs.captured, axis=1) & allowed
    value = np.where(keeps, np.apply_along_axis(aggregate, 1, runs.force) + constant, np.inf)
    return [int(k) for k in np.argsort(value, kind="stable")[:ranking] if keeps[k]]


OVER = {
    "worst": (Objective(), np.max),
    "mean": (Objective(over="mean"), np.mean),
    # of five cases the worst two fifths are the two largest
    "cvar": (Objective(over="cvar", level=0.6), lambda row: np.mean(np.sort(row)[-2:])),
}


@pytest.mark.parametrize("over", OVER)
@pytest.mark.parametrize("seed", range(4))
def test_the_ranking_is_that_of_a_look_at_every_run(over, seed):
    objective, aggregate = OVER[over]
    runs, ranking = made_up(seed, objective), 1 + 3 * seed
    random = np.random.default_rng(99 + seed)
    constant, allowed = random.uniform(0.0, 40.0, 400), random.uniform(size=400) > 0.1
    search = Enumeration(runs, objective, constant=constant, allowed=allowed, ranking=ranking)
    search.run()
    assert [int(k) for k in search.best()] == brute_force(runs, aggregate, constant, allowed, ranking)
    assert len(set(runs.wanted)) == len(runs.wanted) == search.tally({}).runs < search.tally({}).possible
    assert {number for number, _ in runs.wanted} <= set(np.flatnonzero(allowed))
    tally = search.tally({})
    assert tally.priced_out + tally.infeasible + tally.beaten + tally.complete == tally.combinations == 400


@pytest.mark.parametrize("over", OVER)
@pytest.mark.parametrize("seed", range(6))
def test_a_second_objective_orders_those_within_the_tolerance_of_the_least(over, seed):
    """By a look at every run: those within the tolerance by the second objective, the others behind them by the first.

    Which objective has a price, and how many are ranked, is drawn, too; some second values are equal."""
    random = np.random.default_rng(17 + seed)
    (objective, aggregate), then_over = OVER[over], list(OVER)[seed % 3]
    then, aggregate_then = OVER[then_over]
    then = dataclasses.replace(then, weights={"stroke": 1e4})
    runs, ranking, tolerance = made_up(seed, objective), int(random.integers(1, 40)), random.choice([0.02, 0.1, 0.3])
    runs.stroke = np.round(runs.stroke, 3)
    constant, price = random.uniform(0.0, 40.0, 400) * (seed % 2), random.uniform(0.0, 60.0, 400) * (seed % 3 == 1)
    second = Second(then, price, jb.SecondObjective(then, tolerance).ceiling)
    allowed = random.uniform(size=400) > 0.1
    search = Enumeration(runs, objective, constant=constant, allowed=allowed, ranking=ranking, second=second)
    search.run()
    keeps = np.flatnonzero(np.all((runs.stroke <= STROKE) & runs.captured, axis=1) & allowed)
    value = np.apply_along_axis(aggregate, 1, runs.force) + constant
    other = np.apply_along_axis(aggregate_then, 1, 1e4 * runs.stroke) + price
    about_best = [k for k in keeps if value[k] <= (1.0 + tolerance) * min(value[keeps])]
    rest = [k for k in keeps if k not in about_best]
    expected = sorted(about_best, key=lambda k: (other[k], k)) + sorted(rest, key=lambda k: value[k])
    assert [int(k) for k in search.best()] == expected[:ranking]
    assert search.tally({}).runs < search.tally({}).possible


def test_a_price_on_the_ceiling_is_within_it():
    """1.15 times 20 is less than 23 by rounding alone."""
    runs = made_up(1, jb.Objective())
    runs.stroke[:], runs.captured[:] = 0.01, True
    runs.force[:] = 300.0
    runs.force[3] = 100.0
    price = np.full(400, 40.0)
    price[[2, 3]] = 20.0, 23.0
    second = Second(jb.Objective(), np.zeros(400), jb.SecondObjective(jb.Objective(), 0.15).ceiling)
    search = Enumeration(runs, None, constant=price, allowed=np.ones(400, bool), ranking=1, second=second)
    search.run()
    assert search.best() == [3]


def test_a_worst_case_objective_needs_little_more_than_a_run_a_combination():
    runs = made_up(7, Objective(), count=2000)
    search = Enumeration(runs, Objective(), constant=np.zeros(2000), allowed=np.ones(2000, bool), ranking=5)
    search.run()
    assert search.tally({}).runs < 1.4 * 2000, search.tally({})


def test_the_cheapest_is_found_with_hardly_a_run():
    """Price alone is known before any run: those dearer than the best feasible ones are never run."""
    runs = made_up(1, Objective())
    price = np.random.default_rng(5).uniform(10.0, 90.0, 400)
    search = Enumeration(runs, None, constant=price, allowed=np.ones(400, bool), ranking=3)
    search.run()
    keeps = np.all((runs.stroke <= STROKE) & runs.captured, axis=1)
    assert [int(k) for k in search.best()] == [int(k) for k in np.argsort(np.where(keeps, price, np.inf))[:3]]
    assert search.tally({}).runs < 0.5 * search.tally({}).possible


def test_a_verdict_at_a_smaller_tolerance_counts_and_each_combination_once():
    """Values on a limit that another tolerance moves to its other side, and one asked for above a limit on price."""
    runs, allowed = made_up(3, Objective()), np.arange(400) != 7
    search = Enumeration(runs, Objective(), constant=np.zeros(400), allowed=allowed, ranking=5, first=[7])
    search.run()
    before, best = search.tally({}), [int(k) for k in search.best()]
    lost = next(int(k) for k in np.flatnonzero(np.any(runs.stroke > STROKE, axis=1)) if search._farthest[k] > 0.0)
    after = search.tally({best[0]: False, best[1]: True, lost: True, 7: True})
    assert (after.complete, after.infeasible) == (before.complete, before.infeasible)
    assert search.tally({lost: True}).complete == before.complete + 1
    for it in (before, after):
        assert it.priced_out == 1 and it.priced_out + it.infeasible + it.beaten + it.complete == 400


def test_where_none_keeps_the_limits_the_nearest_are_told():
    runs = made_up(2, Objective())
    runs.stroke[:] = STROKE * np.linspace(1.01, 2.0, 400)[:, None]
    runs.captured[:] = True
    search = Enumeration(runs, Objective(), constant=np.zeros(400), allowed=np.ones(400, bool), ranking=3)
    search.run()
    assert len(search.best()) == 0 and [int(k) for k in search.nearest()] == [0, 1, 2]
    assert not np.isnan(search.judged.excess[[0, 1, 2]]).any(), "they are run at every case, to be told"


def test_equal_combinations_stay_in_the_order_of_the_catalogues():
    runs = made_up(3, Objective())
    runs.force[:], runs.stroke[:], runs.captured[:] = 300.0, 0.01, True
    search = Enumeration(runs, Objective(), constant=np.zeros(400), allowed=np.ones(400, bool), ranking=4)
    search.run()
    assert [int(k) for k in search.best()] == [0, 1, 2, 3]


def test_progress_ends_with_all_runs_done_or_spared():
    runs, told = made_up(4, Objective()), []
    each = runs.each

    def reporting(wanted, rtol=None, done=None):
        done(len(wanted) // 2)
        return each(wanted)

    runs.each = reporting
    search = Enumeration(
        runs,
        Objective(),
        constant=np.zeros(400),
        allowed=np.ones(400, bool),
        ranking=2,
        progress=lambda done, total: told.append((done, total)),
    )
    search.run()
    assert told == sorted(told) and told[-1] == (2000, 2000)
