"""How fast stiff forces may be, of oscillators whose rates are known."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.hybrid.loop.trial import _linear_time
from jaxbuffer.hybrid.system import Linearisation

fastest = jax.jit(Linearisation.fastest)


def of_spring(mass, stiffness, damping, pull=1.0):
    """One mass on a spring and a damper that act along ``pull`` times its coordinate."""
    matrices = (jnp.asarray([[x]]) for x in (pull, pull / mass, stiffness, damping))
    return Linearisation(*matrices, 1)


@pytest.mark.parametrize(("mass", "stiffness", "damping"), [(2.0, 800.0, 1.0), (0.5, 8.0, 50.0), (3.0, 0.0, 6.0)])
@pytest.mark.parametrize("pull", [1.0, 0.5])
def test_one_oscillator(mass, stiffness, damping, pull):
    """max(c/m, √(k/m)), both with the square of the lever."""
    expected = max(pull**2 * damping / mass, pull * (stiffness / mass) ** 0.5)
    assert float(fastest(of_spring(mass, stiffness, damping, pull))) == pytest.approx(expected, rel=1e-14)


def test_forces_add_up():
    """Springs of 30 N/m and 70 N/m side by side on 4 kg; a velocity beyond the coordinates has a damper of its own."""
    directions = jnp.array([[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    response = jnp.array([[0.25, 0.25, 0.0], [0.0, 0.0, 2.0]])
    stiff, damped, none = map(jnp.asarray, (np.diag([30.0, 70.0, 900.0]), np.diag([0.0, 0.0, 1.5]), np.zeros((3, 3))))
    assert float(fastest(Linearisation(directions, response, stiff, none, 1))) == pytest.approx(5.0)
    assert float(fastest(Linearisation(directions, response, none, damped, 1))) == pytest.approx(3.0)


def test_a_negative_stiffness_rings_with_nothing():
    assert float(fastest(of_spring(1.0, -4.0, 0.5))) == 0.5


def test_without_stiff_forces():
    nothing = Linearisation.none(3, 2)
    assert nothing.rank == 0
    assert nothing.directions.shape == nothing.response.shape == (3, 0)
    assert float(fastest(nothing)) == 0.0


@pytest.mark.parametrize("shortfall", [1e-3, 1e-6, 1e-10])
def test_a_swinging_force_is_moved_no_farther_than_it_is_even(shortfall):
    """cos ωt at √(2 s)/ω from its top is 1 - s: a step that ends there may be moved onto the top. Moved along its slope
    from as far as any may be, the force is too high by a few s."""
    linear_time = jax.jit(_linear_time)
    time = float(linear_time(of_spring(2.0, 800.0, 1.0), shortfall, jnp.inf))
    assert (2.0 * shortfall) ** 0.5 / 20.0 < time
    phase = 20.0 * time
    moved = float(np.cos(phase) + phase * np.sin(phase))
    assert 0.0 <= moved - 1.0 < 5.0 * max(shortfall, 1e-6)


def test_in_free_flight_a_state_is_moved_by_little_of_a_step():
    """Along a circle, to second order, by a hundredth of a step of a tenth of a radian."""
    time = float(jax.jit(_linear_time)(Linearisation.none(3, 2), 1e-9, 0.1))
    assert time > 0.0
    assert abs(np.exp(1j * time) - (1.0 + 1j * time - 0.5 * time**2)) < 1e-9
