"""The staged search and its intervals, on a damped oscillator whose motion is known."""

import numpy as np
import pytest

from jaxbuffer.fitting.intervals import not_told_apart, uncertainty
from jaxbuffer.fitting.residuals import Block, mean_squares, minimum, outliers, smoothed
from jaxbuffer.fitting.search import StagedSearch

ROWS, NOISE = 400, 0.05
TIMES = np.linspace(0.0, 1.0, ROWS)
LOW, HIGH = np.array([20.0, 0.1]), np.array([200.0, 5.0])  # rad/s and 1/s
TRUTH = np.array([90.0, 1.3])


def motion(numbers, times):
    """e^{-dt} cos(ωt), and its slopes by ω and d."""
    rate, decay = numbers
    envelope = np.exp(-decay * times)
    value = envelope * np.cos(rate * times)
    return value, np.stack([-times * envelope * np.sin(rate * times), -times * value], axis=1)


def residuals_of(measured):
    def residuals(x, share):
        rows = max(int(share * ROWS), 2)
        value, slopes = motion(LOW + x * (HIGH - LOW), TIMES[:rows])
        block = Block((value - measured[:rows])[None] / NOISE, (slopes * (HIGH - LOW) / NOISE)[None])
        return [block]

    return residuals


def record(seed):
    return motion(TRUTH, TIMES)[0] + NOISE * np.random.default_rng(seed).normal(size=ROWS)


def numbers(x):
    return LOW + x * (HIGH - LOW)


def test_the_search_finds_an_oscillation_that_a_plain_descent_misses():
    residuals, start = residuals_of(record(0)), (np.array([30.0, 3.0]) - LOW) / (HIGH - LOW)
    plain = minimum(residuals, start, 1.0, tolerance=1e-9, most=60)
    assert plain.chi > 5.0, "the case is too easy to show anything"
    found = StagedSearch(residuals, ROWS)(start)
    assert found.converged and found.chi < 1.3
    assert numbers(found.x) == pytest.approx(TRUTH, rel=0.02)


def test_intervals_hold_the_truth_as_often_as_they_say():
    inside, draws = np.zeros(2), 100
    start = (np.array([88.0, 1.5]) - LOW) / (HIGH - LOW)
    for seed in range(draws):
        residuals = residuals_of(record(seed))
        known = uncertainty(residuals, minimum(residuals, start, 1.0, tolerance=1e-9))
        inside += (numbers(known.low) <= TRUTH) & (numbers(known.high) >= TRUTH)
    # 95 of 100, give or take three deviations of a binomial count.
    assert np.all(np.abs(inside - 0.95 * draws) <= 3.0 * np.sqrt(draws * 0.95 * 0.05)), inside


def test_an_interval_ends_where_the_least_squares_have_risen_by_its_deviations():
    residuals = residuals_of(record(1))
    best = minimum(residuals, (TRUTH - LOW) / (HIGH - LOW), 1.0, tolerance=1e-12)
    known = uncertainty(residuals, best)
    sums = lambda x: float(np.sum(residuals(x, 1.0)[0].values ** 2))  # noqa: E731
    for end in (known.low[0], known.high[0]):
        # The other unknown at its best, by trying.
        rise = min(sums(np.array([end, other])) for other in np.linspace(0.0, 1.0, 4001)) - sums(best.x)
        assert rise == pytest.approx(3.84, rel=0.08)


def test_unknowns_that_only_their_sum_is_known_of_are_named():
    slopes = np.outer(np.linspace(1.0, 2.0, 50), [100.0, 100.0]) + np.eye(50, 2)
    residuals = lambda x, share: [Block((slopes @ (x - 0.5))[None], slopes[None])]  # noqa: E731
    known = uncertainty(residuals, minimum(residuals, np.array([0.4, 0.6]), 1.0))
    lines = not_told_apart(["one", "other"], known)
    assert any("one and other: correlation -" in line for line in lines)


def test_smoothing_keeps_the_information_of_white_noise():
    block = Block(np.random.default_rng(0).normal(size=(1, 20_000)), np.ones((1, 20_000, 1)))
    values, slopes = smoothed(block, 4.0)
    constant = float(slopes[:, 0] @ slopes[:, 0])
    assert constant == pytest.approx(20_000, rel=0.01)
    # A Gaussian window of four rows averages 4·2√π of them, of which every fourth is kept, scaled by two.
    assert np.var(values) == pytest.approx(4.0 / (4.0 * 2.0 * np.sqrt(np.pi)), rel=0.1)


def test_an_impact_that_is_missed_stands_out_of_records_that_are_met_everywhere_else():
    search, random = StagedSearch(lambda x, share: [], 3000), np.random.default_rng(0)
    for draw in range(50):
        values = random.normal(size=(3, 3000))
        noise = Block(values, np.zeros((3, 3000, 0)))
        assert search.excess([noise]) < 1.0, draw
        place = int(random.integers(3000))
        values[2, place : place + 3] += 9.0
        # All rows together hardly show it.
        assert np.mean(values[2] ** 2) < 1.2
        assert search.excess([noise]) > 1.0, (draw, place)


def test_a_lone_spike_is_no_impact_that_is_missed():
    search, values = StagedSearch(lambda x, share: [], 3000), np.random.default_rng(0).normal(size=(3, 3000))
    values[0, 700], values[2, 1900] = 700.0, -160.0
    assert search.excess([Block(values, np.zeros((3, 3000, 0)))]) < 1.0
    values[1, 700] = 40.0  # in two columns at once: an impact
    assert search.excess([Block(values, np.zeros((3, 3000, 0)))]) > 1.0


def test_spikes_move_the_numbers_by_less_than_the_noise_does():
    clean, spiked, start = record(0), record(0), (np.array([88.0, 1.5]) - LOW) / (HIGH - LOW)
    spiked[[40, 150, 222]] += [8.0, -6.0, 9.0]  # up to 180 deviations
    best = [minimum(residuals_of(it), start, 1.0, tolerance=1e-9) for it in (clean, spiked)]
    deviations = uncertainty(residuals_of(clean), best[0]).deviations
    assert np.all(np.abs(best[1].x - best[0].x) < deviations)


def test_rows_weigh_as_hubers_loss_has_it():
    values, slopes = smoothed(Block(np.array([[2.0, 40.0, -40.0]]), np.ones((1, 3, 1))), 0.0)
    # r² up to five, 2·5·|r| - 5² beyond, and half the loss's derivative: r, then 5 with its sign.
    assert values**2 == pytest.approx([4.0, 375.0, 375.0])
    assert values * slopes[:, 0] == pytest.approx([2.0, 5.0, -5.0])


def test_rows_that_are_many_are_no_outliers():
    values = np.zeros((1, 1000))
    values[0, :10] = 9.0
    assert np.sum(outliers(values)) == 10 and mean_squares(values, values > -1.0)[0] == 0.0
    values[0, :100] = 9.0
    assert not np.any(outliers(values)) and mean_squares(values, values > -1.0)[0] == pytest.approx(8.1)
