"""Attitude control of one body against closed forms, in the plane and in space, with its work and impulse."""

import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.elements import AttitudeControl
from jaxbuffer.fields import POSITIVE, Part, number
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.mechanism import Mechanism
from jaxbuffer.mechanisms.quantity import Quantity
from jaxbuffer.multibody import Body, System
from jaxbuffer.plane import PLANE
from jaxbuffer.space import SPACE, Quaternion, Vector
from registration import registered

INERTIA, ANGLE, RATE, STIFFNESS, DAMPING = 0.4, 0.3, -0.2, 2.0, 0.5
AXIS = {"x": 0, "y": 1, "z": 2}


class Satellite(Part):
    stiffness: float = number(STIFFNESS, "N m/rad", **POSITIVE)


class Turned(Part):
    section = "scenario"
    angle: float = number(ANGLE, "rad")


def flat(design, scenario, stabilisation=20.0):
    """One body in the plane, turned and turning, under control."""
    control = AttitudeControl(0, design.stiffness, DAMPING)
    q, v = jnp.zeros(3).at[2].set(scenario.angle), jnp.zeros(3).at[2].set(RATE)
    return Assembled(
        System((Body(2.0, INERTIA),)), q, v, (control,), size=(1e-2, 1e-2), energy_size=1e-2, momentum_size=1.0
    )


def spatial(axis):
    """The same in space, about one of the body's axes."""

    def assembled(design, scenario, stabilisation=20.0):
        control = AttitudeControl(0, design.stiffness, DAMPING, basis=SPACE)
        turn = [0.0, 0.0, 0.0]
        turn[AXIS[axis]] = scenario.angle
        q = jnp.stack([jnp.asarray(x, float) for x in (0.0, 0.0, 0.0, *Quaternion.of_rotation_vector(Vector(*turn)))])
        v = jnp.zeros(6).at[3 + AXIS[axis]].set(RATE)
        system = System((Body(2.0, (INERTIA, INERTIA, INERTIA)),), basis=SPACE)
        return Assembled(system, q, v, (control,), size=(1e-2, 1e-2), energy_size=1e-2, momentum_size=1.0)

    return assembled


def oscillation(time):
    """Angle and rate of the damped oscillator that the body is."""
    decay = DAMPING / (2.0 * INERTIA)
    omega = np.sqrt(STIFFNESS / INERTIA - decay**2)
    sine = (RATE + decay * ANGLE) / omega
    cos, sin, fall = np.cos(omega * time), np.sin(omega * time), np.exp(-decay * time)
    angle = fall * (ANGLE * cos + sine * sin)
    return angle, fall * (omega * (sine * cos - ANGLE * sin)) - decay * angle


LEFT = Quantity("J", lambda run: run.energy.kinetic, "kinetic energy at the end", "energy left", swept=True, tuned=True)


@pytest.mark.parametrize("assembled", [flat, spatial("x"), spatial("y"), spatial("z")], ids=["plane", "x", "y", "z"])
def test_one_body_is_a_damped_oscillator(assembled):
    with registered(Mechanism("satellite", Satellite, Turned, {"energy_left": LEFT}, assembled)):
        run = jb.simulate(Satellite(), Turned(), 1.5, rtol=1e-9, history=True)
    angle, rate = oscillation(1.5)
    last = np.asarray(run.history.position)[-1, 0]
    assert np.abs(last).max() == pytest.approx(abs(angle), rel=1e-6)
    assert float(run.energy.kinetic) == pytest.approx(0.5 * INERTIA * rate**2, rel=1e-6)
    # What the control put in is all that changed the energy, and all that changed the angular momentum.
    work = 0.5 * INERTIA * (rate**2 - RATE**2)
    assert -float(run.energy.stored["attitude_control"]) == pytest.approx(work, rel=1e-6)
    assert float(run.balance.energy) == pytest.approx(0.0, abs=1e-7)
    assert float(run.balance.angular_momentum) == pytest.approx(0.0, abs=1e-9)


def test_moment_about_each_axis_stays_below_the_limit():
    rotation, spin = np.array([0.3, -0.2, 0.5]), np.array([0.4, 0.1, -0.3])
    quaternion = Quaternion.of_rotation_vector(Vector(*map(jnp.asarray, rotation)))
    q = jnp.asarray([0.1, 0.2, 0.3, *map(float, quaternion)])
    system = System((Body(2.0, (0.3, 0.4, 0.5)),), basis=SPACE)
    kin = system.kinematics(q, jnp.asarray([0.0, 0.0, 0.0, *spin]))
    control = AttitudeControl(0, STIFFNESS, DAMPING, limit=0.4, basis=SPACE)
    axes = np.array([[float(x) for x in axis] for axis in kin.frame(0).axes])
    wanted = STIFFNESS * rotation + DAMPING * axes @ spin
    moment = np.array([float(x) for x in control.evaluate(kin, jnp.zeros(4)).moment])
    np.testing.assert_allclose(axes @ moment, -0.4 * np.tanh(wanted / 0.4), rtol=1e-12)


def test_without_a_limit_it_is_the_law_of_a_large_one():
    system = System((Body(2.0, INERTIA),))
    kin = system.kinematics(jnp.asarray([0.0, 0.0, ANGLE]), jnp.asarray([0.0, 0.0, RATE]))
    moments = [
        float(AttitudeControl(0, STIFFNESS, DAMPING, it).evaluate(kin, jnp.zeros(2)).moment) for it in (None, 1e6)
    ]
    assert moments[0] == pytest.approx(-(STIFFNESS * ANGLE + DAMPING * RATE))
    assert moments[0] == pytest.approx(moments[1])
    assert AttitudeControl(0, STIFFNESS, DAMPING).basis is PLANE
