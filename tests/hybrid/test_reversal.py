"""Steps that pass over the reversal of a force, by hand."""

import jax
import numpy as np
import pytest

from jaxbuffer.hybrid.events.guards import Guards
from jaxbuffer.hybrid.events.reversal import reversal_in_step

end_of_step = jax.jit(reversal_in_step)


def guards(*reversals):
    none = np.zeros(0)
    rows = np.array(reversals, float) if reversals else np.zeros((0, 1))
    return Guards(*[none] * 7, rows, np.zeros(()), np.zeros(()))


@pytest.mark.parametrize(
    ("start", "end", "fraction"),
    [
        (-30.0, 90.0, 0.25),  # far past on both sides: to where it is zero
        (30.0, -10.0, 0.75),
        (-30.0, 0.9, 1.0),  # ends where the slope is seen
        (0.9, -30.0, 1.0),  # begins there
        (-30.0, -3.0, 1.0),  # does not pass zero
        (0.0, 50.0, 1.0),  # has not acted at the start
    ],
)
def test_one_that_goes_far_past_on_both_sides_ends_on_it(start, end, fraction):
    np.testing.assert_allclose(end_of_step(guards([start]), guards([end])), fraction, rtol=1e-15)


def test_the_first_of_several_counts():
    np.testing.assert_allclose(end_of_step(guards([-30.0], [20.0], [5.0]), guards([90.0], [-80.0], [6.0])), 0.2)


@pytest.mark.parametrize(("beside", "fraction"), [(4.0, 0.25), (20.0, 1.0)])
def test_in_space_one_that_passes_close_by(beside, fraction):
    start, end = guards([-30.0, beside, 0.0]), guards([90.0, beside, 0.0])
    np.testing.assert_allclose(end_of_step(start, end), fraction, rtol=1e-15)


def test_where_nothing_reverses_steps_stand():
    assert end_of_step(guards(), guards()) == 1.0
