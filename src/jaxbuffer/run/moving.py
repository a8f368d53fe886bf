"""A run's log with derivatives as its events move with the parameters (docs/model.md, events)."""

import dataclasses

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..hybrid import Kind, Log
from .survey import Survey


def moving_end(log: Log, time: Float[Array, ""], state: Float[Array, " state"]) -> Log:
    """Return the log with an end that moves with the parameters, to a ``time`` [s] and a ``state``. Values stay as they
    are."""
    last = jnp.maximum(log.count - 1, 0)
    return dataclasses.replace(log, time=log.time.at[last].set(time), rows=log.rows.at[last, 0].set(state))


def moving_events(log: Log, events: Survey) -> Log:
    """Return the log with touchdowns and releases that move with the parameters: to the time at which the gap is
    zero."""
    gap = jnp.take_along_axis(events.gap, (log.which % events.gap.shape[1])[:, None], axis=1)[:, 0]
    touch = (log.kind == Kind.TOUCHDOWN) & (log.time > 0.0)  # a run that starts in contact does so at t = 0
    guard = jnp.where(touch, -gap, jnp.where(log.kind == Kind.RELEASE, gap, 0.0))
    return dataclasses.replace(log, time=jax.vmap(shifted)(log.time, guard, log.guard_rate))


# A rule of its own: the value stays the located one to the last digit, the derivative is that of the guard's zero.
@jax.custom_jvp
def shifted(time: Array, guard: Array, rate: Array) -> Float[Array, ""]:
    """Return an event's time [s]: the located one, with the derivative -(∂g/∂p)/ġ of where the guard g crosses zero."""
    return time


@shifted.defjvp
def _shifted_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    (time, _, rate), (time_moves, guard_moves, _) = primals, tangents
    return time, time_moves - guard_moves / rate


@jax.custom_jvp
def carried(state: Array, rate: Array, time: Array) -> Float[Array, " state"]:
    """Return a state as it is, with the derivative at a time that moves. Its own rate counts only with the time that
    locating the event leaves open, which is next to nothing: how that rate changes does not matter."""
    return state


@carried.defjvp
def _carried_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    return primals[0], tangents[0] + primals[1] * tangents[2]
