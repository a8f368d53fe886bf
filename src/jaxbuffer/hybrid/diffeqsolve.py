"""One run by `diffrax.diffeqsolve`, with the same `Result` as the loop's: for the solver `Diffrax`.

The solve saves its steps; events are located afterwards, between them (`locate_events`). As in the loop, tangents are
integrated beside the state, under the same error control: differentiating through the solve bounds the error of the
state only, and takes a linear solve with the whole Jacobian for each implicit stage.
"""

import dataclasses
from collections.abc import Callable
from typing import Any, TypeVar

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .diffrax_problem import VectorField, closed, terms
from .locate_events import Path, locate_events
from .loop.log import Kind, Log, Steps
from .loop.loop import Result, Start
from .loop.state import Status
from .options import Options
from .rungekutta.diffrax_solver import Diffrax
from .rungekutta.onto_touchdowns import OntoTouchdowns
from .rungekutta.root_finder import with_root_finder
from .sensitivity.augmented_state import Columns, Tangents, columns
from .system import HybridSystem, Linearisation, State

P = TypeVar("P")

LEAST_STEP = 1e-14  # s
# Where a force has a kink the rate of its tangents jumps, and no step across it is accurate: one of this length [s] is
# taken as it is.
ACROSS_KINKS = 1e-11
SPACING = 1e-3  # of a first step after a touchdown, for second derivatives
PROPORTIONAL, INTEGRAL = 0.3, 0.4  # of `diffrax.PIDController`, as its documentation has them for stiff problems


class TangentField(eqx.Module):
    """``f(t, y, args) = dy/dt`` of columns (see `Tangents`), the state in the first one, and the stiff part of ∂f/∂y,
    which is the same for all columns."""

    build: Callable[..., HybridSystem] = eqx.field(static=True)

    def __call__(self, t: Any, y: Columns, args: Tangents) -> Columns:
        def rate(primal: Any, state: State) -> State:
            return VectorField(self.build)(t, state, (primal,))

        return args.field(rate)(y)

    def point(self, t: Any, y: Columns, args: Tangents) -> tuple[Columns, Columns, Columns]:
        """Return what each step saves: the columns, their rate, and its rate by central differences along the path."""
        spacing = SPACING * self.build(args.primal).impact_step(y[:, 0])

        # One loop for three evaluations: the field is compiled once, where a push-forward would be compiled anew.
        def evaluate(k: Array, rates: Array) -> Array:
            side = jnp.asarray([0.0, 1.0, -1.0])[k]
            return rates.at[k].set(self(t, y + side * spacing * rates[0], args))

        rate, after, before = jax.lax.fori_loop(0, 3, evaluate, jnp.zeros((3, *y.shape)))
        return y, rate, (after - before) / (2.0 * spacing)

    def linearisation(self, t: Any, y: Columns, args: Tangents) -> Linearisation:
        """See `VectorField.linearisation`."""
        return VectorField(self.build).linearisation(t, y[:, 0], (args.primal,))

    def gaps(self, y: Columns, args: Tangents) -> tuple[Array, Array]:
        """Return the distance of each contact [m], and how fast it closes [m/s]."""
        system, state = self.build(args.primal), y[:, 0]
        gap, rate = jax.jvp(system.gaps, (state,), (system.moving(state),))
        return gap, -rate

    def highest_terminal(self, t: Any, y: Columns, args: Tangents, **_: Any) -> Float[Array, ""]:
        """Return the highest terminal guard, the condition of a `diffrax.Event`."""
        return jnp.max(self.build(args.primal).terminals(y[:, 0]))


def largest_norm(ratios: Columns) -> Float[Array, ""]:
    """Return the largest root mean square of any column, so that each tangent is as accurate as the state."""
    return jnp.sqrt(jnp.max(jnp.mean(ratios * ratios, axis=0)))


def run_by_diffeqsolve(
    build: Callable[[P], HybridSystem],
    tangents: Tangents[P],
    duration: Float[Array, ""] | float,
    options: Options,
    allowed: Bool[Array, ""] | None = None,
) -> Result:
    """Run a system by `diffrax.diffeqsolve`: the arguments and result are those of the loop's `run`, ``options.solver``
    is a `Diffrax`.

    The system must have a smooth contact law: nothing happens to its state at a touchdown.
    """
    duration = jnp.asarray(duration, float)
    begin, active = tangents.start(lambda primal: build(primal).start())
    options = options.shared(build(tangents.primal))
    path, solution = _solved(build, tangents, columns(begin), duration, options, allowed)
    system, alone = build(tangents.primal), path.alone()
    log, status = locate_events(system, alone, active, options.max_events, _status(system, alone, solution))
    if allowed is not None:
        status = jnp.where(allowed, status, Status.INPUT)

    def rate(time: Array, at: Columns, active: Array) -> Columns:
        return tangents.field(lambda primal, state: build(primal).derivative(time, state, active))(at)

    events = jax.vmap(path.at)(log.time)
    rates = jax.vmap(rate)(log.time, events, _before(log))
    started = (log.kind == Kind.NONE) | (log.kind == Kind.TOUCHDOWN) & (log.time == 0.0)
    # A start in contact does not move with the parameters; the loop logs its rate as zero too.
    rates = jnp.where(started[:, None, None], 0.0, rates)
    rows = lambda at: jnp.swapaxes(at, -1, -2)[..., : 1 + tangents.count, :]  # noqa: E731
    log = dataclasses.replace(log, rows=rows(events), rates=rows(rates))
    steps = _history(system, path, log, events, status, options.keep, rows)
    return Result(status, Start(begin[None], active), log, steps, solution.stats["num_steps"], path.steps + 1)


def _solved(
    build: Callable[[P], HybridSystem],
    tangents: Tangents[P],
    start: Columns,
    duration: Float[Array, ""],
    options: Options,
    allowed: Bool[Array, ""] | None,
) -> tuple[Path, diffrax.Solution]:
    """Solve to the end of the step in which a terminal guard rises through zero, and return the steps in columns."""
    system, solver, tolerance = build(tangents.primal), options.solver, options.tolerance
    assert isinstance(solver, Diffrax)
    field = TangentField(build)
    controller = OntoTouchdowns(
        rtol=tolerance.rtol,
        atol=tolerance.atol * system.scales()[:, None],
        pcoeff=PROPORTIONAL,
        icoeff=INTEGRAL,
        dtmin=ACROSS_KINKS if tangents.count else LEAST_STEP,
        force_dtmin=bool(tangents.count),
        norm=largest_norm,
        gaps=field.gaps,
        first=jnp.minimum(system.impact_step(start[:, 0]), duration),
    )
    solution = diffrax.diffeqsolve(
        terms(solver.method, diffrax.ODETerm(field)),
        with_root_finder(solver.method, field.linearisation),
        t0=0.0,
        # A run whose numbers are out of range takes no step.
        t1=duration if allowed is None else jnp.where(allowed, duration, 0.0),
        dt0=None,
        y0=start,
        args=tangents,
        # Without a root finder the solve goes on to the end of the step: the event is located within it afterwards.
        event=diffrax.Event(field.highest_terminal, direction=True),
        stepsize_controller=controller,
        saveat=diffrax.SaveAt(t0=True, steps=True, fn=field.point),
        # The tangents are part of the state, so nothing is differentiated through the solve.
        adjoint=diffrax.ForwardMode(),
        max_steps=min(solver.max_steps, options.max_steps),
        # A failure becomes a `Status`: one failed run must not end the others of a `vmap`.
        throw=False,
    )
    state, rate, second = solution.ys
    return Path(solution.ts, state, rate, second, solution.stats["num_accepted_steps"]), solution


def _status(system: HybridSystem, path: Path, solution: diffrax.Solution) -> Int[Array, ""]:
    """Return the `Status` of a solve that no terminal guard ended."""
    status = jnp.asarray(int(Status.NOT_FINITE))
    for result, meaning in (
        (diffrax.RESULTS.successful, Status.TIMEOUT),
        (diffrax.RESULTS.max_steps_reached, Status.TOO_MANY_STEPS),
        (diffrax.RESULTS.dt_min_reached, Status.STEP_TOO_SMALL),
    ):
        status = jnp.where(solution.result == result, int(meaning), status)
    # A failure whose last state or rate is not finite is reported as that, not as a step too small.
    time, state = path.time[path.steps], path.state[path.steps]
    rate = system.derivative(time, state, closed(system, state))
    return jnp.where(jnp.all(jnp.isfinite(state) & jnp.isfinite(rate)), status, int(Status.NOT_FINITE))


def _before(log: Log) -> Float[Array, "slots contacts"]:
    """Return which contacts are closed just before each event."""
    switches = (log.kind == Kind.TOUCHDOWN) | (log.kind == Kind.RELEASE)
    its_own = switches[:, None] & (jnp.arange(log.active.shape[1])[None] == log.which[:, None])
    return jnp.where(its_own, 1.0 - log.active, log.active)


def _history(
    system: HybridSystem,
    path: Path,
    log: Log,
    events: Float[Array, "slots state columns"],
    status: Int[Array, ""],
    keep: int,
    rows: Callable[[Array], Array],
) -> Steps:
    """Return the first ``keep`` points of a history; its last point is the run's end."""
    slots = keep + 1 if keep else 0
    index = jnp.minimum(jnp.arange(slots), path.steps)
    last = jnp.maximum(log.count - 1, 0)
    ends = (index == path.steps) & (status <= Status.TIMEOUT)
    time = jnp.where(ends, log.time[last], path.time[index])
    points = jnp.where(ends[:, None, None], events[last], path.state[index])
    active = jax.vmap(lambda state: closed(system, state))(points[..., 0])
    return Steps(time, active, rows(points), path.steps + 1)
