"""Mechanisms with published numbers, stepped by jaxbuffer's own integrator; each prints its digits beside them (-s)."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from jaxbuffer.hybrid import solve
from jaxbuffer.multibody import Kinematics
from verification.published import (
    CLEARANCE,
    SQUEEZER_END,
    SQUEEZER_NAMES,
    SQUEEZER_TIME,
    loose_slider_crank,
    spinning_four_bar,
    squeezer,
    squeezer_angles,
    sundials_slider_crank,
)
from verification.riding import options, ride


def assembled(mechanism):
    """A mechanism made by one program in place of many operations."""
    return eqx.filter_jit(mechanism)()


@eqx.filter_jit
def energy_and_closure(mechanism, q, v):
    """Kinetic and stored energy [J], and what the constraints are violated by."""
    kin, system = Kinematics(q, v), mechanism.system
    return system.kinetic_energy(kin) + system.stored_energy(kin), system.constraints(kin).phi


def show(title, rows):
    """Each quantity as found, as published, and their difference."""
    print(f"\n{title}\n  {'':12s} {'found':>20s} {'published':>20s} {'difference':>11s}")
    for name, found, published in rows:
        print(f"  {name:12s} {float(found):20.14g} {float(published):20.14g} {float(found) - float(published):11.1e}")


def test_sundials_slider_crank_and_its_two_gradients():
    """SUNDIALS, idasSlCrank_FSA_dns: G = ∫ kinetic energy over 10 s, dG/dk, dG/dc. Its documentation prints 3.33662,
    0.33346, -0.36375, at its own tolerance; an independent solution has more digits."""

    def g(stiffness, damping):
        log = solve(sundials_slider_crank, (stiffness, damping), 10.0, options(1e-10)).log
        return log.rows[jnp.maximum(log.count - 1, 0), 0, -1]

    here = jnp.asarray(1.0), jnp.asarray(1.0)
    value = jax.jit(g)(*here)
    found = [float(value), *map(float, jax.jit(jax.jacfwd(g, (0, 1)))(*here))]
    names = ("G", "dG/dk", "dG/dc")
    show("Slider-crank of SUNDIALS", zip(names, found, (3.33662, 0.33346, -0.36375), strict=True))
    show("  computed independently", zip(names, found, (3.3366068, 0.333448, -0.363754), strict=True))
    assert_allclose(found, [3.33662, 0.33346, -0.36375], rtol=0, atol=2e-5)
    assert_allclose(found, [3.3366068, 0.333448, -0.363754], rtol=0, atol=5.1e-7)
    assert_allclose(found[0], 3.3366068, rtol=0, atol=5.1e-8)


def test_andrews_squeezer_to_the_test_sets_digits():
    """IVP test set: seven angles after 0.03 s and two and a half turns of the motor."""
    found = squeezer_angles(ride(assembled(squeezer), SQUEEZER_TIME).q)
    show("Andrews' squeezer", zip(SQUEEZER_NAMES, found, SQUEEZER_END, strict=True))
    assert_allclose(found, SQUEEZER_END, rtol=0, atol=5e-9)  # measured 1.3e-9


@pytest.mark.quick
def test_four_bar_keeps_its_energy_and_its_loop():
    """Two seconds, six turns of the crank."""
    mechanism = assembled(spinning_four_bar)
    found = ride(mechanism, 2.0)
    start, _ = energy_and_closure(mechanism, mechanism.q, mechanism.v)
    end, closure = energy_and_closure(mechanism, found.q, found.v)
    show("Four-bar", [("energy [J]", end, start)])
    assert found.q[2] - float(mechanism.q[2]) > 12 * np.pi
    assert_allclose(end, start, rtol=1e-8)
    assert_allclose(closure, 0.0, atol=1e-9)


def lagrangian_slider_crank():
    """The loose slider-crank until first contact from its two angles alone: the slider, a mass at the rod's end."""
    crank, rod, (m1, m2, m3), gravity = 0.153, 0.306, (0.038, 0.038, 0.076), 9.81

    def field(_, y):
        a, b, w, x = y
        cross = (m2 / 2 + m3) * crank * rod
        mass = np.array(
            [
                [7.4e-5 + m1 * crank**2 / 4 + (m2 + m3) * crank**2, cross * np.cos(a - b)],
                [cross * np.cos(a - b), 5.9e-4 + m2 * rod**2 / 4 + m3 * rod**2],
            ]
        )
        weight = gravity * np.array([(m1 / 2 + m2 + m3) * crank * np.cos(a), (m2 / 2 + m3) * rod * np.cos(b)])
        force = cross * np.sin(a - b) * np.array([-x * x, w * w]) - weight
        return [w, x, *np.linalg.solve(mass, force)]

    def touching(_, y):
        return abs(crank * np.sin(y[0]) + rod * np.sin(y[1])) - CLEARANCE

    touching.terminal = True
    run = solve_ivp(field, (0.0, 0.01), [0.0, 0.0, 150.0, -75.0], events=touching, rtol=1e-12, atol=1e-12)
    return run.t_events[0][0], run.y_events[0][0]


def test_slider_crank_with_clearance_up_to_its_first_contact():
    """Flores, Leine & Glocker 2010: crank and rod at (109.558, -49.331) rad/s when the slider first touches.

    The time that goes with these digits was noted as 2.6935 ms; ours and the independent solution's is 2.6925 ms."""
    found = ride(assembled(loose_slider_crank), 0.01)
    time, (*angles, crank, rod) = lagrangian_slider_crank()
    rows = [("ω1 [rad/s]", found.v[2], 109.558), ("ω2 [rad/s]", found.v[5], -49.331)]
    show("Slider-crank with clearance", [*rows, ("time [ms]", 1e3 * found.time[-1], 2.6935)])
    show("  from two angles alone", [("time [ms]", 1e3 * found.time[-1], 1e3 * time), ("ω1", found.v[2], crank)])
    assert found.status in (
        1,
        3,
    )  # an upper corner; both touch at once, as the slider does not turn
    assert_allclose(found.v[[2, 5]], [109.558, -49.331], rtol=0, atol=5.1e-4)
    assert_allclose([found.time[-1], *found.v[[2, 5]]], [time, crank, rod], rtol=1e-9)
    assert_allclose(found.q[[2, 5]], angles, rtol=1e-9)
