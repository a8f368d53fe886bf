"""How hard impacts are: effective kinetic energy before them and the end of compression, against closed forms."""

import dataclasses
import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import jaxbuffer as jb
from jaxbuffer.contact import BallPair, RegularisedCoulomb, Segment
from jaxbuffer.contact.laws import Hertz
from jaxbuffer.hybrid import Kind, Log
from jaxbuffer.mechanisms.assembled import Assembled, BallContact
from jaxbuffer.mechanisms.loads import _effective_energy, effective_energy
from jaxbuffer.multibody import GROUND, Body, System
from jaxbuffer.output.records import run_record

RADIUS = 0.01
BOTH = jnp.array([True, True])


def ball_on(carrier, x, y, angle, point=(0.0, 0.0), name="contact"):
    """A ball on body 0 against a long segment through a point, its direction at an angle from the x-axis."""
    cos, sin = math.cos(angle), math.sin(angle)
    plane = Segment(x - cos, y - sin, cos, sin, 2.0)
    pair = BallPair(RADIUS, plane, -jnp.ones(()), Hertz(1e8), RegularisedCoulomb(0.0, 1e-3))
    return BallContact(0, carrier, pair, point, name=name)


def two_masses(first, second, speeds):
    """Two bodies that move along y, the upper one's ball above the lower one's plane."""
    system = System((Body(first, 0.1), Body(second, 0.2)))
    q, v = jnp.array([0.0, RADIUS, 0.0, 0.0, 0.0, 0.0]), jnp.array([0.0, speeds[0], 0.0, 0.0, speeds[1], 0.0])
    return Assembled(system, q, v, (ball_on(1, 0.0, 0.0, 0.0),))


def wedge(half_angle, velocity, mass=2.0, inertia=0.3, spin=4.0):
    """A ball at rest in a V of planes on the ground, each ``half_angle`` from the vertical; it moves."""
    rise = 0.5 * math.pi - half_angle
    contacts = (ball_on(GROUND, 0.0, 0.0, rise, name="left"), ball_on(GROUND, 0.0, 0.0, -rise, name="right"))
    q, v = jnp.array([0.0, RADIUS / math.sin(half_angle), 0.0]), jnp.array([*velocity, spin])
    return Assembled(System((Body(mass, inertia),)), q, v, contacts)


@eqx.filter_jit  # once for whatever is closed in a mechanism
def energy_at_start(mechanism, closed):
    state, _ = mechanism.start()
    return effective_energy(mechanism, state, closed)


def energy_of(mechanism, closed=None):
    closed = np.ones(mechanism.contact_count, bool) if closed is None else closed
    return float(energy_at_start(mechanism, closed))


@pytest.mark.slow
def test_two_free_masses_and_the_papers_transformation():
    """½ m1 m2/(m1 + m2) (ẋ2 - ẋ1)²; equations 28 to 36: A M⁻¹ Bᵀ = 0, R, RᵀMR, and T = T_c + T_a (M201, M202)."""
    m1, m2, speeds = 1.5, 3.0, np.array([-4.0, 0.4294])
    mechanism = two_masses(m1, m2, speeds)
    mass, normal, along = np.diag([m1, m2]), np.array([[-1.0, 1.0]]), np.array([[m1 / m2, 1.0]])
    assert_allclose(normal @ np.linalg.inv(mass) @ along.T, 0.0, atol=1e-15)
    moved = np.linalg.inv(np.concatenate([normal, along]))
    assert_allclose(moved, np.array([[-m2, m2], [m1, m2]]) / (m1 + m2), rtol=1e-14)
    diagonal = np.diag([m1 * m2, m2**2]) / (m1 + m2)
    assert_allclose(moved.T @ mass @ moved, diagonal, rtol=1e-14, atol=1e-15)
    assert_allclose(moved.T @ normal.T, [[1.0], [0.0]], atol=1e-15)

    shares = 0.5 * np.diag(diagonal) * (np.concatenate([normal, along]) @ speeds) ** 2
    assert_allclose(energy_of(mechanism), 0.5 * m1 * m2 / (m1 + m2) * (speeds[1] - speeds[0]) ** 2, rtol=1e-13)
    assert_allclose(energy_of(mechanism), shares[0], rtol=1e-13)
    kinetic = float(mechanism.system.kinetic_energy(mechanism.first_evaluation()[0].kin))
    assert_allclose(kinetic, shares.sum(), rtol=1e-13)


def test_a_bar_struck_off_its_centre():
    """½ m v²/(1 + 12 a²/L²): the farther out, the less mass is met. It turns as well: its end's speed counts."""
    mass, length, off, speed, spin = 2.0, 0.6, 0.2, 3.0, -5.0
    system = System((Body(mass, mass * length**2 / 12.0),))
    bar = Assembled(system, jnp.array([0.0, RADIUS, 0.0]), jnp.array([0.0, -speed, spin]),
                    (ball_on(GROUND, 0.0, 0.0, 0.0, (off, 0.0)),))  # fmt: skip
    expected = 0.5 * mass / (1.0 + 12.0 * off**2 / length**2) * (speed - spin * off) ** 2
    assert_allclose(energy_of(bar), expected, rtol=1e-13)


def test_two_contacts_of_a_wedge():
    """Both normals span the plane: all but the spin's energy is theirs. One alone has ½ m (v·n)²; their sum is more or
    less than both, since the normals are not at right angles."""
    angle, velocity = 0.6, np.array([0.5, -2.0])
    mechanism = wedge(angle, velocity)
    assert_allclose(energy_of(mechanism), 0.5 * 2.0 * velocity @ velocity, rtol=1e-13)
    for k, side in enumerate((-1.0, 1.0)):
        closing = -velocity @ np.array([side * math.cos(angle), math.sin(angle)])
        alone = energy_of(mechanism, np.arange(2) == k)
        assert_allclose(alone, 0.5 * 2.0 * closing**2, rtol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize(("apart", "together"), [(0.0, True), (1e-6, False)])
def test_touchdowns_at_one_instant_are_one_impact(apart, together):
    """Both of them count both contacts; a microsecond later, the second one does."""
    mechanism = wedge(0.6, (0.0, -2.0))
    state, _ = mechanism.start()
    log = Log.empty(4, state[None], 2, 2)
    log = dataclasses.replace(
        log,
        kind=log.kind.at[:2].set(int(Kind.TOUCHDOWN)),
        which=log.which.at[:2].set(jnp.arange(2)),
        time=log.time.at[:2].set(jnp.array([0.1, 0.1 + apart])),
        active=log.active.at[:2].set(jnp.array([[1.0, 0.0], [1.0, 1.0]])),
        count=jnp.asarray(2),
    )
    touch = log.kind == Kind.TOUCHDOWN
    first, second = (float(_effective_energy(mechanism, log, touch, jnp.asarray(k))) for k in range(2))
    assert_allclose(second, 0.5 * 2.0 * 2.0**2, rtol=1e-12)
    assert_allclose(first, second if together else 4.0 * math.sin(0.6) ** 2, rtol=1e-12)


@pytest.mark.slow
def test_a_dropped_bars_energy_and_end_of_compression():
    """All of m g H/2 belongs to the contact, its derivative by H is m g/2; the end of compression of an independent
    integration of I θ'' = F L cos θ - m g L cos θ/2."""
    design, height = jb.BarDrop(), 0.01
    run = jb.simulate(design, jb.BarDropScenario(height=height), 0.06, rtol=1e-9)
    mass, length = float(design.bar.mass), float(design.bar.length)
    assert_allclose(run.quantity("impact.1.effective_energy"), 0.5 * mass * 9.81 * height, rtol=1e-8)
    (record,) = run_record(run)["impacts"]
    assert_allclose(record["effective_energy"]["value"], run.quantity("impact.1.effective_energy"), rtol=1e-12)
    impact, inertia = design.impact, mass * length**2 / 3.0

    def field(_, y):
        depth, closing = -length * math.sin(y[0]), -length * math.cos(y[0]) * y[1]
        share = min(max(depth / impact.ramp_depth, 0.0), 1.0)
        push = impact.stiffness * max(depth, 0.0) ** impact.exponent
        push = max(0.0, push + impact.damping * share**2 * (3.0 - 2.0 * share) * closing) * (depth > 0.0)
        return [y[1], (push * length - 0.5 * mass * 9.81 * length) * math.cos(y[0]) / inertia]

    def deepest(_, y):
        return y[1]

    start = [0.0, -math.sqrt(3.0 * 9.81 * height) / length]
    deepest.terminal = True
    peer = solve_ivp(field, (0.0, 1e-3), start, "Radau", rtol=1e-9, atol=1e-14, events=deepest, max_step=1e-6)
    found = float(run.quantity("impact.1.compression_end") - run.impacts.time[0])
    assert_allclose(found, peer.t_events[0][0], rtol=1e-4)


@pytest.mark.long
def test_the_energys_derivative():
    """d(m g H/2)/dH = m g/2 by forward differentiation of a whole run; a capture's first impact is its closed form."""
    design = jb.BarDrop()

    def energy(height):
        run = jb.simulate(design, jb.BarDropScenario(height=height), 0.06)
        return run.quantity("impact.1.effective_energy")

    _, slope = jax.jvp(energy, (0.01,), (1.0,))
    assert_allclose(slope, 0.5 * float(design.bar.mass) * 9.81, rtol=1e-6)
    capture = jb.simulate(jb.table2(), jb.Scenario())
    energies = capture.loads("effective_energy")
    assert_allclose(energies[0], capture.first_impact.effective_energy, rtol=1e-12)
    assert len(energies) == int(capture.impacts.count) and np.all(energies > 0.0)
    assert np.isnan(capture.quantity("impact.99.effective_energy"))
