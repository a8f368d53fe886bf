"""All that is read off single instants of a run: the start, the end, an event, and where something is largest.

The mechanism is evaluated in one loop over these instants, so that its equations are compiled once for all of them.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..hybrid import Kind, Log, Start
from ..mechanisms.reading import Reader, Reading
from ..mechanisms.system import ContactSystem
from .moving import carried, shifted

State = Float[Array, " state"]


class Readings(NamedTuple):
    """The readings at a run's instants.

    - ``start``, ``end``: of the run.
    - ``event``: the one that the mechanism's `Reader` looks at; without one it is the end.
    - ``largest``: all observables where each one in question is largest.
    - ``end_time``: which moves with the parameters where a guard ends the run [s].
    """

    start: Reading
    end: Reading
    event: Reading
    largest: Float[Array, "maxima observables"]
    end_time: Float[Array, ""]

    @property
    def observables(self) -> Float[Array, "entries observables"]:
        """Return the observables at the entries of ``largest``, and at the end."""
        return jnp.concatenate([self.largest, self.end.observables[None]])


class _Instant(NamedTuple):
    """One instant as the log has it, or many.

    - ``state``, ``active``; ``rate``: of the state, just before the event.
    - ``time``: which moves with the parameters [s].
    - ``before``: whether observables go with that rate, rather than with the one after the event.
    - ``moves``: whether the state is read where the event moves to, rather than at its fixed time; ``ends``: whether
      it is the run's end.
    """

    state: Float[Array, "*instants state"]
    active: Float[Array, "*instants contacts"]
    rate: Float[Array, "*instants state"]
    time: Float[Array, "*instants"]
    before: Bool[Array, "*instants"]
    moves: Bool[Array, "*instants"]
    ends: Bool[Array, "*instants"]


def readings(
    system: ContactSystem,
    reader: Reader | None,
    start: Start,
    log: Log,
    largest: Int[Array, " maxima"],
    by_guard: Bool[Array, ""],
) -> Readings:
    """Return the readings at a run's instants.

    **Arguments:** ``system``; ``reader``: the mechanism's own; ``start`` of the run; ``log``, whose touchdowns and
    releases move; ``largest``: the entries at which something is largest; ``by_guard``: whether a guard ends the run.
    """
    last = jnp.maximum(log.count - 1, 0)
    event = None if reader is None else reader.slot(system, log)
    named = [last] if event is None else [last, event]
    instants = _instants(system, start, log, jnp.concatenate([jnp.stack(named), largest]), len(named), by_guard)
    # Where an instant moves, its state moves at the rate after the event, which a first visit at the fixed time shows.
    # Without jumps it is the rate before the event too, which the log has; how the end moves shows in its guard alone.
    visits = np.array([1, 2, *[1 + system.jumps] * (len(named) - 1 + len(largest))])
    rows = np.cumsum(visits) - 1  # the last visit of each instant
    moved = np.isin(np.arange(visits.sum()), rows)

    def visit(carry: tuple[State, Array], given: tuple[_Instant, Array]) -> tuple[tuple[State, Array], Reading]:
        (rate_after, end_time), (instant, moved) = carry, given
        rate = jnp.where(instant.ends, instant.rate, rate_after) if system.jumps else instant.rate
        time = jnp.where(instant.ends, end_time, instant.time)
        time = jnp.where(instant.moves & moved, time, jax.lax.stop_gradient(time))
        rate_after, terminals, reading = _look(system, reader, instant, carried(instant.state, rate, time))
        terminal = terminals[jnp.clip(log.which[last], 0, len(terminals) - 1)]
        of_guard = shifted(log.time[last], jnp.where(by_guard, terminal, 0.0), log.guard_rate[last])
        return (rate_after, jnp.where(instant.ends & ~moved, of_guard, end_time)), reading

    given = jax.tree.map(lambda values: values[np.repeat(np.arange(len(visits)), visits)], instants)
    begin = (jnp.zeros_like(start.state), log.time[last])
    (_, end_time), table = jax.lax.scan(visit, begin, (given, jnp.asarray(moved)))
    start_row, end_row, event_row = (rows[min(k, len(named))] for k in range(3))
    of = lambda row: jax.tree.map(lambda values: values[row], table)  # noqa: E731
    return Readings(of(start_row), of(end_row), of(event_row), table.observables[rows[1 + len(named) :]], end_time)


def _instants(
    system: ContactSystem, start: Start, log: Log, slots: Int[Array, " slots"], named: int, by_guard: Bool[Array, ""]
) -> _Instant:
    """Return the start, then the entries of a log at ``slots``; the first ones, ``named``, move with any event."""
    kind, ends = log.kind[slots], slots == jnp.maximum(log.count - 1, 0)
    switches = (kind == Kind.TOUCHDOWN) | (kind == Kind.RELEASE)
    moves = jnp.where(np.arange(len(slots)) < named, switches, largest_at_event(system, kind))
    # A release's entry has the rate before it, where the contact still pushes, and a maximum's the rate at a fixed
    # time, from which its state has moved: both are evaluated anew.
    before = kind == Kind.TOUCHDOWN
    still, never = jnp.zeros_like(start.state), jnp.asarray(False)
    first = _Instant(start.state, start.active, still, jnp.zeros(()), never, never, never)
    others = _Instant(
        state=log.rows[slots, 0],
        active=log.active[slots],
        rate=log.rates[slots, 0],
        time=log.time[slots],
        before=before & (not system.jumps),
        moves=jnp.where(ends, by_guard, moves),
        ends=ends,
    )
    return jax.tree.map(lambda one, more: jnp.concatenate([one[None], more]), first, others)


def largest_at_event(system: ContactSystem, kind: Int[Array, " slots"]) -> Bool[Array, " slots"]:
    """Return at which entries of a log, by their ``kind``, what is largest there moves with the event.

    By the envelope theorem a maximum's derivative needs the state's at fixed time only. But right after a touchdown
    with a jump, or right after a release, a quantity may be largest without being stationary.
    """
    touchdown, release = kind == Kind.TOUCHDOWN, kind == Kind.RELEASE
    return (touchdown & system.jumps) | (release & (system.contact_count > 0 and system.observes_rate))


def _look(
    system: ContactSystem, reader: Reader | None, instant: _Instant, state: State
) -> tuple[State, Float[Array, " terminals"], Reading]:
    """Return the state's rate after the event, the guards of the run's end, and the reading."""
    at, active = system.evaluate(state), instant.active
    rate, masses = jnp.zeros_like(state), None
    if reader is not None and reader.directions is not None:
        rate, masses = system.rate_and_masses(at, active, reader.directions(system, at))
    elif system.jumps or system.observes_rate:
        rate = system.rate_at(at, active)
    # The exact motion conserves momentum: what is computed of it are errors, which have no derivatives.
    momentum = None if system.momentum_scale is None else jax.lax.stop_gradient(system.momentum_at(at))
    reading = Reading(
        state=state,
        observables=system.observables_at(at, jnp.where(instant.before, instant.rate, rate), active),
        energy=system.energy_at(at, active),
        momentum=momentum,
        own=None if reader is None else reader.look(system, at, active, masses),
    )
    return rate, system.terminals_at(at), reading
