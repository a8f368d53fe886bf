"""Textbook problems built from the project's own parts and stepped by its own integrator, against closed forms."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import ellipk

from helpers import GRAVITY, pendulum
from jaxbuffer.contact.laws import ExactRestitution, Hertz, KelvinVoigt, LankaraniNikravesh
from jaxbuffer.hybrid import Kind, solve
from jaxbuffer.mechanisms.assembled import Assembled, BallContact
from jaxbuffer.multibody import (
    GROUND,
    AppliedForce,
    AxialSpringDamper,
    Body,
    FixedAngle,
    Kinematics,
    System,
)
from verification.riding import floor, on_floor, options, ride

MASS, STIFFNESS, SPEED, RADIUS = 1.0, 1.4e8, 4.4294, 0.01  # kg, N/m^1.5, m/s, m


def drop(law, speed=SPEED, mass=MASS, height=1e-4):
    """A ball falling freely at a constant speed onto the floor, from 0.1 mm above it."""
    q, v = jnp.array([0.0, RADIUS + height, 0.0]), jnp.array([0.0, -1.0, 0.0]) * speed
    return Assembled(System((Body(mass, 1e-4),)), q, v, (on_floor(RADIUS, law),), size=(1e-3, 1.0))


@pytest.mark.quick
def test_hertz_impact():
    """δ = (5 m v²/4K)^{2/5}, F = K^{2/5} (5 T/2)^{3/5}, 2.943275 δ/v; 12.366 kN after 1.318 ms / 2."""
    found = ride(drop(Hertz(STIFFNESS)), 5e-3)
    depth = (1.25 * MASS * SPEED**2 / STIFFNESS) ** 0.4
    (touch,), (peak,), (release,) = (found.times(k) for k in (Kind.TOUCHDOWN, Kind.PEAK, Kind.RELEASE))
    force = found.force[found.kind == Kind.PEAK][0, 0]
    assert_allclose(force, STIFFNESS**0.4 * (1.25 * MASS * SPEED**2) ** 0.6, rtol=1e-8)  # measured 3e-9
    assert_allclose((force / STIFFNESS) ** (2 / 3), depth, rtol=1e-8)
    assert_allclose(touch, 1e-4 / SPEED, rtol=1e-9)
    assert_allclose(release - touch, 2.943275 * depth / SPEED, rtol=2e-7)  # seven digits are given
    assert_allclose(peak - touch, (release - touch) / 2, rtol=1e-6)
    assert_allclose([1e3 * depth, 1e-3 * force, 1e3 * (release - touch)], [1.983, 12.366, 1.318], rtol=4e-4)
    assert_allclose(found.v[1], SPEED, rtol=1e-8)


@pytest.mark.parametrize(
    ("law", "delivered"),
    [(LankaraniNikravesh, 0.6842), (ExactRestitution, 0.3)],
    ids=["Lankarani-Nikravesh", "exact"],
)
def test_restitution_delivered_when_0_3_is_asked_for(law, delivered):
    found = ride(drop(law(STIFFNESS, 0.3)), 5e-3)
    assert_allclose(found.v[1] / SPEED, delivered, rtol=0, atol=5.001e-5 if law is not ExactRestitution else 1e-9)


def kelvin_voigt_end(speed, damping, stiffness=2e7, mass=MASS, height=1e-4, end=3e-3):
    """Height and speed of the ball at the end, in closed form: the force ends at arccos(2ζ² - 1)/ω after touchdown."""
    zeta, natural = damping / (2 * jnp.sqrt(stiffness * mass)), jnp.sqrt(stiffness / mass)
    damped = natural * jnp.sqrt(1 - zeta**2)
    spent = jnp.arccos(2 * zeta**2 - 1) / damped
    depth = speed / damped * jnp.exp(-zeta * natural * spent) * jnp.sin(damped * spent)
    back = speed * jnp.exp(-2 * zeta * jnp.arccos(zeta) / jnp.sqrt(1 - zeta**2))
    return jnp.stack([RADIUS - depth + back * (end - height / speed - spent), back])


@pytest.mark.long
def test_kelvin_voigt_impact_and_its_gradients_through_the_jump_of_the_force():
    """Force c v at touchdown itself. The state's derivative by v and c at a later time needs its jump at touchdown."""
    here = jnp.asarray(SPEED), jnp.asarray(1500.0)

    def build(speed, damping):
        return drop(KelvinVoigt(jnp.asarray(2e7), damping), speed)

    def end(*numbers):
        log = solve(build, numbers, 3e-3, options(1e-11)).log
        return log.rows[jnp.maximum(log.count - 1, 0), 0][jnp.array([1, 4])]

    assert_allclose(jax.jit(end)(*here), kelvin_voigt_end(*here), rtol=1e-9)
    found = jax.jit(jax.jacfwd(end, (0, 1)))(*here)
    assert_allclose(found, jax.jacfwd(kelvin_voigt_end, (0, 1))(*here), rtol=1e-7)
    found = ride(drop(KelvinVoigt(2e7, 1500.0)), 3e-3)
    assert_allclose(found.force[found.kind == Kind.TOUCHDOWN][0, 0], 1500.0 * SPEED, rtol=1e-9)


def test_damped_oscillator():
    """x = x0 e^{-ζωt} (cos ω_d t + ζω/ω_d sin ω_d t) after five periods, and half the logarithmic decrement a turn."""
    spring = AxialSpringDamper(GROUND, 0, (0.0, 0.0), (0.0, 0.0), stiffness=90.0, damping=1.2, free_length=1.0)
    system = System((Body(2.5, 0.1),), (FixedAngle(GROUND, 0),), (spring,))
    natural, zeta = np.sqrt(90.0 / 2.5), 1.2 / (2 * np.sqrt(90.0 * 2.5))
    damped = natural * np.sqrt(1 - zeta**2)
    end = 5 * 2 * np.pi / damped + 0.1
    found = ride(Assembled(system, jnp.array([1.3, 0.0, 0.0]), jnp.zeros(3)), end)
    swing = np.cos(damped * end) + zeta * natural / damped * np.sin(damped * end)
    assert_allclose(found.q[0] - 1.0, 0.3 * np.exp(-zeta * natural * end) * swing, rtol=1e-7)
    assert_allclose(
        found.v[0], -0.3 * natural**2 / damped * np.exp(-zeta * natural * end) * np.sin(damped * end), rtol=1e-7
    )


@pytest.mark.parametrize("slip_speed", [1e-2, 1e-3])
def test_block_slides_to_rest(slip_speed):
    """m v̇ = -μ m g tanh(v/v_s): sinh(v/v_s) = sinh(v0/v_s) e^{-μgt/v_s}, and v0²/(2 μ g) as v_s → 0."""
    friction, speed, depth = 0.4, 0.5, (MASS * GRAVITY / STIFFNESS) ** (2 / 3)
    weight = AppliedForce(0, (0.0, -MASS * GRAVITY))
    system = System((Body(MASS, 1e-3),), (FixedAngle(GROUND, 0),), (weight,))
    contact = on_floor(RADIUS, Hertz(STIFFNESS), friction=friction, slip_speed=slip_speed)
    block = Assembled(
        system, jnp.array([0.0, RADIUS - depth, 0.0]), jnp.array([speed, 0.0, 0.0]), (contact,), (True,), size=(1e-3, 1)
    )
    deceleration = friction * GRAVITY
    for part in (0.5, 0.95):
        time = part * speed / deceleration
        # arsinh(sinh(a) e^{-b}) for large a, without overflow
        left = speed / slip_speed - deceleration * time / slip_speed
        exact = slip_speed * np.arcsinh(np.exp(left) / 2 * -np.expm1(-2 * speed / slip_speed))
        assert_allclose(ride(block, time).v[0], exact, rtol=1e-6)
    stopped = ride(block, 1.5 * speed / deceleration)
    distance = speed**2 / (2 * deceleration)
    assert abs(stopped.v[0]) < 1e-6 * speed or slip_speed > 1e-3
    # ∫v dt over the closed form exceeds v0²/(2μg) by π²/12 v_s²/(μg)
    assert_allclose(stopped.q[0], distance + np.pi**2 / 12 * slip_speed**2 / deceleration, rtol=1e-6)


def test_sliding_ball_ends_rolling():
    """5/7 of its speed, whatever the friction: m (v - v0) h = -I ω about the foot at the arm h = R - δ."""
    radius, speed, stiffness = 0.05, 2.0, 1e12
    depth = (MASS * GRAVITY / stiffness) ** (2 / 3)
    inertia = 0.4 * MASS * radius**2
    system = System((Body(MASS, inertia),), (), (AppliedForce(0, (0.0, -MASS * GRAVITY)),))
    contact = on_floor(radius, Hertz(stiffness), friction=0.3, slip_speed=1e-2)
    q, v = jnp.array([0.0, radius - depth, 0.0]), jnp.array([speed, 0.0, 0.0])
    found = ride(Assembled(system, q, v, (contact,), (True,), size=(1e-3, 1.0)), 0.4)
    arm = radius - depth
    assert_allclose(found.v[0], speed / (1 + inertia / (MASS * arm**2)), rtol=1e-8)
    assert_allclose(found.v[0], 5 / 7 * speed, rtol=1e-6)
    assert_allclose(found.v[0] + arm * found.v[2], 0.0, atol=1e-8)


@pytest.mark.parametrize("offset", [0.0, 0.3], ids=["central", "eccentric"])
def test_two_discs_meet_with_their_pre_impact_effective_energy(offset):
    """T_c⁻ = ½ m1 m2/(m1 + m2) (ẋ2 - ẋ1)², with the second body's turning ½ v²/(1/m1 + 1/m2 + s²/I2); the peak force
    without loss is K^{2/5} (5 T_c⁻/2)^{3/5}."""
    disc, other = Body(0.7, 3e-4), Body(2.3, 0.05)
    system = System((disc, other))
    pair = floor(RADIUS, Hertz(STIFFNESS))
    contact = BallContact(0, 1, pair)
    q = jnp.array([offset, RADIUS + 1e-5, 0.0, 0.0, 0.0, 0.0])
    v = jnp.array([0.0, -0.9, 0.0, 0.0, 0.4, 0.0])
    found = ride(Assembled(system, q, v, (contact,), size=(1e-4, 1.0)), 3e-3)
    normal = np.array([0.0, -1.0, 0.0, 0.0, 1.0, offset])  # approach speed = A v
    mobility = system.response(Kinematics(q, v), jnp.asarray(normal)[:, None])[:, 0] @ normal
    energy = 0.5 * 1.3**2 / mobility
    assert_allclose(energy, 0.5 * 1.3**2 / (1 / 0.7 + 1 / 2.3 + offset**2 / 0.05), rtol=1e-14)
    force = found.force[found.kind == Kind.PEAK][0, 0]
    # Eccentric, the body turns a little during the impact: measured 2.5e-6; central 5e-9.
    assert_allclose(force, STIFFNESS**0.4 * (2.5 * energy) ** 0.6, rtol=5e-6 if offset else 2e-8)
    assert_allclose(np.sum(np.array([0.7, 2.3]) * found.v[[1, 4]]), 0.7 * -0.9 + 2.3 * 0.4, rtol=1e-12)


def test_pendulum_period():
    """T = 4 √(2l/3g) K(sin²(θ0/2)) of a uniform rod released at 2.5 rad."""
    amplitude, length = 2.5, 0.8
    swinging = pendulum(amplitude, length=length)
    period = 4.0 * np.sqrt(2 * length / (3 * GRAVITY)) * ellipk(np.sin(amplitude / 2) ** 2)
    hanging = Assembled(swinging.system, swinging.q, swinging.v, ends=(lambda _, kin: -(kin.q[2] + np.pi / 2),))
    found = ride(hanging, period)
    assert found.status == 0
    assert_allclose(4 * found.time[-1], period, rtol=1e-9)
    assert_allclose(found.v[2], -np.sqrt(6 * GRAVITY / length) * np.sin(amplitude / 2), rtol=1e-8)
