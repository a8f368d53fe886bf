"""Every element in a mechanism that is not the docking probe: two free bodies and a third that nothing holds."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from jaxbuffer import InputError
from jaxbuffer.contact import BallPair, Hole, KelvinVoigt, RegularisedCoulomb, Segment
from jaxbuffer.contact.laws import Hertz, HuntCrossley
from jaxbuffer.elements import (
    AttitudeControl,
    BallContact,
    Buffer,
    BufferForce,
    Drive,
    EndStop,
    Integral,
    Latch,
    Motor,
    Oscillators,
    Pin,
    Sensor,
    SpringDamper,
    Thrust,
    deepest,
)
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.multibody import AxialSpringDamper, Body, DrivenAngle, Revolute, System, TorsionalSpringDamper

Q = jnp.array([0.0, 0.0, 0.1, 1.0, 0.2, -0.05, 0.5, 1.0, 0.3])
V = jnp.array([0.2, -0.1, 0.3, -0.1, 0.15, -0.2, 0.05, -0.3, 0.4])
AXIAL = AxialSpringDamper(0, 1, (0.1, 0.0), (-0.1, 0.0), 300.0, 4.0, free_length=0.9)
REAL = BufferForce(1, 2, (0.0, 0.1), (0.0, -0.1), 200.0, 3.0, 0.85, preload=2.0, quadratic=5.0, friction=0.4)
STOPS = (
    EndStop(AXIAL, KelvinVoigt(1e4, 20.0), 0.05),
    EndStop(AXIAL, KelvinVoigt(2e4, 10.0), 0.01, rebound=True, name="rebound"),
)
LATCH = Latch(
    2, 1, (0.1, 0.0), plane=0.3, seat=(0.2, 0.1), stiffness=50.0, damping=2.0, turn_stiffness=3.0, preload=1.0
)
BUSH = BallPair(0.02, Hole(0.0, 0.0, 0.021), jnp.ones(1), Hertz(1e5), RegularisedCoulomb(0.0, 1.0))
PIN = Pin(BallContact(0, 2, BUSH, (0.3, 0.2), (-0.2, -0.6)))


def faster(time):
    """The angle of the third body against the first: that of the start, and then faster and faster."""
    return 0.2 + 0.1 * time + 3.0 * time**2


DRIVE = Drive(DrivenAngle(0, 2, faster))
MOTOR = Motor(1, 7.0, 4.0, carrier=0, angle=-0.1)
ELEMENTS = {
    "buffer": (Buffer(AXIAL),),
    "real buffer": (Buffer(REAL, name="real", lost_in="damper"),),
    "stops": STOPS,
    "latch": (LATCH,),
    "thrust": (Thrust(1, 7.0, 2.0, axis=(0.6, 0.8)),),
    "attitude control": (AttitudeControl(1, 20.0, 3.0, 5.0),),
    "pin": (PIN,),
    "drive": (DRIVE,),
    "motor": (MOTOR,),
    "torsional spring": (SpringDamper(TorsionalSpringDamper(0, 2, 5.0, 0.3)),),
    "all": (
        Buffer(AXIAL),
        *STOPS,
        LATCH,
        Thrust(1, 7.0, 2.0),
        PIN,
        SpringDamper(TorsionalSpringDamper(0, 2, 5.0, 0.3)),
        Oscillators((0, 2), (3.0, 8.0), ("first", "second")),
        Drive(DrivenAngle(0, 2, faster), watched=()),
        MOTOR,
    ),
}


def ball(body, carrier, spin_inertia, name="contact"):
    wall = Segment(0.0, -3.0, 0.0, 1.0, 6.0)
    pair = BallPair(1.2, wall, -1.0, HuntCrossley(1e3, 0.7), RegularisedCoulomb(0.3, 0.1))
    return BallContact(body, carrier, pair, spin_inertia=spin_inertia, name=name)


def mechanism(elements=()):
    system = System((Body(2.0, 0.3), Body(3.0, 0.5), Body(1.0, 0.1)))
    return Assembled(system, Q, V, elements, energy_size=1.0, momentum_size=1.0)


def conserved(assembled, state, active):
    """Rates of both momenta less what came from outside, and of all energies together [N, N m, W]."""
    rate = assembled.derivative(0.0, state, active)
    momenta = jax.jvp(assembled.momentum, (state,), (rate,))[1]
    energy = lambda y: assembled.energy_at(assembled.evaluate(y), active).total  # noqa: E731
    return [*momenta[0], momenta[1], jax.jvp(energy, (state,), (rate,))[1]]


@eqx.filter_jit
def conserved_with_latches_half_closed(name):
    """What is conserved by elements at the start but for their latches, and the largest rate of a velocity there."""
    assembled = mechanism(ELEMENTS[name])
    state, _ = assembled.start()
    active = jnp.asarray([float(name != "thrust over") for name in assembled.contact_names])
    for k, element in enumerate(assembled.elements):
        if isinstance(element, Latch):
            state = state.at[assembled.layout.places[f"element {k}"].start].set(0.4)
    largest = jnp.max(jnp.abs(assembled.derivative(0.0, state, active)[9:18]))
    return conserved(assembled, state, active), largest


@eqx.filter_jit
def first_instant(assembled):
    """What is evaluated at the start, which contacts are closed there, rates and observables."""
    at, closed = assembled.first_evaluation()
    rate = assembled.derivative(0.0, at.state, closed)
    return at, closed, rate, assembled.observables_at(at, rate, closed)


@eqx.filter_jit
def energies(assembled, state, closed):
    return assembled.energy_at(assembled.evaluate(state), closed)


@pytest.mark.parametrize("name", ELEMENTS)
def test_it_acts_on_two_bodies_and_its_energies_are_its_powers(name):
    found, force = conserved_with_latches_half_closed(name)
    assert float(force) > 0.1
    assert_allclose(found, 0.0, atol=1e-11 * float(force) + 1e-12)


def of_one_entry(part):
    """The part with every single number as an array of one entry."""
    plain = lambda leaf: callable(leaf) or np.ndim(leaf)  # noqa: E731
    return jax.tree.map(lambda leaf: leaf if plain(leaf) else jnp.reshape(jnp.asarray(leaf, float), (1,)), part)


@pytest.mark.parametrize("name", ELEMENTS)
def test_arrays_of_one_entry_are_the_numbers_that_they_hold(name):
    elements = (*ELEMENTS[name], ball(1, 2, 0.2))
    one, other = mechanism(elements), mechanism(of_one_entry(elements))
    for single, array in zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True):
        assert np.shape(single) == np.shape(array) and np.all(np.asarray(single) == np.asarray(array))


def test_arrays_of_one_entry_are_numbers_in_a_system_too():
    parts = (Body(2.0, 0.3), Body(3.0, 0.5)), (Revolute(0, 1, (0.1, 0.0), (0.0, 0.2)),), (AXIAL,)
    one, other = System(*parts), System(*of_one_entry(parts))
    assert [np.shape(leaf) for leaf in jax.tree.leaves(one)] == [np.shape(leaf) for leaf in jax.tree.leaves(other)]


@eqx.filter_jit
def pressing_balls(spins):
    """Gaps and speeds of approach of two balls at the start, their slips, the speeds that the stiff part resists, and
    what is conserved."""
    assembled = mechanism((ball(0, 1, spins[0], "first"), ball(2, 1, spins[1], "second")))
    state, active = assembled.start()[0], jnp.ones(2)
    turning = jnp.asarray([1.5, -0.7][: assembled.spins])
    state = state.at[assembled.layout.places["spins"]].set(turning)
    at = assembled.evaluate(state)
    slips = [it.approach.slip[0] for it in at.elements]
    velocities = state[9 : 18 + assembled.spins]
    resisted = assembled.linearisation(0.0, state, active).directions.T @ velocities
    return assembled.gaps_at(at), slips, resisted, conserved(assembled, state, active)


@pytest.mark.slow
@pytest.mark.parametrize("spins", [(None, None), (0.2, None), (None, 0.3), (0.2, 0.3)], ids=str)
def test_balls_that_spin_freely_or_not_in_any_order(spins):
    (gaps, approach_speeds), slips, resisted, rates = jax.tree.map(np.asarray, pressing_balls(spins))
    assert np.all(gaps < 0.0), "both press"
    assert_allclose(rates, 0.0, atol=1e-9)
    # The stiff part's columns are what closes the gaps and what slips, spins included.
    assert_allclose(resisted[:2], approach_speeds, rtol=1e-12)
    assert_allclose(resisted[2:], slips, rtol=1e-12)


@pytest.mark.slow
def test_the_stiff_part_is_that_of_the_equations():
    """Springs, stops, latch and pin against the Jacobian by velocities, in which nothing geometric counts."""

    @jax.jit
    def both():
        assembled = mechanism((Buffer(AXIAL), *STOPS, LATCH))
        state, _ = assembled.start()
        state = state.at[assembled.layout.places["element 3"].start].set(0.4)
        active = jnp.ones(assembled.contact_count)
        stiff = assembled.linearisation(0.0, state, active)
        exact = jax.jacfwd(lambda y: assembled.derivative(0.0, y, active))(state)[9:18, 9:18]
        return -stiff.response @ stiff.damping @ stiff.directions.T, exact

    found, exact = map(np.asarray, both())
    assert_allclose(found, exact, atol=1e-9 * np.abs(exact).max())


def test_switches_whose_force_is_watched_come_first():
    assembled = mechanism((LATCH, *STOPS, Thrust(1, 7.0, 2.0)))
    names = ("stop", "rebound", "latch", "latch closed", "thrust over")
    assert assembled.contact_names == names
    assert assembled.one_way == (False, False, True, True, True)
    assert assembled.observed == ("stop_force", "rebound_force", "latch_force")
    closed = jnp.asarray([1.0, 0.0, 0.0, 1.0, 0.0])
    assert_allclose(assembled.closed_switches(closed, "latch"), [0.0, 1.0])
    assert_allclose(assembled.closed_switches(closed, "stop"), [1.0])


def test_two_parts_of_one_name_are_refused():
    with pytest.raises(InputError, match="2 elements are called 'stop': give each a name of its own"):
        mechanism((STOPS[0], EndStop(AXIAL, KelvinVoigt(1e4, 20.0), 0.07)))
    with pytest.raises(InputError, match="2 observables are called 'stroke'"):
        mechanism((Buffer(AXIAL), Buffer(AXIAL, name="other")))
    assert mechanism((Buffer(AXIAL), Buffer(AXIAL, name="other", stroke="other_stroke"))).observed[-2:] == (
        "other_stroke",
        "other_extension",
    )


def test_a_switch_is_closed_at_the_start_where_the_start_is_beyond_its_place():
    """Only the first stop: the stroke there is more than its 50 mm, and far from the way out."""
    assembled = mechanism((*STOPS, Thrust(1, 7.0, 2.0)))
    closed = dict(zip(assembled.contact_names, np.asarray(first_instant(assembled)[1]), strict=True))
    assert closed == {"stop": 1.0, "rebound": 0.0, "thrust over": 0.0}
    opened = Assembled(assembled.system, Q, V, elements=assembled.elements, closed=(0.0, 0.0, 0.0))
    assert_allclose(first_instant(opened)[1], 0.0, err_msg="what is said counts")


def test_what_would_mislead_is_refused():
    system = System((Body(2.0, 0.3),))
    with pytest.raises(InputError, match="rest_threshold is of bodies that nothing holds to the ground: give"):
        Assembled(system, Q[:3], V[:3], rest_threshold=1e-3)
    with pytest.raises(InputError, match="there are several Oscillators"):
        mechanism((Oscillators((0,), (3.0,), ("first",)), Oscillators((1,), (8.0,), ("second",), name="more")))
    with pytest.raises(InputError, match="an oscillator is on the ground"):
        Oscillators((-1,), (3.0,), ("first",))


def test_oscillators_are_known_to_steps_also_where_nothing_else_is_stiff():
    assembled = mechanism((Oscillators((0, 2), (3.0, 8.0), ("first", "second")),))
    fastest = eqx.filter_jit(lambda of: of.linearisation(0.0, *of.start()).fastest())(assembled)
    assert float(fastest) == pytest.approx(4.0 * 2.0 * np.pi * 8.0)


def test_a_drives_torque_is_that_on_the_body_it_turns():
    """I θ̈ = M on a body that only the drive acts on, and the power is M ω; both drives share one name of energy."""
    assembled = mechanism((DRIVE, Drive(DrivenAngle(-1, 1, lambda time: -0.05 - 0.2 * time), watched=(), name="other")))
    at, closed, rate, observables = jax.tree.map(np.asarray, first_instant(assembled))
    torque = dict(zip(assembled.observed, observables, strict=True))
    assert_allclose(torque["drive_torque"], 0.1 * rate[17], rtol=1e-12)
    assert_allclose(torque["braking_torque"], -torque["drive_torque"])
    assert_allclose(rate[17] - rate[11], 6.0, rtol=1e-12, err_msg="of the angle that is prescribed")
    put_in = np.array(at.state)
    put_in[assembled.layout.places["element 0"]], put_in[assembled.layout.places["element 1"]] = 2.0, 0.5
    assert float(energies(assembled, put_in, closed).drives) == -2.5
    assert_allclose(assembled.part(rate, "element 0"), torque["drive_torque"] * 0.1, rtol=1e-12)


def test_a_motor_has_its_torque_at_rest_and_none_at_its_no_load_speed():
    """The third body is carried by the first, against which the second turns by -0.5 rad/s."""
    assembled = mechanism((MOTOR,))
    at, closed, rate, observables = first_instant(assembled)
    torque = dict(zip(assembled.observed, np.asarray(observables), strict=True))
    assert_allclose(torque["drive_torque"], 7.0 * (1.0 + 0.5 / 4.0), rtol=1e-14)
    assert_allclose(energies(assembled, at.state, closed).drives, -7.0 * (-0.05 - 0.1 + 0.1), rtol=1e-12)
    lost = assembled.part(np.asarray(rate), "lost")[-1]
    assert_allclose(lost, 7.0 / 4.0 * 0.25, rtol=1e-12)
    idle = np.array(at.state)
    idle[14] = 4.3
    observables = eqx.filter_jit(lambda state: assembled.observables_at(assembled.evaluate(state), rate, closed))(idle)
    assert_allclose(observables, [0.0, 0.0], atol=1e-14)


def speed_of(kin, body):
    return kin.v[3 * body]


def jolt_of(kin, acceleration, body):
    return acceleration[3 * body + 1]


def test_sensors_see_motion_accelerations_and_depths_and_integrals_add_up():
    touching = ball(0, 1, None)
    sensors = (
        Sensor(speed_of, 1, name="speed"),
        Sensor(jolt_of, 1, of_acceleration=True, rounding=1e-12, name="jolt"),
        Sensor(deepest, (touching,), least=0.0, name="depth"),
        Sensor(speed_of, 0, watched=False, name="shown"),
        Integral(speed_of, 2, scale=1e-3, name="way"),
    )
    assembled = mechanism((touching, Buffer(AXIAL), *sensors))
    at, closed, rate, observables = first_instant(assembled)
    rate = np.asarray(rate)
    assert assembled.observed == ("contact", "buffer_force", "stroke", "extension", "speed", "jolt", "depth", "way")
    assert assembled.rate_observables() == (False, False, False, False, False, True, False, False)
    assert assembled.lower_bounds == {"extension": 0.0, "depth": 0.0}
    seen = dict(zip(assembled.observed, np.asarray(observables), strict=True))
    assert_allclose([seen["speed"], seen["way"]], [-0.1, 0.0])
    gap, others = eqx.filter_jit(lambda at: (assembled.gaps_at(at)[0], assembled.snapshot_at(at, closed).others))(at)
    assert_allclose([seen["jolt"], seen["depth"]], [rate[13], -np.asarray(gap)[0]])
    assert_allclose(assembled.part(rate, "element 6"), 0.05, err_msg="the integrand")
    assert_allclose([others["shown"], others["speed"], others["jolt"]], [0.2, -0.1, rate[13]])
    assert_allclose(assembled.roundoff()[4:6], [-np.inf, 1e-12])
    assert_allclose(assembled.scales()[assembled.layout.places["element 6"]], 1e-3)


def test_a_joint_that_moves_by_itself_is_no_joint_of_the_system():
    """Whose mechanism would keep neither the time nor what the joint puts in; that of a mechanism may be used again."""
    with pytest.raises(InputError, match=r"prescribes a motion: give it as Drive\(joint\) among the elements"):
        Assembled(System((Body(2.0, 0.3),), (DrivenAngle(-1, 0, faster),)), Q[:3], V[:3])
    assembled = mechanism((DRIVE,))
    again = Assembled(assembled.system, Q, V, elements=assembled.elements)
    assert len(again.system.joints) == len(assembled.system.joints) == 1


@pytest.mark.parametrize("axis", [(3.0, 4.0), (0.0, 0.0), (float("nan"), 0.0)])
def test_a_thrust_along_what_is_no_unit_vector_is_refused(axis):
    with pytest.raises(InputError, match="no unit vector"):
        Thrust(1, 7.0, 2.0, axis=axis)
