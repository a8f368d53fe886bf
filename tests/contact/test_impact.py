"""Two free bodies colliding under the law alone, integrated to the end, against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from jaxbuffer.contact import LankaraniNikravesh, hertz_stiffness
from jaxbuffer.contact.laws import KelvinVoigt, free_impact

MASS, STIFFNESS, SPEED = 1.0, 1.4e8, 4.4294  # kg, N/m^1.5, m/s


class Impact:
    """m δ̈ = -F from touchdown to separation: deepest penetration, its force, duration, speed ratio."""

    def __init__(self, law, mass=MASS, speed=SPEED):
        def field(_, y):
            return [y[1], -float(law.force(y[0], y[1], speed)) / mass]

        def apart(_, y):
            return y[0]

        def turning(_, y):
            return y[1]

        apart.terminal, apart.direction = True, -1
        scale = (mass**2 / (law.stiffness**2 * speed)) ** 0.2
        run = solve_ivp(
            field, (0.0, 20 * scale), [0.0, speed], "DOP853", events=(apart, turning), rtol=1e-10, atol=1e-14
        )
        self.duration = run.t_events[0][-1]
        self.restitution = -run.y_events[0][-1][1] / speed
        self.depth = run.y_events[1][0][0]
        self.force = float(law.force(self.depth, 0.0, speed))


@pytest.fixture(scope="module")
def elastic():
    return Impact(LankaraniNikravesh(STIFFNESS, 1.0))


def test_hertz_impact_as_published(elastic):
    """1.983 mm, 12.366 kN, 1.318 ms."""
    assert_allclose([elastic.depth, elastic.force, elastic.duration], [1.983e-3, 12.366e3, 1.318e-3], rtol=4e-4)


def test_hertz_impact_in_closed_form(elastic):
    """δ = (5 m v²/4K)^{2/5}, F = K^{2/5} (5 T/2)^{3/5}, 2.943275 δ/v, and it gives back what it took."""
    depth = (5 * MASS * SPEED**2 / (4 * STIFFNESS)) ** 0.4
    assert_allclose(elastic.depth, depth, rtol=1e-9)
    assert_allclose(elastic.force, STIFFNESS**0.4 * (1.25 * MASS * SPEED**2) ** 0.6, rtol=1e-9)
    assert_allclose(elastic.duration, 2.943275 * depth / SPEED, rtol=2e-7)  # seven digits are given
    assert_allclose(elastic.restitution, 1.0, rtol=1e-9)


@pytest.mark.parametrize(
    ("asked", "delivered"), [(0.1, 0.6653), (0.3, 0.6842), (0.5, 0.7252), (0.7, 0.7960), (0.9, 0.9132)]
)
def test_lankarani_nikravesh_delivers_its_own_restitution(asked, delivered):
    """Not the one asked for: d (1 + e_out) = ln[(1 + d)/(1 - d e_out)] with d = 3 (1 - e²)/4."""
    law = LankaraniNikravesh(STIFFNESS, asked)
    d = 0.75 * (1 - asked**2)
    exact = brentq(lambda e: d * (1 + e) - np.log((1 + d) / (1 - d * e)), 1e-3, 1.0, xtol=1e-14)
    assert_allclose(exact, delivered, atol=5.1e-5)  # four digits are given
    impact = Impact(law)
    assert_allclose(impact.restitution, exact, rtol=1e-8)
    depth = (2.5 * MASS * SPEED**2 / STIFFNESS * (1 / d - np.log1p(d) / d**2)) ** 0.4
    assert_allclose(impact.depth, depth, rtol=1e-9)


@pytest.mark.parametrize(("mass", "speed"), [(0.02, 0.05), (7.0, 3.0)])
def test_delivered_restitution_depends_on_neither_mass_nor_speed(mass, speed):
    impact = Impact(LankaraniNikravesh(hertz_stiffness(0.015), 0.7), mass, speed)
    assert_allclose(impact.restitution, 0.7960, atol=5.1e-5)


def test_a_damper_pushes_most_at_touchdown():
    """c v, where ζ = c/(2 √(k m)) is above ½: 0.9 and 0.63 here."""
    for stiffness, damping in ((1e3, 57.0), (1e3, 40.0)):
        impact = free_impact(KelvinVoigt(stiffness, damping), 1.0, 0.2)
        assert impact.peak_force == pytest.approx(0.2 * damping, rel=1e-6)
