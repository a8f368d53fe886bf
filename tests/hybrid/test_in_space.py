"""The time loop in space, where positions are more numbers than velocities: a body that bounces on a point of it."""

from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from jaxbuffer.hybrid import (
    Automatic,
    DiagonallyImplicit,
    ExplicitRungeKutta,
    HybridSystem,
    Kind,
    Linearisation,
    Options,
    StepTolerance,
    solve,
)
from jaxbuffer.hybrid.hermite import cubic, state_within
from jaxbuffer.hybrid.rungekutta.newton import NewtonMatrix
from jaxbuffer.multibody import GROUND, AppliedForce, AxialSpringDamper, Body, System, load_at
from jaxbuffer.space import SPACE, Vector

MASS, MOMENTS, TIP = 0.9, (0.02, 0.05, 0.06), (0.2, 0.05, -0.1)  # kg, kg m², m
GRAVITY, STIFFNESS = 9.81, 4e4  # m/s², N/m
TURN = Rotation.from_rotvec([0.3, 0.4, -0.2])
PLACE, SPEED, SPIN = (0.1, -0.2, 0.3), (0.3, -0.1, -0.5), (1.0, -2.0, 3.0)  # of the centre; the spin in body axes
POSITIONS, VELOCITIES = 7, 6


class Bouncing(HybridSystem):
    """A body whose tip a floor pushes back with a linear spring."""

    system: System
    stiffness: jax.Array
    tip: tuple
    speed: tuple

    @property
    def coordinates(self):
        return self.system.coordinates

    @property
    def velocities(self):
        return self.system.velocities

    def position_rate(self, q):
        return self.system.position_rate(q)

    def kinematics(self, state):
        return self.system.kinematics(state[:POSITIONS], state[POSITIONS:])

    def start(self):
        q = jnp.array([*PLACE, *TURN.as_quat(scalar_first=True)])
        return jnp.concatenate([q, jnp.stack(self.speed), jnp.asarray(TURN.apply(SPIN))]), jnp.zeros(1)

    def force(self, state, active):
        return active[0] * self.stiffness * jnp.maximum(-self.gaps(state)[0], 0.0)

    def derivative(self, time, state, active):
        kin = self.kinematics(state)
        point = kin.point(0, self.tip)
        push = Vector(0.0, 0.0, self.force(state, active))
        motion = self.system.motion(kin, (load_at(point, push),))
        return jnp.concatenate([self.position_rate(kin.q).of(kin.v), motion.acceleration])

    def gaps(self, state):
        return self.kinematics(state).point(0, self.tip).place.z[None]

    def touchdown(self, state, approach_acceleration, contact):
        return state

    def terminals(self, state):
        return state[:1] - 10.0

    def observables(self, state, rate, active):
        return self.force(state, active)[None]

    def rate_observables(self):
        return (False,)

    def scales(self):
        return jnp.ones(POSITIONS + VELOCITIES)

    def impact_step(self, state):
        return jnp.asarray(1e-4)

    def linearisation(self, time, state, active):
        kin = self.kinematics(state)
        springs = self.system.springs(kin)
        if not springs:
            return Linearisation.none(VELOCITIES, POSITIONS)
        directions = jnp.stack([self.system.direction(spring.blocks) for spring in springs], axis=1)
        return Linearisation(
            directions=directions,
            response=self.system.response(kin, directions),
            stiffness=jnp.diag(jnp.stack([jnp.asarray(spring.stiffness) for spring in springs])),
            damping=jnp.diag(jnp.stack([jnp.asarray(spring.damping) for spring in springs])),
            coordinates=POSITIONS,
            position_rate=self.position_rate(kin.q),
        )


def bouncing(stiffness=STIFFNESS, tip=TIP, speed=SPEED, spring=()):
    weight = AppliedForce(0, (0.0, 0.0, -GRAVITY * MASS))
    system = System((Body(MASS, MOMENTS),), (), (weight, *spring), basis=SPACE)
    return Bouncing(system, jnp.asarray(stiffness), tuple(map(jnp.asarray, tip)), tuple(map(jnp.asarray, speed)))


@eqx.filter_jit
def run(system, duration, solver, tolerance=1e-10):
    options = Options(solver=solver, tolerance=StepTolerance(tolerance, tolerance), event_time=1e-11, max_events=64)
    return solve(lambda system: system, (system,), duration, options)


def by_scipy(duration, stiffness=STIFFNESS, tip=TIP, speed=SPEED):
    """Events of the same motion, as (what, time, force), and its end, with a rotation matrix and body axes' spins."""
    tip, moments = np.array(tip), np.array(MOMENTS)

    def gap(_, y):
        return y[2] + y[6:15].reshape(3, 3)[2] @ tip

    def gap_rate(_, y):
        return y[5] + y[6:15].reshape(3, 3)[2] @ np.cross(y[15:], tip)

    def rates(t, y, touching):
        turn, spin = y[6:15].reshape(3, 3), y[15:]
        push = np.array([0.0, 0.0, -touching * stiffness * gap(t, y)])
        x, y_, z = spin
        turning = turn @ np.array([[0, -z, y_], [z, 0, -x], [-y_, x, 0]])
        moment = np.cross(tip, turn.T @ push)
        force = push - [0.0, 0.0, GRAVITY * MASS]
        spun = (moment + np.cross(moments * spin, spin)) / moments
        return np.concatenate([y[3:6], force / MASS, turning.ravel(), spun])

    gap.terminal, gap_rate.direction = True, 1.0
    y, time, touching, events = np.concatenate([PLACE, speed, TURN.as_matrix().ravel(), SPIN]), 0.0, 0.0, []
    while time < duration:
        gap.direction = 1.0 if touching else -1.0
        field = partial(rates, touching=touching)
        part = solve_ivp(field, (time, duration), y, "DOP853", events=(gap, gap_rate), rtol=1e-13, atol=1e-14)
        if touching:
            events += [
                (Kind.PEAK, t, -stiffness * gap(t, at))
                for t, at in zip(part.t_events[1], part.y_events[1], strict=True)
            ]
        time, y = part.t[-1], part.y[:, -1]
        if len(part.t_events[0]):
            events.append((Kind.RELEASE if touching else Kind.TOUCHDOWN, time, 0.0))
            touching = 1.0 - touching
    return events, y


DURATION = 0.6
NUMBERS = np.array([STIFFNESS, *TIP, *SPEED])


@eqx.filter_jit
def log_of(numbers):
    """The events of a run with other numbers."""
    return run(bouncing(numbers[0], tuple(numbers[1:4]), tuple(numbers[4:])), DURATION, ExplicitRungeKutta()).log


def read(numbers):
    """Times of the first touchdown, peak and release, and the force at the peak."""
    log = log_of(numbers)
    return jnp.append(log.time[:3], log.values[1, 0])


@pytest.mark.slow
def test_impacts_are_those_of_scipy():
    """Every touchdown, peak and release, and the end, with three or more bounces."""
    events, end = by_scipy(DURATION)
    log = jax.tree.map(np.asarray, log_of(NUMBERS))
    count = int(log.count)
    assert [int(kind) for kind in log.kind[: count - 1]] == [int(kind) for kind, _, _ in events]
    assert sum(kind == Kind.TOUCHDOWN for kind, _, _ in events) >= 3
    np.testing.assert_allclose(log.time[: count - 1], [time for _, time, _ in events], atol=1e-8)
    peaks = [k for k, (kind, _, _) in enumerate(events) if kind == Kind.PEAK]
    np.testing.assert_allclose(log.values[np.array(peaks), 0], [events[k][2] for k in peaks], rtol=1e-7)
    last = log.rows[count - 1, 0]
    np.testing.assert_allclose(last[:3], end[:3], atol=1e-7)
    np.testing.assert_allclose(
        Rotation.from_quat(np.array(last[3:7]), scalar_first=True).as_matrix(), end[6:15].reshape(3, 3), atol=1e-6
    )
    np.testing.assert_allclose(np.linalg.norm(last[3:7]), 1.0, atol=1e-9)


@pytest.mark.slow
def test_derivatives_are_those_of_differences():
    """Times and force of the first impact by stiffness, tip and speed: tangents against SciPy's differences."""

    def by_differences(numbers):
        events, _ = by_scipy(0.25, numbers[0], numbers[1:4], numbers[4:])
        return np.array([*(time for _, time, _ in events[:3]), events[1][2]])

    value, found = by_differences(NUMBERS), np.asarray(jax.jit(jax.jacfwd(read))(NUMBERS))
    np.testing.assert_allclose(read(NUMBERS), value, rtol=1e-8)
    for k, number in enumerate(NUMBERS):
        size = max(abs(number), 0.1)
        sides = [by_differences(NUMBERS + sign * 1e-5 * size * np.eye(7)[k]) for sign in (1.0, -1.0)]
        # relative to the number and to the value: some slopes are zero, as of a touchdown's time by the stiffness
        slope, elasticity = (sides[0] - sides[1]) / 2e-5 / value, size * found[:, k] / value
        np.testing.assert_allclose(elasticity, slope, rtol=1e-5, atol=1e-7)


def stiffly_held():
    """Held by a stiff, well damped spring between a point of the body and one above."""
    top = tuple(np.asarray(PLACE) + TURN.apply([0.1, 0.2, 0.0]) + [0.0, 0.1, 1.0])
    spring = AxialSpringDamper(GROUND, 0, top, (0.1, 0.2, 0.0), 3e7, 2e4, 0.95)
    return bouncing(tip=(0.0, 0.0, 5.0), speed=(0.1, 0.2, 0.0), spring=(spring,))


@pytest.mark.slow
def test_implicit_steps_pass_over_a_stiff_spring():
    """Newton's matrix knows how quaternions move: few steps, and the end of explicit ones."""
    ends, steps = {}, {}
    for name, solver in {"explicit": ExplicitRungeKutta(), "automatic": Automatic()}.items():
        result = run(stiffly_held(), 0.3, solver, 1e-5)
        ends[name], steps[name] = np.asarray(result.log.rows[int(result.log.count) - 1, 0]), int(result.attempts)
    assert steps["automatic"] < 0.3 * steps["explicit"], steps
    np.testing.assert_allclose(ends["automatic"], ends["explicit"], atol=2e-5)


@pytest.mark.slow
def test_the_loop_stays_one_kernel():
    """XLA leaves out any loop that holds a call into a library."""
    program = run.lower(stiffly_held(), 0.1, DiagonallyImplicit(), 1e-7).compile().compiled.as_text()
    inside = [line for line in program.splitlines() if "/while/" in line]
    assert len(inside) > 100
    for forbidden in (" custom-call(", " dot(", " scatter(", " fft(", " sort("):
        assert not [line for line in inside if forbidden in line]


@pytest.mark.slow
def test_newtons_matrix_solves_with_the_stiff_part():
    """(I - shift J) u = r with J by its definition, of positions that are more than velocities; two columns."""
    right, shift = np.random.default_rng(0).normal(size=(13, 2)), 1e-4

    @jax.jit
    def solved(right, shift):
        """The stiff part's factors, the matrices from velocities to rates of positions and back, and u."""
        system = stiffly_held()
        state = system.start()[0]
        stiff, rate = system.linearisation(0.0, state, jnp.zeros(1)), system.position_rate(state[:7])
        n_of = jnp.stack([rate.of(unit) for unit in jnp.eye(6)], axis=1)
        back = jnp.stack([rate.velocity(unit) for unit in jnp.eye(7)], axis=1)
        factors = stiff.directions, stiff.response, stiff.stiffness, stiff.damping
        return factors, n_of, back, NewtonMatrix.of(stiff, shift).solve(right)

    (directions, response, stiffness, damping), n_of, back, found = jax.tree.map(np.asarray, solved(right, shift))
    force, damped = stiffness @ directions.T @ back, damping @ directions.T
    jacobian = np.block([[np.zeros((7, 7)), n_of], [-response @ force, -response @ damped]])
    # what changes a quaternion's size alone is in no force, and stays
    expected = np.linalg.solve(np.eye(13) - shift * jacobian, right)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12)


def test_the_state_within_a_step_is_of_fifth_order():
    """A free body that tumbles: positions and velocities from both ends of a step, against ends by SciPy; a cubic of
    all numbers is of fourth order."""
    system = bouncing(speed=(0.0, 0.0, 0.0))
    rate_of = jax.jit(lambda state: system.derivative(0.0, state, jnp.zeros(1)))
    fifth = jax.jit(lambda start, end, step: state_within(system, start, end, step, 0.4))

    def after(time):
        """The state and its rate."""
        y = by_scipy(time, speed=(0.0, 0.0, 5.0))[1]
        turn = Rotation.from_matrix(y[6:15].reshape(3, 3))
        quaternion = turn.as_quat(scalar_first=True)
        quaternion = quaternion * np.sign(quaternion[0])
        state = np.array([*y[:3], *quaternion, *y[3:6], *turn.apply(y[15:])])
        return state, np.asarray(rate_of(state))

    errors, cubics = [], []
    for step in (0.1, 0.05):
        start, end, middle = after(0.02), after(0.02 + step), after(0.02 + 0.4 * step)[0]
        errors.append(np.max(np.abs(fifth(start, end, step) - middle)))
        cubics.append(np.max(np.abs(cubic(start[0], end[0], step * start[1], step * end[1], 0.4) - middle)))
    assert 4.7 < np.log2(errors[0] / errors[1]) < 6.5, errors
    assert errors[1] < 0.1 * cubics[1]


def test_the_position_acceleration_is_the_rate_of_the_position_rate():
    """By central differences along the motion."""
    step = 1e-5

    @jax.jit
    def both(system):
        state = system.start()[0]
        rate = system.derivative(0.0, state, jnp.zeros(1))
        sides = [state + sign * step * rate for sign in (1.0, -1.0)]
        ahead, behind = (system.position_rate(side[:7]).of(side[7:]) for side in sides)
        return system.position_acceleration(state, rate), (ahead - behind) / (2 * step)

    np.testing.assert_allclose(*both(bouncing()), atol=1e-8)
