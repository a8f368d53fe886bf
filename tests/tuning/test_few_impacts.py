"""The peaks of a run that lists fewer impacts than are looked at."""

from types import SimpleNamespace

import numpy as np

from jaxbuffer.tuning.search.measurement import PEAKS, _all_peaks


def test_one_listed_impact_keeps_its_peak_and_slope():
    run = SimpleNamespace(impacts=SimpleNamespace(peak_force=np.array([7.0])), peak_impact=0, peak_force=7.0)
    peaks, slopes = _all_peaks(run, np.array([[1.0, 2.0]]), np.array([1.0, 2.0]))
    assert peaks.shape == (PEAKS,) and slopes.shape == (PEAKS, 2)
    assert peaks[0] == 7.0 and np.array_equal(slopes[0], [1.0, 2.0])
    assert not peaks[1:].any() and not slopes[1:].any()
