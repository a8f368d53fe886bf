"""The history of a run from the steps that were kept."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..hybrid import Steps
from ..mechanisms.history import History
from ..mechanisms.system import ContactSystem


def history(system: ContactSystem, steps: Steps) -> History:
    """Evaluate the mechanism at kept steps."""

    slots = steps.time.shape[0] - 1
    last = jnp.clip(steps.count - 1, 0, slots - 1)
    # Slots without a step repeat the last one; `trimmed` cuts them off.
    index = jnp.minimum(jnp.arange(slots), last)
    snapshot = functools.partial(history_at, system)
    return jax.vmap(snapshot)(steps.time[index], steps.active[index], steps.rows[index, 0])


def history_at(system: ContactSystem, time: Array, active: Array, state: Array) -> History:
    """Evaluate the mechanism at one instant: return a `History` without its first axis.

    **Arguments:** ``system``; ``time`` [s]; ``active``: 1 for each closed contact, else 0; ``state``.
    """
    at = system.evaluate(state)
    snapshot, kin = system.snapshot_at(at, active), at.kin
    moving = kin.velocity_order.placements
    return History(
        time=time,
        position=kin.poses(),
        velocity=moving(kin.v),
        acceleration=moving(snapshot.acceleration),
        multipliers=snapshot.multipliers,
        gap=snapshot.gap,
        approach_speed=snapshot.approach_speed,
        slip=snapshot.slip,
        contact_force=snapshot.normal,
        friction_force=snapshot.friction,
        others={name: jnp.asarray(value) for name, value in snapshot.others.items()},
        energy=system.energy_at(at, active),
        state=state,
        closed=active,
    )


def trimmed(full: History, count: int) -> History:
    """Return the first ``count`` steps. Those without derivatives become NumPy arrays, which are cut without
    compiling."""
    return jax.tree.map(lambda x: (x if isinstance(x, jax.core.Tracer) else np.asarray(x))[:count], full)
