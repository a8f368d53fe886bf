"""The impacts of a run, one by one, and the time in contact."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..hybrid import Kind, Log
from ..mechanisms.impacts import Impacts
from ..mechanisms.system import ContactSystem
from .survey import Survey


def impacts(system: ContactSystem, log: Log, events: Survey) -> Impacts:
    """Return all impacts of a run whose log's events move (`moving_events`)."""
    contacts = system.impact_contacts
    if not contacts:
        none = jnp.zeros(log.kind.shape[0])
        return Impacts(none, jnp.full(none.shape, -1), none, none, none, jnp.asarray(0))
    # Beyond the room come the highest maxima of later events, which are not in order of time.
    in_order = jnp.arange(log.kind.shape[0]) < log.room
    touch, contact = (log.kind == Kind.TOUCHDOWN) & (log.which < contacts) & in_order, log.which % contacts
    speed = jax.vmap(lambda row, contact: system.memory(row)[contact])(log.rows[:, 0], contact)
    top, release = _impact_ends(log, contacts)
    peak = jnp.maximum(events.force[top, contact], 0.0)

    # Touchdowns first: a stable sort keeps their order, and the size is known when compiling.
    picked = jnp.argsort(~touch, stable=True)
    present = touch[picked]
    return Impacts(
        time=jnp.where(present, log.time[picked], 0.0),
        contact=jnp.where(present, log.which[picked], -1),
        approach_speed=jnp.where(present, speed[picked], 0.0),
        peak_force=jnp.where(present, peak[picked], 0.0),
        release_time=jnp.where(present, release[picked], 0.0),
        count=jnp.sum(touch),
    )


def _impact_ends(log: Log, contacts: int) -> tuple[Int[Array, " slots"], Float[Array, " slots"]]:
    """Return, for the slot of each touchdown, the slot where that contact's force is largest until its next touchdown,
    and the time of its release [s] (NaN where there is none). One pass over the entries in use finds them."""
    slots, each = log.kind.shape[0], jnp.arange(contacts)
    force = log.values[:, :contacts]

    def visit(carry: tuple[Array, Array, Array, Array]) -> tuple[Array, Array, Array, Array]:
        slot, under_way, top, end = carry
        mine = each == log.which[slot]
        under_way = jnp.where(mine & (log.kind[slot] == Kind.TOUCHDOWN), slot, under_way)
        for contact in range(contacts):
            touchdown = under_way[contact]
            better = (touchdown < slots) & (force[slot, contact] > force[top[touchdown], contact])
            # A contact without a touchdown yet has an index beyond the end, and drops what it would write.
            top = top.at[touchdown].set(jnp.where(better, slot, top[touchdown]), mode="drop")
            releases = mine[contact] & (log.kind[slot] == Kind.RELEASE)
            end = end.at[touchdown].set(jnp.where(releases, slot, end[touchdown]), mode="drop")
        return slot + 1, under_way, top, end

    begin = (jnp.asarray(0), jnp.full(contacts, slots), jnp.arange(slots), jnp.full(slots, -1))
    last = jnp.minimum(log.count, log.room)
    _, _, top, end = jax.lax.while_loop(lambda carry: carry[0] < last, visit, begin)
    return top, jnp.where(end >= 0, log.time[end], jnp.nan)


def contact_time(system: ContactSystem, log: Log) -> Float[Array, ""]:
    """Return the time during which at least one contact that has impacts is closed [s]; its derivative is NaN if events
    found no room in the log."""
    last = jnp.minimum(jnp.maximum(log.count - 1, 0), log.room - 1)
    touching = jnp.any(log.active[:, : system.impact_contacts] > 0.5, axis=1)
    inside = (jnp.arange(log.kind.shape[0]) < last) & touching
    following = jnp.append(log.time[1:], 0.0)
    listed = jnp.sum(jnp.where(inside, following - log.time, 0.0))
    return _undifferentiable(listed + log.missed_time, log.overflown)


# A rule of its own, since NaN added to the value for its derivative would show in the value.
@jax.custom_jvp
def _undifferentiable(value: Array, where: Array) -> Float[Array, ""]:
    """Return the value, whose derivative is NaN ``where`` it is not known."""
    return value


@_undifferentiable.defjvp
def _undifferentiable_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    return primals[0], tangents[0] * jnp.where(primals[1], jnp.nan, 1.0)
