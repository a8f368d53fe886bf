"""Hertz's pressure under a ball against textbook formulas."""

import numpy as np
import pytest

from jaxbuffer.contact.laws import hertz_pressure, yield_pressure


@pytest.mark.parametrize(("force", "radius", "young", "poisson"),
                         [(10.0, 0.015, 210e9, 0.3), (250.0, 0.004, 70e9, 0.0), (1.0, 2.0, 3e9, 0.45)])  # fmt: skip
def test_largest_pressure_under_a_ball(force, radius, young, poisson):
    """p = 3 F/(2 π a²) with a³ = 3 F R/(4 E*), 1/E* = 2 (1 - ν²)/E; it goes with the third root of the force."""
    modulus = young / (2.0 * (1.0 - poisson**2))
    a = (3.0 * force * radius / (4.0 * modulus)) ** (1.0 / 3.0)
    found = hertz_pressure(force, radius, modulus)
    assert float(found) == pytest.approx(3.0 * force / (2.0 * np.pi * a**2), rel=1e-12)
    assert float(hertz_pressure(8.0 * force, radius, modulus)) == pytest.approx(2.0 * float(found), rel=1e-12)


def test_yield_begins_at_1_61_times_the_yield_stress():
    """Von Mises' stress is largest below the surface: 0.62 of the largest pressure for ν = 0.3 (Johnson)."""
    assert float(yield_pressure(300e6, 0.3)) == pytest.approx(1.61 * 300e6, rel=5e-3)
    assert float(yield_pressure(1.0, 0.4) / yield_pressure(1.0, 0.3)) == pytest.approx(np.exp(0.0736), rel=1e-12)
