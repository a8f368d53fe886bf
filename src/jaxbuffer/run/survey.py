"""One look at every entry of a run's log."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..hybrid import Kind, Log
from ..mechanisms.system import ContactSystem


class Survey(NamedTuple):
    """What each entry of a log shows: every contact's ``gap`` [m]; the ``force`` [N] of the contacts that have impacts;
    the constraints' largest error ``drift`` [m, rad]."""

    gap: Float[Array, "slots contacts"]
    force: Float[Array, "slots impact_contacts"]
    drift: Float[Array, " slots"]


def state_at(log: Log, slot: Int[Array, ""]) -> Float[Array, " state"]:
    """Return the state at one entry of the log."""
    return log.rows[slot, 0]


def state_of_maximum(system: ContactSystem, log: Log, slot: Int[Array, ""]) -> Float[Array, " state"]:
    """Return the state at one entry of the log, with the derivative that a maximum there has.

    Right after a touchdown with a jump, or right after a release, a quantity may be largest without being stationary:
    the state's derivative then goes with the event.
    """
    state = state_at(log, slot)
    of_rate = system.contact_count > 0 and system.observes_rate
    if not system.jumps and not of_rate:
        return state
    kind = log.kind[slot]
    at_event = (kind == Kind.TOUCHDOWN) & system.jumps | (kind == Kind.RELEASE) & of_rate
    late = system.time_to_contact(state, log.which[slot] % system.contact_count)
    rate = system.derivative(log.time[slot], state, log.active[slot])
    if system.jumps:  # its own change counts only with the time left to the event, as in `ContactSystem.saltation`
        rate = jax.lax.stop_gradient(rate)
    return state + rate * jnp.where(at_event, late, 0.0)


def survey(system: ContactSystem, log: Log) -> Survey:
    """Return what every entry of a run's log shows."""

    def look(slot: Array) -> Survey:
        state, active = state_at(log, slot), log.active[slot]
        at = system.evaluate(state)
        highest = system.evaluate(state_of_maximum(system, log, slot)) if system.jumps else at
        drift = jnp.abs(system.constraint_errors(jax.lax.stop_gradient(at.kin)))
        force = system.normal_force_at(highest, active)
        return Survey(system.gaps_at(at)[0], force, jnp.max(drift, initial=0.0))

    return jax.vmap(look)(jnp.arange(log.kind.shape[0]))
