"""The benchmarks' peers that run in one compiled loop: right, and their Jacobian the derivative of their equations."""

from dataclasses import replace

import numpy as np
import pytest

from in_short import often

pytest.importorskip("numba", reason="numba is not installed: pip install 'jaxbuffer[bench]'")
pytest.importorskip("sksundae", reason="scikit-sundae is not installed: pip install 'jaxbuffer[bench]'")

from benchmarks.accuracy import errors
from benchmarks.peers import parameters as at
from benchmarks.peers.compiled import sundials_library
from benchmarks.peers.parameters import Parameters
from benchmarks.peers.reference import load
from benchmarks.peers.solvers import PEERS, solve
from benchmarks.peers.space import capture as space_capture
from benchmarks.peers.space import watch as space
from benchmarks.peers.space.check import references
from benchmarks.peers.watch import CAPTURE, EVENTS, context_of, forces, slope, slope_jacobian, watch
from benchmarks.plan import REFERENCES

COMPILED = [peer for peer in PEERS if peer.startswith("compiled")]
pytestmark = pytest.mark.slow  # compiling takes most of a minute


def moving(rolling, active, cone_length):
    """A state in contact or out of it, and a softer, larger contact, smooth enough for differences."""
    y, context = context_of(Parameters(rolling=rolling))
    random = np.random.default_rng(2)
    y = y + random.normal(size=25) * np.repeat([0.02, 0.05], [12, 13])
    context[30:32], context[32:34] = active, 0.1
    context[at.RADIUS], context[at.SLIP_SPEED], context[at.STIFFNESS] = 0.2, 0.05, 1e5
    context[at.CONE_LENGTH] = cone_length
    return y, context


@pytest.mark.parametrize("cone_length", [0.02, 0.0735, 0.2], ids=["rim", "between", "flank"])
@pytest.mark.parametrize("active", [(0, 0), (1, 0), (0, 1), (1, 1)])
@pytest.mark.parametrize("rolling", [False, True])
def test_the_jacobian_is_the_slopes_derivative(rolling, active, cone_length):
    y, context = moving(rolling, active, cone_length)
    step = 1e-6
    columns = []
    for e in step * np.eye(25):
        near = slope(y + e, context) - slope(y - e, context)
        far = slope(y + 2 * e, context) - slope(y - 2 * e, context)
        columns.append((8 * near - far) / (12 * step))
    expected = np.stack(columns, axis=1)
    scale = np.abs(expected).max(axis=1, keepdims=True) + 1.0
    assert np.max(np.abs(slope_jacobian(y, context) - expected) / scale) < 1e-7


@pytest.mark.parametrize("cone_length", [0.02, 0.2], ids=["rim", "flank"])
@pytest.mark.parametrize("rolling", [False, True])
def test_the_watched_rate_is_that_of_the_force(rolling, cone_length):
    y, context = moving(rolling, (1, 1), cone_length)
    flow, step = slope(y, context), 1e-6
    rate = (np.array(forces(y + step * flow, context)) - np.array(forces(y - step * flow, context))) / (2 * step)
    assert np.all(np.array(forces(y, context)) > 0.0)
    values = np.empty(EVENTS)
    watch(y, values, context)
    assert values[CAPTURE + 2 :] == pytest.approx(rate, rel=1e-6)


@pytest.mark.parametrize("peer", often(COMPILED, "compiled DOP853", "compiled CVODE Adams"))
def test_compiled_peers_reach_the_reference_captures(peer):
    for case in load(REFERENCES)[:3]:  # welded, free tip, fast
        result = solve(peer, case.parameters, 1e-9, 1e-12)
        assert max(errors(result, case).values()) < 1e-6, case.name
        assert result.peak_time == pytest.approx(case.peak_time, abs=1e-7)


@pytest.mark.parametrize("peer", COMPILED)
def test_compiled_peers_end_in_every_way(peer):
    escaping = {"misalignment": -0.14, "contact_distance": 0.07, "approach_speed": 0.3, "k_A": 2e4, "tip_mass": 0.5}
    captures = [
        solve(peer, replace(Parameters(), **changes), 1e-8, 1e-10)
        for changes in ({"duration": 0.05}, escaping | {"friction": 0.7}, {})
    ]
    assert [capture.outcome for capture in captures] == ["timeout", "escaped", "captured"]
    assert captures[0].end_time == pytest.approx(0.05, rel=1e-12)


def test_a_library_that_is_missing_leaves_no_half_of_cvode(monkeypatch):
    monkeypatch.setattr(sundials_library, "_file", lambda part: None)
    assert sundials_library.functions() is None


SPACE = {case.name: case for case in references()}


@pytest.mark.long
@pytest.mark.parametrize("name", SPACE)
def test_the_peer_in_space_reaches_the_reference_captures(name):
    result = space_capture(SPACE[name].parameters, 1e-9, 1e-12)
    assert max(errors(result, SPACE[name]).values()) < 1e-6


@pytest.mark.parametrize("slant", [0.02, 0.0735], ids=["rim", "cone"])
@pytest.mark.parametrize("name", ["two planes", "free tip, target rolls"])
def test_the_watched_rate_in_space_is_that_of_the_force(name, slant):
    """Everything turns, and the ball is some millimetres deep in a cone that is soft enough for differences."""
    y, context = space.context_of(replace(SPACE[name].parameters, cone_length=slant))
    random = np.random.default_rng(3)
    y = y + random.normal(size=len(y)) * np.repeat([2e-3, 0.05], [space.MOVES_S, len(y) - space.MOVES_S])
    context[space.ACTIVE], context[space.MEMORY] = 1.0, 0.1
    context[space.at.RADIUS], context[space.at.STIFFNESS] = 0.06, 1e5
    flow, step, values = np.empty_like(y), 1e-6, np.empty(4)
    space.slope_into(y, flow, context)
    (ahead,), (behind,) = (space.forces(y + sign * step * flow, context) for sign in (1.0, -1.0))
    space.watch_along(y, flow, values, context)
    assert ahead > 0.0 and values[3] == pytest.approx((ahead - behind) / (2.0 * step), rel=1e-5)
