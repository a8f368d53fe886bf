"""How long an impact takes, as each law says before it is solved."""

import numpy as np
import pytest
from scipy.special import gamma

from jaxbuffer.contact.laws import AdamsImpact, Hertz, KelvinVoigt


def duration(stiffness, exponent, mass, speed):
    """Of m δ̈ = -K δⁿ: 2 ∫ dδ/√(v² - 2 K δ^{n+1}/((n+1) m)), a beta function."""
    n = exponent
    depth = ((n + 1.0) * mass * speed**2 / (2.0 * stiffness)) ** (1.0 / (n + 1.0))
    share = 1.0 / (n + 1.0)
    return 2.0 * depth / speed * np.sqrt(np.pi) * gamma(share) * share / gamma(share + 0.5)


@pytest.mark.parametrize("exponent", [1.5, 2.2])
def test_without_a_damper_it_goes_with_the_duration(exponent):
    """Of every mass, speed and stiffness by the same factor, from 1 to 4."""
    cases = [(1.0, 0.1, 1e7), (0.01, 3.0, 1e7), (20.0, 0.5, 4e9)]
    factors = [
        duration(stiffness, exponent, mass, speed)
        / float(AdamsImpact(stiffness, exponent, 0.0, 1e-4).time_scale(mass, speed))
        for mass, speed, stiffness in cases
    ]
    np.testing.assert_allclose(factors, factors[0], rtol=1e-12)
    assert 1.0 < factors[0] < 4.0


def test_of_hertz_too():
    found = [duration(1e9, 1.5, mass, speed) / float(Hertz(1e9).time_scale(mass, speed))
             for mass, speed in ((1.0, 0.1), (0.02, 4.0))]  # fmt: skip
    np.testing.assert_allclose(found, found[0], rtol=1e-12)
    assert 1.0 < found[0] < 4.0


@pytest.mark.parametrize("law", [AdamsImpact(1e7, 1.5, 1e6, 1e-4), KelvinVoigt(1e3, 1e6)])
def test_a_strong_damper_stops_within_mass_over_damping(law):
    assert 0.3 < float(law.time_scale(2.0, 0.1)) / (2.0 / 1e6) < 3.0


def test_a_spring_and_a_damper_act_side_by_side():
    """1/τ = 1/τ_elastic + c/m."""
    elastic = float(AdamsImpact(1e7, 1.5, 0.0, 1e-4).time_scale(2.0, 0.3))
    both = float(AdamsImpact(1e7, 1.5, 800.0, 1e-4).time_scale(2.0, 0.3))
    assert 1.0 / both == pytest.approx(1.0 / elastic + 400.0, rel=1e-12)
