"""What a run remembers: located events, and accepted steps when a history is wanted.

A run with more events than its log has room for goes on: of the later ones the log keeps the end and, of each
observable, the highest maximum, counts touchdowns and adds up the time in contact.

Both are fixed-size buffers with a spare slot at the end that takes the writes of iterations with nothing to record, so
that every write is a plain slice update and stays in place inside a compiled loop.
"""

import dataclasses
import enum
from typing import TypeVar

import equinox as eqx
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from ..sensitivity.augmented_state import Rows

B = TypeVar("B", "Log", "Steps")
UNMOVED = 1e300  # guard rate of an entry at which no guard is zero: its time does not move with the parameters


class Kind(enum.IntEnum):
    """What an entry of the log records."""

    NONE = -1
    TOUCHDOWN = 0
    RELEASE = 1
    PEAK = 2
    END = 3


class Log(eqx.Module):
    """Located events in order of time.

    ``which``: the contact, observable or terminal guard concerned; ``active``: closed contacts after the event;
    ``values``: all observables; ``guard_rate``: rate of the signed guard at its zero, so that the
    event's time shifts by -guard/guard_rate; ``rows``: state after the event, and its sensitivities at that fixed time;
    ``rates``: their derivatives just before it (where a contact opens or closes, its force's share in those of
    sensitivities is rounding).

    ``latest``: time of the last event [s]. Of events that found no room: ``missed``, each contact's touchdowns;
    ``missed_values``, each observable's largest value at an event of its own (zero for none); ``missed_time``, time in
    contact until them [s].
    """

    kind: Int[Array, " slots"]
    which: Int[Array, " slots"]
    time: Float[Array, " slots"]
    values: Float[Array, "slots observables"]
    guard_rate: Float[Array, " slots"]
    active: Float[Array, "slots contacts"]
    rows: Float[Array, "slots rows state"]
    rates: Float[Array, "slots rows state"]
    count: Int[Array, ""]
    latest: Float[Array, ""]
    missed: Int[Array, " contacts"]
    missed_values: Float[Array, " observables"]
    missed_time: Float[Array, ""]

    @property
    def room(self) -> int:
        """Return how many events are stored in order; then come a slot for each observable, the end's and a spare
        one."""
        return self.kind.shape[-1] - self.values.shape[-1] - 2

    @property
    def overflown(self) -> Bool[Array, ""]:
        """Return whether there were more events than room."""
        return self.count > self.room

    @property
    def used(self) -> Bool[Array, " slots"]:
        """Return which slots hold an event: those behind the count may hold anything, and of a full log those of
        observables that had no later maximum hold none."""
        return (jnp.arange(self.kind.shape[-1]) < self.count[..., None]) & (self.kind != Kind.NONE)

    def with_start_values(self, values: Float[Array, " observables"]) -> "Log":
        """Return the log with the observables of a start in contact."""
        starts = (self.kind == Kind.TOUCHDOWN) & (self.time == 0.0)
        return dataclasses.replace(self, values=jnp.where(starts[:, None], values[None], self.values))

    def with_last_values(self, when: Bool[Array, ""], values: Float[Array, " observables"]) -> "Log":
        """Return the log with these observables in its last entry if ``when``; the log is not overflown."""
        slot = jnp.where(when, self.count - 1, self.kind.shape[0] - 1)
        return _put(self, {"values": values}, slot)

    @staticmethod
    def empty(slots: int, rows: Rows, contacts: int, observables: int) -> "Log":
        """Return an empty log with room for ``slots`` events in order.

        Unused slots hold the start: whatever is computed from them is thrown away, but it must stay finite, or
        reverse-mode derivatives turn it into NaN.
        """
        n = slots + observables + 2
        none, zero = jnp.full(n, int(Kind.NONE)), jnp.zeros(n)
        start = jnp.broadcast_to(rows, (n, *rows.shape))
        return Log(
            kind=none,
            which=none,
            time=zero,
            values=jnp.zeros((n, observables)),
            guard_rate=jnp.ones(n),
            active=jnp.zeros((n, contacts)),
            rows=start,
            rates=0.0 * start,
            count=jnp.asarray(0),
            latest=jnp.zeros(()),
            missed=jnp.zeros(contacts, int),
            missed_values=jnp.zeros(observables),
            missed_time=jnp.zeros(()),
        )

    def append(
        self,
        when: Bool[Array, ""],
        kind: Int[Array, ""],
        which: Int[Array, ""],
        time: Float[Array, ""],
        values: Float[Array, " observables"],
        guard_rate: Float[Array, ""],
        active: Float[Array, " contacts"],
        rows: Rows,
        rates: Rows,
        touching: Bool[Array, ""],
    ) -> "Log":
        """Append an entry if ``when``; ``touching``: whether there was contact since the last event."""
        end, spare = self.kind.shape[0] - 2, self.kind.shape[0] - 1
        missed = when & (self.count >= self.room)
        # Observables of contacts come first, so a touchdown's slot is that of its force.
        its_own = (jnp.arange(values.shape[0]) == which) & ((kind == Kind.PEAK) | (kind == Kind.TOUCHDOWN))
        none_yet = (self.kind[self.room : self.room + values.shape[0]] == Kind.NONE) & (kind == Kind.PEAK)
        higher = its_own & (none_yet | (values > self.missed_values))
        # Of what finds no room, each observable's highest maximum has a slot of its own, and so has the end.
        beyond = jnp.where(kind == Kind.END, end, jnp.where(jnp.any(higher), self.room + which, spare))
        slot = jnp.where(missed, beyond, jnp.where(when, self.count, spare))
        entry = {
            "kind": jnp.where(slot == spare, int(Kind.NONE), kind),
            "which": which,
            "time": time,
            "values": values,
            "guard_rate": guard_rate,
            "active": active,
            "rows": rows,
            "rates": rates,
        }
        touchdown = (jnp.arange(self.missed.shape[0]) == which) & (kind == Kind.TOUCHDOWN)
        return dataclasses.replace(
            _put(self, entry, slot),
            # Once the log is full, any slot but the spare one may be in use: readers look at the kind of each.
            count=jnp.where(missed, self.kind.shape[0] - 1, self.count + when),
            latest=jnp.where(when, time, self.latest),
            missed=self.missed + (missed & touchdown),
            missed_values=jnp.where(missed & higher, values, self.missed_values),
            missed_time=self.missed_time + jnp.where(missed & touching, time - self.latest, 0.0),
        )


class Steps(eqx.Module):
    """Accepted steps: time, closed contacts, state and its sensitivities at that fixed time."""

    time: Float[Array, " slots"]
    active: Float[Array, "slots contacts"]
    rows: Float[Array, "slots rows state"]
    count: Int[Array, ""]

    @staticmethod
    def empty(slots: int, rows: Rows, contacts: int) -> "Steps":
        """Return an empty history with room for ``slots`` steps; 0 stores none at all."""
        n = slots + 1 if slots else 0
        return Steps(jnp.zeros(n), jnp.zeros((n, contacts)), jnp.zeros((n, *rows.shape)), jnp.asarray(0))

    def append(
        self,
        when: Bool[Array, ""],
        time: Float[Array, ""],
        active: Float[Array, " contacts"],
        rows: Rows,
    ) -> "Steps":
        """Append a step if ``when`` and there is room; ``count`` goes on counting."""
        spare = self.time.shape[0] - 1
        if spare < 0:
            return dataclasses.replace(self, count=self.count + when)
        slot = jnp.where(when, jnp.minimum(self.count, spare), spare)
        entry = {"time": time, "active": active, "rows": rows}
        return dataclasses.replace(_put(self, entry, slot), count=self.count + when)


def _put(buffers: B, entry: dict[str, Array], slot: Int[Array, ""]) -> B:
    """Write the items of an entry into one slot of the buffers it names."""
    # A slice update stays in place; a scatter would split the loop's kernel.
    put = lax.dynamic_update_index_in_dim
    new = {
        name: put(getattr(buffers, name), jnp.asarray(item, getattr(buffers, name).dtype), slot, 0)
        for name, item in entry.items()
    }
    return dataclasses.replace(buffers, **new)
