"""Peak forces of the first impact in closed form, against SciPy."""

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from jaxbuffer.mechanisms.probe_cone.closed_form import hertz_peak, loss_factor

share = jax.jit(loss_factor)


def integrated(hysteresis):
    """Peak of F = δ^{3/2} (1 + χ̂ δ̇) with δ̈ = -F and δ̇(0) = 1, over that of χ̂ = 0, which is (5/4)^{3/5}."""

    def force(y):
        return max(y[0], 0.0) ** 1.5 * (1.0 + hysteresis * y[1])

    found = solve_ivp(lambda t, y: [y[1], -force(y)], (0.0, 2.0), [0.0, 1.0], "DOP853", rtol=1e-11, atol=1e-13,
                      dense_output=True)  # fmt: skip
    times = np.linspace(0.0, 2.0, 40001)
    return max(force(y) for y in found.sol(times).T) / 1.25**0.6


@pytest.mark.quick
@pytest.mark.parametrize("hysteresis", [1e-3, 0.1, 0.4, 0.75, 1.5])
def test_peak_with_loss_over_that_without(hysteresis):
    np.testing.assert_allclose(share(hysteresis), integrated(hysteresis), rtol=1e-7)


def test_a_little_loss():
    """1 - 0.4 χ̂ to first order, where the closed form loses its digits and where it takes over."""
    for hysteresis in (0.0, 1e-6, 9.9e-5, 1.1e-4):
        assert float(share(hysteresis)) == pytest.approx(1.0 - 0.4 * hysteresis, abs=2e-8)


def test_peak_of_an_energy():
    """T = (2/5) K δ^{5/2}, F = K δ^{3/2}."""
    depth, stiffness = 2e-4, 3e9
    energy = 0.4 * stiffness * depth**2.5
    assert float(hertz_peak(stiffness, energy)) == pytest.approx(stiffness * depth**1.5, rel=1e-12)
