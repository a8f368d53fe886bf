"""Reported maxima are the maxima: over random designs, no impact lacks its peak and no step exceeds what is reported.

Several quantities peak within a fraction of a microsecond of each other where a free tip sticks; each must be located.
"""

import numpy as np
import pytest
from benchmarks.campaign import BELOW_HISTORY, STUDIES, below, measured, sizes

from jaxbuffer import simulate
from verification.designs import random_case

pytestmark = pytest.mark.slow

REPORTED = {
    "peak_force": "contact_force",
    "peak_hinge_force": "hinge_force",
    "peak_buffer_force": "buffer_force",
    "stroke": "stroke",
    "hinge_angle": "hinge_angle",
}
each_tip = pytest.mark.parametrize("free", [False, True], ids=["welded tip", "free tip"])


@each_tip
def test_every_impact_has_its_peak(free):
    """An impact that ended has pushed; the reported peak is the largest of all impacts' peaks."""
    without = []
    for seed in range(60):
        capture = simulate(*random_case(seed, free))
        impacts, count = capture.impacts, int(capture.impact_count)
        peaks, ended = np.asarray(impacts.peak_force)[:count], np.isfinite(np.asarray(impacts.release_time)[:count])
        np.testing.assert_allclose(capture.peak_force, peaks.max(), rtol=1e-12)
        without += [(seed, impact) for impact in np.flatnonzero(ended & (peaks == 0.0))]
    assert not without


@each_tip
def test_no_step_exceeds_a_reported_maximum(free):
    """Measured: 3e-10. A free tip that sticks makes its friction, and so the hinge force, noisy at the default
    tolerance, where a maximum of noise alone is given up: a step exceeded the reported one by 2.6e-5 (one of 30)."""
    exceeded = []
    for seed in range(30):
        capture = simulate(*random_case(seed, free), history=True)
        assert float(capture.history.time[-1]) == float(capture.end_time)
        for reported, sampled in REPORTED.items():
            largest = float(np.max(np.abs(getattr(capture.history, sampled))))
            allowed = 1e-4 if free and reported == "peak_hinge_force" else 1e-8
            if float(getattr(capture, reported)) < largest * (1 - allowed):
                exceeded.append((seed, reported, float(getattr(capture, reported)), largest))
    assert not exceeded


@pytest.mark.parametrize(
    ("title", "numbers"), [("slider-crank, play in both pins", (61, 188, 207, 306)), ("docking", (0, 1, 2, 3, 4, 5))]
)
def test_no_accepted_step_exceeds_a_maximum_of_the_campaign(title, numbers):
    """Runs of `python -m benchmarks.campaign`. Without a look at the accepted steps the drive torque of these cranks is
    5 to 40 % below a value of their own history: friction reverses, and the torque jumps, while both pins bounce."""
    study = STUDIES[title]()
    cases = list(study.drawn(400, 0))
    for number in numbers:
        *_, reported, size, history = measured(*cases[number], study.duration)
        assert np.max(below(reported, history, sizes(size, history))) <= BELOW_HISTORY, number
