"""A run with the right derivative: `solve` differentiates with respect to every number in the system.

The derivative rule integrates the tangents of the perturbed inputs as rows of the error-controlled state, pushes each
of them through what is read off the run, and returns J·ṗ with that J. It is linear in ṗ, so JAX transposes it: `jvp`,
`jacfwd`, `grad`, `vmap` and `jit` all work.
"""

import dataclasses
from collections.abc import Callable
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..errors import InputError
from .event_times import moving
from .lanes import one_by_one
from .loop.loop import Result, run
from .options import Options
from .rungekutta.diffrax_solver import Diffrax
from .sensitivity.augmented_state import Tangents, push_through_assembly
from .system import HybridSystem

T = TypeVar("T")

# With tangents: how closely events are located [s], and maxima, as a fraction of their height. Where a parameter moves
# the arrival of an impact by a second, the tangent beside its peak holds that much of the force's rate, which cancels
# at the peak only (a step of first order onto it leaves little of that: docs/decisions.md).
EVENT_TIME = 1e-12
SHORTFALL = 1e-12


SECOND = (
    "second derivatives are not offered: a run can't be differentiated twice (jax.hessian, or jax.grad of jax.grad); "
    "take differences of first derivatives instead, of jb.sensitivity(...).gradients say"
)
FIXED = (
    "a run can't be differentiated by its duration, rtol or atol, only by numbers of its design and scenario; "
    "wrap them in jax.lax.stop_gradient where they are computed from those"
)


def solve(
    build: Callable[..., HybridSystem],
    parameters: Any,
    duration: Float[Array, ""] | float,
    options: Options,
    allowed: Bool[Array, ""] | None = None,
) -> Result:
    """Run the system that ``build(*parameters)`` assembles; differentiable in the arrays of ``parameters``.

    **Arguments:** ``duration`` [s]; ``options``; ``allowed``: whether the parameters are in range (default: they are);
    where not, the run takes no step and ends with `Status.INPUT`.

    **Returns:** a `Result` whose ``log.rows`` and ``log.rates`` have one row, the state at each event and its rate.
    Events move with the parameters, and derivatives of the log go with them (`moving`). Those of ``steps`` are at
    their fixed times.
    """
    result = solve_at_fixed_times(build, parameters, duration, options, allowed)
    return result._replace(log=moving(result.log, parameters, build))


def solve_at_fixed_times(
    build: Callable[..., HybridSystem],
    parameters: Any,
    duration: Float[Array, ""] | float,
    options: Options,
    allowed: Bool[Array, ""] | None = None,
) -> Result:
    """Run as `solve` does, with derivatives of ``log.rows`` and ``log.rates`` at the events' fixed times; an event's
    own time shifts by -guard/guard_rate (see `Log`). Nothing else in the log has derivatives."""
    return solve_and_read(build, _as_it_is, parameters, duration, options, allowed)


def solve_and_read(
    build: Callable[..., HybridSystem],
    read: Callable[[Any, Array, Options, Result], T],
    parameters: Any,
    duration: Float[Array, ""] | float,
    options: Options,
    allowed: Bool[Array, ""] | None = None,
) -> T:
    """Run as `solve_at_fixed_times` does, and return ``read(parameters, duration, options, result)``.

    What is read has derivatives pushed forward from those of the result, in reverse mode too: backwards, all that is
    evaluated on the way would be one kernel, which takes longer to compile and, in space, beyond 10 GB
    (docs/decisions.md).
    """
    return _solve_and_read(parameters, build, read, jnp.asarray(duration, float), options, allowed)


def _as_it_is(parameters: Any, duration: Array, options: Options, result: Result) -> Result:
    return result


@eqx.filter_custom_jvp
def _solve_and_read(
    parameters: Any,
    build: Callable[..., HybridSystem],
    read: Callable[[Any, Array, Options, Result], T],
    duration: Array,
    options: Options,
    allowed: Array | None,
) -> T:
    by = _stepper(options)

    def state_alone(parameters: Any, *others: Any) -> Result:
        return by(lambda system: system, Tangents(build(*parameters)), *others)

    return read(parameters, duration, options, one_by_one(state_alone, parameters, duration, options, allowed))


@_solve_and_read.def_jvp
def _solve_and_read_jvp(primals: tuple, tangents: tuple) -> tuple[Any, Any]:
    parameters, build, read, duration, options, allowed = primals
    if jax.tree.leaves(tangents[1:]):
        raise InputError(FIXED)
    leaves, structure = jax.tree.flatten(parameters, is_leaf=_is_none)
    moves = jax.tree.leaves(tangents[0], is_leaf=_is_none)
    chosen = [i for i, move in enumerate(moves) if move is not None]

    def filled(values: list[Array], others: list[Array]) -> Any:
        all_of = list(others)
        for i, value in zip(chosen, values, strict=True):
            all_of[i] = value
        return jax.tree.unflatten(structure, all_of)

    values = [leaves[i] for i in chosen]
    assembled = lambda values, others: build(*filled(values, others))  # noqa: E731
    result = solve_with_tangents(assembled, values, leaves, duration, options, allowed)

    def read_from(values: list[Array], result: Result) -> Any:
        return read(filled(values, leaves), duration, options, result)

    value, columns = with_derivatives(read_from, values, result)
    along = jnp.stack([moves[i] for i in chosen])
    return value, jax.tree.map(lambda x: jnp.sum(along.reshape(-1, *[1] * (x.ndim - 1)) * x, axis=0), columns)


def solve_with_tangents(
    assemble: Callable[[list[Array], Any], HybridSystem],
    values: list[Array],
    others: Any,
    duration: Float[Array, ""] | float,
    options: Options,
    allowed: Bool[Array, ""] | None = None,
) -> Result:
    """Run the system that ``assemble(values, others)`` makes, with a tangent for each of the ``values``, of which
    `with_derivatives` makes derivatives.

    **Returns:** a `Result` whose ``log.rows``, ``log.rates`` and ``steps.rows`` have one row for the state and one for
    each of the values: the derivative at fixed time, times the value's size.
    """
    # With events located to 1e-10 s the worst elasticity is off by 3.7e-3 instead of 1e-4 (docs/decisions.md).
    options = dataclasses.replace(options, event_time=jnp.asarray(EVENT_TIME), shortfall=jnp.asarray(SHORTFALL))
    values, others = jax.tree.map(lambda x: _once(x) if eqx.is_inexact_array(x) else x, (values, others))
    by = _stepper(options)

    def with_tangents(values: list[Array], others: Any, *rest: Any) -> Result:
        assembled = lambda values: assemble(values, others)  # noqa: E731
        build, tangents, moving = push_through_assembly(assembled, motion, values, _sizes(values))
        result = by(build, tangents, *rest)
        # The system does not depend on the other values at all: their tangents are zero, and were not stepped.
        place = {k: 1 + row for row, k in enumerate(moving)}
        rows = np.array([0, *(place.get(k, 1 + len(moving)) for k in range(len(values)))])
        return _with_rows(result, lambda x: jnp.pad(x, [(0, 0), (0, 1), (0, 0)])[:, rows])

    return one_by_one(with_tangents, values, others, jnp.asarray(duration, float), options, allowed)


def motion(system: HybridSystem) -> tuple[Array, ...]:
    """Return all of a system that tangents are lifted through, at its start."""
    state, active = system.start()
    none = jnp.zeros(())
    after = [system.touchdown(state, none, jnp.asarray(0))] if active.shape[0] else []
    return state, system.derivative(none, state, active), *after


def with_derivatives(read: Callable[[list[Array], Result], T], values: list[Array], result: Result) -> tuple[T, T]:
    """Read something off a run of `solve_with_tangents`, with its derivatives.

    **Arguments:** ``read``: a function of the values and of a result with one row, the state, as
    `solve_at_fixed_times` returns it; the ``values`` and ``result`` of the run.

    **Returns:** what is read, and its derivatives by each of the values along a leading axis, None for what has none.
    """

    def push(direction: list[Array], change: Result) -> tuple[T, T]:
        return eqx.filter_jvp(read, (values, _with_rows(result, lambda rows: rows[:, :1])), (direction, change))

    # What is read is evaluated once; each push-forward is along one of the values.
    return eqx.filter_vmap(push, out_axes=(None, 0))(list(jnp.eye(len(values))), _changes(result, values))


def _changes(result: Result, values: list[Array]) -> Result:
    """Return how the result changes with each of the values, along a leading axis: nothing but its rows does."""
    sizes = _sizes(values)[None, :, None]
    change = _with_rows(result, lambda rows: jnp.swapaxes(rows[:, 1:] / sizes, 0, 1)[:, :, None])
    none = jax.tree.map(lambda _: None, change)
    return none._replace(
        start=none.start._replace(rows=change.start.rows),
        log=dataclasses.replace(none.log, rows=change.log.rows, rates=change.log.rates),
        steps=dataclasses.replace(none.steps, rows=change.steps.rows if change.steps.time.shape[0] else None),
    )


def _sizes(values: list[Array]) -> Float[Array, " values"]:
    """Directions are relative (d/d ln p) where there is a value to be relative to: rows of like size share a
    tolerance."""
    all_of = jnp.stack(values)
    return jnp.where(all_of == 0.0, 1.0, jnp.abs(all_of))


def _with_rows(result: Result, of: Callable[[Array], Array]) -> Result:
    start, log, steps = result.start, result.log, result.steps
    start = start._replace(rows=of(start.rows))
    log = dataclasses.replace(log, rows=of(log.rows), rates=of(log.rates))
    return result._replace(start=start, log=log, steps=dataclasses.replace(steps, rows=of(steps.rows)))


def _stepper(options: Options) -> Callable[..., Result]:
    """Return the function that steps a run: the loop with events or, where the solver asks for it,
    `diffrax.diffeqsolve`."""
    if not isinstance(options.solver, Diffrax):
        return run
    from .diffeqsolve import run_by_diffeqsolve  # imports diffrax

    return run_by_diffeqsolve


@jax.custom_jvp
def _once(number: Array) -> Array:
    """Return the number; raise `InputError` where a derivative of a derivative is taken."""
    return number


@_once.defjvp
def _once_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    raise InputError(SECOND)


def _is_none(x: Any) -> bool:
    return x is None
