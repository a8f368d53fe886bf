"""Which rows are clipped: signals with fine and coarse digits, with a range that ends and without."""

import numpy as np
import pytest

from jaxbuffer.fitting.clipping import clipped_rows

TIMES = np.linspace(0.0, 1.0, 2000)
SIGNAL = 3.0 * np.exp(-2.0 * TIMES) * np.sin(40.0 * TIMES) + 0.02 * np.random.default_rng(0).normal(size=2000)


@pytest.mark.parametrize("digit", [1e-6, 0.02])
@pytest.mark.parametrize("ends", [(-1.5, 1.5), (-9.0, 1.2), (-1.1, 9.0)])
def test_rows_at_the_end_of_a_range_are_clipped(digit, ends):
    values = digit * np.round(np.clip(SIGNAL, *ends) / digit)
    beyond = (values == values.max()) & (ends[1] < 9.0) | (values == values.min()) & (ends[0] > -9.0)
    assert np.sum(beyond) > 20 and np.array_equal(clipped_rows(values), beyond)


@pytest.mark.parametrize("digit", [1e-6, 0.02, 0.2])
def test_a_smooth_maximum_is_not_clipped_whatever_its_digits(digit):
    for phase in np.linspace(0.0, 1.0, 11):
        values = digit * np.round((3.0 * np.sin(4.0 * TIMES) * np.exp(-TIMES) + digit * phase) / digit)
        assert not np.any(clipped_rows(values)), phase


def test_what_rests_at_the_beginning_or_the_end_is_not_clipped():
    moving = np.clip(TIMES - 0.3, 0.0, 0.4)
    assert not np.any(clipped_rows(moving)) and not np.any(clipped_rows(0.0 * TIMES))


def test_a_single_largest_value_is_not_clipped():
    assert not np.any(clipped_rows(SIGNAL))
