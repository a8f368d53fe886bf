"""Elements between free bodies of space: what they conserve, their stiff part, and runs against closed forms."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import jaxbuffer as jb
from jaxbuffer.contact import KelvinVoigt
from jaxbuffer.elements import Buffer, BufferForce, EndStop, Latch, Oscillators, Sensor, SpringDamper, Thrust
from jaxbuffer.fields import POSITIVE, Part, number
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.mechanism import Defaults, Mechanism
from jaxbuffer.multibody import GROUND, AxialSpringDamper, Body, System, TorsionalSpringDamper
from jaxbuffer.space import SPACE
from registration import registered

RNG = np.random.default_rng(4)
TURNS = Rotation.from_rotvec([[0.1, -0.3, 0.2], [0.4, 0.2, -0.1], [-0.2, 0.5, 0.3]])
PLACES = np.array([[0.0, 0.0, 0.1], [1.0, 0.2, -0.1], [0.5, 1.0, 0.4]])
Q = jnp.asarray(np.concatenate([np.append(p, t.as_quat(scalar_first=True)) for p, t in zip(PLACES, TURNS)]))  # noqa: B905
V = jnp.asarray(0.3 * RNG.normal(size=18))
AXIAL = AxialSpringDamper(0, 1, (0.1, 0.0, 0.05), (-0.1, 0.02, 0.0), 300.0, 4.0, free_length=0.9)
REAL = BufferForce(1, 2, (0.0, 0.1), (0.0, -0.1, 0.1), 200.0, 3.0, 1.2, preload=2.0, quadratic=5.0, friction=0.4)
STOPS = (
    EndStop(AXIAL, KelvinVoigt(1e4, 20.0), 0.05),
    EndStop(AXIAL, KelvinVoigt(2e4, 10.0), 0.01, rebound=True, name="rebound"),
)
LATCH = Latch(
    2,
    1,
    (0.1, 0.0, -0.1),
    plane=0.3,
    seat=(0.2, 0.1, -0.05),
    stiffness=50.0,
    damping=2.0,
    turn_stiffness=3.0,
    turn_damping=0.4,
    preload=1.0,
)
ELEMENTS = {
    "buffer": (Buffer(AXIAL),),
    "real buffer": (Buffer(REAL, name="real", lost_in="damper"),),
    "stops": STOPS,
    "latch": (LATCH,),
    "thrust": (Thrust(1, 7.0, 2.0, axis=(0.48, 0.6, 0.64)),),
    "torsional spring": (SpringDamper(TorsionalSpringDamper(0, 2, 5.0, 0.3)),),
    "all": (
        Buffer(AXIAL),
        *STOPS,
        LATCH,
        Thrust(1, 7.0, 2.0),
        SpringDamper(TorsionalSpringDamper(0, 2, 5.0, 0.3)),
        Oscillators((0, 2), (3.0, 8.0), ("first", "second")),
    ),
}
SYSTEM = System((Body(2.0, (0.2, 0.3, 0.35)), Body(3.0, (0.4, 0.5, 0.6)), Body(1.0, (0.1, 0.1, 0.15))), basis=SPACE)


def mechanism(elements):
    return Assembled(SYSTEM, Q, V, elements, energy_size=1.0, momentum_size=1.0)


def closing(assembled):
    """The start with its latch half closed, and all switches closed."""
    state, _ = assembled.start()
    for k, element in enumerate(assembled.elements):
        if isinstance(element, Latch):
            state = state.at[assembled.layout.places[f"element {k}"].start].set(0.4)
    return state, jnp.asarray([float(name != "thrust over") for name in assembled.contact_names])


@eqx.filter_jit
def conserved(name):
    """Rates of both momenta less what came from outside, and of all energies together [N, N m, W], of elements that are
    closing, and the largest rate of a velocity there."""
    assembled = mechanism(ELEMENTS[name])
    state, active = closing(assembled)
    rate = assembled.derivative(0.0, state, active)
    momenta = jax.jvp(assembled.momentum, (state,), (rate,))[1]
    energy = jax.jvp(lambda y: assembled.energy_at(assembled.evaluate(y), active).total, (state,), (rate,))[1]
    return [*momenta[0], *momenta[1], energy], jnp.max(jnp.abs(rate[21:39]))


@pytest.mark.parametrize("name", ELEMENTS)
def test_it_acts_on_two_bodies_and_its_energies_are_its_powers(name):
    found, force = conserved(name)
    assert float(force) > 0.1
    assert_allclose(found, 0.0, atol=1e-11 * float(force) + 1e-12)


@pytest.mark.slow
def test_the_stiff_part_is_that_of_the_equations():
    """What buffer, stops and latch make of the accelerations' Jacobian by velocities, and nothing geometric."""
    assembled = mechanism((Buffer(AXIAL), *STOPS, LATCH))
    state, active = closing(assembled)

    def acting(w):
        return assembled.derivative(0.0, state.at[21:39].set(w), active)[21:39]

    free = lambda w: SYSTEM.motion(SYSTEM.kinematics(Q, w)).acceleration  # noqa: E731
    expected = np.asarray(jax.jit(lambda w: jax.jacfwd(acting)(w) - jax.jacfwd(free)(w))(V))
    stiff = assembled.linearisation(0.0, state, active)
    found = -np.asarray(stiff.response) @ np.asarray(stiff.damping) @ np.asarray(stiff.directions).T
    assert_allclose(found, expected, atol=1e-10 * np.max(np.abs(expected)))


# --- a run: one body is pushed along a skew axis, another is caught by a latch ---------------------------------------

MASS, INERTIA, SKEW = 2.0, 0.3, np.array([0.48, -0.6, 0.64])
FORCE, PUSHED, DURATION, FREQUENCY = 6.0, 0.3, 0.8, 5.0  # N, s, s, Hz
STIFF, TURN_STIFF = 800.0, 27.0  # N/m, N m/rad, of the latch
SPEED, SPIN, AXIS = 0.5, 2.0, np.array([0.6, 0.0, 0.8])


class Force(Part):
    section = "force"
    size: float = number(FORCE, "N", **POSITIVE)


class Pushed(Part):
    force: Force = Force()


class Rest(Part):
    section = "scenario"


def angle(kin, body):
    return jnp.sqrt(sum(part**2 for part in kin.basis.relative_rotation(kin.frame(GROUND), kin.frame(body))) + 1e-24)


def pushed(design, scenario, stabilisation=20.0):
    moments = (INERTIA,) * 3
    system = System((Body(MASS, moments), Body(MASS, moments)), stabilisation=stabilisation, basis=SPACE)
    tilted = Rotation.from_rotvec([0.0, 0.0, 0.5])
    q = jnp.asarray([0.0, 2.0, 0.0, *tilted.as_quat(scalar_first=True), -0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    v = jnp.zeros(12).at[6:].set(jnp.asarray([SPEED, 0.0, 0.0, *(SPIN * AXIS)]))
    axis = tuple(map(float, tilted.inv().apply(SKEW)))
    latch = Latch(1, GROUND, (0.0, 0.0), plane=-0.05, seat=(-0.05, 0.0), stiffness=STIFF, turn_stiffness=TURN_STIFF)
    elements = (
        Thrust(0, design.force.size, PUSHED, axis=axis),
        Oscillators((0,), (FREQUENCY,), ("shock",), damping=0.0),
        latch,
        Sensor(angle, 1, name="turn"),
    )
    return Assembled(system, q, v, elements=elements, size=(1e-2, 1.0), energy_size=0.1, momentum_size=1.0)


@pytest.fixture(scope="module", autouse=True)
def known():
    with registered(Mechanism("pushed in space", Pushed, Rest, {}, pushed, defaults=Defaults(duration=DURATION))):
        yield


@pytest.fixture(scope="module")
def run():
    return jb.simulate(Pushed(), Rest(), rtol=1e-10, atol=1e-10, history=True)


@pytest.mark.slow
def test_a_thrust_gives_its_impulse_and_work(run):
    speed = FORCE / MASS * PUSHED
    assert_allclose(run.history.velocity[-1, 0, :3], speed * SKEW, rtol=1e-9)
    assert float(run.energy.stored["thrust"]) == pytest.approx(-0.5 * MASS * speed**2, rel=1e-9)
    # An oscillator without damping on a base that is accelerated at once: twice the acceleration.
    assert float(run.maxima["shock"]) == pytest.approx(2.0 * FORCE / MASS, rel=1e-8)


@pytest.mark.slow
def test_latches_hold_a_body_by_its_rotation_vector(run):
    """It turns on about the axis of its spin and swings back: I φ̈ = -k_t φ, and along x about the seat."""
    time = np.asarray(run.history.time)
    caught = 0.05 / SPEED
    turned, since = SPIN * caught, time - caught
    rate = np.sqrt(TURN_STIFF / INERTIA)
    free, phi = since < 0.0, turned * np.cos(rate * since) + SPIN / rate * np.sin(rate * since)
    expected = np.where(free, SPIN * time, phi)
    seen = np.array(run.history.position)[:, 1, 3:]
    assert_allclose(seen, expected[:, None] * AXIS, atol=1e-7)
    assert float(run.maxima["turn"]) == pytest.approx(np.hypot(turned, SPIN / rate), rel=1e-8)
    along = SPEED * np.sqrt(MASS / STIFF) * np.sin(np.sqrt(STIFF / MASS) * since)
    place = np.where(free, -0.1 + SPEED * time, -0.05 + along)
    assert_allclose(np.asarray(run.history.position)[:, 1, :3], place[:, None] * [1.0, 0.0, 0.0], atol=1e-8)
    # The latches let in a spring that is turned already: that energy comes from outside.
    assert float(run.energy.stored["latch_closing"]) == pytest.approx(-0.5 * TURN_STIFF * turned**2, rel=1e-8)
    assert abs(float(run.balance.energy)) < 1e-8
