"""Histories with derivatives against differences of runs at a tight tolerance, and `simulate` at given times."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.fitting.signals import Parameters, signals, stepped_run
from jaxbuffer.mechanisms.registry import mechanism_of

NAMES = ("active_acceleration_x", "passive_acceleration_x", "stroke")
PATHS = ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T", "buffer.friction")


@pytest.mark.long
def test_slopes_at_fixed_times_are_those_of_tight_runs_through_impacts():
    design = jb.replace(jb.table2(), {"buffer.friction": 0.3})
    of = Parameters(mechanism_of(design), design, jb.Scenario(approach_speed=0.11), PATHS, 1e-6)
    numbers, times = np.array([float(jb.get(design, path)) for path in PATHS]), np.arange(1.0, 40.0, 0.05) * 1e-3
    found = signals(of, stepped_run(of, numbers, 0.041), NAMES, times)

    def tight(values, moments=times):
        run = of._replace(rtol=1e-9)
        return signals(run, stepped_run(run, values, 0.041), NAMES, moments).values

    assert np.max(np.abs(found.values - tight(numbers)).T / [0.05, 0.05, 2e-5]) < 0.05  # of a sensor's noise
    for k in range(len(PATHS)):
        step = np.where(np.arange(len(PATHS)) == k, 1e-5 * numbers, 0.0)
        slope = (tight(numbers + step) - tight(numbers - step)) / (2.0 * step[k])
        error = np.linalg.norm(found.slopes[..., k] - slope, axis=1) / np.linalg.norm(slope, axis=1)
        assert np.all(error < 2e-3), (PATHS[k], error)
    rate = (tight(numbers, times + 1e-7) - tight(numbers, times - 1e-7)) / 2e-7
    assert np.all(np.linalg.norm(found.rates - rate, axis=1) < 1e-3 * np.linalg.norm(rate, axis=1))


@pytest.mark.slow
def test_simulate_gives_a_history_at_the_times_that_are_asked_for():
    middle, step = np.array([0.05, 0.1, 0.15]), 1e-5
    times = np.sort(np.concatenate([middle - step, middle, middle + step]))
    run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.16, times=times)
    history = run.history
    assert np.array_equal(history.time, times)
    # In flight, before and after the time in the middle: rates are differences of what they are rates of.
    for values, rates in ((history.position, history.velocity), (history.velocity, history.acceleration)):
        assert (values[2::3] - values[::3]) / (2.0 * step) == pytest.approx(rates[1::3], rel=1e-4, abs=1e-4)
