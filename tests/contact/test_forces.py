"""Force laws and friction at given instants: values, signs, limits and derivatives."""

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from jaxbuffer.contact import LankaraniNikravesh, RegularisedCoulomb, hertz_stiffness

LAW = LankaraniNikravesh(6.4e9, 0.8)
FRICTION = RegularisedCoulomb(0.33, 1e-3)


def test_stiffness_of_the_tip_on_the_cone():
    """Aluminium on aluminium, 15 mm: the value of the model's table, and the formula by hand."""
    assert_allclose(hertz_stiffness(0.015), 6.43328e9, rtol=7.8e-7)  # six digits are given
    assert_allclose(hertz_stiffness(0.015), 2 / 3 * 71.7e9 / 0.91 * np.sqrt(0.015), rtol=1e-14)


def test_stiffness_of_two_materials():
    """A rigid ball on rubber: K = 4/3 √R E/(1 - ν²) of the rubber alone."""
    assert_allclose(hertz_stiffness(0.04, 1e30, 0.3, 5e6, 0.5), 4 / 3 * 0.2 * 5e6 / 0.75, rtol=1e-14)


@pytest.mark.parametrize(
    ("penetration", "speed", "touchdown", "expected"),
    [
        (1e-6, 0.0, 0.1, 6.4),  # K δ^{3/2} = 6.4e9 · 1e-9
        (4e-6, 0.0, 0.1, 51.2),
        (1e-6, 0.1, 0.1, 6.4 * 1.27),  # χ̂ = 3/4 (1 - 0.64) = 0.27
        (1e-6, -0.05, 0.1, 6.4 * 0.865),
        (1e-6, -0.5, 0.1, 0.0),  # torn apart five times faster than they met: no pull
        (0.0, 0.1, 0.1, 0.0),
        (-1e-6, 0.1, 0.1, 0.0),
    ],
)
def test_law_by_hand(penetration, speed, touchdown, expected):
    assert_allclose(LAW.force(penetration, speed, touchdown), expected, rtol=1e-13)


@pytest.mark.parametrize("restitution", [0.01, 0.5, 1.0])
def test_law_never_pulls(restitution):
    penetration, speed = np.meshgrid(np.linspace(-1e-5, 1e-5, 41), np.linspace(-20.0, 20.0, 81))
    force = np.asarray(jax.jit(LankaraniNikravesh(6.4e9, restitution).force)(penetration, speed, 0.1))
    assert np.min(force) == 0.0
    assert np.max(force) > 0.0


def test_elastic_law_stores_what_it_takes():
    stored, _ = quad(lambda depth: float(LAW.elastic(depth)), 0.0, 3e-5, epsrel=1e-12, epsabs=0.0)
    assert_allclose(LAW.energy(3e-5), stored, rtol=1e-10)


@jax.jit
def slopes(*arguments):
    """Of the force by every argument in both modes, and of the energy by the first."""
    forward, reverse = jax.jacfwd(LAW.force, (0, 1, 2)), jax.grad(LAW.force, (0, 1, 2))
    return forward(*arguments), reverse(*arguments), jax.grad(LAW.energy)(arguments[0])


@pytest.mark.parametrize("penetration", [0.0, -1e-12, -1e-3, 1e-300, 1e-12])
def test_derivatives_are_finite_at_and_off_the_onset(penetration):
    """In both modes, and for every argument; outside they vanish."""
    forward, reverse, of_energy = slopes(penetration, 0.1, 0.2)
    assert np.all(np.isfinite(forward))
    assert_allclose(forward, reverse, rtol=1e-15)
    assert np.isfinite(of_energy)
    if penetration <= 0.0:
        assert_allclose(forward, 0.0, atol=0.0)


def test_slope_of_the_elastic_law():
    """3/2 K √δ = 9.6e6 N/m at a micrometre."""
    assert_allclose(jax.jit(jax.grad(LAW.elastic))(1e-6), 9.6e6, rtol=1e-14)


@pytest.mark.parametrize("slip", [-1.0, -1e-3, -1e-7, 1e-7, 1e-3, 1.0])
def test_friction_opposes_slip_within_coulombs_cone(slip):
    force = float(FRICTION.force(50.0, slip))
    assert force * slip < 0.0
    assert abs(force) <= 0.33 * 50.0
    assert_allclose(force, -0.33 * 50.0 * np.tanh(slip / 1e-3), rtol=1e-14)


def test_friction_tends_to_coulombs_law_as_the_slip_speed_goes_to_zero():
    deviations = [abs(float(RegularisedCoulomb(0.33, s).force(50.0, 2e-3)) + 16.5) for s in (2e-3, 1e-3, 5e-4, 1e-4)]
    assert deviations == sorted(deviations, reverse=True)
    assert deviations[-1] < 1e-12


def test_no_slip_no_friction():
    assert float(FRICTION.force(50.0, 0.0)) == 0.0
