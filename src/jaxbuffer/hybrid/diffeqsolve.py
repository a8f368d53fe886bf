"""One run by `diffrax.diffeqsolve`, with the same `Result` as the loop's: for the solver `Diffrax`.

The solve saves its steps; events are located afterwards, between them (`locate_events`). Sensitivities are those of
plain forward-mode automatic differentiation through the solve: unlike the loop's they are under no error control.
docs/diffrax.md says how wrong they are.
"""

import dataclasses
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import diffrax
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .diffrax_problem import VectorField, closed, event
from .locate_events import Path, locate_events
from .loop.log import Kind, Log, Steps
from .loop.loop import Result
from .loop.state import Status
from .options import Options
from .rungekutta.diffrax_solver import Diffrax
from .sensitivity.augmented_state import Tangents
from .system import HybridSystem, State

P = TypeVar("P")

LEAST_STEP = 1e-14  # s
PROPORTIONAL, INTEGRAL = 0.3, 0.4  # of `diffrax.PIDController`, as its documentation has them for stiff problems


class EventRows(NamedTuple):
    """The part of a `Result` that has derivatives: the state at each entry of the log, its rate there, and the state at
    each kept step."""

    events: Float[Array, "slots state"]
    rates: Float[Array, "slots state"]
    steps: Float[Array, "kept state"]


def run_by_diffeqsolve(
    build: Callable[[P], HybridSystem],
    tangents: Tangents[P],
    duration: Float[Array, ""] | float,
    options: Options,
    allowed: Bool[Array, ""] | None = None,
) -> Result:
    """What `run` of the loop does, with the same arguments and result, where ``options.solver`` is a `Diffrax`.

    The system must have a smooth contact law: nothing happens to its state at a touchdown.
    """
    duration = jnp.asarray(duration, float)

    def through(primal: P) -> tuple[EventRows, Result]:
        return _run(build, primal, duration, options, allowed)

    if tangents.count:
        push = jax.vmap(lambda direction: jax.jvp(through, (tangents.primal,), (direction,), has_aux=True))
        values, moves, results = push(tangents.directions)
        value, result = jax.tree.map(lambda x: x[0], (values, results))
        rows = jax.tree.map(lambda v, t: jnp.concatenate([v[:, None], jnp.moveaxis(t, 0, 1)], axis=1), value, moves)
    else:
        value, result = through(tangents.primal)
        rows = jax.tree.map(lambda v: v[:, None], value)
    return result._replace(
        log=dataclasses.replace(result.log, rows=rows.events, rates=rows.rates),
        steps=dataclasses.replace(result.steps, rows=rows.steps),
    )


def _run(
    build: Callable[[P], HybridSystem],
    primal: P,
    duration: Float[Array, ""],
    options: Options,
    allowed: Bool[Array, ""] | None,
) -> tuple[EventRows, Result]:
    """The rows of a run, differentiable at fixed times, and the rest of its `Result`, without derivatives."""
    system = build(primal)
    start, active = system.start()
    path, solution = _solved(build, primal, start, duration, options, allowed)
    still_system, still_path = jax.lax.stop_gradient((system, path))
    log, status = locate_events(still_system, still_path, active, options.max_events, _status(system, path, solution))
    if allowed is not None:
        status = jnp.where(allowed, status, Status.INPUT)
    log, status = jax.lax.stop_gradient((log, status))

    events = jax.vmap(lambda time: path.at(system, time))(log.time)
    rates = jax.vmap(system.derivative)(log.time, events, _before(log))
    started = (log.kind == Kind.NONE) | (log.kind == Kind.TOUCHDOWN) & (log.time == 0.0)
    rates = jnp.where(started[:, None], 0.0, rates)
    steps, step_rows = _history(system, path, log, events, status, options.keep)
    result = Result(status, log, steps, solution.stats["num_steps"], path.steps + 1)
    return EventRows(events, rates, step_rows), result


def _solved(
    build: Callable[[P], HybridSystem],
    primal: P,
    start: State,
    duration: Float[Array, ""],
    options: Options,
    allowed: Bool[Array, ""] | None,
) -> tuple[Path, diffrax.Solution]:
    """The steps of the solve, to the end of the one in which a terminal guard rises through zero."""
    system, solver, tolerance = jax.lax.stop_gradient(build(primal)), options.solver, options.tolerance
    assert isinstance(solver, Diffrax)

    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(VectorField(build)),
        solver.method,
        t0=0.0,
        t1=duration if allowed is None else jnp.where(allowed, duration, 0.0),
        dt0=jnp.minimum(system.impact_step(jax.lax.stop_gradient(start)), duration),
        y0=start,
        args=(primal,),
        event=event(build, located=False),
        stepsize_controller=diffrax.PIDController(
            rtol=tolerance.rtol,
            atol=tolerance.atol * system.scales(),
            pcoeff=PROPORTIONAL,
            icoeff=INTEGRAL,
            dtmin=LEAST_STEP,
            force_dtmin=False,
        ),
        saveat=diffrax.SaveAt(t0=True, steps=True),
        adjoint=diffrax.ForwardMode(),
        max_steps=min(solver.max_steps, options.max_steps),
        throw=False,
    )
    return Path(jax.lax.stop_gradient(solution.ts), solution.ys, solution.stats["num_accepted_steps"]), solution


def _status(system: HybridSystem, path: Path, solution: diffrax.Solution) -> Int[Array, ""]:
    """How a solve ended, if not by a terminal guard."""
    status = jnp.asarray(int(Status.NOT_FINITE))
    for result, meaning in (
        (diffrax.RESULTS.successful, Status.TIMEOUT),
        (diffrax.RESULTS.max_steps_reached, Status.TOO_MANY_STEPS),
        (diffrax.RESULTS.dt_min_reached, Status.STEP_TOO_SMALL),
    ):
        status = jnp.where(solution.result == result, int(meaning), status)
    time, state = path.time[path.steps], path.state[path.steps]
    rate = system.derivative(time, state, closed(system, state))
    return jnp.where(jnp.all(jnp.isfinite(state) & jnp.isfinite(rate)), status, int(Status.NOT_FINITE))


def _before(log: Log) -> Float[Array, "slots contacts"]:
    """Closed contacts just before each event."""
    switches = (log.kind == Kind.TOUCHDOWN) | (log.kind == Kind.RELEASE)
    its_own = switches[:, None] & (jnp.arange(log.active.shape[1])[None] == log.which[:, None])
    return jnp.where(its_own, 1.0 - log.active, log.active)


def _history(
    system: HybridSystem,
    path: Path,
    log: Log,
    events: Float[Array, "slots state"],
    status: Int[Array, ""],
    keep: int,
) -> tuple[Steps, Float[Array, "kept state"]]:
    """The first ``keep`` points of a history, and their states; its last point is the run's end."""
    slots = keep + 1 if keep else 0
    index = jnp.minimum(jnp.arange(slots), path.steps)
    last = jnp.maximum(log.count - 1, 0)
    ends = (index == path.steps) & (status <= Status.TIMEOUT)
    time = jnp.where(ends, log.time[last], path.time[index])
    rows = jnp.where(ends[:, None], events[last], path.state[index])
    active = jax.lax.stop_gradient(jax.vmap(lambda state: closed(system, state))(rows))
    return Steps(time, active, jnp.zeros((slots, 1, rows.shape[1])), path.steps + 1), rows
