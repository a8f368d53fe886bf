"""The slider-crank's parts as bodies, and what its quantities are made of."""

import math
from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer import InputError, SliderCrank, SliderCrankScenario, replace
from jaxbuffer.elements import BallContact
from jaxbuffer.mechanisms.slider_crank import SLIDER_CRANK
from jaxbuffer.mechanisms.slider_crank.assembly import flanks, ideal_motion, slider_crank
from jaxbuffer.mechanisms.slider_crank.design import check_fit
from jaxbuffer.mechanisms.slider_crank.sensors import off_centre_across, off_centre_along, slider_acceleration
from jaxbuffer.plane import Vector

ASKED = ("rod_deflection", "rod_stress", "torque_ripple", "contact_share")


@pytest.mark.quick
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


def test_a_rod_that_is_no_longer_than_its_crank_is_refused():
    for crank, refused in ((0.2, True), (0.1, True), (0.09, False)):
        design = replace(SliderCrank(), {"crank.length": crank, "rod.length": 0.1})
        if refused:
            with pytest.raises(InputError, match=r"rod\.length must be above crank\.length"):
                check_fit(design, SliderCrankScenario())
        else:
            check_fit(design, SliderCrankScenario())


def test_a_round_bush_is_seen_along_a_unit_tangent():
    """And what the drive puts in stands after nine coordinates, nine velocities and three losses."""
    design = replace(SliderCrank(), {"piston_pin.joint": "clearance", "crank_pin.joint": "clearance"})
    mechanism = slider_crank(design, SliderCrankScenario())
    assert [float(contact.pair.side) for contact in mechanism.all_of(BallContact)] == [1.0, 1.0]
    drive = mechanism.elements.index(mechanism.element("drive"))
    assert mechanism.layout.places[f"element {drive}"].start == 9 + 9 + 3


def test_it_turns_at_5000_revolutions_a_minute():
    assert float(SliderCrankScenario().crank_speed) == pytest.approx(5000.0 / 60.0 * 2.0 * math.pi, rel=1e-14)


def test_a_rigid_rod_bends_by_nothing_and_torques_ripple_between_largest_and_least():
    run = SimpleNamespace(maxima={"drive_torque": 30.0, "braking_torque": 12.0}, peak_force=7.0, penetration=2e-5,
                          contact_time=3.0, end_time=4.0)  # fmt: skip
    of = {name: quantity.of(run) for name, quantity in SLIDER_CRANK.quantities.items() if name in ASKED}
    assert of == dict(zip(ASKED, (0.0, 0.0, 42.0, 0.75), strict=True))
    deep = SLIDER_CRANK.quantities["penetration"].of
    assert deep(run) == 2e-5
    run.maxima["penetration"] = 3e-5
    assert deep(run) == 3e-5


@pytest.mark.quick
def test_a_bush_by_components_is_a_square():
    """Each side is centred at half the width, twice as long as the square is wide; its front is the inside, where the
    centre is at half the width from all four."""
    half = 0.02
    middles = {(half, 0.0), (-half, 0.0), (0.0, half), (0.0, -half)}
    found = set()
    for side in flanks(half):
        middle = [s + 0.5 * side.length * d for s, d in
                  ((side.start_x, side.direction_x), (side.start_y, side.direction_y))]  # fmt: skip
        found.add(tuple(round(x, 15) for x in middle))
        assert side.length == pytest.approx(4.0 * half)
        foot = side.foot(0.0, 0.0, -1.0, 0.9 * half)
        assert float(foot.distance) == pytest.approx(half)
        assert (float(foot.normal_x), float(foot.normal_y)) == pytest.approx((-middle[0] / half, -middle[1] / half))
    assert found == middles


@pytest.mark.quick
@pytest.mark.parametrize("angle", [0.0, 0.4, 2.5, -1.2])
def test_where_it_starts_is_the_textbooks_slider_crank(angle):
    """Closed loop at both pins, and velocities by differences of the positions."""
    design = replace(SliderCrank(), {"rod.centre": 0.3, "crank.unbalance": 1e-4})
    crank, rod, omega = design.crank, design.rod, 7.0

    def at(theta):
        q, v = ideal_motion(design, SliderCrankScenario(crank_angle=theta, crank_speed=omega))
        return np.asarray(q), np.asarray(v)

    q, v = at(angle)
    off = float(crank.unbalance / crank.mass)
    np.testing.assert_allclose(q[:3], [off * math.cos(angle), off * math.sin(angle), angle], atol=1e-15)
    turn = np.array([math.cos(q[5]), math.sin(q[5])])
    pin = crank.length * np.array([math.cos(angle), math.sin(angle)])
    np.testing.assert_allclose(q[3:5] - 0.3 * rod.length * turn, pin, atol=1e-15)
    np.testing.assert_allclose(q[3:5] + 0.7 * rod.length * turn, q[6:8], atol=1e-15)
    assert (q[7], q[8]) == (0.0, 0.0)
    step = 1e-5
    difference = (at(angle + step)[0] - at(angle - step)[0]) * omega / (2.0 * step)
    np.testing.assert_allclose(v, difference, atol=1e-8)


def test_what_is_seen_of_a_slider_crank():
    """The slider is the third of three bodies: its acceleration follows those of two others."""
    assert float(slider_acceleration(None, jnp.zeros(9).at[6].set(-4.0), None)) == 4.0
    centre, origin = (SimpleNamespace(place=Vector(*place)) for place in ((5.0, 7.0), (3.0, 4.0)))
    ball = SimpleNamespace(centre=centre, origin=origin)
    contact = SimpleNamespace(evaluate=lambda kin: ball)
    assert off_centre_along(None, (1.0, contact)) == 2.0
    assert off_centre_across(None, (-1.0, contact)) == -3.0
