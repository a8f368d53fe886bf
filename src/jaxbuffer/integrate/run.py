"""One run of a hybrid system: a single loop of error-controlled steps that lands on every event.

Everything is one `while_loop` of plain array operations: no LAPACK, no scatter, no callback, so that XLA may compile it
into one kernel (see `runtime`).
"""

import enum
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from .._types import Scalar
from ..mechanisms.hybrid import HybridSystem, Linearisation
from .controller import Controller, Pace, Tolerance
from .events import Guards, first_crossing, observe, signed
from .landing import MAX_TRIES, MOST_TRIES, Landing, judge
from .lanes import Lanes, Rows, columns
from .log import Kind, Log, Steps
from .solvers import Automatic, Solver
from .stages import Field, Step
from .stride import Stride

P = TypeVar("P")
OVERSHOT = 5.0  # times the allowed error: a step beyond an event may miss by that and still say where the event is


class Status(enum.IntEnum):
    """How a run ended. Values from 0 up to ``TIMEOUT`` are the system's terminal guards, in order."""

    RUNNING = -1
    TIMEOUT = 100
    TOO_MANY_STEPS = 101
    STEP_TOO_SMALL = 102
    NOT_FINITE = 103
    LOG_FULL = 104


class Options(eqx.Module):
    """How to step.

    **Arguments:** ``solver``; ``tolerance``; ``controller``; ``max_steps``: attempts before giving up; ``max_events``:
    room in the log; ``event_time`` [s]: how closely a step lands on an event; ``keep``: accepted steps to keep for a
    history, 0 for none.
    """

    solver: Solver = Automatic()
    tolerance: Tolerance = Tolerance()
    controller: Controller = Controller()
    event_time: Scalar = 1e-9
    max_steps: int = eqx.field(static=True, default=200_000)
    max_events: int = eqx.field(static=True, default=512)
    keep: int = eqx.field(static=True, default=0)


class Result(NamedTuple):
    """A finished run: ``status`` (see `Status`), located events, kept steps, counts of attempted and accepted steps."""

    status: Int[Array, ""]
    log: Log
    steps: Steps
    attempts: Int[Array, ""]
    accepted: Int[Array, ""]


class _Progress(NamedTuple):
    time: Float[Array, ""]
    rows: Rows
    rate: Rows
    active: Float[Array, " contacts"]
    guards: Guards
    best: Float[Array, " observables"]
    touched: Float[Array, ""]
    pace: Pace
    before_contact: Pace
    landing: Landing
    renew: Bool[Array, ""]
    status: Int[Array, ""]
    attempts: Int[Array, ""]
    log: Log
    steps: Steps


def run(
    build: Callable[[P], HybridSystem], lanes: Lanes[P], duration: Float[Array, ""] | float, options: Options
) -> Result:
    """Step a system from its start until a terminal guard, ``duration`` [s] or a failure.

    **Arguments:** ``build``: from parameters to the system; ``lanes``: its parameters and the directions of the wanted
    sensitivities. **Returns:** a `Result` whose log holds every located event with those sensitivities.
    """
    system = build(lanes.primal)
    duration = jnp.asarray(duration, float)
    scales = system.scales()
    start = lanes.start(lambda p: build(p).start()[0])
    active = system.start()[1]
    begin = _begin(system, start, active, duration, options)
    contacts, observables = active.shape[0], begin.best.shape[0]
    rated = contacts + begin.guards.terminal.shape[0]
    of_rate, count = jnp.asarray(system.rate_observables(), bool), len(options.solver.methods)
    each_contact, each_observable = jnp.arange(contacts), jnp.arange(observables)

    def body(c: _Progress) -> _Progress:
        landing, first = c.landing.under_way, c.renew
        stiff = system.linearisation(c.time, c.rows[0], c.active)
        which, step = options.solver.choose(stiff, c.pace.steps)
        which = jnp.where(landing, options.solver.suited(stiff, c.landing.aim), which)
        step = jnp.where(landing, c.landing.aim, jnp.minimum(step, duration - c.time))
        step = jnp.where(first, 0.0, step)
        releasing = landing & jnp.any((each_contact == c.landing.target) & (c.active > 0.5))
        stride = _where(releasing, Stride.onto(step), Stride.after(jnp.maximum(c.time - c.touched, 0.0), step))
        stride = _where(options.solver.is_implicit(which), Stride.even(step), stride)

        def take(lanes: Lanes[P], rows: Rows, rate: Rows) -> Step:
            field = lambda time, at: lanes.field(lambda p, y: build(p).derivative(time, y, c.active))(at)  # noqa: E731
            allowance = options.tolerance.allowance(rows, scales)
            return _step(options.solver, which, field, stiff, c.time, rows, rate, stride, allowance)

        trial = take(Lanes(lanes.primal), c.rows[:1], c.rate[:1])
        norm = options.tolerance.norm(trial.error, c.rows[:1], trial.end, scales)
        finite = jnp.isfinite(norm) & jnp.all(jnp.isfinite(trial.rate))
        fits = norm <= 1.0
        after = observe(system, c.time + step, trial.end[0], trial.rate[0], c.active, c.best)

        # A step that holds an event is taken again, shortened until it ends on the event.
        patient = c.landing.tries < MAX_TRIES
        crossing = first_crossing(c.guards, after, step, c.active, c.best, c.landing.target, patient)
        guard, guard_rate = signed(after, c.active)
        verdict = judge(c.landing, step, guard, guard_rate, rated, options.event_time)
        # On arrival another event may turn out to lie a little before: then land on that one first.
        arrives = landing & verdict.settled & (c.landing.tries < MOST_TRIES)
        # The error of a step that overshoots an event is mostly what is not smooth there.
        near = norm <= jnp.where(options.solver.is_implicit(which), 1.0, OVERSHOT)
        starts = (~landing & ~first & near | arrives) & finite & (crossing.which >= 0)
        accept = fits & (~landing | verdict.settled) & ~starts & finite
        dropped = landing & ~starts & (verdict.settled & ~fits | ~finite)
        tries = jnp.where(landing, c.landing.tries + 1, 0)
        going = _where(landing & ~verdict.settled, verdict.next, Landing.none())
        next_landing = _where(starts, Landing.begin(crossing, signed(c.guards, c.active)[0], guard, tries), going)

        # Sensitivities, the dear part, are carried along only where the state's own step stands; their errors may yet
        # refuse it.
        if lanes.count:
            trial = lax.cond(
                accept,
                lambda: take(lanes, c.rows, c.rate),
                lambda: Step(c.rows, c.rate, jnp.zeros_like(c.rows), trial.order),
            )
            norm = jnp.maximum(norm, options.tolerance.norm(trial.error, c.rows, trial.end, scales))
            finite, refused = finite & jnp.isfinite(norm), accept & ~(norm <= 1.0)
            accept, dropped = accept & ~refused, dropped | refused
        next_landing = _where(dropped, Landing.none(), next_landing)

        # What the event is, and what it does.
        target = jnp.where(landing & verdict.happened & accept, c.landing.target, -1)
        is_contact = (target >= 0) & (target < contacts)
        is_terminal = (target >= contacts) & (target < rated)
        is_peak = target >= rated
        chosen = is_contact & (each_contact == target)
        closing = is_contact & jnp.any(chosen & (c.active < 0.5))
        active = jnp.where(chosen, 1.0 - c.active, c.active)
        offset = jnp.where(landing, verdict.offset, 0.0)
        at_event = trial.end + offset * trial.rate
        jump = lax.cond(
            closing,
            lambda: lanes.lift(lambda p, y: build(p).touchdown(y, trial.rate[0], target) - y)(at_event),
            lambda: jnp.zeros_like(at_event),
        )
        rows = trial.end + jump
        time = c.time + step
        timed_out = accept & ~is_terminal & (time >= duration * (1.0 - 1e-15))

        kind = jnp.where(closing, Kind.TOUCHDOWN, jnp.where(is_contact, Kind.RELEASE, Kind.NONE))
        kind = jnp.where(is_peak, Kind.PEAK, jnp.where(is_terminal | timed_out, Kind.END, kind))
        values = after.value
        if system.jumps:  # what is largest right after a touchdown has no slope to be found by
            values = lax.cond(closing, lambda: _after_touchdown(system, time, rows[0], active), lambda: values)
        log = c.log.append(
            when=accept & (kind != Kind.NONE),
            kind=kind,
            which=jnp.where(is_contact, target, jnp.where(is_terminal, target - contacts, target - rated)),
            time=time + offset,
            values=values,
            guard_rate=verdict.rate,
            active=active,
            rows=at_event + jump,
        )
        # A maximum landed on, or one of the rate given up as noise, must not be found again, so its slope counts as
        # falling. The best force of a contact is that of its present impact, so that every impact's peak is located.
        done = landing & (each_observable == c.landing.target - rated) & (verdict.happened | of_rate)
        slope = jnp.where(done, -1e-300, after.slope)
        fresh = closing & (each_observable == target)
        best = jnp.where(fresh, 0.0, jnp.maximum(c.best, after.value))

        # Out of contact again, steps go on as they went before.
        told = jnp.where(finite, norm, jnp.inf)
        pace = options.controller.paced(c.pace, which, step, told, trial.order, accept)
        pace = _where((landing | starts | first) & ~dropped, c.pace, pace)
        # What is refused on the way to an event may have been found by a longer step of another method.
        shorter = jnp.minimum(pace.steps, pace.steps[which])
        pace = pace._replace(steps=jnp.where(landing & dropped, shorter, pace.steps))
        opening, closing = is_contact & accept & ~closing, closing & accept
        pace = _where(closing, Pace.of(system.impact_step(rows[0]), count), pace)
        pace = _where(opening, c.before_contact, pace)

        attempts = c.attempts + 1
        stuck = ~accept & (~landing | dropped) & ~starts & (first | (jnp.min(pace.steps) < 1e-14))
        status = jnp.where(
            accept & is_terminal, target - contacts, jnp.where(timed_out, Status.TIMEOUT, Status.RUNNING)
        )
        for failed, code in (
            (attempts >= options.max_steps, Status.TOO_MANY_STEPS),
            (log.count >= options.max_events, Status.LOG_FULL),
            (stuck & finite, Status.STEP_TOO_SMALL),
            (stuck & ~finite, Status.NOT_FINITE),
        ):
            status = jnp.where((status == Status.RUNNING) & failed, code, status)

        return _Progress(
            time=jnp.where(accept, time, c.time),
            rows=jnp.where(accept, rows, c.rows),
            rate=jnp.where(accept, trial.rate, c.rate),
            active=jnp.where(accept, active, c.active),
            guards=_where(accept, after._replace(slope=slope), c.guards),
            best=jnp.where(accept, best, c.best),
            touched=jnp.where(closing, time + offset, c.touched),
            pace=pace,
            before_contact=_where(closing, c.pace, c.before_contact),
            landing=next_landing,
            renew=closing & system.jumps,
            status=status,
            attempts=attempts,
            log=log,
            steps=c.steps.append(accept, time, active, rows[0]),
        )

    end = lax.while_loop(lambda c: c.status == Status.RUNNING, body, begin)
    return Result(end.status, end.log, end.steps, end.attempts, end.steps.count)


def _begin(
    system: HybridSystem,
    start: Rows,
    active: Float[Array, " contacts"],
    duration: Float[Array, ""],
    options: Options,
) -> _Progress:
    """The loop's first state. A run may start in contact: that is its first touchdown.

    Derivatives and guards are still unknown: the loop's first step has length zero and finds them, which spares
    compiling the right-hand side twice. So does the step after a touchdown at which the rate jumps.
    """
    zero, one = jnp.zeros(()), jnp.ones(())
    contacts = active.shape[0]
    shapes = jax.eval_shape(lambda y: (system.terminals(y), system.observables(y, y, active)), jnp.zeros_like(start[0]))
    none, terminal, value = jnp.zeros(contacts), *(jnp.zeros(shape.shape) for shape in shapes)
    guards = Guards(none, none, terminal, terminal, value, value)
    log = Log.empty(options.max_events, start, contacts, value.shape[0])
    first = _after_touchdown(system, zero, start[0], active) if system.jumps else value
    pace = Pace.of(jnp.minimum(system.impact_step(start[0]), duration), len(options.solver.methods))
    for contact in range(contacts):
        log = log.append(
            active[contact] > 0.5, jnp.asarray(Kind.TOUCHDOWN), jnp.asarray(contact), zero, first, one, active, start
        )
    return _Progress(
        time=zero,
        rows=start,
        rate=jnp.zeros_like(start),
        active=active,
        guards=guards,
        best=guards.value,
        touched=zero,
        pace=pace,
        before_contact=pace,
        landing=Landing.none(),
        renew=jnp.asarray(True),
        status=jnp.where(jnp.all(jnp.isfinite(start)), Status.RUNNING, Status.NOT_FINITE),
        attempts=jnp.asarray(0),
        log=log,
        steps=Steps.empty(options.keep, start[0], contacts),
    )


def _step(
    solver: Solver,
    which: Int[Array, ""],
    field: Field,
    stiff: Linearisation,
    time: Array,
    rows: Rows,
    rate: Rows,
    stride: Stride,
    allowance: Rows,
) -> Step:
    """A step of rows within a mode."""
    # lanes that only fill up a vector register are zeros: any allowance does
    allowed = jnp.maximum(columns(allowance), 1e-300)
    step = solver.step(which, field, stiff, time, columns(rows), columns(rate), stride, allowed)
    back = lambda columns: columns.T[: rows.shape[0]]  # noqa: E731
    return Step(back(step.end), back(step.rate), back(step.error), step.order)


def _after_touchdown(system: HybridSystem, time: Array, state: Array, active: Array) -> Float[Array, " observables"]:
    """All observables of a state whose rate is not yet known."""
    return system.observables(state, system.derivative(time, state, active), active)


def _where(condition: Array, new: P, old: P) -> P:
    return jax.tree.map(lambda a, b: jnp.where(condition, a, b), new, old)
