"""How stiff forces answer to motion, as a matrix: springs, then normal forces, then friction."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.elements.stiff_terms import _coupling

NORMAL, FRICTION, BESIDE = np.array([5.0, 7.0]), np.array([2.0, 3.0]), np.array([0.1, 0.2])
CONTACTS = [[5.0, 0.0, 0.0, 0.0], [0.0, 7.0, 0.0, 0.0], [0.1, 0.0, 2.0, 0.0], [0.0, 0.2, 0.0, 3.0]]


@jax.jit
def matrix(springs):
    return _coupling(springs, (jnp.asarray(NORMAL), jnp.asarray(BESIDE)), jnp.asarray(FRICTION))


def test_without_springs():
    np.testing.assert_array_equal(matrix([]), CONTACTS)


@pytest.mark.quick
def test_springs_come_first_and_answer_to_themselves():
    found = np.asarray(matrix([11.0, 13.0]))
    np.testing.assert_array_equal(found[2:, 2:], CONTACTS)
    np.testing.assert_array_equal(found[:2, :2], np.diag([11.0, 13.0]))
    assert not np.any(found[:2, 2:]) and not np.any(found[2:, :2])
