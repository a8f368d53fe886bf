"""A sweep with ``trust`` marks the runs whose numbers are not sure, as `jb.trust` does of single runs."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.run.trust import relative_changes, verdicts
from jaxbuffer.sweeps.chunk import Settings, columns_of_chunk, runs
from jaxbuffer.sweeps.found import UNKNOWN
from jaxbuffer.sweeps.grid import Batch

SPEEDS = [0.1, 0.2, 0.3]  # m/s


@pytest.fixture(scope="module")
def designs():
    return jb.replace(jb.table2(), {"buffer.k_A": 20.0, "buffer.c_A": 1.0})


@pytest.fixture(scope="module")
def swept(designs):
    return jb.sweep(designs, jb.Scenario(approach_speed=SPEEDS), rtol=1e-3, trust=True)


def test_verdicts_are_those_of_single_runs(designs, swept):
    for speed, verdict in zip(SPEEDS, swept.verdicts, strict=True):
        run, closer = (jb.simulate(designs, jb.Scenario(approach_speed=speed), rtol=rtol) for rtol in (1e-3, 1e-4))
        assert verdict == jb.trust(run, closer).verdict


def test_without_trust_nothing_is_said(designs, swept):
    found = jb.sweep(designs, jb.Scenario(approach_speed=SPEEDS), rtol=1e-3)
    assert found.verdicts == ["", "", ""] and not found.doubts("")
    np.testing.assert_array_equal(found.peak_force, swept.peak_force)
    assert list(swept.to_pandas()["trust"]) == swept.verdicts == swept.to_xarray().trust.values.tolist()


def test_a_run_without_numbers_has_no_verdict(designs):
    part = runs(Batch(None, designs, jb.Scenario(approach_speed=SPEEDS)), 8.0, 16, 1, filled=True)
    chunk, wanted = part.call(0)
    settings = Settings(np.asarray(1e-3), np.asarray(20.0), None, trust=True)
    *_, verdict = columns_of_chunk(chunk, wanted & (np.arange(16) != 1), settings)
    assert (verdict[[0, 2]] >= 0).all() and (verdict[np.r_[1, 3:16]] == UNKNOWN).all()


@pytest.mark.parametrize(
    ("error", "outcome", "differs", "verdict"),
    [(9e-5, False, True, 0), (2e-4, False, False, 1), (2e-4, False, True, 2), (2e-2, False, False, 2), (0, True, 0, 2)],
)
def test_verdicts_by_their_definition(error, outcome, differs, verdict):
    assert verdicts(error, outcome, differs) == verdict
    assert verdicts(np.array([0.0, error]), np.array([False, outcome]), np.array([False, differs])).tolist() == [
        0,
        verdict,
    ]


def test_changes_are_relative_to_the_value_or_a_thousandth_of_the_largest_of_its_unit():
    mechanism = jb.simulate(jb.BarDrop(), jb.BarDropScenario()).mechanism
    names = mechanism.swept
    values = {name: np.array([2.0, 1.0, np.nan]) for name in names}
    first = names[0]
    same_unit = [name for name in names if mechanism.quantities[name].unit == mechanism.quantities[first].unit]
    values[first] = np.array([1e-9, 1.0, np.nan])
    others = {name: 1.01 * value for name, value in values.items()} | {first: np.array([1e-4, np.nan, np.nan])}
    changes = relative_changes(mechanism, values, others)
    small = max(1e-9, 1e-3 * 2.0) if len(same_unit) > 1 else 1e-9
    np.testing.assert_allclose(changes[first], [(1e-4 - 1e-9) / small, np.inf, 0.0])
    np.testing.assert_allclose(changes[names[-1]], [0.01, 0.01, 0.0])
