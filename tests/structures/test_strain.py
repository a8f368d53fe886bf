"""Logarithmic strain in closed form against the logarithm of a matrix, and its slope where stretches are equal."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import logm

from jaxbuffer.structures.strain import SMALL, logarithmic


@pytest.mark.parametrize("apart", [1e-9, 0.01, 0.9 * np.sqrt(SMALL), 1.1 * np.sqrt(SMALL), 0.3, 0.9])
@pytest.mark.parametrize("angle", [0.0, 0.4, 1.3])
def test_it_is_half_the_logarithm_of_c(apart, angle):
    """``apart``: the half difference of the squared principal stretches over their mean, on both sides of where the
    series ends."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    metric = turn @ np.diag([1.7 * (1.0 + apart), 1.7 * (1.0 - apart)]) @ turn.T
    exact = 0.5 * logm(metric).real
    found = logarithmic(*(jnp.asarray(metric[k]) for k in ((0, 0), (1, 1), (0, 1))))
    np.testing.assert_allclose(found, [exact[0, 0], exact[1, 1], 2.0 * exact[0, 1]], atol=1e-14)


def test_its_slope_where_nothing_is_strained():
    """½ of a change of C11 is a change of ε11, and γ12 is that of C12."""
    slope = jax.jacobian(lambda c: logarithmic(c[0], c[1], c[2]))(jnp.array([1.0, 1.0, 0.0]))
    np.testing.assert_allclose(slope, np.diag([0.5, 0.5, 1.0]), atol=1e-15)


def test_its_slopes_meet_where_the_series_ends():
    at = jax.grad(lambda d: logarithmic(1.0 + d, 1.0 - d, jnp.asarray(0.0))[0])
    end = float(np.sqrt(SMALL))
    before, after = (float(at(jnp.asarray(end * (1.0 + sign * 1e-12)))) for sign in (-1.0, 1.0))
    assert before == pytest.approx(0.5 / (1.0 + end), abs=1e-12) and after == pytest.approx(before, abs=1e-12)
