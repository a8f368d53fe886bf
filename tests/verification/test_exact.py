"""Whole captures against the paper's equations integrated in SciPy (exact_model.py): every located maximum.

The reference took its largest stroke, hinge angle and hinge force over steps; here they are searched between them.
"""

from functools import cache

import numpy as np
import pytest

from jaxbuffer import simulate
from verification.cases import CASES
from verification.exact_model import ExactModel

pytestmark = pytest.mark.slow

# Captures whose reference maxima fall between steps, and both tips of Table 2; the tolerance SciPy can afford.
TOLERANCES = {"table2": 1e-10, "table2-rolling": 1e-9, "random-1-6": 1e-10, "random-1-10": 1e-10, "random-1-13": 1e-10}
each_case = pytest.mark.parametrize("name", TOLERANCES)


@cache
def exact(name):
    case = CASES[name]
    model = ExactModel(case.design, case.scenario)
    return model.maxima(case.values["end_time"], TOLERANCES[name])


@cache
def capture(name):
    case = CASES[name]
    return simulate(case.design, case.scenario, rtol=1e-10)


@each_case
def test_contact_forces_and_impacts(name):
    (lower, upper, *_), touchdowns = exact(name)
    found = capture(name)
    impacts = found.impacts
    np.testing.assert_allclose(found.peak_force, max(lower, upper), rtol=3e-7)
    assert int(found.peak_flank) == int(upper > lower)
    assert int(found.impact_count) == touchdowns
    for flank, largest in enumerate((lower, upper)):
        here = np.asarray(impacts.peak_force)[np.asarray(impacts.flank) == flank]
        np.testing.assert_allclose(np.max(here, initial=0.0), largest, rtol=1e-6)


@each_case
@pytest.mark.parametrize(
    ("quantity", "index"), [("peak_hinge_force", 2), ("peak_buffer_force", 3), ("stroke", 4), ("hinge_angle", 5)]
)
def test_other_maxima(name, quantity, index):
    np.testing.assert_allclose(getattr(capture(name), quantity), exact(name)[0][index], rtol=1e-6)


@each_case
def test_reference_is_a_lower_bound_where_it_was_taken_over_steps(name):
    (*_, hinge, _, stroke, angle), _ = exact(name)
    values = CASES[name].values
    assert values["hinge_force"] < hinge
    assert values["hinge_angle"] < angle * (1 + 1e-9)
    assert values["stroke"] < stroke * (1 + 1e-9)
