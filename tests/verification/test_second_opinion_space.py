"""A docking in space with MuJoCo's accelerations, in minimal coordinates: see `second_opinion.mujoco_docking`."""

import functools
import os

import pytest

import jaxbuffer as jb
from docking3d.reference import CASES, QUANTITIES

os.environ.setdefault("MUJOCO_GL", "disable")  # nothing is drawn, and machines without a display have no GL
pytest.importorskip("mujoco", reason="mujoco is not installed: pip install 'jaxbuffer[verify]'")

from verification.second_opinion.mujoco_docking import simulate

NAMES = ("two planes", "free tip, target rolls", "free start, all rates")
TIGHT = 1e-9  # rtol of both

pytestmark = [pytest.mark.slow, pytest.mark.long]


@functools.cache
def by_mujoco(name):
    """A reference capture by MuJoCo."""
    case = CASES[name]
    return simulate(case.design, case.scenario, TIGHT, case.duration)


@pytest.mark.parametrize("name", NAMES)
def test_mujoco_and_the_independent_program_agree(name, evidence):
    """In MuJoCo what `jb.mjcf` writes moves as the bodies of a program that shares nothing with the product."""
    case, theirs = CASES[name], by_mujoco(name)
    assert (theirs.outcome, theirs.impacts) == (case.values["outcome"], case.values["impacts"])
    both = [name for name in QUANTITIES if name in theirs.values]
    error = max(abs(theirs.values[name] / case.values[QUANTITIES[name]] - 1.0) for name in both)
    evidence("Docking in space", f"MuJoCo's capture, {name}", error, 1e-7, "an independent program, Kane's method")


@pytest.mark.parametrize("name", NAMES)
def test_mujocos_bodies_and_joints_move_alike(name):
    case, theirs = CASES[name], by_mujoco(name)
    ours = jb.simulate(case.design, case.scenario, case.duration, rtol=TIGHT)
    assert (theirs.outcome, theirs.impacts) == (ours.outcome.name, int(ours.impact_count))
    for quantity, value in theirs.values.items():
        assert float(ours.quantity(quantity)) == pytest.approx(value, rel=1e-6), quantity
