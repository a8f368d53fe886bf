"""The first impact in Exudyn, from its own bodies, joints and connectors; whole captures: `second_opinion`."""

import numpy as np
import pytest

import jaxbuffer as jb

pytest.importorskip("exudyn", reason="exudyn is not installed: pip install 'jaxbuffer[verify]'")

from verification.second_opinion.compare import Opinions
from verification.second_opinion.exudyn_model import simulate

STEPS = (4e-6, 2e-6)  # s
END = 0.009  # s


@pytest.fixture(scope="module")
def opinions():
    ours = jb.simulate(jb.table2(), duration=END, rtol=1e-10)
    # One step more, since Exudyn is looked at where a step starts.
    return Opinions("first impact", ours, {h: simulate(jb.table2(), jb.Scenario(), h, END + h, END) for h in STEPS})


@pytest.mark.parametrize("quantity", ["first_peak", "hinge_force", "stroke"])
def test_both_programs_converge_to_one_another(opinions, quantity):
    """Exudyn's trapezoidal rule is of second order: a quarter of the deviation at half the step, none extrapolated."""
    coarse, fine = (opinions.scalars(step)[quantity] for step in STEPS)
    assert abs(coarse) < 5e-4
    assert abs((4 * fine - coarse) / 3) < 3e-6
    assert abs(fine) < 0.3 * abs(coarse) or abs(fine) < 1e-6


def test_all_bodies_are_at_the_same_places_after_the_impact(opinions):
    log = opinions.ours.log
    coarse, fine = (opinions.theirs[step].courses[-1] for step in STEPS)
    np.testing.assert_allclose([coarse[0], fine[0]], END, rtol=0, atol=1e-12)
    ours = np.asarray(log.rows[int(log.count) - 1, 0, :12])
    assert np.max(np.abs(ours - fine[4:])) < 1e-8  # m, rad; measured 6e-9
    assert np.max(np.abs(ours - (4 * fine - coarse)[4:] / 3)) < 1e-9


def test_they_count_the_same_impacts(opinions):
    assert opinions.agree(STEPS[0]) and opinions.agree(STEPS[1])
