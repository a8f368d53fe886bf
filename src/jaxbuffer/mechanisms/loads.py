"""How hard each impact is: the effective kinetic energy before it, and when its compression ends (M200 to M203).

Both follow from a run's log and are computed after the run, where they are asked for.
"""

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..hybrid import Kind, Log
from ..plane import ldl_solve
from ..programs.cache import Static, stored
from .registry import mechanism_of
from .system import ContactSystem

SIMULTANEOUS = 1e-9  # s, far below any impact's duration, and above what touchdowns are located to
FINEST, GROWTH, STEPS = 0.05, 1.03, 96  # steps of M203: the first, over the time to the largest force; how they grow
LAST = 4  # steps along the closing speed


@functools.partial(stored, what="the loads of impacts")
def load(
    name: Static, parameters: tuple[Any, Any, Any], log: Log, numbers: Int[Array, " impacts"]
) -> Float[Array, " impacts"]:
    """Return one load of some impacts, by their ``numbers`` from 0, with derivatives as the impacts move.

    **Arguments:** ``name``: of the load, a key of `LOADS`; ``parameters``: design, scenario and Baumgarte's gain [1/s];
    ``log`` of the run, with derivatives at fixed times. **Returns:** it, NaN for what is no impact.
    """
    system = mechanism_of(parameters[0]).system(*parameters)
    slots, contacts = jnp.arange(log.kind.shape[0]), system.impact_contacts
    if not contacts:
        return jnp.full(numbers.shape, jnp.nan)
    touch = (log.kind == Kind.TOUCHDOWN) & (log.which < contacts) & (slots < log.room)
    of = LOADS[name.value]
    # Touchdowns first: a stable sort keeps their order, and the size is known when compiling.
    touchdowns = jnp.argsort(~touch, stable=True)[numbers]
    return jax.vmap(lambda slot: jnp.where(touch[slot], of(system, log, touch, slot), jnp.nan))(touchdowns)


def _effective_energy(
    system: ContactSystem, log: Log, touch: Bool[Array, " slots"], slot: Int[Array, ""]
) -> Float[Array, ""]:
    """Return T_c⁻ [J] over the contacts that are closed after the touchdown at a slot.

    Touchdowns that no impact could tell apart are one impact: each of them counts the contacts of all.
    """
    state, rate, contacts = log.rows[slot, 0], log.rates[slot, 0], system.impact_contacts
    closed = log.active[slot, :contacts] > 0.5
    # At one instant every other contact can touch down once at most, and their entries follow this one's.
    for later in range(1, contacts):
        following = jnp.minimum(slot + later, log.kind.shape[0] - 1)
        together = touch[following] & (log.time[following] - log.time[slot] <= SIMULTANEOUS)
        closed = closed | together & (jnp.arange(contacts) == log.which[following])
    if system.jumps:  # the log has the rate just before the touchdown, and sensitivities just after it
        rate = system.derivative(log.time[slot], state, log.active[slot])
    # The state at the touchdown as it moves.
    state = state + jax.lax.stop_gradient(rate) * system.time_to_contact(state, log.which[slot])
    return effective_energy(system, state, closed)


def effective_energy(
    system: ContactSystem, state: Float[Array, " state"], closed: Bool[Array, " contacts"]
) -> Float[Array, ""]:
    """Return T_c [J] of a state along the normals of the contacts that are ``closed``, of those that have impacts
    (M200)."""
    at = system.evaluate(state)
    # An open contact is a row and a column of the identity, with no speed.
    inverse = jnp.where(closed[:, None] & closed[None], system.inverse_masses_at(at), jnp.eye(closed.shape[0]))
    speeds = jnp.where(closed, system.gaps_at(at)[1][: closed.shape[0]], 0.0)
    return 0.5 * jnp.sum(speeds * ldl_solve(inverse, speeds))


def _compression_end(
    system: ContactSystem, log: Log, touch: Bool[Array, " slots"], slot: Int[Array, ""]
) -> Float[Array, ""]:
    """Return when the contact that touches down at a slot is no longer closing [s] (M203); NaN if the run ends before.

    From the largest force on, which no law has later than the deepest penetration, the contact goes on closing. Steps
    are short where the closing speed changes fast, and long where a damper alone slows it down; the last ones are along
    the closing speed itself, so that the end needs no search. NaN where all steps do not get there.
    """
    slots, contact = jnp.arange(log.kind.shape[0]), log.which[slot]
    used = slots < jnp.minimum(log.count, log.room)
    later = used & (slots > slot) & (log.which == contact)
    following = jnp.min(jnp.where(later & touch, slots, slots.shape[0]))
    force = log.values[:, contact]
    top = jnp.argmax(jnp.where(used & (slots >= slot) & (slots < following), force, -jnp.inf))
    released = later & (slots < following) & (log.kind == Kind.RELEASE)
    last = jnp.where(jnp.any(released), log.time[jnp.argmax(released)], log.time[jnp.maximum(log.count - 1, 0)])
    active = log.active[top]

    def closing(state: Array) -> Array:
        return system.gaps_at(system.evaluate(state))[1][contact]

    def rates(point: Array) -> tuple[Array, Array]:
        """Return the rates of state and time, and of the closing speed."""
        rate = system.derivative(log.time[top], point[:-1], active)
        return jnp.append(rate, 1.0), jax.jvp(closing, (point[:-1],), (rate,))[1]

    begin, start = log.rows[slot, 0], jnp.append(log.rows[top, 0], log.time[top])
    # These two only measure the steps: where they lead does not depend on them, and neither do its derivatives.
    speed = jax.lax.stop_gradient(closing(begin))
    time = jax.lax.stop_gradient(jnp.maximum(log.time[top] - log.time[slot], system.impact_step(begin)))

    def by_arc(point: Array) -> Array:
        rate, change = rates(point)
        return rate / jnp.sqrt((change / speed) ** 2 + 1.0 / time**2)

    def by_speed(point: Array) -> Array:
        rate, change = rates(point)
        return rate / change

    def onwards(point: Array, step: Array) -> tuple[Array, None]:
        after = _stepped(by_arc, point, step)
        # A step that goes beyond the end of compression is not taken: the steps along the speed finish.
        return jnp.where(closing(after[:-1]) > 0.0, after, point), None

    near = jax.lax.scan(onwards, start, FINEST * GROWTH ** jnp.arange(STEPS))[0]
    # With the closing speed as the variable the last step ends exactly where it is zero (Hénon's step).
    step = -closing(near[:-1]) / LAST
    end = jax.lax.fori_loop(0, LAST, lambda _, point: _stepped(by_speed, point, step), near)[-1]
    return jnp.where((end >= log.time[slot]) & (end <= last), end, jnp.nan)


def _stepped(slope: Callable[[Array], Array], point: Array, step: Array) -> Array:
    """Return the point after a step of the classical Runge-Kutta method."""
    first = slope(point)
    second = slope(point + 0.5 * step * first)
    third = slope(point + 0.5 * step * second)
    return point + step / 6.0 * (first + 2.0 * (second + third) + slope(point + step * third))


LOADS = {"effective_energy": _effective_energy, "compression_end": _compression_end}
