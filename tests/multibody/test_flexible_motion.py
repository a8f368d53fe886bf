"""Free flexible bodies: what they conserve, and that the choice of the frame is a choice."""

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from helpers import Mechanism, integrate
from jaxbuffer.multibody import AppliedForce, AxialSpringDamper, Body, FlexibleBody, System
from jaxbuffer.multibody.flexible import Bar, cantilever_bar, free_bar

TOPIC = "Motion of flexible bodies"
SOFT = Bar.rectangle(0.8, 0.02, 0.01, 2700.0, 7e7)  # m, kg/m³, Pa: softer than metal, so that it bends much


def tumbling(body, stretch=True):
    """Thrown, turning, bent and about to swing."""
    rng = np.random.default_rng(3)
    size = body.modes.size
    q = np.concatenate([[0.3, -0.2, 0.4], 0.01 * rng.normal(size=size)])
    v = np.concatenate([[1.5, 0.7, 3.0], 0.3 * rng.normal(size=size)])
    return Mechanism(System((FlexibleBody(body.modes),)), q, v)


BODIES = {
    "mean axes": lambda: free_bar(SOFT, 2, 1),
    "mean axes, stiffened": lambda: free_bar(SOFT, 2, 1, geometric=True),
    "clamped to its frame, with a tip": lambda: cantilever_bar(SOFT, 1, 1, tip_mass=0.1, tip_inertia=1e-4),
}


@eqx.filter_jit
def built(build, *arguments):
    """A builder's body, in one program in place of its many operations."""
    return build(*arguments)


@eqx.filter_jit
def along(system, q, v):
    """Energy, linear and angular momentum, and stored energy at each of a motion's times."""

    def at(q, v):
        kin = system.kinematics(q, v)
        stored = system.stored_energy(kin)
        return system.kinetic_energy(kin) + stored, system.linear_momentum(kin), system.angular_momentum(kin), stored

    return jax.vmap(at)(q, v)


@pytest.mark.parametrize("name", BODIES)
def test_a_free_body_conserves_momenta_and_energy(name, evidence):
    """Half a second, a quarter of a turn and some forty swings of the first mode along the bar."""
    mechanism = tumbling(built(BODIES[name]))
    q, v = integrate(mechanism, np.linspace(0.0, 0.5, 6), 1e-12)
    total, linear, angular, stored = map(np.asarray, along(mechanism.system, q, v))
    source = "conservation"
    evidence(TOPIC, "free body, energy, relative", np.ptp(total) / total[0], 1e-8, source, detail=name)
    evidence(
        TOPIC,
        "free body, linear momentum, relative",
        np.max(np.ptp(linear, axis=0)) / np.max(np.abs(linear)),
        1e-9,
        source,
        detail=name,
    )
    evidence(
        TOPIC,
        "free body, angular momentum, relative",
        np.ptp(angular) / np.max(np.abs(angular)),
        1e-9,
        source,
        detail=name,
    )
    assert np.ptp(stored) > 1e-3 * total[0]


def test_a_tied_pair_conserves_too(evidence):
    """A flexible bar and a body on a spring between markers."""
    bar = built(free_bar, SOFT, 2, 1)
    spring = AxialSpringDamper(0, 1, bar.end, (0.05, 0.0), 400.0, 0.0, 0.2)
    system = System((FlexibleBody(bar.modes), Body(0.3, 1e-3)), (), (spring,))
    q, v = np.zeros((2, system.coordinates))
    q[3:5] = 0.7, 0.1
    v[[2, 4]] = 2.0, -1.0
    q, v = integrate(Mechanism(system, q, v), np.linspace(0.0, 0.5, 6), 1e-12)
    total, linear, angular, _ = map(np.asarray, along(system, q, v))
    evidence(TOPIC, "tied pair, energy, relative", np.ptp(total) / total[0], 1e-8, "conservation")
    evidence(
        TOPIC, "tied pair, linear momentum", np.max(np.abs(linear[-1] - linear[0])), 1e-9, "conservation", "kg m/s"
    )
    evidence(TOPIC, "tied pair, angular momentum", abs(angular[-1] - angular[0]), 1e-9, "conservation", "kg m²/s")


@eqx.filter_jit
def acceleration_of_a_falling_bar():
    body = FlexibleBody(cantilever_bar(SOFT, 2, 1, tip_mass=0.1).modes)
    weight = AppliedForce(0, (0.0, -9.81 * body.mass), body.centre_of_mass)
    system = System((body,), (), (weight,))
    rest = jnp.zeros(system.coordinates).at[2].set(0.5)
    return system.motion(system.kinematics(rest, jnp.zeros_like(rest))).acceleration


@pytest.mark.quick
def test_a_falling_bar_falls_as_a_stone(evidence):
    """The weight at the centre of mass of a body clamped to its frame: it falls by g t²/2, and does not swing."""
    found = np.asarray(acceleration_of_a_falling_bar())
    expected = np.zeros_like(found)
    expected[1] = -9.81
    evidence(TOPIC, "weight of a flexible body", np.max(np.abs(found - expected)), 1e-10, "free fall", "m/s²")


@eqx.filter_jit
def trajectory(body, velocities):
    """Of three material points, after 50 ms from the undeformed body with these velocities."""
    system = System((FlexibleBody(body.modes),))

    def field(time, y, system):
        return y[1], system.motion(system.kinematics(*y)).acceleration

    q, v = diffrax.diffeqsolve(
        diffrax.ODETerm(field),
        diffrax.Dopri8(),
        0.0,
        0.05,
        1e-5,
        (jnp.zeros(system.coordinates), velocities),
        args=system,
        stepsize_controller=diffrax.PIDController(rtol=1e-11, atol=1e-13),
        max_steps=100_000,
    ).ys
    kin = system.kinematics(q[-1], v[-1])
    return jnp.stack([jnp.stack(kin.point(0, body.marker(station)).place) for station in (0.0, 0.3, 1.0)])


def test_a_frame_may_be_clamped_or_mean(evidence):
    """A free bar that is set turning and bending: in mean axes, and in a frame clamped to its start, whose modes span
    the same shapes. Material points go the same way but for second order of the motion: a tenth of the speeds leaves a
    hundredth of the difference, since the frames turn against each other and straight shapes shorten nothing."""
    mean, clamped = built(free_bar, SOFT, 6), built(cantilever_bar, SOFT, 6)
    stations = np.linspace(0.0, 1.0, 41)
    shape, lateral = (np.array([body.marker(s).displacement_y for s in stations]) for body in (mean, clamped))
    lever = 0.8 * (stations - 0.5)
    basis = np.column_stack([lateral, np.ones_like(lever), lever])
    coefficients, *_ = np.linalg.lstsq(basis, shape[:, 0], rcond=None)
    assert np.max(np.abs(basis @ coefficients - shape[:, 0])) < 1e-6
    *rates, shift, turn = coefficients
    gaps = []
    for kick in (0.1, 0.01):
        first = trajectory(mean, kick * np.array([0.0, 0.0, 10.0, 1.0, *np.zeros(7)]))
        second = trajectory(clamped, kick * np.array([0.0, shift, 10.0 + turn, *rates]))
        gaps.append(np.max(np.abs(np.asarray(first) - np.asarray(second))))
    order, told = np.log10(gaps[0] / gaps[1]), f"{gaps[0]:.2e} and {gaps[1]:.2e} m"
    claim = "two frames, order of their difference in the speeds"
    evidence(TOPIC, claim, abs(order - 2.0), 0.1, "theory", detail=told)
