"""What latches and a thrust do at an instant: forces by hand, action and reaction, energy that closing puts in."""

import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from docking.states import LATCH, REAL_BUFFER, mechanism, moving, own
from jaxbuffer.mechanisms.probe_cone.bodies import P, T

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


@each_time
def test_force_and_moment_by_hand(since):
    instant = latched(since, {"latch.depth": 0.0004})
    at = instant.at
    centre = at.elements[0].centre
    tip, cone, probe = np.array(centre.place), at.kin.frame(T), at.kin.frame(P)
    turn = np.array([[np.cos(0.05), -np.sin(0.05)], [np.sin(0.05), np.cos(0.05)]])
    origin = np.array(cone.origin)
    r = tip - origin - turn @ np.array([-0.096 - 0.015 * np.sqrt(0.5) + 0.0004, 0.0])
    arm = tip - origin
    u = np.array(centre.velocity) - np.array(cone.velocity) - cone.spin * np.array([-arm[1], arm[0]])
    force = -share(since) * (2e4 * r + 3.0 * r / np.sqrt(r @ r + 1e-8) + 100.0 * u)
    moment = -share(since) * (50.0 * (probe.angle - cone.angle) + 2.0 * (probe.spin - cone.spin))
    latch, acting = instant.mechanism.element("latch"), instant.mechanism.evaluated(at, "latch")
    closed = instant.mechanism.closed_switches(instant.active, "latch")
    assert_allclose(tuple(latch.force(acting, closed)), force, rtol=1e-9)
    assert_allclose(latch.observables(acting, closed)["latch_force"], np.linalg.norm(force), rtol=1e-9)
    assert_allclose(latch.loads(acting, closed)[2].moment, moment, rtol=1e-12)
    energy = 0.5 * 2e4 * r @ r + 3.0 * (np.sqrt(r @ r + 1e-8) - 1e-4) + 0.5 * 50.0 * (probe.angle - cone.angle) ** 2
    assert_allclose(latch.stored(acting, closed)["latch"], share(since) * energy, rtol=1e-9)
    loss = share(since) * (100.0 * u @ u + 2.0 * (probe.spin - cone.spin) ** 2)
    assert_allclose(latch.losses(acting, closed)["latch_damper"], loss, rtol=1e-9)


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
    gap, closing = assembled.gaps_at(before.at)
    assert_allclose(gap[2], 0.002, rtol=1e-9)
    assert_allclose([gap[3], closing[3]], [0.02, 0.0])  # which does not come nearer before the crossing
    assert_allclose([gap[4], closing[4]], [1.1, 1.0])
    after = moving(assembled, closed=(CLOSING,), since_crossing=0.015, time=0.4)
    gap, closing = assembled.gaps_at(after.at)
    assert_allclose([gap[3], closing[3]], [0.005, 1.0])


@each_tip
def test_closed_at_once_it_stores_its_energy_at_once(free_tip):
    assembled = mechanism(LATCH | {"latch.closing_time": 0.0, "probe.free_tip": free_tip})
    instant = moving(assembled, closed=(CLOSING,))
    acting, closed = assembled.evaluated(instant.at, "latch"), assembled.closed_switches(instant.active, "latch")
    assert float(acting.share) == 1.0
    assert float(acting.share_rate) == 0.0
    which = assembled.contact_names.index(CLOSING)
    after = assembled.touchdown(instant.state, jnp.zeros(()), jnp.asarray(which))
    stored = assembled.element("latch").stored(acting, closed)["latch"]
    assert_allclose(own(assembled, after, "latch")["closing_work"], stored, rtol=1e-12)


@each_tip
def test_a_thrusts_impulse_and_work_stand_in_the_ledgers(free_tip):
    assembled = mechanism({"probe.free_tip": free_tip}, thrust=1.3, thrust_time=1.5)
    instant = moving(assembled, ahead=-0.002, time=0.4)
    frame = instant.at.kin.frame(0)
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
