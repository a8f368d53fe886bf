"""What a run remembers: located events, and accepted steps when a history is wanted.

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

from .lanes import Rows

B = TypeVar("B", "Log", "Steps")


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

    @staticmethod
    def empty(slots: int, rows: Rows, contacts: int, observables: int) -> "Log":
        """A log with room for ``slots`` events.

        Unused slots hold the start: whatever is computed from them is thrown away, but it must stay finite, or
        reverse-mode derivatives turn it into NaN.
        """
        n = slots + 1
        none, zero = jnp.full(n, int(Kind.NONE)), jnp.zeros(n)
        start = jnp.broadcast_to(rows, (n, *rows.shape))
        values = jnp.zeros((n, observables))
        return Log(none, none, zero, values, jnp.ones(n), jnp.zeros((n, contacts)), start, 0.0 * start, jnp.asarray(0))

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
    ) -> "Log":
        """The log with one more entry if ``when``."""
        entry = (jnp.where(when, kind, int(Kind.NONE)), which, time, values, guard_rate, active, rows, rates)
        slot = jnp.where(when, self.count, self.kind.shape[0] - 1)
        return _put(self, entry, slot, self.count + when)


class Steps(eqx.Module):
    """Accepted steps: time, closed contacts, state and its sensitivities at that fixed time."""

    time: Float[Array, " slots"]
    active: Float[Array, "slots contacts"]
    rows: Float[Array, "slots rows state"]
    count: Int[Array, ""]

    @staticmethod
    def empty(slots: int, rows: Rows, contacts: int) -> "Steps":
        """Room for ``slots`` steps; none at all for 0."""
        n = slots + 1 if slots else 0
        return Steps(jnp.zeros(n), jnp.zeros((n, contacts)), jnp.zeros((n, *rows.shape)), jnp.asarray(0))

    def append(
        self,
        when: Bool[Array, ""],
        time: Float[Array, ""],
        active: Float[Array, " contacts"],
        rows: Rows,
    ) -> "Steps":
        """One more step if ``when`` and there is room; ``count`` goes on counting."""
        spare = self.time.shape[0] - 1
        if spare < 0:
            return dataclasses.replace(self, count=self.count + when)
        slot = jnp.where(when, jnp.minimum(self.count, spare), spare)
        entry = (time, active, rows)
        return _put(self, entry, slot, self.count + when)


def _put(buffers: B, entry: tuple, slot: Int[Array, ""], count: Int[Array, ""]) -> B:
    """Every buffer (all fields but the last, the count) with its item of the entry written into one slot."""
    names = [field.name for field in dataclasses.fields(buffers)[:-1]]
    put = lax.dynamic_update_index_in_dim
    new = {
        name: put(getattr(buffers, name), jnp.asarray(item, getattr(buffers, name).dtype), slot, 0)
        for name, item in zip(names, entry, strict=True)
    }
    return dataclasses.replace(buffers, **new, count=count)
