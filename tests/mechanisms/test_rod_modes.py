"""How many modes a rod that bends has: their highest period beside the time of a peak, in words."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.slider_crank.bending import rise_time, rod_period
from jaxbuffer.mechanisms.slider_crank.summary import bending_validity
from jaxbuffer.multibody.flexible import free_bar


def design(modes, **changes):
    return jb.replace(jb.SliderCrank(), {"rod.depth": 0.015, "rod.modes": modes, **changes})


@pytest.mark.parametrize("modes", [2, 3, 4, 8])
def test_the_highest_period_is_that_of_the_rods_own_modes(modes):
    rod = design(modes, **{"rod.length": 0.2, "rod.young_modulus": 7e10}).rod
    frequencies = free_bar(rod.bar, modes - 2).modes.frequencies()
    found = rod_period(design(modes, **{"rod.length": 0.2, "rod.young_modulus": 7e10}))
    assert float(found) == pytest.approx(1.0 / float(np.max(frequencies)), rel=1e-9)


@pytest.mark.quick
def test_a_force_takes_the_time_of_its_spring():
    """Two bodies of 0.14 kg and the rod's 0.212 kg on a spring of 1e8 N/m: √(m/k)."""
    mass = 1.0 / (1.0 / 0.14 + 1.0 / (7850.0 * 0.015**2 * 0.12))
    assert float(rise_time(design(2), 1e4, 1e-4)) == pytest.approx(np.sqrt(mass / 1e8), rel=1e-12)
    assert bending_validity(design(0), 1e4, 1e-4) == []
    (limit,) = bending_validity(design(2), np.array([1.0, 1e6]), 1e-4)
    assert list(limit.passed) == [False, True]


def test_a_summary_says_the_number_of_modes():
    text = repr(jb.simulate(design(2), jb.SliderCrankScenario(), 0.003))
    assert "rod modes                2; period of the highest 44." in text
    assert "the rod's 2 modes are too few for the peak" in text
