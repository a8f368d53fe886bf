"""Spectra of signals against pyyeti's values and the closed forms of pulses; the shear below a struck surface."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer import InputError
from jaxbuffer.shock import hertz_shear, largest_response, shock_spectrum


def half_sine(samples):
    return jnp.sin(jnp.pi * jnp.linspace(0.0, 1.0, samples))


def test_a_damped_spectrum_of_a_half_sine():
    """pyyeti.srs 1.4.7, Q = 10."""
    ratios = np.array([0.25, 0.5, 0.75, 0.8099, 1.0, 2.0])
    found = shock_spectrum(half_sine(4001), 1.0 / 4000.0, ratios, 0.05)
    np.testing.assert_allclose(found, [0.87808, 1.46264, 1.64490, 1.65142, 1.62379, 1.21237], atol=2e-5)


def test_without_damping_it_is_the_closed_form():
    ratios = np.array([0.2, 0.5, 0.8, 1.3, 2.2])
    found = shock_spectrum(half_sine(4001), 1.0 / 4000.0, ratios, 0.0)
    np.testing.assert_allclose(found, largest_response("half-sine", ratios), atol=2e-5)


def test_it_is_differentiable_by_the_signal():
    size = jax.grad(lambda a: shock_spectrum(a * half_sine(401), 1.0 / 400.0, np.array([0.7]), 0.05)[0])(3.0)
    assert float(size) == pytest.approx(float(shock_spectrum(half_sine(401), 1.0 / 400.0, np.array([0.7]), 0.05)[0]))


@pytest.mark.parametrize("frequency", [0.0, 30.0])
def test_frequencies_that_the_samples_do_not_show_are_refused(frequency):
    with pytest.raises(InputError, match=rf"{frequency:.6g} Hz; allowed: \(0, 20\] Hz"):
        shock_spectrum(half_sine(401), 1.0 / 400.0, np.array([1.0, frequency]))


def test_hertzs_shear_is_largest_half_a_radius_deep():
    """Johnson: 0.310 q0 at 0.48 a for ν = 0.3; seed 003 says about 2/((1 + ν)π)."""
    depth = np.linspace(0.0, 3.0, 30001)
    shear = np.asarray(hertz_shear(depth, 0.3))
    assert shear.max() == pytest.approx(0.310, abs=5e-4)
    assert depth[shear.argmax()] == pytest.approx(0.48, abs=5e-3)
    assert depth[shear.argmax()] == pytest.approx(2.0 / (1.3 * np.pi), rel=0.02)
    # at the surface: σz = -q0, σr = -(1 + 2ν)/2 q0
    assert shear[0] == pytest.approx(0.5 * (1.0 - 0.8), abs=1e-12)
