"""Largest values over a run, each at its located time."""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..hybrid import Kind, Log
from ..mechanisms.run import Maxima
from ..mechanisms.system import ContactSystem
from .readings import Readings


class Places(NamedTuple):
    """Where in a log something is largest: the entry, ``slots``, and the observable, ``columns``, of the largest
    contact force, if there are contacts, and then of each other observable."""

    slots: Int[Array, " maxima"]
    columns: Int[Array, " maxima"]


def places_of(system: ContactSystem, log: Log) -> Places:
    """Return where in a log the largest contact force is, and each other observable."""
    contacts = system.impact_contacts
    # Any entry may hold a maximum: of two at one instant only one is logged under its own name, and a quantity may be
    # largest at the end.
    # The entry of a start in contact does not know what depends on the state's rate; the start is looked at apart.
    starts = (log.kind == Kind.TOUCHDOWN) & (log.time == 0.0)
    candidates = jnp.where(starts[:, None], -jnp.inf, log.values[:, contacts:])
    others = jnp.arange(contacts, log.values.shape[1])
    if contacts:
        force = jnp.max(log.values[:, :contacts], axis=1, keepdims=True)
        candidates = jnp.concatenate([force, candidates], axis=1)
    slots = jnp.argmax(jnp.where(log.used[:, None], candidates, -jnp.inf), axis=0)
    if not contacts:
        return Places(slots, others)
    contact = jnp.argmax(log.values[slots[0], :contacts])
    return Places(slots, jnp.concatenate([contact[None], others]))


def maxima(system: ContactSystem, log: Log, places: Places, read: Readings) -> Maxima:
    """Return the largest values over the start, all located events and the end."""
    contacts, values = system.impact_contacts, read.largest[jnp.arange(len(places.columns)), places.columns]
    located = values[1:] if contacts else values
    largest = jnp.maximum(located, read.start.observables[contacts:])
    others = dict(zip(system.observed[contacts:], largest, strict=True))
    if not contacts:  # there is no force
        return Maxima(jnp.zeros(()), jnp.zeros(()), jnp.asarray(-1), others)
    return Maxima(values[0], _peak_time(system, log, places), places.columns[0], others)


def _peak_time(system: ContactSystem, log: Log, places: Places) -> Float[Array, ""]:
    """Return when a contact force is largest, with the derivative -(∂slope/∂p)/(dslope/dt)."""
    slot, contact = places.slots[0], places.columns[0]
    its_own = (log.kind[slot] == Kind.PEAK) & (log.which[slot] == contact)
    # Where the force is largest without being stationary its time moves with that event alone: an infinite rate adds
    # nothing.
    rate = jnp.where(its_own, log.guard_rate[slot], jnp.inf)
    point = (log.rows[slot, 0], log.rates[slot, 0])
    return _with_slope(log.time[slot], system, point, log.active[slot], contact, rate)


@eqx.filter_custom_jvp
def _with_slope(
    time: Array, system: ContactSystem, point: tuple[Array, Array], active: Array, contact: Array, rate: Array
) -> Float[Array, ""]:
    """Return the time of a maximum [s] with the derivative of where the force's slope is zero. A rule of its own, since
    the slope is asked for by derivatives alone.

    **Arguments:** ``point``: the state and its rate; ``active``; ``contact``: whose force it is; ``rate``: how fast the
    slope falls [N/s²].
    """
    return time


@_with_slope.def_jvp
def _with_slope_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    (time, system, point, active, contact, rate), (time_moves, *moves) = primals, tangents

    def slope(system: ContactSystem, point: tuple[Array, Array]) -> Array:
        force = lambda state: system.normal_force(state, active)[contact]  # noqa: E731
        return jax.jvp(force, point[:1], point[1:])[1]

    change: Any = eqx.filter_jvp(slope, (system, point), tuple(moves[:2]))[1]
    still = jnp.zeros_like(time)
    return time, (still if time_moves is None else time_moves) + (still if change is None else change) / rate
