"""One run of a hybrid system: a single loop of error-controlled steps that lands on every event.

Each trip of the loop is an attempt at a step (`attempt`), a decision about it (`decision`) and, where it has landed on
an event, what that does (`occurrence`). Everything is one `while_loop` of plain array operations: no LAPACK, no
scatter, no callback, so that XLA may compile it into one kernel (see `runtime`).
"""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from ..mechanisms.hybrid import HybridSystem
from .attempt import Attempt, attempt
from .controller import Pace
from .decision import Decision, decide
from .events import next_release
from .landing import Landing
from .lanes import Lanes
from .log import Log, Steps
from .occurrence import Occurrence, logged, occurrence
from .options import Options
from .progress import Place, Progress, Status, begin
from .task import Task
from .trees import where

P = TypeVar("P")


class Result(NamedTuple):
    """A finished run: ``status`` (see `Status`), located events, kept steps, counts of attempted and accepted steps."""

    status: Int[Array, ""]
    log: Log
    steps: Steps
    attempts: Int[Array, ""]
    accepted: Int[Array, ""]


def run(
    build: Callable[[P], HybridSystem],
    lanes: Lanes[P],
    duration: Float[Array, ""] | float,
    options: Options,
    allowed: Bool[Array, ""] | None = None,
) -> Result:
    """Step a system from its start until a terminal guard, ``duration`` [s] or a failure.

    **Arguments:** ``build``: from parameters to the system; ``lanes``: its parameters and the directions of the wanted
    sensitivities; ``allowed``: whether its parameters are in range, None for yes. **Returns:** a `Result` whose log
    holds every located event with those sensitivities.
    """
    task = Task.of(build, lanes, jnp.asarray(duration, float), options)
    end = lax.while_loop(lambda c: c.status == Status.RUNNING, lambda c: _trip(task, c), begin(task, allowed))
    return Result(end.status, end.log, end.steps, end.attempts, end.steps.count)


def _trip(task: Task[P], c: Progress) -> Progress:
    """One trip of the loop."""
    a = attempt(task, c)
    d = decide(task, c, a)
    o = occurrence(task, c, a, d)
    log, pace = logged(task, c, a, d, o), _paced(task, c, a, d, o)
    reached, best, returns = _reached(task, c, a, d, o)
    at = where(returns, c.ahead, where(d.arrived, reached, c.at))
    # A release so near that no other step can be accurate is landed on without looking for it first.
    contact, release = next_release(at.guards, o.active)
    foreseen = d.arrived & ~o.is_contact & (release <= jnp.minimum(o.onset, pace.steps[0]))
    return Progress(
        at=at,
        ahead=where(d.stands, reached, c.ahead),
        active=jnp.where(d.arrived, o.active, c.active),
        best=jnp.where(d.arrived, best, c.best),
        touched=jnp.where(o.closing, o.time + o.offset, c.touched),
        onset=jnp.where(o.closing, o.onset, c.onset),
        pace=pace,
        before_contact=where(o.closing, c.pace, c.before_contact),
        landing=where(foreseen, Landing.toward(contact, release, at.guards.gap), d.landing),
        whole=d.again,
        renew=o.closing & task.system.jumps | o.opening & bool(task.lanes.count),
        status=_status(task, c, a, d, o, pace),
        attempts=c.attempts + 1,
        log=log,
        # A history ends where the run does, not where the last step landed beside that.
        steps=c.steps.append(
            d.arrived, o.time + o.is_terminal * o.offset, o.active, jnp.where(o.is_terminal, o.there, o.rows)
        ),
    )


def _reached(
    task: Task[P], c: Progress, a: Attempt, d: Decision, o: Occurrence
) -> tuple[Place, Float[Array, " observables"], Bool[Array, ""]]:
    """The place at the step's end, each observable's best so far, and whether the run returns to the end of a longer
    step, in which it has only looked at a maximum.

    A maximum landed on, or one of the rate given up as noise, must not be found again, so its slope counts as falling.
    The best force of a contact is that of its present impact, so that every impact's peak is located.
    """
    done = c.landing.under_way & task.sought(c.landing.target) & (d.verdict.happened | task.of_rate)
    guards = a.guards._replace(slope=jnp.where(done, -1e-300, a.guards.slope))
    fresh = o.closing & (task.each_observable == o.target)
    best = jnp.where(fresh, 0.0, jnp.maximum(c.best, a.guards.value))
    returns = o.is_peak & c.landing.aside
    best = jnp.where(returns, jnp.maximum(best, c.ahead.guards.value), best)
    return Place(o.time, o.rows, a.trial.rate, guards), best, returns


def _paced(task: Task[P], c: Progress, a: Attempt, d: Decision, o: Occurrence) -> Pace:
    """How far steps may go from here. Out of contact again, they go on as they went before."""
    landing = c.landing.under_way
    told = jnp.where(a.finite, a.norm, jnp.inf)
    pace = task.options.controller.paced(c.pace, a.which, a.step, told, a.trial.order, d.accept)
    pace = where((landing | d.starts & ~d.stands | c.renew) & ~d.dropped | d.again, c.pace, pace)
    # What is refused on the way to an event may have been found by a longer step of another method.
    shorter = jnp.minimum(pace.steps, pace.steps[a.which])
    pace = pace._replace(steps=jnp.where(landing & d.dropped, shorter, pace.steps))
    pace = where(o.closing, Pace.of(o.onset, len(task.options.solver.methods)), pace)
    return where(o.opening, c.before_contact, pace)


def _status(task: Task[P], c: Progress, a: Attempt, d: Decision, o: Occurrence, pace: Pace) -> Int[Array, ""]:
    """Whether and how the run ends here."""
    free = ~c.landing.under_way | d.dropped
    stuck = ~d.accept & ~d.again & free & ~d.starts & (c.renew | (jnp.min(pace.steps) < 1e-14))
    over = jnp.where(o.timed_out, Status.TIMEOUT, Status.RUNNING)
    status = jnp.where(o.is_terminal, o.target - task.contacts, over)
    for failed, code in (
        (c.attempts + 1 >= task.options.max_steps, Status.TOO_MANY_STEPS),
        (stuck & a.finite, Status.STEP_TOO_SMALL),
        (stuck & ~a.finite, Status.NOT_FINITE),
    ):
        status = jnp.where((status == Status.RUNNING) & failed, code, status)
    return status
