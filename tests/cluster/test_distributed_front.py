"""A front by an executor: all of its points are tuned by it, and are those that threads find."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cluster.connect import connected
from made_up import made_up_tuning


def test_all_points_are_tuned_by_the_executor(monkeypatch):
    given = []

    def tune(problem, *, executor, **options):
        given.append(executor)
        return made_up_tuning(problem)

    monkeypatch.setattr("jaxbuffer.tuning.pareto.tune", tune)
    problem = jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)])
    for executor in (ThreadPoolExecutor(1), None):
        jb.pareto(problem, ["peak_force", "stroke"], limits={"stroke": [0.025, 0.02, 0.015]}, executor=executor)  # m
        assert given == [executor] * 3
        given.clear()


@pytest.mark.slow
def test_the_front_is_the_same():
    stiffness, scenarios = (
        jb.Variable("impact.stiffness", 1e10, 1e12),
        [jb.BarDropScenario(height=h) for h in (0.1, 0.2)],
    )
    drops = jb.Problem(jb.BarDrop(), scenarios, [stiffness], duration=0.25)
    asked = {"points": 2, "starts": 1, "iterations": 3}
    here = jb.pareto(drops, ["peak_force", "penetration"], **asked)
    with connected("local") as client:
        there = jb.pareto(drops, ["peak_force", "penetration"], executor=client.get_executor(), **asked)
    assert np.array_equal(here.values, there.values)
    assert [one.records for one in here.points] == [one.records for one in there.points]
