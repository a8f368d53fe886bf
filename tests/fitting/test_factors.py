"""Which factor of 10^k or -1 makes a column alike: signals whose factor is known."""

import numpy as np
import pytest

from jaxbuffer.fitting.factors import better_factor, factor_within

TIMES = np.linspace(0.0, 1.0, 1000)
MODEL = 0.007 * np.sin(7.0 * TIMES) * np.exp(-TIMES)


@pytest.mark.parametrize("factor", [0.1, 0.001, 1000.0, -1.0, -0.01])
# A start that is off by a half, and moves too slowly, is near enough to tell.
@pytest.mark.parametrize("start", [1.0, 1.5, 0.67])
def test_the_factor_between_a_column_and_its_quantity_is_found(factor, start):
    noise = 2e-5 * np.random.default_rng(0).normal(size=len(TIMES))
    measured = (start * 0.007 * np.sin(7.5 * TIMES) * np.exp(-TIMES) + noise) / factor
    assert better_factor(measured, MODEL) == pytest.approx(factor)


@pytest.mark.parametrize("measured", [MODEL, 2.0 * MODEL, 0.4 * MODEL, MODEL + 0.002, 0.0 * MODEL])
def test_a_column_that_is_only_met_badly_has_no_other_unit(measured):
    assert better_factor(measured, MODEL) is None


def test_a_column_beyond_what_a_design_allows_is_brought_within_by_a_power_of_ten():
    assert factor_within(6.6 * np.sin(7.0 * TIMES), 0.1365) == pytest.approx(0.01)
    spikes = np.where(np.arange(1000) % 100 == 0, 5.0, 0.1)
    assert factor_within(spikes, 0.1365) is None
