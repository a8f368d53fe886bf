"""Cosine and sine against NumPy's, over the whole range promised."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.plane import trigonometry

cos_sin = jax.jit(trigonometry.cos_sin)


@pytest.mark.parametrize("size", [1e-8, 1.0, 10.0, 1e3, 1e5])
def test_against_numpy(size):
    angle = np.random.default_rng(0).uniform(-size, size, 100_000)
    cos, sin = map(np.asarray, cos_sin(angle))
    assert np.max(np.abs(cos - np.cos(angle))) < 3e-16
    assert np.max(np.abs(sin - np.sin(angle))) < 3e-16


def test_small_angles_keep_their_digits():
    angle = np.array([0.0, 1e-300, 1e-20, -1e-9, 1e-5])
    np.testing.assert_allclose(cos_sin(angle)[1], np.sin(angle), rtol=2e-16)


@pytest.mark.parametrize("quadrant", range(-4, 5))
def test_between_quadrants(quadrant):
    angle = np.nextafter(np.pi / 4, [0.0, 1.0]) + quadrant * np.pi / 2
    cos, sin = cos_sin(angle)
    np.testing.assert_allclose(cos, np.cos(angle), atol=3e-16)
    np.testing.assert_allclose(sin, np.sin(angle), atol=3e-16)


def test_derivatives():
    angle = np.linspace(-4.0, 4.0, 9)
    _, (d_cos, d_sin) = jax.jit(lambda it: jax.jvp(cos_sin, (it,), (jnp.ones(9),)))(angle)
    np.testing.assert_allclose(d_cos, -np.sin(angle), atol=1e-15)
    np.testing.assert_allclose(d_sin, np.cos(angle), atol=1e-15)


def test_nothing_becomes_something():
    assert np.all(np.isnan(np.stack(cos_sin(np.array([np.nan, np.inf])))))
