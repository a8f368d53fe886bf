"""The control of a body's attitude, in the plane and in space, against closed forms."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import jaxbuffer as jb
from in_short import quick
from jaxbuffer.contact import BallPair, KelvinVoigt, RegularisedCoulomb, Revolved, Segment
from jaxbuffer.elements import AttitudeControl, BallContact
from jaxbuffer.fields import POSITIVE, Part, number
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.mechanism import Defaults, Mechanism
from jaxbuffer.multibody import Body, System
from jaxbuffer.plane import PLANE
from jaxbuffer.space import SPACE
from registration import registered

MASS, INERTIA, ANGLE, SPIN, DURATION = 2.0, 0.4, 0.3, -0.5, 1.5
STIFFNESS, DAMPING, SPEED = 5.0, 0.7, 0.8  # N m/rad, N m s/rad, m/s
SKEW = np.array([0.48, -0.6, 0.64])


class Control(Part):
    section = "control"
    limit: float = number(1e5, "N m", **POSITIVE)
    stiffness: float = number(STIFFNESS, "N m/rad", **POSITIVE)


class Turned(Part):
    control: Control = Control()


class Thrown(Part):
    section = "scenario"
    gap: float = number(1.7, "m", doc="to the wall that the body flies to")


def mechanism_of(basis, axis):
    """A body that turns about an axis, and flies to a wall without friction on another body at rest."""

    def turned(design, scenario, stabilisation=20.0):
        wall = Segment(-1e3, 0.0, 1.0, 0.0, 2e3)
        shape, side = (wall, -1.0) if basis is PLANE else (Revolved(Segment(-1e3, 2.0, 1.0, 0.0, 2e3)), 1.0)
        ball = BallContact(0, 1, BallPair(0.1, shape, side, KelvinVoigt(1e5, 10.0), RegularisedCoulomb(0.0, 1.0)))
        control = AttitudeControl(0, design.control.stiffness, DAMPING, design.control.limit, until=ball)
        high = 0.1 + scenario.gap - (0.0 if basis is PLANE else 2.0)
        if basis is PLANE:
            moments, first, second, spin = INERTIA, [ANGLE], [0.0], [SPIN]
            places, speeds = ([0.0, high], [0.0, 0.0]), ([0.0, -SPEED], [0.0, 0.0])
        else:
            moments, second, spin = (INERTIA,) * 3, [1.0, 0.0, 0.0, 0.0], SPIN * axis
            first = Rotation.from_rotvec(ANGLE * axis).as_quat(scalar_first=True)
            places, speeds = ([0.0, high, 0.0], [0.0, 0.0, 0.0]), ([0.0, -SPEED, 0.0], [0.0, 0.0, 0.0])
        q = jnp.concatenate([jnp.asarray([*place, *turn]) for place, turn in zip(places, (first, second), strict=True)])
        v = jnp.concatenate([jnp.asarray([*speeds[0], *spin]), jnp.zeros(basis.velocities)])
        system = System((Body(MASS, moments),) * 2, stabilisation=stabilisation, basis=basis)
        size = (1e-2, 1.0)
        return Assembled(system, q, v, (ball, control), size=size, energy_size=1.0, momentum_size=MASS * SPEED)

    return turned


class TurnedInSpace(Turned):
    pass


def of(name, design, basis, axis):
    return Mechanism(name, design, Thrown, {}, mechanism_of(basis, axis), defaults=Defaults(duration=DURATION))


@pytest.fixture(scope="module", autouse=True)
def known():
    in_space = of("turned in space", TurnedInSpace, SPACE, SKEW)
    with registered(of("turned in the plane", Turned, PLANE, None)), registered(in_space):
        yield


BOTH = pytest.mark.parametrize("design", quick([Turned, TurnedInSpace], Turned))


TOUCHES, LIMIT = 0.4, 0.2  # s, N m
AT_ITS_LIMIT = Control(limit=LIMIT, stiffness=3e4)
RUNS = {
    "small moments": (Control(), Thrown()),
    "at its limit": (AT_ITS_LIMIT, Thrown()),
    "touchdown": (AT_ITS_LIMIT, Thrown(gap=TOUCHES * SPEED)),
    "in contact": (Control(), Thrown(gap=0.0)),
}


@functools.cache
def runs(design):
    """All of `RUNS`, one after the other while their program is in memory: it is a test's, so it is not stored."""
    return {
        name: jb.simulate(design(control), scenario, rtol=1e-10, atol=1e-10, history=True)
        for name, (control, scenario) in RUNS.items()
    }


def seen(run):
    """Time, angle about the axis and spin about it; nothing turns about another axis."""
    time, position, velocity = (np.array(it) for it in (run.history.time, run.history.position, run.history.velocity))
    if position.shape[-1] == 3:
        return time, position[:, 0, 2], velocity[:, 0, 2]
    turns, spins = position[:, 0, 3:], velocity[:, 0, 3:]
    assert_allclose(np.cross(turns, SKEW), 0.0, atol=1e-8)
    return time, turns @ SKEW, spins @ SKEW


@BOTH
def test_small_moments_make_a_damped_oscillator(design):
    run = runs(design)["small moments"]
    time, angle, _ = seen(run)
    decay = DAMPING / (2.0 * INERTIA)
    rate = np.sqrt(STIFFNESS / INERTIA - decay**2)
    sine = (SPIN + decay * ANGLE) / rate
    at = lambda t: np.exp(-decay * t) * (ANGLE * np.cos(rate * t) + sine * np.sin(rate * t))  # noqa: E731
    assert_allclose(angle, at(time), atol=1e-8)
    # Its work is what the kinetic energy has changed by, its impulse the spin's.
    spin = float(seen(run)[2][-1])
    work = 0.5 * INERTIA * (spin**2 - SPIN**2)
    assert float(run.energy.stored["control"]) == pytest.approx(-work, rel=1e-7)
    for error in (run.balance.energy, run.balance.angular_momentum, run.balance.linear_momentum):
        assert abs(float(error)) < 1e-8
    assert abs(work) > 0.01


def test_at_its_limit_the_moment_is_constant():
    """In the plane: until the angle is near zero, φ = φ_0 + ω_0 t - M t²/2I."""
    run = runs(Turned)["at its limit"]
    time, angle, _ = seen(run)
    short = time < 0.45
    assert_allclose(angle[short], ANGLE + SPIN * time[short] - 0.1 / INERTIA * time[short] ** 2, atol=1e-8)
    assert float(run.maxima["control_moment"]) == pytest.approx(0.2, rel=1e-9) and np.sum(short) > 2


@pytest.mark.slow
def test_in_space_each_axis_of_the_body_has_its_own_limit():
    """At one instant, by NumPy: -M tanh((k φ + c ω)/M) about the body's axes, in which φ is as in inertial ones."""
    rng = np.random.default_rng(2)
    turn = Rotation.from_rotvec([0.9, -0.4, 1.1])
    q, v = jnp.asarray([0.0, 0.0, 0.0, *turn.as_quat(scalar_first=True)]), jnp.asarray(rng.normal(size=6))
    control = AttitudeControl(0, STIFFNESS, DAMPING, 3.0)
    system = System((Body(MASS, (0.2, 0.3, 0.4)),), basis=SPACE)
    made = Assembled(system, q, v, (control,), energy_size=1.0, momentum_size=1.0)
    state, active = made.start()
    at = made.evaluate(state)
    found = control.loads(at.elements[0], active)[0].moment
    own = turn.inv().apply(np.array(v[3:]))
    expected = turn.apply(-3.0 * np.tanh((STIFFNESS * turn.as_rotvec() + DAMPING * own) / 3.0))
    assert_allclose([*found], expected, rtol=1e-12)
    rate = made.derivative(0.0, state, active)
    momenta = jax.jvp(made.momentum, (state,), (rate,))[1]
    energy = jax.jvp(lambda y: made.energy_at(made.evaluate(y), active).total, (state,), (rate,))[1]
    assert_allclose([*momenta[0], *momenta[1], energy], 0.0, atol=1e-12)
    # For implicit steps: how the moment answers to the spin.
    free = lambda w: system.motion(system.kinematics(q, w)).acceleration  # noqa: E731
    acting = lambda w: made.derivative(0.0, state.at[7:13].set(w), active)[7:13]  # noqa: E731
    slopes = np.asarray(jax.jit(lambda w: jax.jacfwd(acting)(w) - jax.jacfwd(free)(w))(v))
    stiff = made.linearisation(0.0, state, active)
    linear = -np.asarray(stiff.response) @ np.asarray(stiff.damping) @ np.asarray(stiff.directions).T
    assert_allclose(linear, slopes, atol=1e-10)


@BOTH
def test_it_ends_at_the_first_touchdown(design):
    """With its limit far below what it would need, the spin falls evenly until the ball touches, and stays then."""
    run = runs(design)["touchdown"]
    time, spin = spun(run)
    before, after = time <= TOUCHES + 1e-9, time >= TOUCHES - 1e-9
    assert float(run.impacts.time[0]) == pytest.approx(TOUCHES, rel=1e-6)
    slope = -LIMIT / INERTIA
    assert_allclose(spin[before], slope * time[before], atol=1e-7)
    assert_allclose(spin[after], slope * TOUCHES, atol=1e-6)
    assert time[-1] == pytest.approx(DURATION)
    assert abs(float(run.balance.energy)) < 1e-7 and abs(float(run.balance.angular_momentum)) < 1e-8


def spun(run):
    """Time, and by how much the spin has changed: in space about the body's x axis, since one moment about each of the
    axes of a body with equal moments of inertia changes the spin about each evenly."""
    time, position, velocity = (np.array(it) for it in (run.history.time, run.history.position, run.history.velocity))
    if position.shape[-1] == 3:
        return time, velocity[:, 0, 2] - velocity[0, 0, 2]
    turns = Rotation.from_rotvec(position[:, 0, 3:])
    spin = turns.inv().apply(velocity[:, 0, 3:])[:, 0]
    return time, spin - spin[0]


@BOTH
def test_a_start_in_contact_has_none_of_it(design):
    _, spin = spun(runs(design)["in contact"])
    assert_allclose(spin, 0.0, atol=1e-9)
