"""A free start and latches in Exudyn, without an impact on the way, so that long steps do; others: `second_opinion`."""

import numpy as np
import pytest

import jaxbuffer as jb
from verification.docking_cases import DOCKING

pytest.importorskip("exudyn", reason="exudyn is not installed: pip install 'jaxbuffer[verify]'")

from verification.second_opinion.compare import DOCKED, Opinions, motion_apart
from verification.second_opinion.exudyn_model import simulate

NAME = "through the middle"
STEPS = (4e-4, 2e-4)  # s


@pytest.fixture(scope="module")
def opinions():
    case, duration = DOCKING[NAME], DOCKED[NAME]
    ours = jb.simulate(case.design, case.scenario, duration, rtol=1e-10, history=True)
    return Opinions(NAME, ours, {h: simulate(case.design, case.scenario, h, duration) for h in STEPS})


def test_they_end_alike(opinions):
    assert {opinions.ours.outcome.name, *(other.outcome for other in opinions.theirs.values())} == {"latched"}
    assert {other.impacts for other in opinions.theirs.values()} == {0}


@pytest.mark.parametrize("quantity", ["peak_latch_force", "stroke", "latch_time"])
def test_both_programs_converge_to_one_another(opinions, quantity):
    """Largest values at Exudyn's steps, not between them, are off by less than the square of a step's share."""
    ours = float(opinions.ours.quantity(quantity))
    name = quantity.removeprefix("peak_") if quantity == "peak_latch_force" else quantity
    coarse, fine = (abs(getattr(opinions.theirs[step], name) / ours - 1.0) for step in STEPS)
    assert fine < 2e-5
    assert fine < 0.5 * coarse or fine < 1e-6


def test_all_bodies_move_alike_while_the_latches_hold(opinions):
    coarse, fine = (motion_apart(opinions.ours, opinions.theirs[step]) for step in STEPS)
    assert fine < 3e-7  # m; measured 1.2e-7
    assert fine < 0.5 * coarse
    angles = [motion_apart(opinions.ours, opinions.theirs[step], angles=True) for step in STEPS]
    assert angles[1] < 1e-6  # rad
    assert np.all(np.isfinite(angles))
