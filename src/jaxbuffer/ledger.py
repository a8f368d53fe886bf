"""The energy ledger, and what numerical error did to what a capture conserves."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .integrate import Log
from .mechanisms.assembly import N
from .mechanisms.capture import CaptureMechanism
from .mechanisms.probe_in_cone import Posture


class Energy(eqx.Module):
    """The ledger at one instant [J]: kinetic, springs, elastic contact, end stop, and what was lost so far (by an end
    stop ``stop_damper``)."""

    kinetic: Float[Array, "..."]
    spring: Float[Array, "..."]
    contact: Float[Array, "..."]
    stop: Float[Array, "..."]
    axial_damper: Float[Array, "..."]
    torsional_damper: Float[Array, "..."]
    hysteresis: Float[Array, "..."]
    friction: Float[Array, "..."]
    stop_damper: Float[Array, "..."]

    @property
    def dissipated(self) -> Float[Array, "..."]:
        """Everything lost [J]."""
        return self.axial_damper + self.torsional_damper + self.hysteresis + self.friction + self.stop_damper

    @property
    def total(self) -> Float[Array, "..."]:
        """The sum, constant in time [J]."""
        return self.kinetic + self.spring + self.contact + self.stop + self.dissipated


def energy(mechanism: CaptureMechanism, at: Posture, active: Float[Array, " contacts"]) -> Energy:
    """The ledger of one state."""
    losses = mechanism.losses(at.state)
    if mechanism.stop is None:
        losses = jnp.append(losses, 0.0)
    return Energy(*map(jnp.asarray, mechanism.stored(at, active)), *losses)


class Balance(eqx.Module):
    """What should not change, and by how much it did over the run.

    ``energy``: relative to the initial energy; ``linear_momentum`` relative to m_S v0, ``angular_momentum`` to
    m_S v0 · 1 m; ``drift``: largest constraint error [m, rad] at any located event. They have no derivatives.
    """

    energy: Float[Array, ""]
    linear_momentum: Float[Array, ""]
    angular_momentum: Float[Array, ""]
    drift: Float[Array, ""]


def balance(
    mechanism: CaptureMechanism, start: tuple[Array, Array], log: Log, drift: Float[Array, " slots"]
) -> tuple[Energy, Balance]:
    """The ledger at the end of a run, and conservation from its start (state, closed contacts) to its last state, with
    the constraints' error at each entry of the log."""
    last = jnp.maximum(log.count - 1, 0)
    states, closed = jnp.stack([start[0], log.rows[last, 0]]), jnp.stack([start[1], log.active[last]])
    ledger = jax.vmap(lambda state, active: energy(mechanism, mechanism.posture(state), active))(states, closed)
    held = jax.lax.stop_gradient
    linear, angular = jax.vmap(lambda state: momentum(held(mechanism), state))(held(states))
    total, scale = held(ledger.total), held(mechanism.design.active.mass * mechanism.scenario.approach_speed)
    used = jnp.arange(log.kind.shape[0]) < log.count
    return jax.tree.map(lambda both: both[1], ledger), Balance(
        energy=(total[1] - total[0]) / total[0],
        linear_momentum=jnp.max(jnp.abs(linear[1] - linear[0])) / scale,
        angular_momentum=jnp.abs(angular[1] - angular[0]) / scale,
        drift=jnp.max(jnp.where(used, held(drift), 0.0)),
    )


def momentum(mechanism: CaptureMechanism, state: Float[Array, " state"]) -> tuple[Array, Array]:
    """Linear [kg m/s] and angular momentum [kg m²/s] of a state."""
    kin = mechanism.kinematics(state)
    angular = mechanism.system.angular_momentum(kin.q, kin.v)
    if mechanism.spins:
        angular = angular + mechanism.probe.tip_inertia * state[2 * N]
    return mechanism.system.linear_momentum(kin.v), angular
