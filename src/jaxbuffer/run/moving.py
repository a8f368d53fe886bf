"""A run's log with derivatives as its events move with the parameters (docs/model.md, events)."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..hybrid import UNMOVED, Kind, Log
from ..mechanisms.system import ContactSystem
from .survey import Survey


def moving_maxima(system: ContactSystem, log: Log) -> Log:
    """Return the log with states at maxima whose derivatives go with the motion: each parameter moves the maximum's
    time by as much as leaves the least change of position and velocity.

    At a maximum this adds nothing to what is largest there, since its rate is zero; but the time of an event is known
    to 1e-13 s at best. Where a force is as sharp as some microseconds and a parameter delays its impact by a second,
    the derivative at a fixed time holds the force's rate over that uncertainty times the delay.
    """
    ours = (log.kind == Kind.PEAK) & (log.guard_rate < UNMOVED)
    state = _with_the_motion(log.rows[:, 0], system, log.active, ours)
    return dataclasses.replace(log, rows=log.rows.at[:, 0].set(state))


# A rule of its own, since the states' rates are asked for by derivatives alone. Those in the log are a little beside.
@eqx.filter_custom_jvp
def _with_the_motion(
    states: Float[Array, "slots state"], system: ContactSystem, active: Array, maximum: Bool[Array, " slots"]
) -> Float[Array, "slots state"]:
    """Return states as they are, whose changes, at a ``maximum``, have lost what a delay explains of them."""
    return states


@_with_the_motion.def_jvp
def _with_the_motion_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    (states, system, active, maximum), (changes, *_) = primals, tangents
    if changes is None:
        return states, jnp.zeros_like(states)

    def moved(state: Array, change: Array, active: Array, maximum: Array) -> Array:
        rate = system.derivative(jnp.zeros(()), state, active)
        along, of = (jnp.concatenate([x[system.places[name]] for name in ("q", "v")]) for x in (rate, change))
        size = jnp.vdot(along, along)
        delay = -jnp.vdot(along, of) / jnp.where(size > 0.0, size, 1.0)
        return change + jnp.where(maximum, delay, 0.0) * rate

    return states, jax.vmap(moved)(states, changes, active, maximum)


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
