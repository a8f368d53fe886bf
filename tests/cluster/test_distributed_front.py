"""A front over a scheduler: one client for all of its points, and the points that threads find."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer import InputError
from jaxbuffer.cluster.connect import connected
from made_up import made_up_tuning

OBJECTIVES = ["peak_force", "stroke"]
LIMITS = {"stroke": [0.025, 0.02, 0.015]}  # m


def problem():
    return jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)])


@pytest.fixture
def clients(monkeypatch):
    """Tunings without the wait: the client of each, and its state then."""
    given = []

    def tune(problem, *, client, **options):
        given.append((client, client and client.status))
        return made_up_tuning(problem)

    monkeypatch.setattr("jaxbuffer.tuning.pareto.tune", tune)
    return given


def test_all_points_share_one_client_which_ends_with_them(clients):
    front = jb.pareto(problem(), OBJECTIVES, client="local", workers=1, limits=LIMITS)
    (client,) = {client for client, _ in clients}
    assert [status for _, status in clients] == ["running"] * 3 == ["running"] * len(front.points)
    assert client.status == "closed"


def test_a_client_that_is_given_stays_open(clients):
    with connected("local", 1) as mine:
        jb.pareto(problem(), OBJECTIVES, 2, client=mine)
        assert {client for client, _ in clients} == {mine} and mine.status == "running"


def test_without_a_scheduler_there_is_none(clients):
    jb.pareto(problem(), OBJECTIVES, limits=LIMITS)
    assert [client for client, _ in clients] == [None] * 3


def test_a_scheduler_that_is_none_is_refused_before_any_point(clients):
    with pytest.raises(InputError, match="scheduler lokal is unknown; expected local, processes or an address"):
        jb.pareto(problem(), OBJECTIVES, client="lokal")
    assert clients == []


@pytest.mark.slow
def test_the_front_is_the_same(tmp_path):
    stiffness, scenarios = (
        jb.Variable("impact.stiffness", 1e10, 1e12),
        [jb.BarDropScenario(height=h) for h in (0.1, 0.2)],
    )
    drops = jb.Problem(jb.BarDrop(), scenarios, [stiffness], duration=0.25)
    asked = {"points": 2, "starts": 1, "iterations": 3}
    here, there = (jb.pareto(drops, ["peak_force", "penetration"], client=c, **asked) for c in (None, "local"))
    assert np.array_equal(here.values, there.values)
    assert [one.records for one in here.points] == [one.records for one in there.points]
