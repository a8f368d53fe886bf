"""What a certificate and a horizon make of other solves, which are made up here."""

import contextlib

import numpy as np
import pytest

import jaxbuffer as jb
import jaxbuffer.sensitivities.horizon as horizons
from jaxbuffer.cluster.pool import Pool
from jaxbuffer.mechanisms.impacts import Impacts
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.sensitivities import evidence
from jaxbuffer.sensitivities.evidence import (
    FLOOR,
    NOISE,
    TightSolve,
    TightSolves,
    course_of,
    each,
    together,
)
from jaxbuffer.sensitivities.gradients import Gradients
from made_up import made_up_capture


def capture(forces, flanks=None, **named):
    """With an impact for each force, and one more slot that is empty."""
    count = len(forces)
    padded = np.append(np.asarray(forces, float), 0.0)
    contact = np.append(np.zeros(count, int) if flanks is None else flanks, -1)
    times = np.linspace(0.0, 0.1, count + 1)
    made = made_up_capture(peak=max(forces), **named)
    object.__setattr__(made, "impacts", Impacts(times, contact, times, padded, times, np.asarray(count)))
    return made


def horizon_of(monkeypatch, ours, theirs, **options):
    calls = []

    def simulate(design, scenario, duration, **given):
        calls.append((duration, given))
        return theirs

    monkeypatch.setattr(horizons, "simulate", simulate)
    return horizons.horizon(ours, **options), calls


@pytest.mark.parametrize(("theirs", "flanks", "trusted"), [
    ([200.0, 100.0, 50.0], [0, 1, 0], 3),
    ([200.1, 100.0, 50.0], [0, 1, 0], 3),
    ([200.0, 100.2, 50.0], [0, 1, 0], 1),
    ([200.0, 99.8, 50.0], [0, 1, 0], 1),
    ([201.0, 100.0, 50.0], [0, 1, 0], 0),
    ([200.0, 100.0, 50.0], [0, 0, 0], 1),
    ([200.0, 100.0], [0, 1], 2),
    ([200.0, 100.0, 50.0, 5.0], [0, 1, 0, 1], 3),
    ([200.0, 0.0, 50.0], [0, 1, 0], 1),
])  # fmt: skip
def test_impacts_are_trusted_up_to_the_first_that_changes(monkeypatch, theirs, flanks, trusted):
    """By 1e-3, or by touching another contact."""
    result, calls = horizon_of(monkeypatch, capture([200.0, 100.0, 50.0], [0, 1, 0]), capture(theirs, flanks))
    assert (result.trusted, result.impacts, result.change, result.rtol) == (trusted, 3, 1e-3, 1e-9)
    assert len(result.changes) == min(3, len(theirs))
    if trusted == 3 and theirs[0] == 200.1:
        np.testing.assert_allclose(result.changes, [1.0 - 200.0 / 200.1, 0.0, 0.0], rtol=1e-9, atol=1e-15)
    ((duration, given),) = calls
    assert duration == float(capture([1.0]).end_time)
    assert given["rtol"] == 1e-9
    assert given["history"]


def test_a_horizon_with_another_tolerance_and_change(monkeypatch):
    ours, theirs = capture([200.0, 100.0]), capture([204.0, 110.0])
    result, calls = horizon_of(monkeypatch, ours, theirs, rtol=1e-11, change=0.05)
    assert (result.trusted, result.impacts) == (1, 2)
    assert calls[0][1]["rtol"] == 1e-11
    assert str(result).startswith("the first 1 of 2 impacts can be trusted one by one")


def solve(run, names=("stroke", "peak_force")):
    """A tight solve by two parameters."""
    paths = ("buffer.k_A", "buffer.c_A")
    return TightSolve(PROBE_CONE, jb.table2(), jb.Scenario(), paths, names, 8.0, None, int(run.code), course_of(run))


@pytest.fixture
def pool():
    """One thread."""
    with contextlib.closing(Pool(workers=1)) as pool:
        yield pool


def test_solves_are_made_once_each_and_tightly(monkeypatch, pool):
    calls = []

    def simulate(design, scenario, duration, rtol, solver):
        calls.append((float(design.buffer.k_A), float(design.buffer.c_A), duration, rtol))
        return capture([240.0])

    monkeypatch.setattr(evidence, "simulate", simulate)
    tight, along = TightSolves(solve(capture([250.0])), np.array([100.0, 2.0]), np.array([10.0, 1.0]), pool), [1.0, 0.5]
    for moves in ((0.1, 0.1), (0.1, -0.1), (-0.1,)):
        result = tight.after([(np.array(along), move) for move in moves])
        np.testing.assert_allclose(result, [[0.0075, 240.0]] * len(moves))
    assert calls == [(101.0, 2.05, 8.0, 1e-11), (99.0, 1.95, 8.0, 1e-11)]
    assert len(tight.known) == 2


@pytest.mark.parametrize(("forces", "flanks", "expected"), [
    ([200.0, 251.0, 10.0], [0, 1, 0], 251.0),  # the same impact
    ([260.0, 251.0, 10.0], [0, 1, 0], 251.0),  # though another one is the largest by now
    ([200.0, 251.0], [0, 1], 251.0),  # whatever comes after it
    ([200.0, 251.0, 10.0, 5.0], [0, 1, 1, 1], 251.0),
    ([200.0, 251.0, 10.0], [1, 1, 0], np.nan),  # a course of another kind
    ([200.0], [0], np.nan),
])  # fmt: skip
def test_the_peak_is_followed_by_its_impact(forces, flanks, expected):
    result = solve(capture([200.0, 250.0, 10.0], [0, 1, 0])).values_of(capture(forces, flanks))
    np.testing.assert_allclose(result, [0.0075, expected])


def test_another_outcome_is_not_compared():
    tight = solve(capture([250.0]))
    assert np.all(np.isnan(tight.values_of(capture([250.0], outcome=jb.Outcome.failed_step_size))))
    assert tight.values_of(capture([250.0])).tolist() == [0.0075, 250.0]


def test_without_an_impact_or_the_peak_among_the_quantities_there_is_none_to_follow():
    assert solve(capture([250.0]), names=("stroke",)).values_of(capture([200.0], [1])).tolist() == [0.0075]
    assert solve(capture([0.0])).values_of(capture([200.0], [1])).tolist() == [0.0075, 200.0]


def test_how_a_certificate_weighs():
    """Solves are good to ten times their tolerance, and an elasticity below a thousandth counts as that."""
    assert pytest.approx(1e-10) == NOISE
    assert FLOOR == 1e-3


class Powers:
    """Stands in for solves of quantities that are powers of the parameters."""

    def __init__(self, truth):
        self.truth, self.known = np.asarray(truth), {}

    def inside(self, direction, move):
        return True

    def after(self, moves):
        moved = {(along.tobytes(), move): np.exp(self.truth @ np.log1p(move * along)) for along, move in moves}
        self.known |= moved
        return list(moved.values())


@pytest.mark.parametrize(("gather", "thorough"), [(each, True), (together, False)])
def test_evidence_says_how_it_was_gathered(gather, thorough):
    truth, claimed = [[0.3, -0.05], [-0.8, 0.1]], np.array([[0.3, -0.05], [-0.8, 0.12]])
    tight, changes = Powers(truth), np.full((2, 2), 7e-5)
    result = gather(tight, claimed, np.ones(2), changes)
    assert result.thorough is thorough
    assert result.solves == len(tight.known) > 0
    np.testing.assert_array_equal(result.by_tolerance, changes)
    assert result.by_differences[1, 1] == pytest.approx(0.02, rel=0.1 if thorough else 1.0)
    assert np.max(result.by_differences[0]) < 1e-6
    assert np.max(result.uncertainty) < 1e-5


def test_gradients_by_their_names():
    """Of a quantity by its place in the catalogue, of an impact by its number from 1, if it is there."""
    run = capture([250.0, 80.0])
    names = list(run.mechanism.quantities)
    rows = np.arange(2.0 * len(names)).reshape(-1, 2)
    by_impact = {"peak_force": np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])}
    result = Gradients(run, rows[:, 0], rows, by_impact)
    np.testing.assert_array_equal(result.of(names[3]), [6.0, 7.0])
    np.testing.assert_array_equal(result.of("impact.1.peak_force"), [1.0, 2.0])
    np.testing.assert_array_equal(result.of("impact.2.peak_force"), [3.0, 4.0])
    np.testing.assert_array_equal(result.of("impact.3.peak_force"), [np.nan, np.nan])
