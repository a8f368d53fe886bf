"""Events that move with the parameters: the derivatives of a log's entries, from sensitivities at fixed times.

An event lies where a guard g(y, p) crosses zero. Its time moves by dt/dp = -(∂g/∂p at fixed time)/ġ, and whatever is
read there moves by its rate times that, on top of its change at a fixed time.
"""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .loop.log import Kind, Log
from .system import HybridSystem

Build = Callable[..., HybridSystem]


@eqx.filter_custom_jvp
def moving(log: Log, parameters: Any, build: Build) -> Log:
    """Return the same log, with derivatives of events that move.

    **Arguments:** ``log`` of a run of the system ``build(*parameters)``, with derivatives of ``rows`` at fixed times.

    **Returns:** the log, whose ``time``, ``values``, ``rows`` and ``rates`` have the derivatives that differences of
    runs have. A start in contact, and an end because the time is up, stay at their times. ``guard_rate``, itself found
    by differences, has none: NaN; nor have ``missed_time`` and ``missed_values`` where events were missed.
    """
    return log


@moving.def_jvp
def _moving_jvp(primals: tuple, tangents: tuple) -> tuple[Log, Log]:
    (log, parameters, build), (log_moves, parameters_move, _) = primals, tangents
    rows_move = jnp.zeros_like(log.rows) if log_moves.rows is None else log_moves.rows
    moves = _moves(log, rows_move, parameters, parameters_move, build)
    return log, dataclasses.replace(jax.tree.map(lambda _: None, log), **moves)


class _Entry(NamedTuple):
    """One entry of a log (see `Log`)."""

    kind: Int[Array, ""]
    which: Int[Array, ""]
    time: Float[Array, ""]
    guard_rate: Float[Array, ""]
    active: Float[Array, " contacts"]

    @property
    def moves(self) -> Bool[Array, ""]:
        """Return whether the entry's time depends on the parameters."""
        return (self.kind != Kind.NONE) & (self.which >= 0) & ~self.starts

    @property
    def starts(self) -> Bool[Array, ""]:
        """Return whether the run starts in contact here; its rate is logged as zero."""
        return (self.kind == Kind.TOUCHDOWN) & (self.time == 0.0)

    @property
    def before(self) -> Float[Array, " contacts"]:
        """Return which contacts are closed before the event."""
        switches = (self.kind == Kind.TOUCHDOWN) | (self.kind == Kind.RELEASE)
        mine = jnp.arange(self.active.shape[0]) == self.which
        return jnp.where(switches & mine, 1.0 - self.active, self.active)


@eqx.filter_jit
def _moves(log: Log, rows_move: Array, parameters: Any, parameters_move: Any, build: Build) -> dict[str, Array]:
    """Return the changes of the log's fields, by name, with a change of the parameters."""
    used = log.used
    # unused slots may hold anything: the first entry stands in for them
    rows, rows_move = (jnp.where(used[:, None], x[:, 0], x[0, 0]) for x in (log.rows, rows_move))

    def moves_of(entry: _Entry, row: Array, row_move: Array) -> dict[str, Array]:
        def pushed(look: Callable[[HybridSystem, _Entry, Array], Any], move: Array) -> Any:
            of = lambda parameters, row: look(build(*parameters), entry, row)  # noqa: E731
            values, moves = eqx.filter_jvp(of, (parameters, row), (parameters_move, move))
            still = lambda value, move: jnp.zeros_like(value) if move is None else move  # noqa: E731
            # A move is None where nothing moves: in a mechanism without observables.
            return jax.tree.map(still, values, moves)

        # The implicit function theorem: the guard stays zero when the parameters move. Its rate is the run's own, since
        # that of a maximum's guard would take one derivative more here.
        later = jnp.where(entry.moves, -pushed(_guard, row_move) / entry.guard_rate, 0.0)
        # From the derivative at a fixed time to that at the event.
        moved = row_move + later * build(*parameters).derivative(entry.time, row, entry.active)
        values, rate = pushed(_shown, moved)
        rate = jnp.where(entry.starts, 0.0, rate)
        unknown = jnp.nan * later
        return {"time": later, "values": values, "guard_rate": unknown, "rows": moved[None], "rates": rate[None]}

    entries = _Entry(log.kind, log.which, log.time, log.guard_rate, log.active)
    each = jax.vmap(moves_of)(entries, rows, rows_move)
    moves = {name: jnp.where(used.reshape(-1, *[1] * (x.ndim - 1)), x, 0.0) for name, x in each.items()}
    latest = moves["time"][jnp.maximum(log.count - 1, 0)]
    unknown = latest * jnp.where(log.overflown, jnp.nan, 0.0)
    missed_values = jnp.broadcast_to(unknown, log.missed_values.shape)
    return {**moves, "latest": latest, "missed_time": unknown, "missed_values": missed_values}


def _guard(system: HybridSystem, entry: _Entry, row: Float[Array, " state"]) -> Float[Array, ""]:
    """Return the function that crosses zero upwards at the event: a gap or its negative, a guard of the end, an
    observable's fall."""

    def its(values: Array) -> Array:
        return jnp.sum(jnp.where(jnp.arange(values.shape[0]) == entry.which, values, 0.0))

    def observed(row: Array) -> Array:
        return its(system.observables_anew(entry.time, row, entry.active))

    rate = system.derivative(entry.time, row, entry.active)
    slope = jax.jvp(observed, (row,), (rate,))[1]
    gap = its(system.gaps(row))
    contact = jnp.where(entry.kind == Kind.TOUCHDOWN, -gap, gap)
    other = jnp.where(entry.kind == Kind.PEAK, -slope, its(system.terminals(row)))
    return jnp.where((entry.kind == Kind.TOUCHDOWN) | (entry.kind == Kind.RELEASE), contact, other)


def _shown(system: HybridSystem, entry: _Entry, row: Float[Array, " state"]) -> tuple[Array, Array]:
    """Return the observables after the event, and the state's rate before it."""
    after = system.derivative(entry.time, row, entry.active)
    rate = system.derivative(entry.time, row, entry.before) if system.jumps else after
    return system.observables(row, after, entry.active), rate
