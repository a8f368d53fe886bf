"""How far the buffer's rod goes out beyond its free position: a largest value like the others."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

import jaxbuffer as jb

LATCH = {"latch.stiffness": 2e3, "latch.damping": 50.0}  # N/m, N s/m


@pytest.fixture(scope="module")
def latched():
    """Table 2 with latches: after capture the vehicles swing on a spring that also pulls."""
    return jb.simulate(jb.replace(jb.table2(), LATCH), jb.Scenario(), 20.0, rtol=1e-9, history=True)


def test_the_extension_is_the_deepest_point_of_a_dense_stroke(latched):
    """Between the steps the stroke is a cubic through its values and rates, here from differences of the lengths of the
    buffer; the interpolation's own error there is below 1e-7 of it. No accepted step is beyond it."""
    history, extension = latched.history, float(latched.extension)
    time, stroke = np.asarray(history.time), np.asarray(history.stroke)
    assert 1e-3 < -stroke.min() <= extension * (1.0 + 1e-12)
    lowest = int(np.argmin(stroke))
    near = slice(lowest - 4, lowest + 5)
    t, index = np.unique(time[near], return_index=True)
    dense = CubicHermiteSpline(t, stroke[near][index], np.gradient(stroke[near][index], t, edge_order=2))
    fine = np.linspace(t[1], t[-2], 20_001)
    assert extension == pytest.approx(-dense(fine).min(), rel=1e-5)
    at = latched.maximum_times["extension"]
    assert float(latched.quantity("extension_time")) == at == pytest.approx(fine[dense(fine).argmin()], abs=1e-3)
    assert f"{1e3 * extension:.6g} mm beyond the free length at" in repr(latched)
