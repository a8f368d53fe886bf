"""The slider-crank's parts as bodies, and what its quantities are made of."""

import math
from types import SimpleNamespace

import pytest

from jaxbuffer import SliderCrank, SliderCrankScenario, replace
from jaxbuffer.mechanisms.slider_crank import SLIDER_CRANK

ASKED = ("rod_deflection", "rod_stress", "torque_ripple", "contact_share")


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


def test_it_turns_at_5000_revolutions_a_minute():
    assert float(SliderCrankScenario().crank_speed) == pytest.approx(5000.0 / 60.0 * 2.0 * math.pi, rel=1e-14)


def test_a_rigid_rod_bends_by_nothing_and_torques_ripple_between_largest_and_least():
    run = SimpleNamespace(maxima={"drive_torque": 30.0, "braking_torque": 12.0}, peak_force=7.0, penetration=2e-5,
                          contact_time=3.0, end_time=4.0)  # fmt: skip
    of = {name: quantity.of(run) for name, quantity in SLIDER_CRANK.quantities.items() if name in ASKED}
    assert of == dict(zip(ASKED, (0.0, 0.0, 42.0, 0.75), strict=True))
    deep = SLIDER_CRANK.quantities["penetration"].of
    assert deep(run) == 2e-5
    for watched, expected in ((3e-5, 3e-5), (-1e-6, 0.0)):
        run.maxima["penetration"] = watched
        assert float(deep(run)) == expected
