"""A docking in space with MuJoCo's accelerations, in minimal coordinates: see `second_opinion.mujoco_docking`."""

import os

import pytest

import jaxbuffer as jb
from docking3d.reference import CASES

os.environ.setdefault("MUJOCO_GL", "disable")  # nothing is drawn, and machines without a display have no GL
pytest.importorskip("mujoco", reason="mujoco is not installed: pip install 'jaxbuffer[verify]'")

from verification.second_opinion.mujoco_docking import simulate

NAMES = ("two planes", "free tip, target rolls", "free start, all rates")
TIGHT = 1e-9  # rtol of both

pytestmark = [pytest.mark.slow, pytest.mark.long]


@pytest.mark.parametrize("name", NAMES)
def test_mujocos_bodies_and_joints_move_alike(name):
    case = CASES[name]
    ours = jb.simulate(case.design, case.scenario, case.duration, rtol=TIGHT)
    theirs = simulate(case.design, case.scenario, TIGHT, case.duration)
    assert (theirs.outcome, theirs.impacts) == (ours.outcome.name, int(ours.impact_count))
    for quantity, value in theirs.values.items():
        assert float(ours.quantity(quantity)) == pytest.approx(value, rel=1e-6), quantity
