"""Axes of joints, guides, flanks and thrusts have the length 1, or are refused."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer import InputError
from jaxbuffer.contact import Segment
from jaxbuffer.elements import Thrust
from jaxbuffer.multibody import GROUND, AxialSpringDamper, PointOnLine, Prismatic

MADE = {
    "PointOnLine: normal": lambda x, y: PointOnLine(GROUND, 0, normal=(x, y)),
    "Prismatic: normal": lambda x, y: Prismatic(GROUND, 0, normal=(x, y)),
    "guide": lambda x, y: AxialSpringDamper(0, 1, (0.0, 0.0), (0.0, 0.0), 1.0, 0.0, 1.0, guide=(x, y)),
    "Segment: direction": lambda x, y: Segment(0.0, 0.0, x, y, 1.0),
    "thrust: axis": lambda x, y: Thrust(0, 1.0, 1.0, axis=(x, y)),
}


@pytest.mark.parametrize("name", MADE)
def test_an_axis_that_is_no_unit_vector_is_refused(name):
    with pytest.raises(InputError, match=rf"^{name} \(3, 4\) is no unit vector; its length is 5: divide both by that$"):
        MADE[name](3.0, 4.0)
    for x, y in ((0.0, 0.0), (np.nan, 1.0), (1.0, 1e-2)):
        with pytest.raises(InputError, match="no unit vector"):
            MADE[name](x, y)
    MADE[name](0.6, -0.8)
    MADE[name](0.70710678, 0.70710678)  # as typed


def test_each_segment_of_several_is_looked_at_and_traced_ones_are_not():
    ones, zeros = np.ones(3), np.zeros(3)
    with pytest.raises(InputError, match=r"direction \(1, 2\)"):
        Segment(zeros, zeros, ones, np.array([0.0, 0.0, 2.0]), 1.0)
    jax.jit(lambda angle: Segment(0.0, 0.0, jnp.cos(angle), jnp.sin(angle), 1.0).direction_x)(0.3)
