"""Kelvin and Voigt's spring and damper: gradients through critical damping."""

import jax
import numpy as np
import pytest

from jaxbuffer.contact.laws import KelvinVoigt


@pytest.mark.parametrize("ratio", [0.1, 0.6, 0.999, 1.0, 1.001, 3.0])
def test_a_dampers_restitution_has_a_slope_on_both_sides_of_critical(ratio):
    """By the damping, against central differences; ζ = c/(2 √(k m))."""
    mass, stiffness = 0.5, 800.0
    critical = 2.0 * np.sqrt(stiffness * mass)

    def delivered(share):
        return KelvinVoigt(stiffness, critical * share).delivered_restitution(mass, 0.1)

    delivered, step = jax.jit(delivered), 1e-5
    slope = float(jax.jit(jax.grad(delivered))(ratio))
    difference = float(delivered(ratio + step) - delivered(ratio - step)) / (2.0 * step)
    assert slope == pytest.approx(difference, rel=1e-6)
    assert slope < 0.0
