"""The slider-crank's parts as bodies."""

import pytest

from jaxbuffer import SliderCrank, replace


def test_a_rod_with_a_section_is_a_uniform_bar():
    """m = ρ w d L, and m L²/12 about its middle."""
    design = replace(SliderCrank(), {"rod.length": 0.3, "rod.depth": 0.02, "rod.width": 0.01, "rod.density": 2700.0})
    mass = 2700.0 * 0.02 * 0.01 * 0.3
    assert float(design.rod.body.mass) == pytest.approx(mass, rel=1e-14)
    assert float(design.rod.body.inertia) == pytest.approx(mass * 0.3**2 / 12.0, rel=1e-14)
    assert float(design.rod.bar.mass) == pytest.approx(mass, rel=1e-14)


def test_a_rod_without_one_has_the_given_numbers():
    rod = replace(SliderCrank(), {"rod.mass": 0.5, "rod.inertia": 3e-4}).rod
    assert (float(rod.body.mass), float(rod.body.inertia)) == (0.5, 3e-4)
