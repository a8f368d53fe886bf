"""Mechanisms assembled from parts and integrated, against closed forms and published numbers."""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.special import ellipk

from helpers import (
    GRAVITY,
    energies,
    four_bar,
    integrate,
    merged_pair,
    pendulum,
    phi,
    slider_crank,
    sprung_slider_crank,
    welded_pair,
)
from jaxbuffer.multibody import Kinematics


@pytest.mark.parametrize("amplitude", [0.1, 1.0, 2.5])
def test_pendulum_swings_with_the_elliptic_period(amplitude):
    """T = 4 √(2l/3g) K(sin²(θ0/2)) of a uniform rod; a quarter of it after release the rod hangs."""
    length = 0.8
    period = 4.0 * np.sqrt(2 * length / (3 * GRAVITY)) * ellipk(np.sin(amplitude / 2) ** 2)
    mechanism = pendulum(amplitude, length=length)
    q, v = integrate(mechanism, jnp.array([0.0, period / 4, period / 2, period]))
    swing, rate = np.asarray(q[:, 2]) + np.pi / 2, np.asarray(v[:, 2])
    assert abs(swing[1] / rate[1]) < 1e-12 * period  # measured 1.2e-13
    np.testing.assert_allclose(swing[[2, 3]], [-amplitude, amplitude], rtol=1e-12)  # measured 1e-13
    np.testing.assert_allclose(
        rate[1], -np.sqrt(6 * GRAVITY / length) * np.sin(amplitude / 2), rtol=1e-10
    )  # measured 8e-12


@pytest.mark.slow
def test_four_bar_keeps_its_energy_and_its_loop():
    """Two seconds, six turns of the crank."""
    mechanism = four_bar()
    q, v = integrate(mechanism, jnp.linspace(0.0, 2.0, 81))
    total = np.asarray(energies(mechanism.system, q, v))
    assert float(q[-1, 2] - q[0, 2]) > 12 * np.pi
    assert np.ptp(total) < 5e-11 * abs(total[0])  # measured 5e-12
    closure = jax.vmap(lambda q: phi(mechanism.system, q))(q)
    assert float(jnp.max(jnp.abs(closure))) < 2e-11  # m; measured 2.3e-12


@pytest.mark.slow
def test_stabilisation_is_what_holds_the_loop():
    """Without Baumgarte's terms the loop of the same run at a loose tolerance opens a thousand times as far."""
    opened = []
    for gain in (0.0, 20.0):
        mechanism = four_bar(gain)
        q, _ = integrate(mechanism, jnp.linspace(0.0, 2.0, 81), 1e-5)
        opened.append(float(jnp.max(jnp.abs(phi(mechanism.system, q[-1])))))
    assert opened[1] < 1e-2 * opened[0]  # measured 4.6e-9 m and 5.9e-6 m


@pytest.mark.slow
def test_slider_crank_follows_its_kinematics_and_keeps_its_energy():
    """x = r cos θ + √(l² - r² sin²θ) and its derivative; crank, rod and slider swap kinetic energy only."""
    crank, rod = 0.15, 0.35
    mechanism = slider_crank(crank, rod)
    q, v = (np.asarray(y) for y in integrate(mechanism, jnp.linspace(0.0, 1.5, 61)))
    angle, rate = q[:, 2], v[:, 2]
    assert angle[-1] - angle[0] > 4 * np.pi
    along = np.sqrt(rod**2 - (crank * np.sin(angle)) ** 2)
    np.testing.assert_allclose(q[:, 6], crank * np.cos(angle) + along, atol=1e-11)  # m; measured 2.4e-12
    slope = -crank * np.sin(angle) - crank**2 * np.sin(angle) * np.cos(angle) / along
    np.testing.assert_allclose(v[:, 6], slope * rate, atol=5e-10)  # m/s; measured 6e-11
    np.testing.assert_allclose(q[:, 7:9], 0.0, atol=1e-15)

    # The one-degree-of-freedom form ½ J(θ) θ̇² = const gives the crank's rate at every angle.
    dip = -np.arcsin(crank * np.sin(angle) / rod)
    dip_slope = -crank * np.cos(angle) / (rod * np.cos(dip))
    middle = np.stack([-crank * np.sin(angle) - rod / 2 * np.sin(dip) * dip_slope, crank * np.cos(angle) / 2])
    inertia = 0.006 + 0.6 * np.sum(middle**2, axis=0) + 0.6 * rod**2 / 12 * dip_slope**2 + 0.9 * slope**2
    np.testing.assert_allclose(rate, rate[0] * np.sqrt(inertia[0] / inertia), rtol=5e-10)  # measured 4e-11


@pytest.mark.slow
def test_weld_makes_two_bodies_one():
    """Swinging on a pin, drawn by a spring-damper: the same angle as the merged body's."""
    times = jnp.linspace(0.0, 2.0, 21)
    welded, _ = integrate(welded_pair(0.3), times)
    merged, _ = integrate(merged_pair(0.3), times)
    assert float(jnp.ptp(merged[:, 2])) > 0.5
    np.testing.assert_allclose(welded[:, 2], merged[:, 2], atol=2e-12)  # rad; measured 2e-13
    np.testing.assert_allclose(welded[:, 5] - welded[:, 2], 0.6, atol=1e-14)


@pytest.mark.slow
def test_slider_crank_of_sundials_and_its_gradients():
    """idasSlCrank_FSA_dns: G = ∫ kinetic energy over 10 s and its derivatives, as its documentation prints them."""

    def g(parameters):
        mechanism = sprung_slider_crank(*parameters)

        def field(_, y, __):
            q, v, _ = y
            system = mechanism.system
            kin = Kinematics(q, v)
            return v, system.motion(kin).acceleration, system.kinetic_energy(kin)

        return diffrax.diffeqsolve(
            diffrax.ODETerm(field),
            diffrax.Dopri8(),
            t0=0.0,
            t1=10.0,
            dt0=1e-3,
            y0=(mechanism.q, mechanism.v, jnp.zeros(())),
            stepsize_controller=diffrax.PIDController(rtol=1e-10, atol=1e-10),
            adjoint=diffrax.ForwardMode(),
            max_steps=100_000,
        ).ys[2][0]

    here = jnp.array([1.0, 1.0])
    assert abs(float(jax.jit(g)(here)) - 3.33662) < 2e-5
    np.testing.assert_allclose(jax.jit(g)(here), 3.3366068, atol=5e-8)
    np.testing.assert_allclose(jax.jit(jax.jacfwd(g))(here), [0.333448, -0.363754], atol=5e-7)
