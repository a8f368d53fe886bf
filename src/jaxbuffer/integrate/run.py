"""One run of a hybrid system: a single loop of error-controlled steps that lands on every event.

Everything is one `while_loop` of plain array operations: no LAPACK, no scatter, no callback, so that XLA may compile it
into one kernel (see `runtime`).
"""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Float, Int

from ..mechanisms.hybrid import HybridSystem, Linearisation
from .controller import Pace
from .events import first_crossing, nearly_best, next_release, next_touchdown, observe, signed
from .landing import MAX_TRIES, MOST_TRIES, Landing, judge
from .lanes import Lanes, Rows, columns
from .log import Kind, Log, Steps
from .options import Options
from .progress import Place, Progress, Status, after_touchdown, begin
from .solvers import Solver
from .stages import Field, Step, Watch
from .stride import Stride

P = TypeVar("P")
CONSERVED = 0.03  # of the tolerance: by how much a step may change what the motion does not
BEYOND = 1.5  # of the way to the next touchdown as foreseen: from a step much beyond it, where it is is a poor guess
SHY = 0.6  # of the way to the next release as foreseen: near it no step is accurate that does not end there
LOOK = 1e-3  # of a step as accuracy allows: how far beside its end the second derivative is taken from
OVERSHOT = 5.0  # times the allowed error: a step beyond an event may miss by that and still say where the event is


class Result(NamedTuple):
    """A finished run: ``status`` (see `Status`), the last state's rate, located events, kept steps, counts of attempted
    and accepted steps."""

    status: Int[Array, ""]
    rate: Float[Array, " state"]
    log: Log
    steps: Steps
    attempts: Int[Array, ""]
    accepted: Int[Array, ""]


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
    beginning = begin(system, start, active, duration, options)
    contacts, observables = active.shape[0], beginning.best.shape[0]
    rated = contacts + beginning.at.guards.terminal.shape[0]
    of_rate, count = jnp.asarray(system.rate_observables(), bool), len(options.solver.methods)
    each_contact, each_observable = jnp.arange(contacts), jnp.arange(observables)

    def body(c: Progress) -> Progress:
        landing, first = c.landing.under_way, c.renew
        stiff = system.linearisation(c.at.time, c.at.rows[0], c.active)
        touchdown, (_, release) = next_touchdown(c.at.guards, c.active), next_release(c.at.guards, c.active)
        well_before = jnp.where(release > c.onset, SHY * release, jnp.inf)
        which, step = options.solver.choose(stiff, jnp.minimum(c.pace.steps, well_before))
        which = jnp.where(landing, options.solver.suited(stiff, c.landing.aim), which)
        step = jnp.minimum(step, BEYOND * touchdown)
        step = jnp.where(landing, c.landing.aim, jnp.minimum(step, duration - c.at.time))
        step = jnp.where(first, 0.0, step)
        releasing = landing & jnp.any((each_contact == c.landing.target) & (c.active > 0.5))
        stride = _where(releasing, Stride.onto(step), Stride.after(jnp.maximum(c.at.time - c.touched, 0.0), step))
        stride = _where(options.solver.is_implicit(which), Stride.even(step), stride)

        def take(lanes: Lanes[P], rows: Rows, rate: Rows) -> Step:
            field = lambda time, at: lanes.field(lambda p, y: build(p).derivative(time, y, c.active))(at)  # noqa: E731
            allowance = options.tolerance.allowance(rows, scales)
            near = lambda state, rate: nearly_best(system, state, rate, c.active, c.best)  # noqa: E731
            watch = Watch(near, LOOK * jnp.min(c.pace.steps)) if any(system.rate_observables()) else None
            return _step(options.solver, which, field, stiff, c.at.time, rows, rate, stride, allowance, watch)

        def alone() -> Step:
            return take(Lanes(lanes.primal), c.at.rows[:1], c.at.rate[:1]).filled_up(lanes.count)

        # Sensitivities, the dear part, ride along only where the step is likely to stand.
        whole = c.whole | ~landing & (step < jnp.minimum(touchdown, release))
        trial = lax.cond(whole, lambda: take(lanes, c.at.rows, c.at.rate), alone) if lanes.count else alone()
        norms = options.tolerance.norms(trial.error, c.at.rows, trial.end, scales)
        after = observe(system, trial.end[0], trial.rate[0], trial.second, c.active)
        # An estimate from a few stages may miss what is not smooth between them, a tip that begins to roll say.
        lost = jnp.where(first, 0.0, jnp.abs(after.invariant - c.at.guards.invariant))
        own_norm = jnp.maximum(norms[0], lost / (CONSERVED * options.tolerance.rtol + after.rounding))
        norm = jnp.maximum(own_norm, jnp.max(norms))
        finite = jnp.isfinite(norm) & jnp.all(jnp.isfinite(trial.rate))
        fits = norm <= 1.0

        # A step that holds an event is taken again, shortened until it ends on the event: the run goes on from there.
        # Only where that is a maximum and nothing else, the step itself stands, and the run goes on from its end. What
        # a step shows whose error is too large may be a touchdown, but no maximum.
        maxima = fits & (c.landing.tries < MAX_TRIES)
        crossing = first_crossing(c.at.guards, after, step, c.active, c.best, c.landing.target, maxima)
        guard = signed(after, c.active)
        own = each_observable == c.landing.target - rated
        shortfall = options.shortfall * jnp.sum(jnp.where(own, jnp.abs(after.value), 0.0))
        verdict = judge(c.landing, step, guard, rated, options.event_time, shortfall)
        # On arrival another event may turn out to lie a little before: then land on that one first.
        arrives = landing & verdict.settled & (c.landing.tries < MOST_TRIES)
        # The error of a step that overshoots an event is mostly what is not smooth there.
        near = own_norm <= jnp.where(options.solver.is_implicit(which), 1.0, OVERSHOT)
        starts = (~landing & ~first & near | arrives) & finite & (crossing.which >= 0)
        stands = starts & ~landing & fits & crossing.alone & (crossing.which >= rated)
        accept = fits & (~landing | verdict.settled) & (~starts | stands) & finite
        dropped = landing & ~starts & (verdict.settled & ~fits | ~finite)
        tries = jnp.where(landing, c.landing.tries + 1, 0)
        going = _where(landing & ~verdict.settled, verdict.next, Landing.none())
        found = Landing.begin(crossing, signed(c.at.guards, c.active).value, guard.value, tries, stands)
        next_landing = _where(starts, found, going)
        next_landing = _where(dropped, Landing.none(), next_landing)
        # A step of the state alone that stands is taken again with its sensitivities.
        again = accept & ~whole & bool(lanes.count)
        next_landing = _where(again, c.landing._replace(there=verdict.there), next_landing)
        accept = accept & ~again
        stands = stands & accept
        arrived = accept & ~stands

        # What the event is, and what it does.
        target = jnp.where(landing & verdict.happened & arrived, c.landing.target, -1)
        is_contact = (target >= 0) & (target < contacts)
        is_terminal = (target >= contacts) & (target < rated)
        is_peak = target >= rated
        chosen = is_contact & (each_contact == target)
        closing = is_contact & jnp.any(chosen & (c.active < 0.5))
        active = jnp.where(chosen, 1.0 - c.active, c.active)
        offset = jnp.where(landing, verdict.offset, 0.0)
        at_event = _shifted(trial, offset, system.coordinates)

        def touch() -> tuple[Rows, Array]:
            jump = lanes.lift(lambda p, y: build(p).touchdown(y, trial.rate[0], target) - y)(at_event)
            return jump, options.tolerance.first_step(lanes.count) * system.impact_step(trial.end[0] + jump[0])

        jump, onset = lax.cond(closing, touch, lambda: (jnp.zeros_like(at_event), c.onset))
        rows = trial.end + jump
        time = c.at.time + step
        timed_out = arrived & ~is_terminal & (time >= duration * (1.0 - 1e-15))

        kind = jnp.where(closing, Kind.TOUCHDOWN, jnp.where(is_contact, Kind.RELEASE, Kind.NONE))
        kind = jnp.where(is_peak, Kind.PEAK, jnp.where(is_terminal | timed_out, Kind.END, kind))
        values = after.value + jnp.where(own & is_peak, 0.5 * offset * after.slope, 0.0)
        if system.jumps:  # what is largest right after a touchdown has no slope to be found by
            values = lax.cond(closing, lambda: after_touchdown(system, time, rows[0], active), lambda: values)
        log = c.log.append(
            when=arrived & (kind != Kind.NONE),
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
        done = landing & own & (verdict.happened | of_rate)
        slope = jnp.where(done, -1e-300, after.slope)
        fresh = closing & (each_observable == target)
        best = jnp.where(fresh, 0.0, jnp.maximum(c.best, after.value))
        reached = Place(time, rows, trial.rate, after._replace(slope=slope))
        returns = is_peak & c.landing.aside
        best = jnp.where(returns, jnp.maximum(best, c.ahead.guards.value), best)

        # Out of contact again, steps go on as they went before.
        told = jnp.where(finite, norm, jnp.inf)
        pace = options.controller.paced(c.pace, which, step, told, trial.order, accept)
        pace = _where((landing | starts & ~stands | first) & ~dropped | again, c.pace, pace)
        # What is refused on the way to an event may have been found by a longer step of another method.
        shorter = jnp.minimum(pace.steps, pace.steps[which])
        pace = pace._replace(steps=jnp.where(landing & dropped, shorter, pace.steps))
        opening, closing = is_contact & accept & ~closing, closing & accept
        pace = _where(closing, Pace.of(onset, count), pace)
        pace = _where(opening, c.before_contact, pace)

        at = _where(returns, c.ahead, _where(arrived, reached, c.at))
        # A release so near that no other step can be accurate is landed on without looking for it first.
        contact, release = next_release(at.guards, active)
        foreseen = arrived & ~is_contact & (release <= jnp.minimum(onset, pace.steps[0]))
        next_landing = _where(foreseen, Landing.toward(contact, release, at.guards.gap), next_landing)

        attempts = c.attempts + 1
        stuck = ~accept & ~again & (~landing | dropped) & ~starts & (first | (jnp.min(pace.steps) < 1e-14))
        status = jnp.where(is_terminal, target - contacts, jnp.where(timed_out, Status.TIMEOUT, Status.RUNNING))
        for failed, code in (
            (attempts >= options.max_steps, Status.TOO_MANY_STEPS),
            (log.count >= options.max_events, Status.LOG_FULL),
            (stuck & finite, Status.STEP_TOO_SMALL),
            (stuck & ~finite, Status.NOT_FINITE),
        ):
            status = jnp.where((status == Status.RUNNING) & failed, code, status)

        return Progress(
            at=at,
            ahead=_where(stands, reached, c.ahead),
            active=jnp.where(arrived, active, c.active),
            best=jnp.where(arrived, best, c.best),
            touched=jnp.where(closing, time + offset, c.touched),
            onset=jnp.where(closing, onset, c.onset),
            pace=pace,
            before_contact=_where(closing, c.pace, c.before_contact),
            landing=next_landing,
            whole=again,
            renew=closing & system.jumps | opening & bool(lanes.count),
            status=status,
            attempts=attempts,
            log=log,
            # A history ends where the run does, not where the last step landed beside that.
            steps=c.steps.append(
                arrived, time + is_terminal * offset, active, jnp.where(is_terminal, at_event[0], rows[0])
            ),
        )

    end = lax.while_loop(lambda c: c.status == Status.RUNNING, body, beginning)
    return Result(end.status, end.at.rate[0], end.log, end.steps, end.attempts, end.steps.count)


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
    watch: Watch | None,
) -> Step:
    """A step of rows within a mode."""
    # lanes that only fill up a vector register are zeros: any allowance does
    allowed = jnp.maximum(columns(allowance), 1e-300)
    step = solver.step(which, field, stiff, time, columns(rows), columns(rate), stride, allowed, watch)
    back = lambda columns: columns.T[: rows.shape[0]]  # noqa: E731
    return step._replace(end=back(step.end), rate=back(step.rate), error=back(step.error))


def _shifted(step: Step, offset: Float[Array, ""], n: int) -> Rows:
    """Where a step ends, moved by a small time [s] to second order in its n coordinates, whose accelerations are known,
    to first order in all else."""
    bend = jnp.pad(step.rate[:, n : 2 * n], [(0, 0), (0, step.rate.shape[1] - n)])
    return step.end + offset * (step.rate + 0.5 * offset * bend)


def _where(condition: Array, new: P, old: P) -> P:
    return jax.tree.map(lambda a, b: jnp.where(condition, a, b), new, old)
