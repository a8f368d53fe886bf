"""Runs of mechanisms of space against closed forms: a top that nothing holds, and a body on a spring."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jaxbuffer as jb
from jaxbuffer.elements import Sensor, SpringDamper
from jaxbuffer.fields import POSITIVE, Part, number
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.mechanism import Defaults, Mechanism
from jaxbuffer.mechanisms.quantity import Quantity
from jaxbuffer.mechanisms.relative_energy import rigid_energy
from jaxbuffer.mechanisms.view import Names, View
from jaxbuffer.multibody import GROUND, AxialSpringDamper, Body, System
from jaxbuffer.space import SPACE
from registration import registered

MASS, ROLL, ACROSS = 2.0, 0.05, 0.2  # kg, kg m²
TURN, SPIN = Rotation.from_rotvec([0.4, -0.7, 0.2]), np.array([9.0, 1.5, -0.8])  # of the top; its spin in its own axes
ALONG = np.array([2.0, -1.0, 2.0]) / 3.0  # of the spring
LENGTH, DAMPING = 0.7, 3.0  # m, N s/m
TIME = 1.3  # s


class Spring(Part):
    section = "spring"
    stiffness: float = number(150.0, "N/m", **POSITIVE)


class Twins(Part):
    spring: Spring = Spring()


class Thrown(Part):
    section = "scenario"
    speed: float = number(0.4, "m/s", **POSITIVE, doc="of the body on the spring, along it")


def stretch(kin, spring):
    return spring.state(kin).length - LENGTH


def bodies_of_space(design, scenario, stabilisation=20.0):
    """A top that turns freely and flies straight on, and a turning body on a spring along a skew line."""
    spring = AxialSpringDamper(GROUND, 1, (0.0, 0.0), (0.0, 0.0), design.spring.stiffness, DAMPING, LENGTH)
    moments = (ROLL, ACROSS, ACROSS)
    system = System((Body(MASS, moments), Body(MASS, moments)), stabilisation=stabilisation, basis=SPACE)
    q = jnp.asarray([0.1, 0.2, 0.3, *TURN.as_quat(scalar_first=True), *(LENGTH * ALONG), 1.0, 0.0, 0.0, 0.0])
    spins = [*TURN.apply(SPIN)], [3.0, 0.0, 0.0]
    v = jnp.concatenate([jnp.asarray([1.0, 0.0, -1.0, *spins[0]]), scenario.speed * ALONG, jnp.asarray(spins[1])])
    elements = SpringDamper(spring, name="spring"), Sensor(stretch, spring, name="stretch")
    return Assembled(system, q, v, elements=elements, size=(1e-2, 1.0), energy_size=1.0)


STRETCH = Quantity("m", lambda run: run.maxima["stretch"], "largest stretch", "stretch", swept=True, tuned=True)
VIEW = View(title="Twins", names=lambda design: Names(bodies=("top", "bob")))
TWINS = Mechanism(
    "twins of space",
    Twins,
    Thrown,
    {"stretch": STRETCH},
    bodies_of_space,
    defaults=Defaults(duration=TIME),
    view=VIEW,
)


@pytest.fixture(scope="module", autouse=True)
def known():
    with registered(TWINS):
        yield


@pytest.fixture(scope="module")
def run(known):
    return jb.simulate(Twins(), Thrown(), rtol=1e-10, atol=1e-10, history=True)


def test_a_free_top_precesses_about_its_angular_momentum(run):
    """Its axis turns about H at |H|/I across, and itself about its axis as fast as at the start."""
    momentum = TURN.apply(SPIN * [ROLL, ACROSS, ACROSS])
    time = np.asarray(run.history.time)
    assert time[-1] == pytest.approx(TIME, rel=1e-14)
    seen = Rotation.from_rotvec(np.array(run.history.position)[:, 0, 3:])
    about = Rotation.from_rotvec(np.outer(time, momentum) / ACROSS)
    np.testing.assert_allclose(seen.apply([1.0, 0.0, 0.0]), (about * TURN).apply([1.0, 0.0, 0.0]), atol=1e-7)
    # Of H the spin about the top's own axis is ROLL times it: what the precession does not turn itself goes on alone.
    own = Rotation.from_rotvec(np.outer(time, [SPIN[0] * (1.0 - ROLL / ACROSS), 0.0, 0.0]))
    np.testing.assert_allclose((seen * own.inv()).as_matrix(), (about * TURN).as_matrix(), atol=1e-7)
    place = np.array([0.1, 0.2, 0.3]) + np.outer(time, [1.0, 0.0, -1.0])
    np.testing.assert_allclose(np.asarray(run.history.position)[:, 0, :3], place, atol=1e-12)


def swing(stiffness, speed, time):
    decay = DAMPING / (2.0 * MASS)
    rate = jnp.sqrt(stiffness / MASS - decay**2)
    return speed / rate * jnp.exp(-decay * time) * jnp.sin(rate * time)


def largest_swing(stiffness, speed):
    decay = DAMPING / (2.0 * MASS)
    rate = jnp.sqrt(stiffness / MASS - decay**2)
    return swing(stiffness, speed, jnp.arctan2(rate, decay) / rate)


def test_a_body_on_a_spring_swings_along_it(run):
    time = np.asarray(run.history.time)
    place = ALONG * (LENGTH + np.asarray(swing(150.0, 0.4, time)))[:, None]
    np.testing.assert_allclose(np.asarray(run.history.position)[:, 1, :3], place, atol=1e-9)
    assert float(run.stretch) == pytest.approx(float(largest_swing(150.0, 0.4)), rel=1e-9)
    energy = run.energy
    assert abs(float(run.balance.energy)) < 1e-9 and float(energy.lost["damper"]) > 0.05
    top = 0.5 * float(np.sum(np.array([ROLL, ACROSS, ACROSS]) * SPIN**2)) + 0.5 * MASS * 2.0
    assert float(energy.total) == pytest.approx(top + 0.5 * MASS * 0.4**2 + 0.5 * ROLL * 9.0, rel=1e-12)


def test_tables_name_what_there_is_of_space(run):
    columns = run.to_dataframe().columns
    assert "top position z [m]" in columns and "bob velocity spin_x [rad/s]" in columns, list(columns)
    assert "rotation_z" in " ".join(columns) and "velocity [m/s, m/s, m/s, rad/s" in repr(run.history)


def test_the_largest_stretch_has_the_slopes_of_the_closed_form():
    def of(numbers):
        design = jb.replace(Twins(), {"spring.stiffness": numbers[0]})
        return jb.simulate(design, Thrown(speed=numbers[1]), rtol=1e-10, atol=1e-10).stretch

    numbers = jnp.array([150.0, 0.4])
    np.testing.assert_allclose(jax.jacfwd(of)(numbers), jax.grad(lambda n: largest_swing(*n))(numbers), rtol=1e-7)


@eqx.filter_jit
def energies(system, q, v, spins=()):
    """As a rigid body, and the kinetic energy [J]."""
    kin, spins = system.kinematics(q, v), [(inertia, SPACE.turn(*spin)) for inertia, spin in spins]
    return rigid_energy(system, kin, spins), system.kinetic_energy(kin)


@pytest.mark.quick
def test_the_energy_of_the_whole_as_a_rigid_body_is_that_of_one_body():
    """Three bodies that move as one: their kinetic energy; and of any motion ½ P²/M + ½ H·J⁻¹H by NumPy."""
    rng = np.random.default_rng(1)
    masses, moments = [1.0, 2.5, 0.7], [(0.2, 0.3, 0.4), (0.1, 0.5, 0.45), (0.3, 0.3, 0.2)]
    system = System(tuple(Body(m, i) for m, i in zip(masses, moments, strict=True)), basis=SPACE)
    places, turns = rng.normal(size=(3, 3)), Rotation.random(3, rng=rng)
    q = np.concatenate([np.append(p, t.as_quat(scalar_first=True)) for p, t in zip(places, turns)])  # noqa: B905
    velocity, spin = rng.normal(size=(2, 3))
    together = np.concatenate([np.append(velocity + np.cross(spin, place), spin) for place in places])
    rigid, kinetic = energies(system, q, together)
    assert float(rigid) == pytest.approx(float(kinetic), rel=1e-12)

    v, ball = rng.normal(size=(3, 6)), (0.3, rng.normal(size=3))
    centre = np.average(places, axis=0, weights=masses)
    inertia, momentum = ball[0] * np.eye(3), ball[0] * ball[1]
    for m, i, place, turn, (*u, x, y, z) in zip(masses, moments, places, turns.as_matrix(), v, strict=True):
        own, arm = turn @ np.diag(i) @ turn.T, place - centre
        inertia = inertia + own + m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        momentum = momentum + own @ [x, y, z] + m * np.cross(arm, u)
    linear = np.array(masses) @ v[:, :3]
    expected = 0.5 * linear @ linear / sum(masses) + 0.5 * momentum @ np.linalg.solve(inertia, momentum)
    rigid, _ = energies(system, q, v.ravel(), (ball,))
    assert float(rigid) == pytest.approx(expected, rel=1e-12)
