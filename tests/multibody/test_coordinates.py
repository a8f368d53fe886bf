"""The order of the coordinates, against numbers that are counted by hand."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.multibody import Coordinates, Kinematics
from jaxbuffer.space import SPACE

ORDER = Coordinates(3, (0, 2, 4))
VALUES = np.arange(15.0)  # of each coordinate its own number


def test_three_of_each_body_then_the_modal_ones():
    assert ORDER.count == 15 and Coordinates(3).count == 9
    assert [ORDER.columns(body) for body in range(3)] == [(0, 1, 2), (3, 4, 5, 9, 10), (6, 7, 8, 11, 12, 13, 14)]
    assert Coordinates(3).columns(2) == (6, 7, 8)


def test_in_space_seven_of_each_position_and_six_of_each_velocity():
    kin = Kinematics(jnp.array([1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0] * 2), jnp.arange(12.0), basis=SPACE)
    assert (kin.order.count, kin.velocity_order.count) == (14, 12)
    assert kin.order.columns(1) == (7, 8, 9, 10, 11, 12, 13) and kin.velocity_order.columns(1) == (6, 7, 8, 9, 10, 11)
    np.testing.assert_array_equal(kin.velocity_order.placements(np.asarray(kin.v))[1], [6, 7, 8, 9, 10, 11])
    flexible = Coordinates(2, (0, 3), each=6)
    assert flexible.count == 15 and flexible.columns(1) == (6, 7, 8, 9, 10, 11, 12, 13, 14)


@pytest.mark.parametrize("rows", [(), (4,), (2, 5)], ids=str)
def test_placements_are_read_from_any_number_of_rows(rows):
    values = np.broadcast_to(VALUES, (*rows, 15))
    placed = ORDER.placements(values)
    assert placed.shape == (*rows, 3, 3)
    np.testing.assert_array_equal(placed.reshape(-1, 3, 3)[-1], [[0, 1, 2], [3, 4, 5], [6, 7, 8]])
    np.testing.assert_array_equal(ORDER.angle(values, 1), np.full(rows, 5.0))
    np.testing.assert_array_equal(values[..., ORDER.modal(2)].reshape(-1, 4)[-1], [11, 12, 13, 14])


def test_a_body_moves_along_x_and_y():
    assert tuple(ORDER.translation(VALUES, 2)) == (6.0, 7.0)
    assert ORDER.modal(0) == slice(9, 9), "a rigid body has no modal coordinates"
