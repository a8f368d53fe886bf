"""Elasticities of the peak force over random designs against differences of tight solves by another solver.

The captures that are differenced use the explicit solver at rtol 1e-11 and know nothing of sensitivities; Richardson's
extrapolation leaves them an error near 1e-8 (the two steps' difference, asserted below).
"""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.hybrid import ExplicitRungeKutta
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.sensitivities.gradients import gradients
from verification.cases import CASES
from verification.designs import PARAMETERS, random_case

STEP = 1e-3


def elasticities_by_differences(design, scenario):
    values = np.array([jb.get(design, path) for path in PARAMETERS])

    def log_peak(k, move):
        moved = values.copy()
        moved[k] *= np.exp(move)
        capture = jb.simulate(
            jb.replace(design, dict(zip(PARAMETERS, moved, strict=True))),
            scenario,
            rtol=1e-11,
            solver=ExplicitRungeKutta(),
        )
        return np.log(float(capture.peak_force))

    coarse = np.array([(log_peak(k, STEP) - log_peak(k, -STEP)) / (2 * STEP) for k in range(5)])
    fine = np.array([(log_peak(k, STEP / 2) - log_peak(k, -STEP / 2)) / STEP for k in range(5)])
    return (4 * fine - coarse) / 3, np.abs(fine - coarse)


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 14, 111])
def test_elasticities_where_a_free_tip_comes_to_stick(seed):
    """Of the first 120 designs with a free tip three have impacts in which the ball comes to stick and its friction
    decides the peak: elasticities are off by up to 23 % if errors of its spin are held beside the spin itself."""
    design, scenario = random_case(seed, free_tip=True)
    values = [jb.get(design, path) for path in PARAMETERS]
    linear = gradients(PROBE_CONE, design, scenario, PARAMETERS, values, 8.0)
    found = np.asarray(linear.gradients[0]) * values / float(linear.results[0])
    expected, uncertainty = elasticities_by_differences(design, scenario)
    assert float(uncertainty.max()) < 1e-4
    np.testing.assert_allclose(found, expected, atol=1e-3 * float(np.abs(expected).max()))


@pytest.mark.long
@pytest.mark.parametrize(("free_tip", "count"), [(False, 50), (True, 10)])
def test_elasticities_over_random_designs(free_tip, count, capsys):
    errors, wrong_signs, largest = [], 0, 0.0
    for seed in range(count):
        design, scenario = random_case(seed, free_tip)
        values = [jb.get(design, path) for path in PARAMETERS]
        linear = gradients(PROBE_CONE, design, scenario, PARAMETERS, values, 8.0)
        found = np.asarray(linear.gradients[0]) * values / float(linear.results[0])
        expected, uncertainty = elasticities_by_differences(design, scenario)
        errors.append(np.abs(found - expected) / np.maximum(np.abs(expected), 1e-3))
        wrong_signs += int(np.sum((np.sign(found) != np.sign(expected)) & (np.abs(expected) > 1e-4)))
        largest = max(largest, float(uncertainty.max()))
    quantiles = np.quantile(np.concatenate(errors), [0.5, 0.9, 0.99, 1.0])
    with capsys.disabled():
        print(
            f"\nelasticities of {count} random designs ({'free' if free_tip else 'welded'} tip), relative error: "
            f"median {quantiles[0]:.1e}, 90 % {quantiles[1]:.1e}, 99 % {quantiles[2]:.1e}, worst {quantiles[3]:.1e}; "
            f"wrong signs {wrong_signs}; differences' own uncertainty {largest:.1e}"
        )
    assert wrong_signs == 0
    assert quantiles[2] < 1e-3
    assert quantiles[3] < 2e-3  # measured 1.1e-3
    assert largest < 2e-4  # of each step alone; extrapolation leaves its square


@pytest.mark.long
@pytest.mark.parametrize("rtol", [1e-3, 1e-4, 1e-5])
def test_sensitivities_stop_no_run_and_hold_none_up(rtol):
    """Whatever the tolerance: every reference capture ends as it should, after at most three times the attempts
    that it takes alone (2.2 measured). A random design besides whose slow slide into the throat holds a maximum that
    only a bad step sees."""
    cases = [(case.design, case.scenario, case.values["outcome"]) for case in CASES.values()]
    slide = random_case(25)
    cases.append((*slide, jb.simulate(*slide, rtol=1e-8).outcome.name))
    for design, scenario, outcome in cases:
        values = [jb.get(design, path) for path in PARAMETERS]
        capture = gradients(PROBE_CONE, design, scenario, PARAMETERS, values, 8.0, rtol=rtol).run
        assert capture.outcome.name == outcome
        assert int(capture.attempts) < 3 * int(jb.simulate(design, scenario, rtol=rtol).attempts)
