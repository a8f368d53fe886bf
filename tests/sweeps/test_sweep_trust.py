"""A sweep with ``trust`` marks the runs whose numbers are not sure, as `jb.trust` does of single runs."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.hybrid import AUTOMATIC
from jaxbuffer.run.trust import VERDICTS, relative_changes, verdicts
from jaxbuffer.sweeps import chunk as chunks
from jaxbuffer.sweeps.chunk import SweepSettings, columns_of_chunk
from jaxbuffer.sweeps.columns import NO_VERDICT
from jaxbuffer.sweeps.grid import Batch

SPEEDS = [0.1, 0.2, 0.3]  # m/s


@pytest.fixture(scope="module")
def designs():
    return jb.replace(jb.table2(), {"buffer.k_A": 20.0, "buffer.c_A": 1.0})


@pytest.fixture(scope="module")
def swept(designs):
    return jb.sweep(designs, jb.Scenario(approach_speed=SPEEDS), rtol=1e-3, trust=True)


@pytest.mark.slow
def test_verdicts_are_those_of_single_runs(designs, swept):
    for speed, verdict in zip(SPEEDS, swept.verdicts, strict=True):
        run, closer = (jb.simulate(designs, jb.Scenario(approach_speed=speed), rtol=rtol) for rtol in (1e-3, 1e-4))
        assert verdict == jb.trust(run, closer).verdict


def test_without_trust_nothing_is_said(designs, swept):
    sweep = jb.sweep(designs, jb.Scenario(approach_speed=SPEEDS), rtol=1e-3)
    assert sweep.verdicts == ["", "", ""] and not sweep.sanity_checks("")
    np.testing.assert_array_equal(sweep.peak_force, swept.peak_force)
    assert list(swept.to_dataframe()["trust"]) == swept.verdicts == swept.to_xarray().trust.values.tolist()


def test_a_run_without_numbers_has_no_verdict(designs):
    chunk, mask = Batch(np.arange(3), designs, jb.Scenario(approach_speed=SPEEDS), 8.0).chunk(0, 16)
    settings = SweepSettings(np.asarray(1e-3), np.asarray(20.0), AUTOMATIC, trust=True)
    *_, verdict = columns_of_chunk(chunk, mask & (np.arange(16) != 1), settings)
    assert (verdict[[0, 2]] >= 0).all() and (verdict[np.r_[1, 3:16]] == NO_VERDICT).all()


@pytest.fixture
def bar():
    return jb.replace(jb.BarDrop(), {"impact.damping": 0.0}), jb.BarDropScenario(height=[0.1, 0.194])


@pytest.mark.parametrize(("rtol", "known"), [(1e-12, True), (9e-13, False), (1e-13, False)])
def test_below_rtol_1e_12_nothing_is_known(bar, rtol, known):
    """A run at 1e-13, the least allowed, is no tenth of it: at rtol 1e-13 it is the run itself."""
    sweep = jb.sweep(*bar, 0.22, rtol=rtol, trust=True)
    if known:
        assert sweep.verdicts == ["trusted"] * 2 and sweep.sanity_checks("") == []
    else:
        (said,) = sweep.sanity_checks("see trust")
        assert sweep.verdicts == ["unknown"] * 2 == sweep.to_dataframe()["trust"].tolist()
        assert said.startswith("2 of 2 drops have numbers of unknown error: a tenth of rtol is below 1e-13, the least")


def test_a_run_that_fails_at_a_tenth_of_the_tolerance_only(bar, monkeypatch):
    call = Batch(np.arange(2), *bar, 0.22).chunk(0, 16)
    solve = chunks.solve_chunk

    def failing(mechanism, chunk, mask, rtol, *others):
        return solve(mechanism, chunk, mask & ((rtol > 5e-6) | (np.arange(16) == 0)), rtol, *others)

    monkeypatch.setattr(chunks, "solve_chunk", failing)
    *_, verdict = columns_of_chunk(*call, SweepSettings(np.asarray(1e-5), np.asarray(20.0), AUTOMATIC, trust=True))
    assert verdict[:3].tolist() == [VERDICTS.index("trusted"), VERDICTS.index("unknown"), NO_VERDICT]


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
    values[first] = np.array([1e-3, 1.0, np.nan])
    others = {name: 1.01 * value for name, value in values.items()} | {first: np.array([3e-3, np.nan, np.nan])}
    changes = relative_changes(mechanism, values, others)
    small = max(1e-3, 1e-3 * 2.0) if len(same_unit) > 1 else 1e-3
    np.testing.assert_allclose(changes[first], [2e-3 / small, np.inf, 0.0])
    np.testing.assert_allclose(changes[names[-1]], [0.01, 0.01, 0.0])
