"""One run of a hybrid system: a single loop of error-controlled steps that locates every event (docs/loop.md).

Each iteration takes one trial step (`take_trial`), decides what becomes of it (`decide`), finds what event lies at its
end (`event_at_end`) and updates the loop's state accordingly. An integer phase says what the trial step is for.

The whole loop is one `while_loop` of plain array operations: no LAPACK, no scatter, no callback, so that XLA may
compile it into one kernel (see `process`).
"""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from .. import lanes
from ..options import Options
from ..sensitivity.augmented_state import Tangents
from ..system import HybridSystem
from ..trees import where
from .decision import Decision, decide
from .event import Event, event_at_end, logged
from .log import Log, Steps
from .phase import StepOutcome
from .state import LoopState, Status, initial_state
from .task import Task
from .trial import take_trial
from .update import advance, next_phase, next_status, next_step_sizes

P = TypeVar("P")


class Start(NamedTuple):
    """The start of a run: ``rows``, the state and its sensitivities, with an axis in front as in a `Log`; ``active``:
    which contacts are closed there."""

    rows: Float[Array, "one rows state"]
    active: Float[Array, " contacts"]

    @property
    def state(self) -> Float[Array, " state"]:
        """Return the state alone."""
        return self.rows[0, 0]


class Result(NamedTuple):
    """A finished run.

    ``status``: how it ended (see `Status`); ``start`` of the run; ``log``: located events; ``steps``: accepted steps,
    as many as a history asks for; ``attempts``: number of trial steps; ``accepted``: number of accepted ones.
    """

    status: Int[Array, ""]
    start: Start
    log: Log
    steps: Steps
    attempts: Int[Array, ""]
    accepted: Int[Array, ""]


def run(
    build: Callable[[P], HybridSystem],
    tangents: Tangents[P],
    duration: Float[Array, ""] | float,
    options: Options,
    allowed: Bool[Array, ""] | None = None,
) -> Result:
    """Step a system from its start until a terminal guard, ``duration`` [s] or a failure.

    **Arguments:** ``build``: from parameters to the system; ``tangents``: its parameters and the directions in which
    derivatives are wanted; ``duration`` [s]; ``options``; ``allowed``: whether its parameters are in range, None for
    yes. **Returns:** a `Result` whose log holds every located event with those tangents.
    """
    task = Task.of(build, tangents, jnp.asarray(duration, float), options)
    start = initial_state(task, allowed)
    end = loop_from(task, start)
    begin = Start(start.point.rows[None], start.active)
    # Where nothing jumps a force at the start is zero, and says nothing.
    log = end.log.with_start_values(end.first_values) if task.system.jumps else end.log
    return Result(end.status, begin, log, end.steps, end.attempts, end.steps.count)


def loop_from(task: Task[P], start: LoopState) -> LoopState:
    """Iterate from a state of the loop until the run has ended, or its duration is over."""
    if lanes.in_turn():
        return lax.while_loop(_running, lambda state: _iterate(task, state), start)
    going_on = lambda state: lanes.in_any_lane(_running(state))  # noqa: E731
    return lax.while_loop(going_on, lambda state: _iterate_where_running(task, state), start)


def _running(state: LoopState) -> Bool[Array, ""]:
    return state.status == Status.RUNNING


def _iterate_where_running(task: Task[P], state: LoopState) -> LoopState:
    """Iterate once in each lane that has not ended, of those that are stepped together.

    A condition of each lane's own would make `vmap` copy all of the loop's state in each iteration. The log is by far
    the most of it, and keeps its lane's by itself, as an iteration without an accepted step writes nothing into it.
    """
    running = _running(state)
    new = _iterate(task, state, running)
    return where(running, new, state)._replace(log=new.log, steps=new.steps)


def _iterate(task: Task[P], state: LoopState, running: Bool[Array, ""] | None = None) -> LoopState:
    """Iterate once; a run that is not ``running`` accepts no step."""
    trial = take_trial(task, state)
    decision = decide(task, state, trial)
    if running is not None:
        # A rejected step writes neither into the log nor into the history, so these need no copy for the lanes that
        # ended.
        decision = decision._replace(outcome=jnp.where(running, decision.outcome, int(StepOutcome.REJECT)))
    event = event_at_end(task, state, trial, decision)
    log, in_log = logged(task, state, trial, decision, event)
    step_sizes = next_step_sizes(task, state, trial, decision, event)
    point, step_end, extremes, located, given_up = advance(task, state, trial, decision, event)
    phase, bracket = next_phase(task, state, decision, event, point, step_sizes)
    return LoopState(
        point=point,
        active=jnp.where(decision.accepted, event.active, state.active),
        phase=phase,
        bracket=bracket,
        step_end=step_end,
        extremes=extremes,
        logged=in_log,
        located=located,
        given_up=given_up,
        step_sizes=step_sizes,
        # Steps within an impact are far shorter than those of free motion, which go on afterwards with the length from
        # before it.
        step_sizes_before_contact=where(event.touchdown, state.step_sizes, state.step_sizes_before_contact),
        # The root of time counts from the event itself, not from the step's end, which lies a little beside it.
        last_touchdown=jnp.where(event.touchdown, event.time + event.offset, state.last_touchdown),
        contact_step=jnp.where(event.touchdown, event.contact_step, state.contact_step),
        first_values=jnp.where(state.attempts == 0, trial.guards.value, state.first_values),
        status=next_status(task, state, trial, decision, event, step_sizes),
        attempts=state.attempts + 1,
        log=log,
        steps=_with_step(state.steps, decision, event),
    )


def _with_step(steps: Steps, decision: Decision, event: Event) -> Steps:
    """Append this step to the history if it is accepted. The history ends on the event that ends the run, not beside
    it."""
    time = event.time + event.terminal * event.offset
    rows = jnp.where(event.terminal, event.rows_at_event, event.rows)
    return steps.append(decision.accepted, time, event.active, rows)
