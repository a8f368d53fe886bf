"""Many runs, several at a time: a lane whose run is over takes the next one at once, so that none waits."""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array

from jaxbuffer.hybrid import HybridSystem, Options, Result
from jaxbuffer.hybrid.loop.loop import _iterate
from jaxbuffer.hybrid.loop.state import LoopState, Status, initial_state
from jaxbuffer.hybrid.loop.task import Task
from jaxbuffer.hybrid.sensitivity.augmented_state import Tangents

from .transform import Lanes, Mapped, Stored

BUFFERS = ("kind", "which", "time", "values", "guard_rate", "active", "rows", "rates")


class _Queue(NamedTuple):
    """``places`` of the runs under way (the number of runs: none), the ``following`` run, ``inputs`` and ``carried``
    of those under way, ``stored`` logs and ``ended`` states of all runs, ``iterations`` so far."""

    places: Array
    following: Array
    inputs: list[Array]
    carried: list[Array]
    stored: list[Array]
    ended: list[Array]
    iterations: Array


def run_all(
    build: Callable[..., HybridSystem], parameters: Any, duration: Array, options: Options, location: Any, lanes: int
) -> tuple[Result, Array]:
    """Step all runs, so many at a time.

    **Arguments:** ``build``: from the parameters of a run to its system; ``parameters``, ``duration`` [s] and
    ``location`` (`Options.event_time`, `Options.shortfall`), each with a leading axis of runs. **Returns:** a `Result`
    with that axis, and the number of iterations.
    """
    count = duration.shape[0]
    split = lambda parameters: eqx.partition(build(*parameters), eqx.is_array)  # noqa: E731
    _, static = eqx.filter_eval_shape(split, jax.tree.map(_first, parameters))
    inputs = (jax.vmap(lambda parameters: split(parameters)[0])(parameters), duration, location)

    def task_of(inputs: Any) -> Task:
        arrays, duration, (event_time, shortfall) = inputs
        system = eqx.combine(arrays, static)
        mine = dataclasses.replace(options, event_time=event_time, shortfall=shortfall)
        return Task.of(lambda system: system, Tangents(system), duration, mine)

    starts = jax.vmap(lambda inputs: initial_state(task_of(inputs)))(inputs)
    traced = jax.make_jaxpr(lambda state, inputs: _iterate(task_of(inputs), state))(
        jax.tree.map(_first, starts), jax.tree.map(_first, inputs)
    )
    leaves, structure = jax.tree_util.tree_flatten_with_path(starts)
    of_buffer = [_is_buffer(path) for path, _ in leaves]
    carried = [leaf for (_, leaf), buffer in zip(leaves, of_buffer, strict=True) if not buffer]
    stored = [_one_more(leaf) for (_, leaf), buffer in zip(leaves, of_buffer, strict=True) if buffer]
    names = [path[0].name for (path, _), buffer in zip(leaves, of_buffer, strict=True) if not buffer]
    status, inputs = names.index("status"), jax.tree.leaves(inputs)

    def together(carried: list[Any], stored: list[Any]) -> list[Any]:
        a, b = iter(carried), iter(stored)
        return [next(b) if buffer else next(a) for buffer in of_buffer]

    def iterate(queue: _Queue) -> _Queue:
        mapped = Mapped(queue.places, queue.places < count)
        given = [*together([*map(Lanes, queue.carried)], [*map(Stored, queue.stored)]), *map(Lanes, queue.inputs)]
        found = mapped.call(traced.jaxpr, traced.consts, given)
        now = [mapped.spread(x) for x, buffer in zip(found, of_buffer, strict=True) if not buffer]
        logs = [x.array for x, buffer in zip(found, of_buffer, strict=True) if buffer]
        over = mapped.busy & (now[status] != Status.RUNNING)

        def renewed() -> _Queue:
            ended = [
                _put(all_runs, x, jnp.where(over, queue.places, count))
                for all_runs, x in zip(queue.ended, now, strict=True)
            ]
            fresh = jnp.minimum(queue.following + jnp.cumsum(over) - 1, count)
            places = jnp.where(over, fresh, queue.places)
            renew = lambda all_runs, x: jnp.where(over, _taken(all_runs, places), x)  # noqa: E731
            return _Queue(
                places,
                queue.following + jnp.sum(over),
                [*map(renew, inputs, queue.inputs)],
                [*map(renew, carried, now)],
                queue.stored,
                ended,
                queue.iterations,
            )

        queue = lax.cond(jnp.any(over), renewed, lambda: queue._replace(carried=now))
        return queue._replace(stored=logs, iterations=queue.iterations + 1)

    places = jnp.minimum(jnp.arange(lanes), count)
    take = lambda all_runs: _taken(all_runs, places)  # noqa: E731
    queue = _Queue(
        places,
        jnp.asarray(lanes),
        [*map(take, inputs)],
        [*map(take, carried)],
        stored,
        [*map(_one_more, carried)],
        jnp.asarray(0),
    )
    queue = lax.while_loop(lambda queue: jnp.any(queue.places < count), iterate, queue)
    end: LoopState = jax.tree.unflatten(structure, [x[:count] for x in together(queue.ended, queue.stored)])
    return Result(end.status, end.log, end.steps, end.attempts, end.steps.count), queue.iterations


def _is_buffer(path: Any) -> bool:
    names = [getattr(key, "name", None) for key in path]
    return names[0] in ("log", "steps") and names[-1] in BUFFERS


def _first(x: Array) -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct(x.shape[1:], x.dtype)


def _one_more(all_runs: Array) -> Array:
    """One place more, for lanes without a run."""
    return jnp.concatenate([all_runs, all_runs[:1]])


def _taken(all_runs: Array, places: Array) -> Array:
    return jnp.moveaxis(jnp.take(all_runs, places, axis=0, mode="clip"), 0, -1)


def _put(all_runs: Array, x: Array, places: Array) -> Array:
    for lane in range(x.shape[-1]):
        all_runs = lax.dynamic_update_slice(all_runs, x[None, ..., lane], (places[lane], *(0,) * (all_runs.ndim - 1)))
    return all_runs
