"""Means over the turns of a slider-crank, and their standard errors."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.slider_crank.statistics import contact_shares, standard_error, turn_starts

TURN = 0.012  # s


@pytest.fixture(scope="module")
def run():
    return jb.simulate(jb.SliderCrank(), jb.SliderCrankScenario(), 8.5 * TURN, max_events=1024, history=True)


def test_turns_begin_where_the_crank_does(run):
    np.testing.assert_allclose(turn_starts(run), TURN * np.arange(9), atol=1e-7 * TURN)


def test_statistics_are_those_of_the_history(run):
    """Impacts and contact by the impacts' own times; their largest force read off a history of all steps."""
    found = jb.turn_statistics(run)
    assert found.turns == 7
    time, force = np.asarray(run.history.time), np.asarray(run.history.contact_force)[:, 0]
    touches = np.asarray(run.impacts.time)[: int(run.impacts.count)]
    peaks = np.array([np.max(part) for part in np.split(force, np.searchsorted(time, touches))[1:]])
    begins = np.floor(touches / TURN)
    turns = [peaks[begins == k] for k in range(1, 8)]
    largest = [np.max(turn) if turn.size else np.nan for turn in turns]  # one long impact may fill a turn
    np.testing.assert_allclose(found.largest_force.by_turn, largest, rtol=2e-3, equal_nan=True)
    counted = np.histogram(touches, TURN * np.arange(9))[0]
    assert list(found.impacts.by_turn) == list(counted[1:])
    hits = np.stack([np.asarray(x)[: int(run.impacts.count)] for x in (run.impacts.time, run.impacts.release_time)])
    hits = np.nan_to_num(hits, nan=8.5 * TURN)  # in contact at the end
    edges = TURN * np.arange(9)
    overlap = np.minimum(hits[1], edges[1:, None]) - np.maximum(hits[0], edges[:-1, None])
    shares = np.sum(np.maximum(overlap, 0.0), axis=1) / TURN
    np.testing.assert_allclose(contact_shares(run, turn_starts(run)), shares, rtol=1e-6)
    rest = np.sum(np.maximum(np.minimum(hits[1], 8.5 * TURN) - np.maximum(hits[0], 8.0 * TURN), 0.0))
    assert np.sum(shares) * TURN + rest == pytest.approx(float(run.contact_time), rel=1e-6)


def test_a_motor_turns_are_counted_by_its_angle():
    drive = {"drive.kind": "torque", "drive.torque": 20.0, "drive.no_load_speed": 400.0, "crank.inertia": 0.01}
    run = jb.simulate(
        jb.replace(jb.SliderCrank(), drive), jb.SliderCrankScenario(crank_speed=0.0), 0.3, max_events=4096, history=True
    )
    angle, time = np.asarray(run.history.position)[:, 0, 2], np.asarray(run.history.time)
    starts = turn_starts(run)
    assert len(starts) == int(angle[-1] / (2.0 * np.pi)) + 1 > 5
    np.testing.assert_allclose(np.interp(starts, time, angle), 2.0 * np.pi * np.arange(len(starts)), atol=5e-3)


@pytest.mark.quick
def test_standard_errors_of_independent_and_of_alike_values():
    """1/√n of white noise; of x_k = a x_{k-1} + noise (1 + a)/(1 - a) times the variance of the mean."""
    random = np.random.default_rng(3)
    white, alike = [], []
    for _ in range(200):
        noise = random.standard_normal(512)
        white.append(standard_error(noise))
        values = np.empty(512)
        values[0] = noise[0]
        for k in range(1, 512):
            values[k] = 0.5 * values[k - 1] + np.sqrt(0.75) * noise[k]
        alike.append(standard_error(values))
    assert np.mean(white) == pytest.approx(1.0 / np.sqrt(512.0), rel=0.25)
    assert np.mean(alike) == pytest.approx(np.sqrt(3.0 / 512.0), rel=0.25)
    assert np.isnan(standard_error(np.array([1.0])))


@pytest.mark.long
def test_the_summary_has_them_and_says_what_is_missing(run):
    assert "means over 7 turns ± standard error" in repr(run)
    short = jb.simulate(jb.SliderCrank(), jb.SliderCrankScenario(), 8.5 * TURN, max_events=32)
    assert "the log has room for" in repr(short) and "means over" not in repr(short)
    with pytest.raises(jb.InputError, match="raise max_events"):
        jb.turn_statistics(short)
    with pytest.raises(jb.InputError, match="4 whole turns after the first; this run has 0"):
        jb.turn_statistics(jb.simulate(jb.SliderCrank(), jb.SliderCrankScenario()))
