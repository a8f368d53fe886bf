"""A run in intervals: what one ends with, the next goes on from, with other loads or parameters.

An interval is differentiated by the state that it starts from and by every number of the system. As in `solve`,
tangents are integrated beside the state under the same error control; here those by the state's own numbers are among
them.
"""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from .event_times import moving
from .events.bracketing import Bracket
from .lanes import one_by_one
from .loop.log import Kind, Log, Steps
from .loop.loop import loop_from
from .loop.phase import Phase
from .loop.state import LoopState, Status, initial_state
from .loop.task import Task
from .options import Options
from .sensitivity.augmented_state import Rows, Tangents, push_through_assembly
from .solve import EVENT_TIME, SHORTFALL, motion
from .system import HybridSystem

Build = Callable[..., HybridSystem]


class Checkpoint(NamedTuple):
    """Where a run stands between two intervals.

    ``time`` [s]; ``state``; ``largest``: the largest value of each observable so far; ``touchdowns`` of each contact so
    far; ``loop``: all else that the loop goes on with: modes, step sizes, status; ``event_time`` [s]: how closely
    events are located. Derivatives are those of ``state`` and ``largest``, and of the ``time`` at which a guard ends
    the run.
    """

    time: Float[Array, ""]
    state: Float[Array, " state"]
    largest: Float[Array, " observables"]
    touchdowns: Int[Array, " contacts"]
    loop: LoopState
    event_time: Float[Array, ""]

    @property
    def running(self) -> Array:
        """Return whether the run has not ended."""
        return self.loop.status == Status.RUNNING


class _Interval(NamedTuple):
    """One interval: the ``log`` of its events, and the loop's state at its ``end``."""

    log: Log
    end: LoopState


def first_checkpoint(build: Build, parameters: Any, options: Options, allowed: Any = None) -> Checkpoint:
    """Return the start of a run of the system ``build(*parameters)``.

    **Arguments:** ``options``; ``allowed``: as of `solve`.
    """
    system = build(*parameters)
    state, active = system.start()
    largest = system.observables(state, system.derivative(0.0, state, active), active)
    # The loop's own state has no derivatives: an interval's begin with the state.
    still = jax.lax.stop_gradient(system)
    task = Task.of(lambda it: it, Tangents(still), jnp.asarray(jnp.inf), options)
    loop = initial_state(task, allowed)._replace(logged=jax.lax.stop_gradient(largest), attempts=jnp.asarray(1))
    return Checkpoint(
        jnp.zeros(()), state, largest, (active > 0.5).astype(int), _stripped(loop), jnp.asarray(task.event_time)
    )


def next_checkpoint(
    build: Build, parameters: Any, before: Checkpoint, length: Float[Array, ""], options: Options, sizes: Any
) -> Checkpoint:
    """Step a run on by an interval, or to its end if that comes first; a run that has ended stays as it is.

    **Arguments:** ``build``, ``parameters``: the system of the interval, ``build(*parameters)``, whose start counts for
    nothing; ``before``: where the interval starts; ``length`` [s]; ``options``, whose room for events is that of one
    interval; ``sizes``: as ``parameters``, how large a change of each is that matters, None for its own size.
    """
    loop = jax.lax.stop_gradient(before.loop)
    until = loop.point.time + length
    options = dataclasses.replace(options, event_time=jax.lax.stop_gradient(before.event_time))
    interval = _interval((before.state, parameters), loop, build, until, options, sizes)
    log, end = moving(interval.log, parameters, build), interval.end
    last = jnp.maximum(log.count - 1, 0)
    # A run that had ended, or that failed at once, has logged nothing.
    ended = log.count > 0
    values = jnp.where(log.used[:, None], log.values, -jnp.inf)
    contacts = jnp.arange(before.touchdowns.shape[0])
    touched = jnp.sum(
        (log.used & (log.kind == Kind.TOUCHDOWN))[:, None] & (log.which[:, None] == contacts[None]), axis=0
    )
    return Checkpoint(
        time=jnp.where(ended, log.time[last], before.time),
        state=jnp.where(ended, log.rows[last, 0], before.state),
        largest=jnp.maximum(before.largest, jnp.max(values, axis=0)),
        touchdowns=before.touchdowns + touched + log.missed,
        loop=end,
        event_time=before.event_time,
    )


@eqx.filter_custom_jvp
def _interval(
    moved: tuple[Array, Any], loop: LoopState, build: Build, until: Array, options: Options, sizes: Any
) -> _Interval:
    """Step through an interval; derivatives by the state and the parameters, ``moved``, are at fixed times."""
    state, parameters = moved

    def state_alone(state: Array, parameters: Any, *others: Any) -> _Interval:
        return _through(lambda system: system, Tangents(build(*parameters)), state[None], *others)

    return one_by_one(state_alone, state, parameters, loop, until, options)


@_interval.def_jvp
def _interval_jvp(primals: tuple, tangents: tuple) -> tuple[_Interval, _Interval]:
    ((state, parameters), loop, build, until, options, sizes), ((state_moves, parameters_move), *_) = primals, tangents
    leaves, structure = jax.tree.flatten(parameters, is_leaf=_is_none)
    moves = jax.tree.leaves(parameters_move, is_leaf=_is_none)
    of_sizes = jax.tree.leaves(sizes, is_leaf=_is_none)
    chosen = [i for i, move in enumerate(moves) if move is not None]
    # Tangents need a number of the system that they may change, though none has been asked for.
    chosen = chosen or [len(leaves) - 1]
    values = [leaves[i] for i in chosen]
    scale = jnp.stack([_size(leaves[i], of_sizes[i]) for i in chosen])
    options = dataclasses.replace(options, event_time=jnp.asarray(EVENT_TIME), shortfall=jnp.asarray(SHORTFALL))

    def with_tangents(state: Array, values: list[Array], others: list[Array], scale: Array, *rest: Any) -> Any:
        def assembled(values: list[Array]) -> HybridSystem:
            filled = list(others)
            for i, value in zip(chosen, values, strict=True):
                filled[i] = value
            return build(*jax.tree.unflatten(structure, filled))

        pushed = push_through_assembly(assembled, motion, values, scale)
        of_state = assembled(values).scales()
        own = jnp.diag(of_state) if state_moves is not None else jnp.zeros((0, state.shape[0]))
        none = jnp.zeros((len(pushed.moving), state.shape[0]))
        # The system does not change along the tangents by the state's own numbers.
        still = lambda it: jnp.pad(it, [(own.shape[0], 0)] + [(0, 0)] * (it.ndim - 1))  # noqa: E731
        directions = jax.tree.map(still, pushed.tangents.directions)
        rows = jnp.concatenate([state[None], own, none])
        interval = _through(pushed.fill, Tangents(pushed.tangents.primal, directions), rows, *rest)
        # A one at the row of each value that moves the system; of the others there is no row.
        places = (jnp.arange(len(values))[:, None] == jnp.asarray(pushed.moving, int)[None]).astype(float)
        return interval, of_state, places

    interval, of_state, places = one_by_one(with_tangents, state, values, leaves, scale, loop, until, options)
    by_value = jnp.stack([jnp.zeros(()) if moves[i] is None else moves[i] for i in chosen]) / scale
    by_state = jnp.zeros(0) if state_moves is None else state_moves / of_state
    shares = jnp.concatenate([by_state, by_value @ places])
    rows_move = jnp.sum(interval.log.rows[:, 1:] * shares[None, :, None], axis=1, keepdims=True)
    none = jax.tree.map(lambda _: None, interval)
    changed = dataclasses.replace(none.log, rows=rows_move)
    log = dataclasses.replace(interval.log, rows=interval.log.rows[:, :1], rates=interval.log.rates[:, :1])
    return interval._replace(log=log), none._replace(log=changed)


def _through(
    build: Callable[[Any], HybridSystem],
    tangents: Tangents[Any],
    rows: Rows,
    loop: LoopState,
    until: Array,
    options: Options,
) -> _Interval:
    """Step rows through an interval."""
    task = Task.of(build, tangents, until, options)
    log = Log.empty(options.max_events, rows, task.contacts, task.observables)
    point = loop.point._replace(rows=rows, rate=jnp.zeros_like(rows))
    # What the system does may have changed, so that the derivative is evaluated again.
    start = loop._replace(
        point=point,
        phase=jnp.asarray(int(Phase.REEVALUATE)),
        bracket=Bracket.none(),
        step_end=point,
        first_values=jnp.zeros(task.observables),
        log=log,
        steps=Steps.empty(0, rows, task.contacts),
    )
    end = loop_from(task, start)
    status = jnp.where(end.status == Status.TIMEOUT, int(Status.RUNNING), end.status)
    return _Interval(end.log, _stripped(end._replace(status=status, attempts=jnp.asarray(1))))


def _stripped(loop: LoopState) -> LoopState:
    """Return the loop's state without what an interval makes anew."""
    none: Any = None
    point = loop.point._replace(rows=none, rate=none)
    return loop._replace(point=point, phase=none, bracket=none, step_end=none, first_values=none, log=none, steps=none)


def _size(value: Array, size: Array | None) -> Float[Array, ""]:
    own = jnp.where(value == 0.0, 1.0, jnp.abs(value))
    return own if size is None else jnp.maximum(jnp.abs(value), size)


def _is_none(x: Any) -> bool:
    return x is None
