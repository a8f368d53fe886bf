"""The energies at the end of a run, and what numerical error did to what the motion conserves."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..hybrid import Log
from ..mechanisms.energy import Balance, Energy
from ..mechanisms.system import ContactSystem
from .readings import Readings


def balance(system: ContactSystem, read: Readings, log: Log, drift: Float[Array, " slots"]) -> tuple[Energy, Balance]:
    """Return the energies at the end of a run, and conservation from its start to its end.

    **Arguments:** ``drift``: the constraints' error at each entry of the log [m, rad].
    """
    # The exact motion conserves all of this, so its derivative is zero: what is computed are errors.
    constant = jax.lax.stop_gradient
    before, after = constant(read.start.energy.total), constant(read.end.energy.total)
    scale, first, last = system.momentum_scale, read.start.momentum, read.end.momentum
    linear = angular = jnp.full((), jnp.nan)  # where the ground takes part
    if scale is not None and first is not None and last is not None:
        linear, angular = (jnp.max(jnp.abs(b - a)) / constant(scale) for a, b in zip(first, last, strict=True))
    return read.end.energy, Balance(
        # The total may be near zero, since the zero of a potential is arbitrary: a scale of the system bounds it.
        energy=(after - before) / jnp.maximum(jnp.abs(before), constant(jnp.asarray(system.energy_scale))),
        linear_momentum=linear,
        angular_momentum=angular,
        drift=jnp.max(jnp.where(log.used, constant(drift), 0.0)),
    )
