"""The energies at the end of a run, and what numerical error did to what the motion conserves."""

from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..hybrid import Log
from ..mechanisms.energy import Balance, Energy
from ..mechanisms.system import ContactSystem


def balance(
    system: ContactSystem, start: tuple[Any, Array], log: Log, drift: Float[Array, " slots"]
) -> tuple[Energy, Balance]:
    """Return the energies at the end of a run, and conservation from ``start`` (evaluated state, closed contacts) to
    its last state.

    **Arguments:** ``drift``: the constraints' error at each entry of the log [m, rad].
    """
    last = jnp.maximum(log.count - 1, 0)
    states, closed = jnp.stack([start[0].state, log.rows[last, 0]]), jnp.stack([start[1], log.active[last]])
    energies = jax.vmap(lambda state, active: system.energy_at(system.evaluate(state), active))(states, closed)
    # The exact motion conserves all of this, so its derivative is zero: what is computed are errors.
    constant = jax.lax.stop_gradient
    total = constant(energies.total)
    used = jnp.arange(log.kind.shape[0]) < log.count
    linear, angular = _momentum_change(constant(system), constant(states))
    return jax.tree.map(lambda both: both[1], energies), Balance(
        # The total may be near zero, since the zero of a potential is arbitrary: a scale of the system bounds it.
        energy=(total[1] - total[0]) / jnp.maximum(jnp.abs(total[0]), constant(jnp.asarray(system.energy_scale))),
        linear_momentum=linear,
        angular_momentum=angular,
        drift=jnp.max(jnp.where(used, constant(drift), 0.0)),
    )


def _momentum_change(system: ContactSystem, states: Float[Array, "2 state"]) -> tuple[Array, Array]:
    """Return the change of both momenta from first to last, over the system's; NaN where the ground takes part."""
    scale = system.momentum_scale
    if scale is None:
        return jnp.full((), jnp.nan), jnp.full((), jnp.nan)
    linear, angular = jax.vmap(system.momentum)(states)
    return jnp.max(jnp.abs(linear[1] - linear[0])) / scale, jnp.abs(angular[1] - angular[0]) / scale
