"""Events of a finished solve, located between its saved steps: touchdowns, releases, the run's end, maxima.

Between two steps the state is the quintic Hermite polynomial with the values and first two derivatives of both ends: a
cubic would miss the peak force of Table 2 by 8e-5, since implicit steps are long. A step within which a guard of a
contact or of the end rises above zero and falls again is searched in two parts.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from .diffrax_problem import closed
from .events.crossing import NEARLY, unlocated_maximum
from .events.excursion import Look, first_excursion
from .events.guards import Extremes
from .hermite import quintic
from .loop.log import UNMOVED, Kind, Log
from .loop.state import Status
from .system import Active, HybridSystem, State

HALVINGS = 36  # of a step, to locate an event


class Path(NamedTuple):
    """Saved steps: the time of each point [s], the state there, its rate and second derivative, each as columns with
    tangents or alone; ``steps`` taken in all after the start. Times of unused points are infinite."""

    time: Float[Array, " points"]
    state: Float[Array, "points state *columns"]
    rate: Float[Array, "points state *columns"]
    second: Float[Array, "points state *columns"]
    steps: Int[Array, ""]

    def alone(self) -> "Path":
        """Return the path of the state without its tangents."""
        return self._replace(state=self.state[..., 0], rate=self.rate[..., 0], second=self.second[..., 0])

    def at(self, time: Float[Array, ""]) -> Float[Array, "state *columns"]:
        """Return the state at a time."""
        step = jnp.clip(jnp.searchsorted(self.time, time, side="left") - 1, 0, jnp.maximum(self.steps - 1, 0))
        return self.within(step, time)

    def within(self, step: Int[Array, ""], time: Float[Array, ""]) -> Float[Array, "state *columns"]:
        """Return the state at a time within a known step."""
        after = jnp.minimum(step + 1, self.steps)
        t0, t1 = self.time[step], self.time[after]
        h = jnp.where(t1 > t0, t1 - t0, 1.0)
        x = (time - t0) / h
        before, later = ((self.state[k], self.rate[k], self.second[k]) for k in (step, after))
        return quintic(before, later, h, x)[0]


class GuardValues(NamedTuple):
    """What is watched of a state: gaps [m], terminal guards, observables and the slopes of observables."""

    gap: Float[Array, " contacts"]
    terminal: Float[Array, " terminals"]
    slope: Float[Array, " observables"]
    value: Float[Array, " observables"]

    def signed(self, active: Active) -> Float[Array, " guards"]:
        """Return gaps, terminal guards and slopes, in this order, each with the sign that makes it rise through zero at
        its event; ``active``: closed contacts."""
        gap = jnp.where(active > 0.5, 1.0, -1.0) * self.gap
        return jnp.concatenate([gap, self.terminal, -self.slope])


def guards_at(system: HybridSystem, time: Float[Array, ""], state: State) -> GuardValues:
    """Return the guards of a state; its gaps alone say which contacts are closed."""
    active = closed(system, state)

    def observed(time: Array, state: Array) -> Array:
        return system.observables_anew(time, state, active)

    rate = system.derivative(time, state, active)
    value, slope = jax.jvp(observed, (time, state), (jnp.ones(()), rate))
    return GuardValues(system.gaps(state), system.terminals(state), slope, value)


class SearchState(NamedTuple):
    """Where the search stands: the step that is searched, the time [s] to which it has been, closed contacts and guards
    there, each observable's largest and smallest values so far and its largest in the log, `Status`, the log."""

    step: Int[Array, ""]
    time: Float[Array, ""]
    active: Active
    guards: GuardValues
    extremes: Extremes
    logged: Float[Array, " observables"]
    status: Int[Array, ""]
    log: Log


def locate_events(
    system: HybridSystem, path: Path, active: Active, slots: int, unless_ended: Int[Array, ""]
) -> tuple[Log, Int[Array, ""]]:
    """Locate the events of a solve, and return their log, whose rows are states alone, and the `Status` of the run.

    **Arguments:** ``active``: contacts closed at the start; ``slots``: room in the log; ``unless_ended``: the status of
    a run that no terminal guard ends.
    """
    start, still = path.state[0], jnp.zeros_like(path.state[0])
    guards = guards_at(system, path.time[0], start)
    log = Log.empty(slots, start[None], active.shape[0], guards.value.shape[0])
    for contact in range(active.shape[0]):
        log = log.append(
            when=active[contact] > 0.5,
            kind=jnp.asarray(int(Kind.TOUCHDOWN)),
            which=jnp.asarray(contact),
            time=path.time[0],
            values=guards.value,
            guard_rate=jnp.ones(()),
            active=active,
            rows=start[None],
            rates=still[None],
            touching=jnp.asarray(False),
        )
    running = jnp.asarray(int(Status.RUNNING))
    search = SearchState(
        step=jnp.asarray(0),
        time=path.time[0],
        active=active,
        guards=guards,
        extremes=Extremes(guards.value, guards.value),
        logged=guards.value,
        status=running,
        log=log,
    )
    search = lax.while_loop(
        lambda s: (s.step < path.steps) & (s.status == Status.RUNNING), lambda s: _step(system, path, s), search
    )
    status = jnp.where(search.status == Status.RUNNING, unless_ended, search.status)
    log = search.log.append(
        when=status == Status.TIMEOUT,
        kind=jnp.asarray(int(Kind.END)),
        which=jnp.asarray(-1),
        time=path.time[path.steps],
        values=search.guards.value,
        guard_rate=jnp.ones(()),
        active=search.active,
        rows=path.state[path.steps][None],
        rates=system.derivative(path.time[path.steps], path.state[path.steps], search.active)[None],
        touching=system.touching(search.active),
    )
    return log, status


def _step(system: HybridSystem, path: Path, s: SearchState) -> SearchState:
    """Search one step, or its next part: all its events, in order of time."""
    contacts, end = s.active.shape[0], path.time[s.step + 1]
    until = _until(system, path, s)
    whole = until >= end
    guards = guards_at(system, until, path.within(s.step, until))
    before, after = s.guards.signed(s.active), guards.signed(s.active)
    # A contact that has just switched may be beyond zero by rounding: where it is at the end of the step counts.
    happens = (after >= 0.0) & (before < 0.0)
    happens = happens.at[:contacts].set(after[:contacts] > 0.0)

    def located(s: SearchState) -> SearchState:
        find = lambda which: _time(system, path, s, which, until, happens[which])  # noqa: E731
        # One guard after the other, since `vmap` would bisect for those that have no event too.
        times = lax.map(find, jnp.arange(happens.shape[0]))
        # In order of time, because an event that ends the run hides those after it.
        order = jnp.argsort(times)

        def append(k: Array, s: SearchState) -> SearchState:
            still = happens[order[k]] & (s.status == Status.RUNNING)
            return lax.cond(still, lambda: _appended(system, path, s, order[k], times[order[k]]), lambda: s)

        return lax.fori_loop(0, happens.shape[0], append, s)

    s = _with_start(system, path, s, guards.value, happens[contacts + len(s.guards.terminal) :])
    s = lax.cond(jnp.any(happens), lambda: located(s), lambda: s)
    extremes = s.extremes.including(guards.value)
    return s._replace(step=s.step + whole, time=until, guards=guards, extremes=extremes)


def _until(system: HybridSystem, path: Path, s: SearchState) -> Float[Array, ""]:
    """Return the time to which to search next [s]: the step's end, or the top of a guard that rises above zero before
    it and falls again."""
    contacts, terminals = s.active.shape[0], s.guards.terminal.shape[0]
    end = path.time[s.step + 1]
    length = end - s.time

    def at(fraction: Array) -> Float[Array, " guards"]:
        state = path.within(s.step, s.time + fraction * length)
        gaps, terminals = system.gaps_and_terminals(state)
        return jnp.concatenate([jnp.where(s.active > 0.5, 1.0, -1.0) * gaps, terminals])

    def guards_along(fraction: Array) -> Look:
        value, rate = jax.jvp(at, (fraction,), (jnp.ones(()),))
        return Look(value, rate, jnp.zeros_like(value))

    possible = jnp.ones(contacts + terminals, bool)
    fraction = first_excursion(guards_along, guards_along(jnp.zeros(())), possible)
    return jnp.where(fraction < 1.0, s.time + fraction * length, end)


def _with_start(
    system: HybridSystem,
    path: Path,
    s: SearchState,
    end: Float[Array, " observables"],
    located: Bool[Array, " observables"],
) -> SearchState:
    """Log the start as a maximum where an observable falls from there to the step's ``end`` unlocated; ``located``:
    those with a maximum within the step."""
    if not len(end):
        return s
    start, state = s.guards.value, path.within(s.step, s.time)
    falls = unlocated_maximum(start, end, s.logged, s.extremes) & ~located
    active = closed(system, state)
    log = s.log.append(
        when=jnp.any(falls),
        kind=jnp.asarray(int(Kind.PEAK)),
        which=jnp.argmax(falls),
        time=s.time,
        values=start,
        guard_rate=jnp.asarray(UNMOVED),
        active=active,
        rows=state[None],
        rates=system.derivative(s.time, state, active)[None],
        touching=system.touching(active),
    )
    return s._replace(log=log, logged=jnp.where(jnp.any(falls), jnp.maximum(s.logged, start), s.logged))


def _time(
    system: HybridSystem,
    path: Path,
    s: SearchState,
    which: Int[Array, ""],
    until: Float[Array, ""],
    happens: Bool[Array, ""],
) -> Float[Array, ""]:
    """Return when a guard rises through zero before ``until`` [s], by bisection; infinite where it does not."""

    def halve(_: int, bracket: tuple[Array, Array]) -> tuple[Array, Array]:
        low, high = bracket
        middle = 0.5 * (low + high)
        guards = guards_at(system, middle, path.within(s.step, middle))
        beyond = guards.signed(s.active)[which] >= 0.0
        return jnp.where(beyond, low, middle), jnp.where(beyond, middle, high)

    bracket = (s.time, until)
    return lax.cond(happens, lambda: lax.fori_loop(0, HALVINGS, halve, bracket)[1], lambda: jnp.inf)


def _appended(
    system: HybridSystem, path: Path, s: SearchState, guard: Int[Array, ""], time: Float[Array, ""]
) -> SearchState:
    """Append one more event to the search's log."""
    contacts, terminals = s.active.shape[0], s.guards.terminal.shape[0]
    state = path.within(s.step, time)
    is_contact, is_peak = guard < contacts, guard >= contacts + terminals
    is_end = ~is_contact & ~is_peak
    which = guard - jnp.where(is_contact, 0, jnp.where(is_end, contacts, contacts + terminals))
    its_own = is_contact & (jnp.arange(contacts) == which)
    closing = jnp.any(its_own & (s.active < 0.5))
    active = jnp.where(its_own, 1.0 - s.active, s.active)
    rate = system.derivative(time, state, active)
    values = system.observables(state, rate, active)

    def signed(time: Array, state: Array) -> Array:
        return guards_at(system, time, state).signed(s.active)[guard]

    guard_rate = jax.jvp(signed, (time, state), (jnp.ones(()), rate))[1]
    contact_kind = jnp.where(closing, int(Kind.TOUCHDOWN), int(Kind.RELEASE))
    highest = jnp.arange(values.shape[0]) == which
    when = ~is_peak | jnp.any(highest & (values > s.extremes.below_largest(NEARLY)))
    log = s.log.append(
        when=when,
        kind=jnp.where(is_contact, contact_kind, jnp.where(is_end, int(Kind.END), int(Kind.PEAK))),
        which=which,
        time=time,
        values=values,
        guard_rate=guard_rate,
        active=active,
        rows=state[None],
        rates=rate[None],
        touching=system.touching(s.active),
    )
    # The largest force of a contact is that of its present impact, so that every impact's peak is logged.
    extremes = Extremes(*(jnp.where(closing & highest, 0.0, value) for value in s.extremes))
    return s._replace(
        active=active,
        extremes=extremes.including(values),
        logged=jnp.where(when, jnp.maximum(s.logged, values), s.logged),
        status=jnp.where(is_end, which, s.status),
        log=log,
    )
