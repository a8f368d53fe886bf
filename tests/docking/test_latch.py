"""What latches and a thrust do at an instant: forces by hand, action and reaction, energy that closing puts in."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from docking.states import LATCH, REAL_BUFFER, mechanism, moving, own
from jaxbuffer.mechanisms.probe_cone.bodies import P, S, T

CLOSING, LATCHED, THRUST_OVER = "latch", "latch closed", "thrust over"  # contacts
TIMES = {"just closing": 0.002, "half closed": 0.01, "nearly closed": 0.019, "closed": 0.3}
each_time = pytest.mark.parametrize("since", TIMES.values(), ids=TIMES)
each_tip = pytest.mark.parametrize("free_tip", [False, True], ids=["welded tip", "free tip"])


def share(since, closing_time=0.02):
    x = min(since / closing_time, 1.0)
    return x * x * (3.0 - 2.0 * x)


def latched(since, values=None, **scenario):
    return moving(
        mechanism(LATCH | (values or {}), **scenario), ahead=0.0009, closed=(CLOSING,), since_crossing=float(since)
    )


@eqx.filter_jit  # once for all states of a mechanism
def parts(assembled, state):
    """The tip's centre, and the frames of the cone, of the probe and of the active vehicle."""
    at = assembled.evaluate(state)
    return at.elements[0].centre, *(at.kin.frame(body) for body in (T, P, S))


@eqx.filter_jit
def acting(assembled, state, active):
    """The latch's share with its rate, its force and moment, and what it observes, stores and loses."""
    latch, at = assembled.element("latch"), assembled.evaluated(assembled.evaluate(state), "latch")
    closed = assembled.closed_switches(active, "latch")
    loads, stored, lost = latch.loads(at, closed), latch.stored(at, closed), latch.losses(at, closed)
    return {
        "share": (at.share, at.share_rate),
        "force": tuple(latch.force(at, closed)),
        "observed": latch.observables(at, closed)["latch_force"],
        "moment": loads[2].moment,
        "stored": stored["latch"],
        "lost": lost["latch_damper"],
    }


@eqx.filter_jit
def gaps(assembled, state):
    return assembled.gaps_at(assembled.evaluate(state))


@eqx.filter_jit
def after_touchdown(assembled, state, which):
    return assembled.touchdown(state, jnp.zeros(()), which)


@each_time
def test_force_and_moment_by_hand(since):
    # With LATCH's turn_damping the moments of spring and damper cancel in this state.
    instant = latched(since, {"latch.depth": 0.0004, "latch.turn_damping": 3.0})
    centre, cone, probe, _ = parts(instant.mechanism, instant.state)
    tip = np.array(centre.place)
    turn = np.array([[np.cos(0.05), -np.sin(0.05)], [np.sin(0.05), np.cos(0.05)]])
    origin = np.array(cone.origin)
    r = tip - origin - turn @ np.array([-0.096 - 0.015 * np.sqrt(0.5) + 0.0004, 0.0])
    arm = tip - origin
    angle, spin = float(probe.angle) - float(cone.angle), float(probe.spin) - float(cone.spin)
    u = np.array(centre.velocity) - np.array(cone.velocity) - float(cone.spin) * np.array([-arm[1], arm[0]])
    force = -share(since) * (2e4 * r + 3.0 * r / np.sqrt(r @ r + 1e-8) + 100.0 * u)
    moment = -share(since) * (50.0 * angle + 3.0 * spin)
    found = acting(*instant)
    assert_allclose(found["force"], force, rtol=1e-9)
    assert_allclose(found["observed"], np.linalg.norm(force), rtol=1e-9)
    assert_allclose(found["moment"], moment, rtol=1e-12)
    energy = 0.5 * 2e4 * r @ r + 3.0 * (np.sqrt(r @ r + 1e-8) - 1e-4) + 0.5 * 50.0 * angle**2
    assert_allclose(found["stored"], share(since) * energy, rtol=1e-9)
    loss = share(since) * (100.0 * u @ u + 3.0 * spin**2)
    assert_allclose(found["lost"], loss, rtol=1e-9)


@each_tip
@each_time
def test_it_acts_on_both_vehicles(since, free_tip):
    instant = latched(since, {"probe.free_tip": free_tip, **REAL_BUFFER})
    linear, angular = instant.momentum_rates()
    assert_allclose([*linear, angular], 0.0, atol=1e-10)


@each_tip
@each_time
def test_what_closing_puts_in_stands_in_the_ledger(since, free_tip):
    instant = latched(since, {"probe.free_tip": free_tip})
    rest, flow = instant.energy_rate()
    assert flow > 1e-2
    assert abs(rest) < 1e-12 * flow
    closing = own(instant.mechanism, instant.rate, "latch")["closing_work"]
    assert (float(closing) > 0.0) == (since < 0.02)


def test_before_the_crossing_it_does_nothing():
    instant = moving(mechanism(LATCH), ahead=-0.001, since_crossing=0.01)
    plain = moving(mechanism(), ahead=-0.001)
    assert_allclose(instant.rate[12:24], plain.rate[12:24], atol=0.0)
    assert float(own(instant.mechanism, instant.rate, "latch")["since_crossing"]) == 0.0


def test_its_contacts_close_once():
    assembled = mechanism(LATCH, thrust=1.0, thrust_time=1.5)
    names = assembled.contact_names
    assert names == ("lower", "upper", CLOSING, LATCHED, THRUST_OVER)
    assert assembled.one_way == (False, False, True, True, True)
    before = moving(assembled, ahead=-0.002, time=0.4)
    gap, closing = np.asarray(gaps(assembled, before.state))
    assert_allclose(gap[2], 0.002, rtol=1e-9)
    assert_allclose([gap[3], closing[3]], [0.02, 0.0])  # which does not come nearer before the crossing
    assert_allclose([gap[4], closing[4]], [1.1, 1.0])
    after = moving(assembled, closed=(CLOSING,), since_crossing=0.015, time=0.4)
    gap, closing = np.asarray(gaps(assembled, after.state))
    assert_allclose([gap[3], closing[3]], [0.005, 1.0])


@each_tip
def test_closed_at_once_it_stores_its_energy_at_once(free_tip):
    assembled = mechanism(LATCH | {"latch.closing_time": 0.0, "probe.free_tip": free_tip})
    instant = moving(assembled, closed=(CLOSING,))
    found = acting(*instant)
    assert tuple(map(float, found["share"])) == (1.0, 0.0)
    which = np.asarray(assembled.contact_names.index(CLOSING))
    after = after_touchdown(assembled, instant.state, which)
    assert_allclose(own(assembled, after, "latch")["closing_work"], found["stored"], rtol=1e-12)


@each_tip
def test_a_thrusts_impulse_and_work_stand_in_the_ledgers(free_tip):
    assembled = mechanism({"probe.free_tip": free_tip}, thrust=1.3, thrust_time=1.5)
    instant = moving(assembled, ahead=-0.002, time=0.4)
    frame = parts(assembled, instant.state)[-1]
    force = 1.3 * np.array([np.cos(-0.02), np.sin(-0.02)])
    found = [float(rate) for rate in own(assembled, instant.rate, "thrust").values()]
    velocity, origin = np.array(frame.velocity), np.array(frame.origin)
    turning = origin[0] * force[1] - origin[1] * force[0]
    assert_allclose(found, [1.0, force @ velocity, *force, turning], rtol=1e-12)
    # Momentum less what it put in is conserved, and so is energy.
    linear, angular = instant.momentum_rates()
    assert_allclose([*linear, angular], 0.0, atol=1e-10)
    rest, flow = instant.energy_rate()
    assert abs(rest) < 1e-12 * flow
    over = moving(assembled, ahead=-0.002, closed=(THRUST_OVER,), time=1.6)
    assert_allclose([float(rate) for rate in list(own(assembled, over.rate, "thrust").values())[1:]], 0.0)
