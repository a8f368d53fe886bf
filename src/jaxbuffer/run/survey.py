"""One look at every entry of a run's log."""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..hybrid import Kind, Log
from ..mechanisms.system import ContactSystem


class Survey(NamedTuple):
    """What each entry of a log shows: every contact's ``gap`` [m]; the ``force`` [N] of the contacts that have impacts;
    the constraints' largest error ``drift`` [m, rad]."""

    gap: Float[Array, "slots contacts"]
    force: Float[Array, "slots impact_contacts"]
    drift: Float[Array, " slots"]

    def with_forces(self, slots: Int[Array, " some"], observables: Float[Array, "some observables"]) -> "Survey":
        """Return the survey with the forces that are read at some entries: those at the run's end, as it moves with the
        parameters, and the largest one to its last digit."""
        return self._replace(force=self.force.at[slots].set(observables[:, : self.force.shape[1]]))


def survey(system: ContactSystem, log: Log) -> Survey:
    """Return what every entry of a run's log shows."""

    def look(slot: Array) -> Survey:
        state, active = log.rows[slot, 0], log.active[slot]
        at = system.evaluate_contacts(state)
        drift = jnp.abs(system.constraint_errors(jax.lax.stop_gradient(at.kin)))
        force = system.normal_force_at(at, active)
        if system.jumps:
            closes = log.kind[slot] == Kind.TOUCHDOWN
            force = _at_touchdown(force, system, state, active, log.which[slot] % system.contact_count, closes)
        return Survey(system.gaps_at(at)[0], force, jnp.max(drift, initial=0.0))

    return jax.vmap(look)(jnp.arange(log.kind.shape[0]))


@eqx.filter_custom_jvp
def _at_touchdown(
    force: Array,
    system: ContactSystem,
    state: Array,
    active: Array,
    contact: Int[Array, ""],
    closes: Bool[Array, ""],
) -> Float[Array, " impact_contacts"]:
    """Return the forces of a state with the derivative that they have where the ``contact`` ``closes``.

    Right after a touchdown with a jump a force may be largest without being stationary: its derivative then goes with
    the event. A rule of its own, since the state's rate is asked for by derivatives alone.
    """
    return force


@_at_touchdown.def_jvp
def _at_touchdown_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Any]:
    (force, system, state, active, contact, closes), (force_moves, system_moves, state_moves, *_) = primals, tangents

    def until_contact(system: ContactSystem, state: Array) -> Array:
        return system.time_to_contact(state, contact)

    late = eqx.filter_jvp(until_contact, (system, state), (system_moves, state_moves))[1]
    moved = jnp.zeros_like(force) if force_moves is None else force_moves
    if late is None:
        return force, moved
    along = system.derivative(jnp.zeros(()), state, active) * jnp.where(closes, late, 0.0)
    return force, moved + jax.jvp(lambda state: system.normal_force(state, active), (state,), (along,))[1]
