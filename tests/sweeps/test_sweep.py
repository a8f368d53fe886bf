"""Sweeps: what they find, what they refuse, and that one capture leaves the others alone."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.hybrid import AUTOMATIC
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.programs.cache import Static
from jaxbuffer.sweeps.chunk import solve_chunk
from jaxbuffer.sweeps.grid import Batch
from jaxbuffer.sweeps.result import SweepInterrupted
from jaxbuffer.sweeps.sweep import CHUNK
from verification.cases import CASES, PATHS, WELDED


def together(names):
    """Reference captures as one design and one scenario with an array for every number that differs."""
    cases = [CASES[name] for name in names]
    values = {path: np.array([float(jb.get(c.design, path)) for c in cases]) for path in PATHS.values()}
    fields = ("approach_speed", "contact_distance", "misalignment", "passive_rate")
    scenario = jb.Scenario(**{f: np.array([float(getattr(c.scenario, f)) for c in cases]) for f in fields})
    return jb.replace(jb.table2(), values), scenario, [c.values for c in cases]


@pytest.mark.slow
def test_all_reference_captures_at_once():
    design, scenarios, expected = together(WELDED)
    calls = []
    sweep = jb.sweep(design, scenarios, progress=lambda done, count: calls.append((done, count)))
    assert [outcome.name for outcome in sweep.outcomes] == [v["outcome"] for v in expected]
    for name, tolerance in (("peak_force", 1e-4), ("stroke", 1e-4), ("end_time", 1e-3)):
        np.testing.assert_allclose(getattr(sweep, name), [v[name] for v in expected], rtol=tolerance)
    np.testing.assert_array_equal(sweep.impact_count, [v["impacts"] for v in expected])
    assert calls[-1] == (len(WELDED), len(WELDED))
    assert "captured" in repr(sweep) and "peak_force [N]" in repr(sweep)


@pytest.mark.slow
def test_a_capture_cut_short_leaves_the_others_alone():
    duration = np.array([8.0, 1e-3])
    sweep = jb.sweep(jb.table2(), jb.Scenario(approach_speed=np.array([0.1, 0.1])), duration)
    assert [outcome.name for outcome in sweep.outcomes] == ["captured", "timeout"]
    np.testing.assert_allclose(sweep.peak_force, [253.13152694328107, 141.5785], rtol=1e-5)


def test_one_capture():
    sweep = jb.sweep(jb.table2(), jb.Scenario(), workers=1)
    assert len(sweep) == 1
    np.testing.assert_allclose(sweep.peak_force, 253.13152694328107, rtol=1e-4)


@pytest.mark.slow
def test_one_program_for_any_number_of_runs():
    """What is not wanted takes no step, and a run's numbers don't depend on its place or on how many there are."""
    solve_chunk.programs.clear()
    speeds = np.linspace(0.1, 0.2, 19)
    all_runs = jb.sweep(jb.table2(), jb.Scenario(approach_speed=speeds), 0.05)
    for count in (1, 3, 16, 17):
        few = jb.sweep(jb.table2(), jb.Scenario(approach_speed=speeds[-count:]), 0.05)
        np.testing.assert_array_equal(few.peak_force, all_runs.peak_force[-count:])
    assert len(solve_chunk.programs) == 1
    batch = Batch(np.arange(19), jb.table2(), jb.Scenario(approach_speed=speeds), 0.05)
    result = solve_chunk.first(
        PROBE_CONE, *batch.chunk(16, 16), np.asarray(1e-6), np.asarray(20.0), AUTOMATIC, Static(())
    )
    assert np.all((np.asarray(result.attempts) > 0) == (np.arange(16) < 3))


@pytest.mark.parametrize(
    ("speeds", "distances", "message"),
    [
        (np.full(3, 0.1), np.full(2, 0.04), r"one shape \(n,\).*\(2,\), \(3,\)"),
        (np.full((2, 2), 0.1), 0.04, r"one shape \(n,\)"),
    ],
)
def test_arrays_that_do_not_fit(speeds, distances, message):
    with pytest.raises(jb.InputError, match=message):
        jb.sweep(jb.table2(), jb.Scenario(approach_speed=speeds, contact_distance=distances))


def test_no_workers():
    with pytest.raises(jb.InputError, match="workers = 0"):
        jb.sweep(jb.table2(), jb.Scenario(), workers=0)


def test_an_interrupt_hands_over_what_was_done():
    def interrupt(done, count):
        raise KeyboardInterrupt

    speeds = np.full(2 * CHUNK + 1, 0.1)
    with pytest.raises(SweepInterrupted, match=r"(16|32) of 33 captures done") as stop:
        jb.sweep(jb.table2(), jb.Scenario(approach_speed=speeds), workers=1, progress=interrupt)
    done, result = stop.value.done, stop.value.partial
    assert done.sum() in (CHUNK, 2 * CHUNK), "no more than two chunks are under way at a time"
    np.testing.assert_allclose(result.peak_force[done], 253.13152694328107, rtol=1e-4)
    assert np.isnan(result.peak_force[~done]).all()
