"""The buffer's end stop at one instant: its force, what it stores and loses, and what stays conserved."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from jaxbuffer import InputError, replace, table2
from mechanisms.states import TIPS, mechanism, pressed
from mechanisms.test_conservation import energy_rate, momentum_rates

STIFFNESS, DAMPING, END = 2e4, 20.0, 0.05  # N/m, N s/m, m
STOP = {"buffer_max_stroke": END, "buffer_stop_stiffness": STIFFNESS, "buffer_stop_damping": DAMPING}
each_tip = pytest.mark.parametrize("tip", TIPS)
each_seed = pytest.mark.parametrize("seed", range(3))


def stopped(tip, seed, closed=1.0, **choices):
    """A mechanism with its stop, and a state in which the tip is pressed and the stroke is beyond the stop's place."""
    assembled = mechanism(TIPS[tip], **(STOP | choices))
    state, active = pressed(mechanism(TIPS[tip], buffer_free_length=0.3), "lower flank", seed)
    state = jnp.asarray(np.insert(state, -2, 0.0))  # the stop's loss, after the other four
    return assembled, state, jnp.asarray(np.append(active, closed))


@eqx.filter_jit
def stop_forces(assembled, state, active):
    """As it is watched, and of a stop that is open."""
    watched = assembled.observables(state, jnp.zeros_like(state), active)[assembled.observed.index("stop_force")]
    at = assembled.evaluated(assembled.evaluate(state), "stop")
    return watched, assembled.element("stop").force(at, jnp.zeros(1))


@pytest.mark.quick
@each_tip
@each_seed
def test_force_is_that_of_a_one_sided_spring_and_damper(tip, seed):
    """Against the model's formula, from the anchors' distance and its rate by differences."""
    assembled, state, active = stopped(tip, seed, buffer_free_length=0.3)

    def length(y):
        q = np.asarray(y[:12])
        rear = q[6:8] - assembled.parts.probe.rear * np.array([np.cos(q[8]), np.sin(q[8])])
        anchor = q[3:5] - 0.5 * 0.1365 * np.array([np.cos(q[5]), np.sin(q[5])])
        return np.linalg.norm(rear - anchor)

    step = 1e-6
    moved = [np.asarray(state[:12]) + sign * step * np.asarray(state[12:24]) for sign in (1.0, -1.0)]
    rate = -(length(moved[0]) - length(moved[1])) / (2.0 * step)
    depth = 0.3 - length(state) - END
    assert depth > 0.0
    expected = max(0.0, STIFFNESS * depth + DAMPING * rate)
    watched, of_open = stop_forces(assembled, state, active)
    assert_allclose(watched, expected, rtol=1e-7)
    assert float(of_open) == 0.0


@each_tip
@each_seed
def test_energy_and_momentum_stay_balanced(tip, seed):
    assembled, state, active = stopped(tip, seed, buffer_free_length=0.3)
    linear, angular, largest = momentum_rates(assembled, state, active)
    assert_allclose(linear, 0.0, atol=2e-15 * largest)
    assert_allclose(angular, 0.0, atol=2e-15 * largest)
    rest, flow = energy_rate(assembled, state, active)
    assert flow > 0.1
    assert abs(rest) < 2e-14 * flow


def test_a_stop_closed_and_open_differ_by_its_force_along_the_cylinder():
    assembled, state, active = stopped("welded", 1, buffer_free_length=0.3)
    rates = [assembled.derivative(0.0, state, active.at[2].set(closed)) for closed in (1.0, 0.0)]
    force = np.asarray(assembled.system.masses()) * np.asarray(rates[0] - rates[1])[12:24]
    pushed = force[0::3].sum(), force[1::3].sum()
    assert_allclose(pushed, 0.0, atol=1e-10 * np.max(np.abs(force)))
    assert np.max(np.abs(force)) > 100.0


@pytest.mark.quick
@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"buffer.max_stroke": 0.2},
            "buffer.max_stroke = 0.2 m is out of range; allowed: (0, 0.1365] m; it ends where the spring's ends meet,"
            " at buffer.free_length",
        ),
        ({"buffer.max_stroke": 0.0}, "buffer.max_stroke = 0 m is out of range; allowed: (0, inf) m"),
        ({"buffer.stop_stiffness": -1.0}, "buffer.stop_stiffness = -1 N/m is out of range; allowed: (0, inf) N/m"),
        (
            {"buffer.stop_damping": 5.0},
            "buffer.stop_damping = 5 N s/m needs an end stop: give buffer.stop_stiffness [N/m] too",
        ),
        ({"contact.yield_stress": 0.0}, "contact.yield_stress = 0 Pa is out of range; allowed: (0, inf) Pa"),
    ],
)
def test_bad_numbers_are_named(values, message):
    with pytest.raises(InputError) as caught:
        replace(table2(), values)
    assert str(caught.value) == message
