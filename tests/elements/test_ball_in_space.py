"""A ball in a surface of revolution, on moving bodies of space."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import jaxbuffer as jb
from in_short import quick
from jaxbuffer.contact import BallPair, KelvinVoigt, RegularisedCoulomb, Revolved, Segment
from jaxbuffer.contact.laws import HuntCrossley
from jaxbuffer.elements import BallContact
from jaxbuffer.errors import InputError
from jaxbuffer.fields import POSITIVE, Part, number
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.mechanism import Defaults, Mechanism
from jaxbuffer.multibody import GROUND, AppliedForce, Body, Kinematics, System
from jaxbuffer.space import SPACE
from registration import registered

RADIUS, MOUTH, SLOPE = 0.3, (-0.4, 0.9), 0.7  # m; where the cone's meridian ends, and its angle to the axis
START = (0.2, MOUTH[1] - 0.6 * np.tan(SLOPE))
POINT, ORIGIN = (0.1, -0.2, 0.05), (-0.1, 0.3, 0.2)  # of the ball on its body, of the cone on its own
MASSES, MOMENTS = (2.0, 3.0), ((0.1, 0.2, 0.25), (0.3, 0.5, 0.45))


def cone(friction=0.3):
    meridian = Segment(*START, -np.cos(SLOPE), np.sin(SLOPE), 0.6 / np.cos(SLOPE))
    return BallPair(RADIUS, Revolved(meridian), -1.0, HuntCrossley(1e4, 0.7), RegularisedCoulomb(friction, 0.1))


def contact(spin_inertia=None):
    return BallContact(0, 1, cone(), POINT, ORIGIN, spin_inertia=spin_inertia)


def moving(seed, slant=0.5, depth=0.01, inside=True):
    """Positions and velocities of both bodies, the ball pressed into the cone by a depth, or far beyond an end."""
    rng = np.random.default_rng(seed)
    turns, azimuth = Rotation.random(2, rng=rng), rng.uniform(0.0, 2.0 * np.pi)
    along, inward = np.array([-np.cos(SLOPE), np.sin(SLOPE)]), -np.array([np.sin(SLOPE), np.cos(SLOPE)])
    x, r = np.array(START) + slant * along + (RADIUS - depth) * inward
    place = np.array([x, r * np.cos(azimuth), r * np.sin(azimuth)])
    at = rng.normal(size=3)
    centre = at + turns[1].apply(np.array(ORIGIN) + place)
    bodies = (centre - turns[0].apply(POINT), turns[0]), (at, turns[1])
    q = np.concatenate([np.append(origin, turn.as_quat(scalar_first=True)) for origin, turn in bodies])
    return jnp.asarray(q), jnp.asarray(rng.normal(size=12)), centre


def mechanism(element, seed=0, **where):
    q, v, _ = moving(seed, **where)
    return between_two_bodies(element, q, v)


@eqx.filter_jit
def between_two_bodies(element, q, v):
    """The mechanism of a contact."""
    system = System(tuple(Body(m, i) for m, i in zip(MASSES, MOMENTS, strict=True)), basis=SPACE)
    return Assembled(system, q, v, (element,), energy_size=1.0, momentum_size=1.0)


def conserved(assembled, state, active):
    """Rates of both momenta and of all energies together [N, N m, W]."""
    rate = assembled.derivative(0.0, state, active)
    momenta = jax.jvp(assembled.momentum, (state,), (rate,))[1]
    energy = lambda y: assembled.energy_at(assembled.evaluate(y), active).total  # noqa: E731
    return [*momenta[0], *momenta[1], jax.jvp(energy, (state,), (rate,))[1]]


@eqx.filter_jit
def approaches(element, q, v):
    """Gap, normal and speeds of the contact at positions and velocities in space."""
    return element.evaluate(Kinematics(q, v, basis=SPACE)).approach


@eqx.filter_jit
def turning(assembled, seed=5):
    """The start, a free ball spinning about all axes."""
    state, _ = assembled.start()
    spins = np.random.default_rng(seed).normal(size=assembled.spins)
    return state.at[assembled.layout.places["spins"]].set(spins)


@eqx.filter_jit  # once for all states of a mechanism
def pressed(assembled):
    """Gap, normal and speeds, the forces of the contact while it is closed, and what is conserved, at the start."""
    state, active = turning(assembled), jnp.ones(1)
    at = assembled.evaluate(state)
    forces = assembled.contact_forces(at, active)[0]
    return at.elements[0].approach, forces, conserved(assembled, state, active)


@pytest.mark.parametrize("spin_inertia", [None, 0.07], ids=["fixed", "free"])
@pytest.mark.parametrize("seed", quick(range(3), 0))
def test_forces_conserve_momenta_and_energy(seed, spin_inertia):
    approach, forces, rates = pressed(mechanism(contact(spin_inertia), seed))
    assert float(approach.gap[0]) == pytest.approx(-0.01, rel=1e-9)
    assert float(forces.normal[0]) > 3.0 and abs(float(forces.friction[0])) > 1.0
    assert_allclose(rates, 0.0, atol=1e-10)


def by_search(q, centre):
    """The nearest point of the cone, of all its points, in inertial axes."""
    turn = Rotation.from_quat(np.array(q[10:14]), scalar_first=True)
    along, length = np.array([-np.cos(SLOPE), np.sin(SLOPE)]), 0.6 / np.cos(SLOPE)

    def place(u):
        x, r = np.array(START) + length * u[0] * along
        local = np.array([x, r * np.cos(u[1]), r * np.sin(u[1])])
        return np.array(q[7:10]) + turn.apply(np.array(ORIGIN) + local)

    away = lambda u: np.sum((place(u) - centre) ** 2)  # noqa: E731
    starts = [(u, phi) for u in (0.1, 0.5, 0.9) for phi in (0.0, 2.0, 4.0)]
    bounds = [(0.0, 1.0), (None, None)]
    runs = [minimize(away, start, bounds=bounds, method="L-BFGS-B", tol=1e-18) for start in starts]
    return place(min(runs, key=lambda it: it.fun).x)


@pytest.mark.parametrize(("slant", "depth"), [(0.5, 0.01), (0.3, -0.1), (0.95, -0.2), (-0.2, -0.1)])
def test_the_foot_is_the_nearest_point_and_speeds_are_those_of_the_material_there(slant, depth):
    """On the cone and beyond its ends."""
    q, v, centre = moving(2, slant, depth)
    foot = by_search(q, centre)
    q, v = np.asarray(q), np.asarray(v)
    approach = jax.tree.map(np.asarray, approaches(contact(), q, v))
    distance = np.linalg.norm(centre - foot)
    normal = (centre - foot) / distance
    assert_allclose(approach.gap, distance - RADIUS, atol=1e-9)
    assert_allclose([part[0] for part in approach.normal], normal, atol=1e-6)
    # Each body's material at the foot, by v + ω × arm.
    first, second = (v[k : k + 3] + np.cross(v[k + 3 : k + 6], foot - q[i : i + 3]) for k, i in ((0, 0), (6, 7)))
    relative = first - second
    across = relative - relative @ normal * normal
    assert_allclose(approach.approach_speed, -relative @ normal, atol=1e-5)
    assert_allclose(approach.slip, np.linalg.norm(across), atol=1e-5)
    assert_allclose([part[0] for part in approach.tangent], across / np.linalg.norm(across), atol=1e-5)


@eqx.filter_jit
def closing(assembled):
    """The rate of the gap and the speed of approach at the start."""
    state, _ = assembled.start()
    rate = jax.jvp(assembled.gaps, (state,), (assembled.moving(state),))[1]
    return rate, assembled.gaps_at(assembled.evaluate(state))[1]


@pytest.mark.parametrize("seed", range(3))
def test_the_gap_closes_at_the_approach_speed(seed):
    rate, speed = closing(mechanism(contact(), seed))
    assert_allclose(-np.asarray(rate), speed, rtol=1e-12)


def test_in_one_plane_it_is_the_ball_on_a_flank():
    """The cone's meridian above its axis, everything in the plane z = 0: gap, speeds and loads are the plane's."""
    meridian, numbers = cone().shape.meridian, dict(radius=RADIUS, side=-1.0, law=cone().law, friction=cone().friction)
    flat = BallContact(0, 1, BallPair(shape=meridian, **numbers), POINT[:2], ORIGIN[:2])
    round_ = BallContact(0, 1, cone(), (*POINT[:2], 0.0), (*ORIGIN[:2], 0.0))
    angles, places = (0.4, -0.3), ((-0.15, 0.75), (0.0, 0.0))
    v = np.random.default_rng(3).normal(size=6)
    turned = [(np.cos(a / 2), 0.0, 0.0, np.sin(a / 2)) for a in angles]
    q3 = np.concatenate([[*p, 0.0, *turn] for p, turn in zip(places, turned, strict=True)])
    v3 = np.concatenate([[*v[k : k + 2], 0.0, 0.0, 0.0, v[k + 2]] for k in (0, 3)])
    q2 = np.concatenate([[*p, a] for p, a in zip(places, angles, strict=True)])

    @jax.jit
    def pressed(q2, v2, q3, v3):
        at2, at3 = flat.evaluate(Kinematics(q2, v2)), round_.evaluate(Kinematics(q3, v3, basis=SPACE))
        return at2, at3, flat.loads(at2, jnp.ones(1)), round_.loads(at3, jnp.ones(1))

    at2, at3, loads2, loads3 = jax.tree.map(np.asarray, pressed(q2, v, q3, v3))
    for name in ("gap", "approach_speed", "distance"):
        assert_allclose(getattr(at3.approach, name), getattr(at2.approach, name), rtol=1e-13)
    assert_allclose(at3.approach.slip, abs(at2.approach.slip), rtol=1e-13)
    assert float(at2.approach.gap[0]) < -0.01
    for one, other in zip(loads2, loads3, strict=True):
        assert_allclose([*other.force], [*one.force, 0.0], rtol=1e-12, atol=1e-13)
        assert_allclose([*other.moment], [0.0, 0.0, one.moment], rtol=1e-12, atol=1e-12)


def test_on_the_axis_all_is_finite():
    """There any direction will do: the gap is that of all of them, and nothing is NaN, nor any slope."""
    meridian = cone().shape.meridian

    def gap(place):
        q = jnp.concatenate([place, jnp.array([1.0, 0.0, 0.0, 0.0])])
        element = BallContact(0, GROUND, cone())
        at = element.evaluate(Kinematics(q, jnp.zeros(6), basis=SPACE))
        loads = element.loads(at, jnp.ones(1))
        return at.approach.gap[0], jnp.stack([*loads[0].force, *loads[0].moment, *loads[1].moment])

    place = np.array([-0.1, 0.0, 0.0])
    distance = jax.jit(lambda: meridian.foot(-0.1, 0.0, -1.0, RADIUS).distance)()
    at, *slopes = jax.jit(lambda x: (gap(x), jax.jacfwd(gap)(x), jax.jacrev(gap)(x)))(place)
    assert float(at[0]) == pytest.approx(float(distance) - RADIUS, rel=1e-14)
    for leaf in jax.tree.leaves((at, slopes)):
        assert np.all(np.isfinite(leaf))
    beside = jax.jit(gap)(place + np.array([0.0, 1e-9, 1e-9]))[0]
    assert float(beside) == pytest.approx(float(at[0]), abs=2e-9)


@pytest.mark.slow
@pytest.mark.parametrize("spin_inertia", [None, 0.07], ids=["fixed", "free"])
def test_the_stiff_part_is_that_of_the_equations(spin_inertia):
    """What the contact makes of the accelerations' Jacobian by velocities, friction across the slip included."""
    assembled = mechanism(contact(spin_inertia))
    state = turning(assembled)
    own = slice(assembled.coordinates, assembled.coordinates + 12 + assembled.spins)

    @jax.jit
    def slopes(active):
        of = lambda w: assembled.derivative(0.0, state.at[own].set(w), jnp.full(1, active))[own]  # noqa: E731
        return jax.jacfwd(of)(state[own])

    @jax.jit
    def stiff_part(state):
        """Response, damping and directions, the speeds that it resists, and how the contact is approached."""
        stiff = assembled.linearisation(0.0, state, jnp.ones(1))
        approach = assembled.evaluate(state).elements[0].approach
        return stiff.response, stiff.damping, stiff.directions, stiff.directions.T @ state[own], approach

    response, damping, directions, speeds, at = jax.tree.map(np.asarray, stiff_part(state))
    found = -response @ damping @ directions.T
    expected = np.asarray(slopes(1.0)) - np.asarray(slopes(0.0))
    assert_allclose(found, expected, atol=1e-9 * np.max(np.abs(expected)))
    # Springs, here friction across, come first; across the slip nothing slips.
    assert_allclose(speeds, [0.0, at.approach_speed[0], at.slip[0]], atol=1e-8)


def test_friction_has_its_slope_where_nothing_slips():
    """-μ F_n/v_s in all directions, also where the slip is zero to the last bit."""
    element = BallContact(0, GROUND, cone())
    x, r = np.array(START) + 0.5 * np.array([-np.cos(SLOPE), np.sin(SLOPE)])
    place = np.array([x, r, 0.0]) - (RADIUS - 0.01) * np.array([np.sin(SLOPE), np.cos(SLOPE), 0.0])
    q = jnp.asarray([*place, 1.0, 0.0, 0.0, 0.0])

    @jax.jit
    def force(v):
        at = element.evaluate(Kinematics(q, jnp.concatenate([v, jnp.zeros(3)]), basis=SPACE))
        return jnp.stack(element.loads(at, jnp.ones(1))[0].force)

    slope_along = jax.jit(lambda across: jax.jvp(force, (jnp.zeros(3),), (across,))[1])
    normal = np.linalg.norm(force(np.zeros(3)))
    for across in ([0.0, 0.0, 1.0], [-np.cos(SLOPE), np.sin(SLOPE), 0.0]):
        assert_allclose(slope_along(np.array(across)), -0.3 * normal / 0.1 * np.array(across), rtol=1e-6, atol=1e-6)


def test_a_shape_of_the_plane_is_refused_in_space():
    pair = BallPair(RADIUS, cone().shape.meridian, -1.0, cone().law, cone().friction)
    with pytest.raises(InputError, match="the shape of the contact 'contact' is a Segment: in the plane give"):
        mechanism(BallContact(0, 1, pair, POINT, ORIGIN))
    flat = System((Body(1.0, 1.0),) * 2)
    with pytest.raises(InputError, match="is a Revolved: in the plane give a Segment"):
        Assembled(flat, jnp.zeros(6), jnp.zeros(6), (BallContact(0, 1, cone()),))


# --- a run: a ball that slides along a round hole until it rolls -----------------------------------------------------

HOLE, WEIGHT, MASS, AXIS = 1.5, 20.0, 2.0, Rotation.from_rotvec([0.3, -0.5, 0.8])  # m, N, kg; of the hole
STIFF, OUT = 1e6, np.array([0.0, 0.6, -0.8])  # N/m; where in the hole it lies, in its axes


class Rolling(Part):
    section = "ball"
    speed: float = number(1.0, "m/s", **POSITIVE)


class RollingBall(Part):
    ball: Rolling = Rolling()


class Nothing(Part):
    section = "scenario"


def rolling(design, scenario, stabilisation=20.0):
    """A body whose ball spins freely on it lies in a round hole, pressed by its weight, and slides along its axis."""
    hole = Segment(-5.0, HOLE, 1.0, 0.0, 10.0)
    pair = BallPair(0.2, Revolved(hole), 1.0, KelvinVoigt(STIFF, 0.0), RegularisedCoulomb(0.3, 1e-3))
    down = AXIS.apply(OUT)
    system = System(
        (Body(MASS, (0.1, 0.1, 0.1)), Body(1e9, (1e9, 1e9, 1e9))),
        forces=(AppliedForce(0, tuple(WEIGHT * down)),),
        stabilisation=stabilisation,
        basis=SPACE,
    )
    turned = AXIS.as_quat(scalar_first=True)
    q = jnp.asarray([*(down * (HOLE - 0.2 + WEIGHT / STIFF)), 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, *turned])
    v = jnp.zeros(12).at[:3].set(design.ball.speed * jnp.asarray(AXIS.apply([1.0, 0.0, 0.0])))
    ball = BallContact(0, 1, pair, spin_inertia=0.4 * MASS * 0.2**2)
    return Assembled(system, q, v, (ball,), closed=jnp.ones(1), size=(1e-3, 1.0), energy_size=1.0)


@pytest.fixture(scope="module", autouse=True)
def known():
    with registered(Mechanism("ball that rolls", RollingBall, Nothing, {}, rolling, defaults=Defaults(duration=0.4))):
        yield


@pytest.mark.slow
def test_a_sliding_ball_comes_to_roll():
    """It slows down at μ g until it rolls, at 5/7 of its speed but for the depth by which it is pressed in."""
    run = jb.simulate(RollingBall(), Nothing(), rtol=1e-9, atol=1e-9, history=True)
    arm = 0.2 - WEIGHT / STIFF
    share = MASS * arm**2 / (MASS * arm**2 + 0.4 * MASS * 0.2**2)
    velocity = AXIS.inv().apply(np.array(run.history.velocity)[:, 0, :3])
    time, slowing = np.asarray(run.history.time), 0.3 * WEIGHT / MASS
    slides = time < 0.9 * (1.0 - share) / slowing
    assert_allclose(velocity[slides, 0], 1.0 - slowing * time[slides], atol=1e-6)
    assert_allclose(velocity[-1], [share, 0.0, 0.0], atol=1e-6)
    assert np.sum(slides) > 3 and float(run.history.slip[-1, 0]) < 1e-6
    lost = 0.5 * MASS - 0.5 * MASS * share**2 - 0.5 * 0.4 * MASS * 0.2**2 * (share / arm) ** 2
    assert float(run.energy.lost["friction"]) == pytest.approx(lost, rel=1e-6)
