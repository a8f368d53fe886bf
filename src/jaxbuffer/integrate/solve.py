"""A run with the right derivative: `solve` differentiates with respect to every number in the system.

The derivative rule integrates the sensitivities of the perturbed inputs as rows of the error-controlled state and
returns J·ṗ with that J. It is linear in ṗ, so JAX transposes it: `jvp`, `jacfwd`, `grad`, `vmap` and `jit` all work.
"""

import dataclasses
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.custom_batching import sequential_vmap
from jaxtyping import Array, Float

from ..mechanisms.hybrid import HybridSystem
from .lanes import Lanes, through
from .options import Options
from .run import Result, run

# How closely steps land on events while sensitivities ride along [s], and on maxima, of their height: where a parameter
# moves the arrival of an impact by a second, that much of the force's slope is in the sensitivity beside its peak, and
# cancels at the peak only (a step of first order onto it leaves little of that: docs/numerics.md).
EVENT_TIME = 1e-12
SHORTFALL = 1e-12


def solve(
    build: Callable[..., HybridSystem], parameters: Any, duration: Float[Array, ""] | float, options: Options
) -> Result:
    """Run the system that ``build(*parameters)`` assembles; differentiable in the arrays of ``parameters``.

    **Returns:** a `Result` whose ``log.rows`` and ``log.rates`` have one row, the state at each event and its rate.
    Their tangents are derivatives at the event's *fixed* time; an event's own time shifts by -guard/guard_rate (see
    `Log`).
    """
    return _solve(
        parameters, build, jax.lax.stop_gradient(jnp.asarray(duration, float)), jax.lax.stop_gradient(options)
    )


@eqx.filter_custom_jvp
def _solve(parameters: Any, build: Callable[..., HybridSystem], duration: Array, options: Options) -> Result:
    return _per_lane(lambda p, d, o: run(lambda system: system, Lanes(build(*p)), d, o), parameters, duration, options)


@_solve.def_jvp
def _solve_jvp(primals: tuple, tangents: tuple) -> tuple[Result, Result]:
    parameters, build, duration, options = primals
    leaves, structure = jax.tree.flatten(parameters, is_leaf=_is_none)
    moves = jax.tree.leaves(tangents[0], is_leaf=_is_none)
    chosen = [i for i, move in enumerate(moves) if move is not None]
    options = dataclasses.replace(options, event_time=jnp.asarray(EVENT_TIME), shortfall=jnp.asarray(SHORTFALL))
    # Directions are relative (d/d ln p) where there is a value to be relative to: rows of like size share a tolerance.
    sizes = [jnp.where(leaves[i] == 0.0, 1.0, jnp.abs(leaves[i])) for i in chosen]

    def with_rows(leaves: list[Array], sizes: list[Array], duration: Array, options: Options) -> Result:
        def assembled(values: list[Array]) -> HybridSystem:
            filled = list(leaves)
            for i, value in zip(chosen, values, strict=True):
                filled[i] = value
            return build(*jax.tree.unflatten(structure, filled))

        directions = [jnp.zeros(len(chosen)).at[k].set(size) for k, size in enumerate(sizes)]
        return run(*through(assembled, [leaves[i] for i in chosen], directions), duration, options)

    result = _per_lane(with_rows, leaves, sizes, duration, options)
    shares = [moves[i] / size for i, size in zip(chosen, sizes, strict=True)]

    def moved(rows: Array) -> Array:
        return sum(rows[:, 1 + k, None] * share for k, share in enumerate(shares))

    def of(result: Result, rows: Array, rates: Array) -> Result:
        return result._replace(log=dataclasses.replace(result.log, rows=rows, rates=rates))

    log = result.log
    value = of(result, log.rows[:, :1], log.rates[:, :1])
    return value, of(jax.tree.map(lambda _: None, value), moved(log.rows), moved(log.rates))


def _is_none(x: Any) -> bool:
    return x is None


def _per_lane(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call ``function`` compiled; under `vmap` on a CPU, lane by lane, so that no lane waits for the slowest."""
    arrays, static = eqx.partition(arguments, eqx.is_array)

    def call(arrays: Any) -> Any:
        return function(*eqx.combine(arrays, static))

    return sequential_vmap(call)(arrays) if jax.default_backend() == "cpu" else call(arrays)
