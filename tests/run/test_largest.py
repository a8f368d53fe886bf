"""Largest values and conservation, read off logs written by hand for a system of a few lines."""

import dataclasses
from typing import ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.hybrid import Kind, Log, Start
from jaxbuffer.mechanisms.energy import Energy
from jaxbuffer.run.conservation import balance
from jaxbuffer.run.maxima import Places, _peak_time, maxima, places_of
from jaxbuffer.run.moving import moving_end
from jaxbuffer.run.readings import readings

SPEED, RATE = 3.0, 2.0  # of the first number of a state; of a guard


class Evaluated(NamedTuple):
    state: jax.Array


class Toy(eqx.Module):
    """The state's first two numbers are the forces of two contacts, the third an observable "height" times the weight
    ``p``, the fourth a gap. The first number falls at `SPEED`, the second stands, the third rises at 1."""

    p: float | jax.Array = 1.0
    jumps: bool = eqx.field(default=False, static=True)
    impact_contacts: int = eqx.field(default=2, static=True)
    momentum_scale: float | None = 4.0
    of_rate: bool = eqx.field(default=False, static=True)
    contact_count: ClassVar[int] = 2
    observed: ClassVar[tuple[str, ...]] = ("force_0", "force_1", "height", "rate")
    energy_scale: ClassVar[float] = 8.0

    def derivative(self, time, state, active):
        return jnp.array([-SPEED, 0.0, 1.0, -RATE])

    def evaluate(self, state):
        return Evaluated(state)

    def normal_force_at(self, at, active):
        # the slope of a force is its rate times the weight, and an own share of the first contact's
        return at.state[:2] * jnp.array([self.p, self.p**2])

    def rate_at(self, at, active):
        return self.derivative(0.0, at.state, active)

    def normal_force(self, state, active):
        return self.normal_force_at(self.evaluate(state), active)

    def terminals_at(self, at):
        return jnp.array([7.0, 3.0]) * (self.p - 1.0)

    def rate_observables(self):
        return False, False, False, self.of_rate

    @property
    def observes_rate(self):
        return self.of_rate

    def observables(self, state, rate, active):
        return jnp.array([self.p * state[0], self.p**2 * state[1], self.p * state[2], rate[2]])

    def observables_at(self, at, rate, active):
        return self.observables(at.state, rate, active)

    def energy_at(self, at, active):
        return Energy({"kinetic": at.state[0], "contact": active[0]}, {"friction": at.state[2]})

    def momentum_at(self, at):
        return jnp.array([at.state[0], 2.0 * at.state[1]]), at.state[2]


append = jax.jit(Log.append)
empty = jax.jit(Log.empty, static_argnums=(0, 2, 3))


def logged(entries, room=6):
    """Of entries (kind, which, time, forces and height)."""
    log = empty(room, np.zeros((1, 4)), 2, 4)
    for kind, which, time, state in entries:
        row = np.array([[*state, 0.0]])
        values = np.array([*state, 1.0])
        active, rate = np.array([1.0, 0.0]), np.ones((1, 4))
        log = append(log, True, int(kind), which, time, values, RATE, active, row, rate, True)
    return log


ENTRIES = [
    (Kind.TOUCHDOWN, 0, 1.0, (0.0, 0.0, 3.0)),
    (Kind.PEAK, 0, 2.0, (6.0, 5.0, 2.0)),
    (Kind.PEAK, 1, 3.0, (4.0, 9.0, 7.0)),
    (Kind.END, 0, 4.0, (1.0, 2.0, -1.0)),
]


def start(state=(0.0, 0.0, 1.0)):
    return Start(np.array([[[*state, 0.0]]]), np.zeros(2))


def read(toy, log, begin, by_guard=False):
    return readings(toy, None, begin, log, places_of(toy, log).slots, jnp.asarray(by_guard))


@eqx.filter_jit  # once for all logs and starts of a toy
def largest(toy, log, begin):
    return maxima(toy, log, places_of(toy, log), read(toy, log, begin))


@eqx.filter_jit
def conserved(toy, log, begin, drift):
    return balance(toy, read(toy, log, begin), log, drift)


@eqx.filter_jit
def by_weight(of, *given):
    """A function of the weight p and of what is ``given``, and its derivative by p, at p = 1."""
    return jax.jvp(lambda p: of(p, *given), (1.0,), (1.0,))


def later(log, p):
    """The log whose touchdowns and releases come dp/4 later."""
    switches = (log.kind == Kind.TOUCHDOWN) | (log.kind == Kind.RELEASE)
    return dataclasses.replace(log, time=log.time + jnp.where(switches, 0.25, 0.0) * (p - 1.0))


def largest_force(p, log, begin):
    """The largest force, and its contact."""
    return largest(Toy(p), log, begin)[:3:2]


def peak_time(p, log, places):
    return _peak_time(Toy(p), log, places)


def peak_time_with_jumps(p, log, places):
    return _peak_time(Toy(p, jumps=True), later(log, p), places)


def end(p, log, begin, by_guard):
    """Times and states of the log whose end moves, and the energy lost until there."""
    at = read(Toy(p), log, begin, by_guard)
    moved = moving_end(log, at.end_time, at.end.state)
    return moved.time, moved.rows[:, 0], at.end.energy.friction


def test_the_largest_of_all_entries():
    top = largest(Toy(), logged(ENTRIES), start())
    assert (float(top.peak_force), float(top.peak_time), int(top.peak_contact)) == (9.0, 3.0, 1)
    assert {name: float(value) for name, value in top.others.items()} == {"height": 7.0, "rate": 1.0}


@pytest.mark.slow
def test_another_observable_may_be_largest_while_another_contact_pushes_more():
    entries = [(Kind.PEAK, 0, 2.0, (6.0, 5.0, 2.0)), (Kind.PEAK, 1, 3.0, (4.0, 5.0, 7.0))]
    top = largest(Toy(), logged(entries), start())
    assert (float(top.peak_force), float(top.peak_time), int(top.peak_contact)) == (6.0, 2.0, 0)
    assert float(top.others["height"]) == 7.0


def test_a_value_at_the_start_counts_and_unused_entries_do_not():
    """Below zero too: unused entries hold zeros."""
    entries = [(kind, which, time, (a, b, height - 20.0)) for kind, which, time, (a, b, height) in ENTRIES]
    assert float(largest(Toy(), logged(entries), start((0.0, 0.0, -30.0))).others["height"]) == -13.0
    assert float(largest(Toy(), logged(entries), start((0.0, 0.0, -2.0))).others["height"]) == -2.0


def test_empty_slots_of_a_full_log_do_not_count():
    """What had no maximum after the log was full has an empty slot, which holds zeros: above all that is negative."""
    entries = [(kind, which, time, (a, b, height - 20.0)) for kind, which, time, (a, b, height) in ENTRIES]
    log = logged([*entries, (Kind.PEAK, 0, 5.0, (7.0, 0.0, -15.0)), (Kind.END, 0, 6.0, (0.0, 0.0, -14.0))], room=3)
    assert log.overflown
    assert float(largest(Toy(), log, start((0.0, 0.0, -30.0))).others["height"]) == -13.0


def test_the_entry_of_a_start_in_contact_is_no_value():
    """It holds zeros, which are above everything that is negative; the start's own value is looked at apart."""
    entries = [(Kind.TOUCHDOWN, 0, 0.0, (0.0, 0.0, 0.0)), (Kind.END, 0, 4.0, (1.0, 2.0, -5.0))]
    assert float(largest(Toy(), logged(entries), start((0.0, 0.0, -7.0))).others["height"]) == -5.0
    assert float(largest(Toy(), logged(entries), start((0.0, 0.0, -3.0))).others["height"]) == -3.0


@pytest.mark.parametrize(("entries", "force", "contact"), [(ENTRIES[:2], 6.0, 0), (ENTRIES, 9.0, 1)])
def test_forces_differentiate_at_fixed_time(entries, force, contact):
    """The envelope theorem: d(p F)/dp = F, d(p² F)/dp = 2 F; the log itself does not move."""
    top, move = by_weight(largest_force, logged(entries), start())
    assert (float(top[0]), int(top[1])) == (force, contact)
    assert float(move[0]) == force * (1 + contact)


@pytest.mark.parametrize(("slot", "contact", "expected"), [(1, 0, SPEED / RATE), (2, 1, 0.0), (1, 1, 0.0), (3, 0, 0.0)])
def test_the_time_of_a_peak_moves_with_its_slope(slot, contact, expected):
    """-(∂slope/∂p)/ġ: the guard is minus the slope -3 p of the first force, and rises at 2; the slope of the second is
    zero. At another observable's maximum, or the end, time stands."""
    log = logged(ENTRIES)
    log = dataclasses.replace(log, rates=jnp.asarray(np.full(log.rates.shape, [-SPEED, 0.0, 1.0, -RATE])))
    time, move = by_weight(peak_time, log, Places(np.array([slot]), np.array([contact])))
    assert float(time) == ENTRIES[slot][2]
    np.testing.assert_allclose(move, -expected, rtol=1e-15)


@pytest.mark.parametrize("contact", [0, 1])
def test_where_a_force_jumps_it_may_be_largest_at_the_touchdown_itself(contact):
    """Its time moves with that touchdown, and no further."""
    log = logged([(Kind.TOUCHDOWN, 0, 1.0, (6.0, 0.0, 0.0)), *ENTRIES[-1:]])
    time, move = by_weight(peak_time_with_jumps, log, Places(np.array([0]), np.array([contact])))
    assert (float(time), float(move)) == (1.0, 0.25)


@pytest.mark.parametrize(("by_guard", "earlier"), [(True, 1.5), (False, 0.0)])
def test_the_end_moves_with_its_guard_and_takes_the_state_along(by_guard, earlier):
    """The second guard, 3 (p - 1) at the end, rises at 2: the end comes 1.5 dp earlier, and the state with its rate of
    1 there; what is read at the end has that state."""
    log = logged([*ENTRIES[:-1], (Kind.END, 1, *ENTRIES[-1][2:])])
    found, moves = by_weight(end, log, start(), np.asarray(by_guard))
    (time, rows, friction), (time_moves, rows_move, friction_moves) = found, moves
    np.testing.assert_array_equal(time, log.time)
    np.testing.assert_array_equal(rows, log.rows[:, 0])
    expected = np.zeros(log.kind.shape[0])
    expected[len(ENTRIES) - 1] = -earlier
    np.testing.assert_allclose(time_moves, expected, atol=1e-15)
    np.testing.assert_allclose(rows_move, expected[:, None] * np.ones(4), atol=1e-15)
    assert (float(friction), float(friction_moves)) == (-1.0, -earlier)


def test_where_a_force_jumps_its_state_goes_with_the_touchdown():
    """The state's rate (-3, 0, 1, -2) times dt = dp/4 at the first contact; a maximum's state stands."""
    jumping = [(Kind.TOUCHDOWN, 0, 1.0, (6.0, 0.0, 0.0)), (Kind.PEAK, 2, 2.0, (1.0, 1.0, 8.0))]
    moving = lambda p, log, begin: largest(Toy(p, jumps=True), later(log, p), begin)  # noqa: E731
    top, move = by_weight(moving, logged(jumping), start())
    assert (float(top.peak_force), float(top.others["height"])) == (6.0, 8.0)
    np.testing.assert_allclose(move.peak_force, 6.0 - SPEED * 0.25, rtol=1e-15)
    np.testing.assert_allclose(move.others["height"], 8.0, rtol=1e-15)


def test_what_is_largest_at_a_release_goes_with_it():
    """The third number's rate in the log, 0.5, times dt = dp/4; what depends on the state's rate has the one after the
    release, not the one in the step that ended there. A maximum stands."""
    entries = [(Kind.RELEASE, 0, 1.0, (0.0, 0.0, 7.0)), (Kind.PEAK, 0, 2.0, (6.0, 0.0, 2.0))]
    log = logged(entries)
    rates, values = np.array(log.rates), np.array(log.values)
    rates[0, 0, 2], values[0, 3] = 0.5, 9.0
    log = dataclasses.replace(log, rates=jnp.asarray(rates), values=jnp.asarray(values))
    moving = lambda p, log, begin: largest(Toy(p, of_rate=True), later(log, p), begin)  # noqa: E731
    top, move = by_weight(moving, log, start())
    assert (float(top.others["height"]), float(top.others["rate"])) == (7.0, 1.0)
    np.testing.assert_allclose(move.others["height"], 7.0 + 0.5 * 0.25, rtol=1e-15)
    assert float(move.peak_force) == 6.0


def test_without_contacts_there_is_no_force():
    toy = Toy(impact_contacts=0)
    top = largest(toy, logged(ENTRIES), start())
    assert (float(top.peak_force), float(top.peak_time), int(top.peak_contact)) == (0.0, 0.0, -1)
    expected = {"force_0": 6.0, "force_1": 9.0, "height": 7.0, "rate": 1.0}
    assert {name: float(value) for name, value in top.others.items()} == expected


@pytest.mark.parametrize(("first", "scale"), [(1.0, 8.0), (30.0, 32.0), (-30.0, 28.0)])
def test_what_a_motion_conserves(first, scale):
    """Energy over the larger of its first value and the system's scale; momentum over the system's; the last entry
    is the end. A tangent in the log takes no part."""
    before, log = (first, 0.5, 2.0), logged(ENTRIES)
    rows = np.asarray(log.rows)
    log = dataclasses.replace(log, rows=jnp.asarray(np.concatenate([rows, 100.0 + rows], axis=1)))
    drift = np.array([1e-9, 3e-9, 2e-9, 0.0] + [7.0] * 8)
    end, found = conserved(Toy(), log, start(before), drift)
    total = before[0] + before[2]
    assert (float(end.kinetic), float(end.contact), float(end.friction)) == (1.0, 1.0, -1.0)
    np.testing.assert_allclose(found.energy, (1.0 - total) / scale, rtol=1e-14)
    np.testing.assert_allclose(found.linear_momentum, max(abs(1.0 - before[0]), abs(4.0 - 2.0 * before[1])) / 4.0)
    np.testing.assert_allclose(found.angular_momentum, abs(-1.0 - before[2]) / 4.0)
    assert float(found.drift) == 3e-9


def test_where_the_ground_takes_part_momentum_says_nothing():
    _, found = conserved(Toy(momentum_scale=None), logged(ENTRIES), start(), np.zeros(12))
    assert np.isnan(found.linear_momentum)
    assert np.isnan(found.angular_momentum)


def test_of_a_run_without_an_event_the_start_is_the_end():
    _, found = conserved(Toy(), logged([]), start((0.0, 0.0, 0.0)), np.ones(12))
    assert float(found.energy) == float(found.linear_momentum) == float(found.drift) == 0.0
