"""A sensor's low-pass against the closed form of a sine behind it."""

import numpy as np
import pytest

from jaxbuffer.fitting.low_pass import SHORTEST, Filtered

RATE = 7.0  # rad/s of the sine


def answer(times, lag):
    """Of τ y' = sin(ωt) - y, y(0) = 0."""
    settled = np.sin(RATE * times) - RATE * lag * np.cos(RATE * times)
    return (settled + RATE * lag * np.exp(-times / lag)) / (1.0 + (RATE * lag) ** 2)


@pytest.mark.parametrize("lag", [0.0, 1e-4, 1e-2, 0.3, 10.0])
def test_a_sine_behind_a_low_pass_and_its_slope_are_the_closed_form(lag):
    nodes = np.sort(np.random.default_rng(0).uniform(0.0, 1.0, 1000))
    nodes[0], nodes[5] = 0.0, nodes[6]  # steps may end at one time twice
    between = 0.5 * (nodes[1:] + nodes[:-1])
    sensor = Filtered(nodes, lag)
    on, inside = np.sin(RATE * nodes)[:, None], np.sin(RATE * between)[:, None]
    found = sensor.answer(on, inside)
    lag = max(lag, SHORTEST)
    assert np.max(np.abs(found[:, 0] - answer(nodes, lag))) < 1e-6
    step = 1e-4 * lag
    slope = (answer(nodes, lag + step) - answer(nodes, lag - step)) / (2.0 * step)
    assert np.max(np.abs(sensor.slope(on, inside, found)[:, 0] - slope)) < 1e-3 * np.max(np.abs(slope)) + 1e-4


@pytest.mark.parametrize("lag", [0.0, 1e-4, 1e-2, 0.3])
def test_between_nodes_a_sine_behind_a_low_pass_is_the_closed_form_too(lag):
    nodes = np.sort(np.append(np.random.default_rng(0).uniform(0.0, 1.0, 2000), 0.0))
    nodes[5] = nodes[6]
    times = np.concatenate([nodes, np.random.default_rng(1).uniform(0.0, nodes[-1], 300)])
    on, between = np.sin(RATE * nodes)[:, None], np.sin(0.5 * RATE * (nodes[1:] + nodes[:-1]))[:, None]
    found, signal, by_lag = Filtered(nodes, lag).within(times, on, between)
    lag = max(lag, SHORTEST)
    assert np.max(np.abs(signal[:, 0] - np.sin(RATE * times))) < 1e-6
    assert np.max(np.abs(found[:, 0] - answer(times, lag))) < 1e-6
    step = 1e-4 * lag
    slope = (answer(times, lag + step) - answer(times, lag - step)) / (2.0 * step)
    assert np.max(np.abs(by_lag[:, 0] - slope)) < 1e-3 * np.max(np.abs(slope)) + 1e-4
