"""Which factor of 10^k or -1 makes a column alike: signals whose factor is known."""

from types import SimpleNamespace

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.fitting.factors import better_factor, doubts, factor_within

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


@pytest.mark.parametrize(("typed", "factor"), [(1000.0, "0.001"), (10.0, "0.1"), (-1.0, "-1")])
def test_a_doubt_names_the_factor_that_makes_a_column_alike(typed, factor):
    """A stroke of up to 7 mm in mm is above the 136.5 mm of the design in m; times 0.01, within these, it is not."""
    sensor = SimpleNamespace(quantity="stroke", offset=0.0)
    prediction = SimpleNamespace(
        sensors={"stroke": sensor},
        values=[typed * MODEL],
        recording=SimpleNamespace(name="a.csv"),
        units={"stroke": "m"},
    )
    (line,) = doubts(prediction, np.array([1.2 * MODEL]), jb.table2())
    assert line.startswith('a.csv: column "stroke": unit or sign?')
    assert f"unless times {factor}." in line or f"Times {factor} it is far nearer" in line
