"""Largest values over a run, each at its located time."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..hybrid import Kind, Log
from ..mechanisms.run import Maxima
from ..mechanisms.system import ContactSystem
from .moving import shifted
from .survey import state_at, state_of_maximum


def maxima(system: ContactSystem, log: Log, start: tuple[Any, Array]) -> Maxima:
    """Return the largest values over the start (posture, closed contacts), all located events and the end."""
    at, active = start
    first = system.observables_at(at, system.derivative(jnp.zeros(()), at.state, active), active)
    located = _located(system, log)
    pairs = zip(located.others.items(), first[system.impact_contacts :], strict=True)
    return located._replace(others={name: jnp.maximum(value, begin) for (name, value), begin in pairs})


def _located(system: ContactSystem, log: Log) -> Maxima:
    """Return the largest values over all located events and the end.

    By the envelope theorem a maximum's derivative needs the state's at fixed time only; its time's needs the slope's.
    """
    contacts = system.impact_contacts

    def observe(slot: Array) -> tuple[Array, Array]:
        state, active = state_of_maximum(system, log, slot), log.active[slot]
        # After a touchdown with a jump, or a release, the rate is another than in the step that ends there.
        rate = log.rates[slot, 0]
        if system.jumps:
            rate = system.derivative(log.time[slot], state, active)
        elif system.observes_rate:
            after = system.derivative(log.time[slot], state, active)
            rate = jnp.where(log.kind[slot] == Kind.RELEASE, after, rate)
        return system.observables(state, rate, active), rate

    # Any entry may hold a maximum: of two at one instant only one is logged under its own name, and a quantity may be
    # largest at the end.
    used = jnp.arange(log.kind.shape[0]) < log.count
    if not contacts:
        return _without_contacts(system, log, used, observe)
    force = jnp.max(log.values[:, :contacts], axis=1, keepdims=True)
    # The entry of a start in contact does not know what depends on the state's rate; the start is looked at apart.
    starts = (log.kind == Kind.TOUCHDOWN) & (log.time == 0.0)
    rest = jnp.where(starts[:, None], -jnp.inf, log.values[:, contacts:])
    candidates = jnp.concatenate([force, rest], axis=1)
    slots = jnp.argmax(jnp.where(used[:, None], candidates, -jnp.inf), axis=0)
    contact = jnp.argmax(log.values[slots[0], :contacts])
    columns = jnp.concatenate([contact[None], jnp.arange(contacts, len(system.observed))])
    observables, rates = jax.vmap(observe)(slots)
    peak, *values = observables[jnp.arange(len(slots)), columns]
    others = dict(zip(system.observed[contacts:], values, strict=True))
    return Maxima(peak, _peak_time(system, log, slots[0], contact, rates[0]), contact, others)


def _without_contacts(system: ContactSystem, log: Log, used: Array, observe: Callable[[Array], Any]) -> Maxima:
    """Return the other observables' largest values: without a contact there is no force."""
    slots = jnp.argmax(jnp.where(used[:, None], log.values, -jnp.inf), axis=0)
    values = jax.vmap(observe)(slots)[0][jnp.arange(len(slots)), jnp.arange(len(slots))]
    others = dict(zip(system.observed, values, strict=True))
    return Maxima(jnp.zeros(()), jnp.zeros(()), jnp.asarray(-1), others)


def _peak_time(
    system: ContactSystem, log: Log, slot: Int[Array, ""], contact: Int[Array, ""], rate: Float[Array, " state"]
) -> Float[Array, ""]:
    """Return when a contact force is largest, with the derivative -(∂slope/∂p)/(dslope/dt)."""
    state, active = state_at(log, slot), log.active[slot]
    slope = jax.jvp(lambda y: system.normal_force_at(system.evaluate(y), active), (state,), (rate,))[1]
    its_own = (log.kind[slot] == Kind.PEAK) & (log.which[slot] == contact)
    if system.jumps:
        touchdown = (log.kind[slot] == Kind.TOUCHDOWN) & (log.which[slot] == contact) & (log.time[slot] > 0.0)
        slope = jnp.where(touchdown, system.gaps(state)[: system.impact_contacts], slope)
        its_own = its_own | touchdown
    # Where the force is largest without being stationary its time moves with that event alone: an infinite rate adds
    # nothing.
    return shifted(log.time[slot], -slope[contact], jnp.where(its_own, log.guard_rate[slot], jnp.inf))
