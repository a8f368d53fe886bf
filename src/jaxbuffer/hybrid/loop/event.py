"""The event on which an accepted step ends, and what it does to the state."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from ..events.crossing import unlocated_maximum
from ..rungekutta.stages import Step
from ..sensitivity.augmented_state import Rows
from ..system import HybridSystem
from .decision import Decision
from .log import UNMOVED, Kind, Log
from .state import LoopState
from .task import Task
from .trial import Trial


class Event(NamedTuple):
    """An event, or none, at a step's end.

    ``guard`` it belongs to (-1: there is none); whether it is a ``touchdown``, a ``release``, a ``terminal`` guard's
    crossing or an observable's ``maximum``; ``timed_out``: whether the run's time is up; ``time`` of the step's end
    [s]; ``offset`` [s]: time from there to the event; ``rows_at_event``: state and tangents at the event, after its
    jump; ``rows``: those at the step's end with the same jump, from which the run goes on; ``active``: which contacts
    are closed after it; ``contact_step``: how long a step next to a touchdown or its release may be [s].
    """

    guard: Int[Array, ""]
    touchdown: Bool[Array, ""]
    release: Bool[Array, ""]
    terminal: Bool[Array, ""]
    maximum: Bool[Array, ""]
    timed_out: Bool[Array, ""]
    time: Float[Array, ""]
    offset: Float[Array, ""]
    rows_at_event: Rows
    rows: Rows
    active: Float[Array, " contacts"]
    contact_step: Float[Array, ""]

    @property
    def of_contact(self) -> Bool[Array, ""]:
        """Return whether a contact closes or opens."""
        return self.touchdown | self.release

    @property
    def kind(self) -> Int[Array, ""]:
        """Return what the log calls the event."""
        kind = jnp.where(self.touchdown, Kind.TOUCHDOWN, jnp.where(self.release, Kind.RELEASE, Kind.NONE))
        return jnp.where(self.maximum, Kind.PEAK, jnp.where(self.terminal | self.timed_out, Kind.END, kind))


def event_at_end(task: Task, state: LoopState, trial: Trial, decision: Decision) -> Event:
    """Return the event at the end of a trial step; there is none unless the step is accepted and ends on one.

    The run goes on from the step's end, a little beside the event: state, tangents and rate fit each other there. The
    log keeps the state moved onto the event.
    """
    contacts, refinement = task.contacts, decision.refinement
    here = state.locating & refinement.occurred & decision.accepted
    located = jnp.where(here, state.bracket.guard, -1)
    passed, ending = _passed_unlocated(state, trial, decision)
    guard = jnp.where(passed, contacts + ending, located)
    of_contact = (guard >= 0) & (guard < contacts)
    terminal = (guard >= contacts) & (guard < task.rated)
    chosen = of_contact & (task.each_contact == guard)
    # A contact's guard has one number, whether it closes or opens: its present state says which of the two this is.
    touchdown = of_contact & jnp.any(chosen & (state.active < 0.5))
    # The offset is that of the guard that was located; one that jumps is passed somewhere within the step.
    offset = jnp.where(state.locating & (guard == located), refinement.offset, 0.0)
    at_event = _moved(task.system, trial.step, offset)

    def touch() -> tuple[Rows, Float[Array, ""]]:
        return _touchdown(task, trial, at_event, guard, chosen)

    # The jump takes a push-forward of the whole assembly, and touchdowns are few: it is evaluated only there.
    jump, contact_step = lax.cond(touchdown, touch, lambda: (jnp.zeros_like(at_event), state.contact_step))
    time = state.point.time + trial.length
    return Event(
        guard=guard,
        touchdown=touchdown,
        release=of_contact & ~touchdown,
        terminal=terminal,
        maximum=guard >= task.rated,
        # The last step's length is a difference of times, so its end may miss the duration by rounding.
        timed_out=decision.accepted & ~terminal & (time >= task.duration * (1.0 - 1e-15)),
        time=time,
        offset=offset,
        rows_at_event=at_event + jump,
        rows=trial.step.end + jump,
        active=jnp.where(chosen, 1.0 - state.active, state.active),
        contact_step=contact_step,
    )


def _passed_unlocated(state: LoopState, trial: Trial, decision: Decision) -> tuple[Bool[Array, ""], Int[Array, ""]]:
    """Return whether a guard of the run's end rises through zero in an accepted step, and which one.

    It has been located, unless it jumps with another event, as where a tip comes behind a flank: the search then ends
    on either of the two. The run must end there all the same, since the guard may fall again and never cross.
    """
    rises = (state.point.guards.terminal < 0.0) & (trial.guards.terminal > 0.0)
    return decision.accepted & jnp.any(rises), jnp.argmax(rises)


def _touchdown(
    task: Task, trial: Trial, at_event: Rows, contact: Int[Array, ""], chosen: Bool[Array, " contacts"]
) -> tuple[Rows, Float[Array, ""]]:
    """Return how state and tangents jump where a contact closes, and how long the first step after that may be [s]."""
    approach_acceleration = -jnp.sum(jnp.where(chosen, trial.guards.gap_acceleration, 0.0))
    jumped = lambda p, y: task.build(p).touchdown(y, approach_acceleration, contact) - y  # noqa: E731
    jump = task.tangents.lift(jumped)(at_event)
    first_step = task.options.tolerance.first_step(task.tangents.count)
    return jump, first_step * task.system.impact_step(trial.step.end[0] + jump[0])


def logged(
    task: Task, state: LoopState, trial: Trial, decision: Decision, event: Event
) -> tuple[Log, Float[Array, " observables"]]:
    """Append the step's start, where an observable falls from there unlocated, and the event at its end, if any.

    **Returns:** the log, and the largest value of each observable in it.
    """
    state = _with_values_after(task, state, trial, decision)
    log, highest = _with_start(task, state, trial, decision)
    mine = task.observable_of(event.guard) & event.maximum
    # At the event: the rate of the one that has a maximum there falls to zero on the way.
    values = trial.guards.value + jnp.where(mine, 0.5, 1.0) * event.offset * trial.guards.value_rate
    # Guards are numbered through all kinds; the log counts each kind from zero.
    first = jnp.where(event.of_contact, 0, jnp.where(event.terminal, task.contacts, task.rated))
    when = decision.accepted & (event.kind != Kind.NONE)
    log = log.append(
        when=when,
        kind=event.kind,
        which=event.guard - first,
        time=event.time + event.offset,
        values=values,
        guard_rate=decision.refinement.guard_rate,
        active=event.active,
        rows=event.rows_at_event,
        # near a maximum of what depends on the rate, where it matters, the second derivative is known; else it is zero
        rates=trial.step.rate + event.offset * trial.step.second,
        touching=task.system.touching(state.active),
    )
    known = when & ~task.sudden(event.kind) & (mine | ~log.overflown)
    return log, jnp.where(known, jnp.maximum(highest, values), highest)


def _with_values_after(task: Task, state: LoopState, trial: Trial, decision: Decision) -> LoopState:
    """Put the observables after a sudden event in place of those before it, in the log, once the derivative has been
    evaluated there."""
    log = state.log
    last = log.kind[jnp.maximum(log.count - 1, 0)]
    after = decision.accepted & state.reevaluating & (state.attempts > 0) & ~log.overflown & task.sudden(last)
    logged = jnp.where(after, jnp.maximum(state.logged, trial.guards.value), state.logged)
    return state._replace(log=log.with_last_values(after, trial.guards.value), logged=logged)


def _with_start(
    task: Task, state: LoopState, trial: Trial, decision: Decision
) -> tuple[Log, Float[Array, " observables"]]:
    """Log the step's start as a maximum where an observable falls from there unlocated.

    **Returns:** the log, and the largest value of each observable in it.
    """
    if not task.observables:
        return state.log, state.logged
    point = state.point
    begins = state.attempts == 0  # the start of the run is looked at anyway
    highest = jnp.where(begins, trial.guards.value, state.logged)
    falls = unlocated_maximum(point.guards.value, trial.guards.value, highest, state.extremes)
    falls = falls & (point.guards.value > task.system.roundoff())
    when = decision.accepted & jnp.any(falls) & ~begins
    which = jnp.argmax(falls)
    log = state.log.append(
        when=when,
        kind=jnp.asarray(int(Kind.PEAK)),
        which=which,
        time=point.time,
        values=point.guards.value,
        guard_rate=jnp.asarray(UNMOVED),
        active=state.active,
        rows=point.rows,
        rates=point.rate,
        touching=task.system.touching(state.active),
    )
    mine = (task.each_observable == which) | ~log.overflown
    return log, jnp.where(when & mine, jnp.maximum(highest, point.guards.value), highest)


def _moved(system: HybridSystem, step: Step, offset: Float[Array, ""]) -> Rows:
    """Move the end of a step by a small time [s]: to second order in its coordinates, whose accelerations are known, to
    first order in all else."""
    of_state, of_tangent = jax.linearize(system.position_acceleration, step.end[0], step.rate[0])
    tangents = jax.vmap(of_tangent)(step.end[1:], step.rate[1:])
    after = step.rate.shape[1] - system.coordinates
    acceleration = jnp.pad(jnp.concatenate([of_state[None], tangents]), [(0, 0), (0, after)])
    return step.end + offset * (step.rate + 0.5 * offset * acceleration)
