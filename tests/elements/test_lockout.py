"""A lockout: a mass that is held where it crosses a plane, by the closed form of an oscillator."""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.elements import Lockout
from jaxbuffer.elements.lockout import held_stroke
from jaxbuffer.fields import Part, number
from jaxbuffer.fields.needs import inactive
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.mechanism import Mechanism
from jaxbuffer.mechanisms.probe_cone.mechanism import PROBE_CONE
from jaxbuffer.mechanisms.quantity import Quantity
from jaxbuffer.mechanisms.registry import mechanism_of
from jaxbuffer.multibody import GROUND, AxialSpringDamper, Body, Prismatic, System
from registration import registered

MASS, SPEED, SPRING, STIFFNESS, DAMPING, PLANE = 3.0, 0.4, 50.0, 800.0, 6.0, 0.02  # kg, m/s, N/m, N/m, N s/m, m
DURATION = 0.6  # s


class Wagon(Part):
    spring: float = number(SPRING, "N/m")
    stiffness: float = number(STIFFNESS, "N/m")
    damping: float = number(DAMPING, "N s/m")
    plane: float = number(PLANE, "m")


class Start(Part):
    section = "scenario"
    speed: float = number(SPEED, "m/s")


def held_wagon(design, scenario, stabilisation=20.0):
    """A mass that runs against a spring, whose shortening is held once the mass is ``plane`` from its start."""
    guide = AxialSpringDamper(GROUND, 0, (1.0, 0.0), (0.0, 0.0), stiffness=design.spring, damping=0.0, free_length=1.0)
    lockout = Lockout(guide, 0, GROUND, (0.0, 0.0), design.plane, design.stiffness, design.damping)
    # The mass moves towards the spring's other end: its place is the stroke, and it crosses the plane upwards.
    system = System((Body(MASS, 1.0),), (Prismatic(GROUND, 0),), (guide,))
    v = jnp.array([1.0, 0.0, 0.0]) * scenario.speed
    return Assembled(
        system, jnp.zeros(3), v, elements=(lockout,), size=(1e-3, SPEED), energy_size=0.5 * MASS * SPEED**2
    )


QUANTITIES = {
    "peak_lockout_force": Quantity("N", lambda run: run.maxima["lockout_force"], "largest force"),
    "lockout_stroke": Quantity("m", lambda run: held_stroke(run, "lockout"), "stroke that is held"),
    "lockout_loss": Quantity("J", lambda run: run.energy.lost["lockout_damper"], "energy lost"),
}


@pytest.fixture(scope="module")
def wagon():
    with registered(Mechanism("held wagon", Wagon, Start, QUANTITIES, held_wagon)):
        yield


@jax.jit
def after(stiffness, damping, plane, time):
    """Stroke and its rate [m, m/s] a time [s] after the crossing: m s̈ = -k s - k_h (s - s_h) - c ṡ from s_h on."""
    speed = jnp.sqrt(SPEED**2 - SPRING / MASS * plane**2)
    both = SPRING + stiffness
    rest, decay = stiffness * plane / both, damping / (2.0 * MASS)
    swing = jnp.sqrt(both / MASS - decay**2)
    first, second = plane - rest, (speed + decay * (plane - rest)) / swing
    cos, sin, fall = jnp.cos(swing * time), jnp.sin(swing * time), jnp.exp(-decay * time)
    stroke = rest + fall * (first * cos + second * sin)
    rate = fall * ((second * swing - decay * first) * cos - (first * swing + decay * second) * sin)
    return stroke, rate


def crossing(plane):
    """When the mass is at the plane [s], of the oscillator that the spring alone makes of it."""
    swing = math.sqrt(SPRING / MASS)
    return jnp.arcsin(plane * swing / SPEED) / swing


@jax.jit
def peak(stiffness, damping, plane):
    """The largest force of spring and damper [N], at one of many instants and, between them, by Newton's method."""

    def force(time):
        stroke, rate = after(stiffness, damping, plane, time)
        return stiffness * (stroke - plane) + damping * rate

    times = jnp.linspace(0.0, DURATION - crossing(PLANE), 20001)
    time = times[jnp.argmax(jnp.abs(jax.vmap(force)(times)))]
    slope, curvature = jax.grad(force), jax.grad(jax.grad(force))
    for _ in range(6):
        time = time - slope(time) / curvature(time)
    return jnp.abs(force(jax.lax.stop_gradient(time)))


def test_a_mass_is_held_where_it_crosses(wagon):
    """Stroke, force, energies and the whole motion are those of the oscillator's closed form."""
    run = jb.simulate(Wagon(), Start(), DURATION, history=True, rtol=1e-9)
    begun = float(crossing(PLANE))
    assert run.switch_times["lockout"] == pytest.approx(begun, abs=1e-9)
    assert float(run.quantity("lockout_stroke")) == pytest.approx(PLANE, rel=1e-9)
    assert float(run.maxima["lockout_force"]) == pytest.approx(float(peak(STIFFNESS, DAMPING, PLANE)), rel=1e-6)
    time, place = np.asarray(run.history.time), np.asarray(run.history.position)[:, 0, 0]
    late = time > begun
    expected, _ = after(STIFFNESS, DAMPING, PLANE, time[late] - begun)
    assert late.sum() > 10
    np.testing.assert_allclose(place[late], expected, atol=1e-8)
    stroke, rate = map(float, after(STIFFNESS, DAMPING, PLANE, DURATION - begun))
    stored = 0.5 * STIFFNESS * (stroke - PLANE) ** 2
    left = 0.5 * MASS * rate**2 + 0.5 * SPRING * stroke**2 + stored
    assert float(run.energy.stored["lockout"]) == pytest.approx(stored, rel=1e-6)
    assert float(run.energy.lost["lockout_damper"]) == pytest.approx(0.5 * MASS * SPEED**2 - left, rel=1e-6)
    assert abs(float(run.balance.energy)) < 1e-8


@pytest.mark.slow
def test_its_gradients_are_those_of_the_closed_form(wagon):
    paths, names = ("stiffness", "damping", "plane"), ("peak_lockout_force", "lockout_stroke", "lockout_loss")
    found = jb.sensitivity(Wagon(), Start(), wrt=paths, quantities=names, duration=DURATION, certify="none")

    def loss(*numbers):
        stroke, rate = after(*numbers, DURATION - crossing(numbers[2]))
        stored = 0.5 * numbers[0] * (stroke - numbers[2]) ** 2
        return 0.5 * MASS * SPEED**2 - 0.5 * MASS * rate**2 - 0.5 * SPRING * stroke**2 - stored

    numbers = np.array([STIFFNESS, DAMPING, PLANE])
    expected = [jax.grad(of, argnums=(0, 1, 2))(*numbers) for of in (peak, lambda *it: it[2] + 0.0 * it[0], loss)]
    for name, row, exact in zip(names, np.asarray(found.gradients), np.asarray(expected), strict=True):
        size = np.abs(exact * numbers).max()
        np.testing.assert_allclose(row * numbers, exact * numbers, atol=1e-5 * size, err_msg=name)
    # The closed form's own derivatives, against differences of it.
    for k, step in enumerate(1e-6 * numbers):
        moved = [loss(*(numbers + sign * step * np.eye(3)[k])) for sign in (1.0, -1.0)]
        assert (moved[0] - moved[1]) / (2.0 * step) == pytest.approx(float(expected[2][k]), rel=1e-5)


LATCHED = {"latch.stiffness": 2000.0, "latch.damping": 50.0}
LOCKED = {"lockout.stiffness": 2e4, "lockout.damping": 100.0}


def test_a_docking_has_it_by_its_stiffness():
    design, scenario = jb.replace(jb.table2(), LATCHED | LOCKED), jb.Scenario()
    system = eqx.filter_jit(PROBE_CONE.system)(design, scenario)
    lockout, latch = system.element("lockout"), system.element("latch")
    assert (lockout.stiffness, lockout.damping) == (2e4, 100.0)
    assert float(lockout.plane) == float(latch.plane) and lockout.guide is not None
    assert {"peak_lockout_force", "lockout_stroke"} <= set(PROBE_CONE.meant(lambda path: jb.get(design, path)))
    assert "lockout_force" in mechanism_of(design).names(design).others


def test_what_is_said_of_a_design_before_a_run():
    view, alone = PROBE_CONE.view, jb.replace(jb.table2(), LOCKED)
    assert "lockout.stiffness = 20000 N/m has no effect: it needs latch.stiffness" in inactive(alone)
    soft = jb.replace(jb.table2(), LATCHED | {"lockout.stiffness": 500.0})
    # Two springs in a row of 500 N/m each share the stroke that is held.
    assert any("pushed the rod out by 50% of the stroke" in line for line in view.sanity_checks(soft))
    firm = jb.replace(soft, {"lockout.stiffness": 5000.0})
    assert not any("lockout" in line for line in view.sanity_checks(firm))
    with pytest.raises(jb.InputError, match=r"lockout\.stiffness = -1 N/m is out of range"):
        jb.replace(soft, {"lockout.stiffness": -1.0})
