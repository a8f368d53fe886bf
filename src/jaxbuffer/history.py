"""Time histories of a capture: everything one would plot, at every accepted step."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .integrate import Steps
from .ledger import Energy, energy
from .mechanisms.assembly import N
from .mechanisms.capture import CaptureMechanism

BODIES = ("active", "cylinder", "probe", "passive")
MULTIPLIERS = ("hinge x", "hinge y", "prismatic moment", "prismatic force")


class History(eqx.Module):
    """Histories along the first axis ("steps").

    ``time`` [s]; ``position`` (steps, 4 bodies, [x, y, angle]) [m, m, rad] and ``velocity`` of S, B, P, T;
    ``tip_spin`` [rad/s]; ``multipliers`` (steps, 4) [N, N, N m, N]; per flank (lower, upper) ``gap`` [m],
    ``approach_speed`` and ``slip`` [m/s], ``contact_force`` F_n and ``friction_force`` F_t [N]; ``hinge_force`` and
    ``buffer_force`` [N]; ``stop_force`` of the end stop [N], 0 without one; ``stroke`` [m]; ``hinge_angle`` [rad];
    ``throat_distance`` [m] before the capture plane; ``energy`` [J]. Inside `jit` the arrays have their
    full capacity, the last state repeated.

    Derivatives are those at fixed times, so ``time`` has none, though the steps lie elsewhere for other parameters.
    """

    time: Float[Array, " steps"]
    position: Float[Array, "steps 4 3"]
    velocity: Float[Array, "steps 4 3"]
    tip_spin: Float[Array, " steps"]
    multipliers: Float[Array, "steps 4"]
    gap: Float[Array, "steps 2"]
    approach_speed: Float[Array, "steps 2"]
    slip: Float[Array, "steps 2"]
    contact_force: Float[Array, "steps 2"]
    friction_force: Float[Array, "steps 2"]
    hinge_force: Float[Array, " steps"]
    buffer_force: Float[Array, " steps"]
    stop_force: Float[Array, " steps"]
    stroke: Float[Array, " steps"]
    hinge_angle: Float[Array, " steps"]
    throat_distance: Float[Array, " steps"]
    energy: Energy


def history(mechanism: CaptureMechanism, steps: Steps) -> History:
    """Evaluate the mechanism at kept steps."""

    def at(time: Array, active: Array, state: Array) -> History:
        posture = mechanism.posture(state)
        kin, (motion, forces, _) = posture.kin, mechanism.dynamics(posture, active)
        values = mechanism.observables(state, mechanism.derivative(time, state, active), active)
        seen = dict(zip(mechanism.observed, values, strict=True))
        angle = kin.q[5] - kin.q[2]
        return History(
            time=time,
            position=kin.q.reshape(4, 3),
            velocity=kin.v.reshape(4, 3),
            tip_spin=state[2 * N] if mechanism.spins else kin.v[8],
            multipliers=motion.multipliers,
            gap=forces.approach.gap,
            approach_speed=forces.approach.approach_speed,
            slip=forces.approach.slip,
            contact_force=forces.normal,
            friction_force=forces.friction,
            hinge_force=seen["hinge_force"],
            buffer_force=jnp.copysign(seen["buffer_force"], mechanism.axial.tension(kin)),
            stop_force=jnp.asarray(mechanism.stop_force(posture, active)),
            stroke=seen["stroke"],
            hinge_angle=jnp.copysign(seen["hinge_angle"], angle),
            throat_distance=mechanism.throat(kin, posture.tip)[0],
            energy=energy(mechanism, posture, active),
        )

    slots = steps.time.shape[0] - 1
    last = jnp.clip(steps.count - 1, 0, slots - 1)
    index = jnp.minimum(jnp.arange(slots), last)
    return jax.vmap(at)(steps.time[index], steps.active[index], steps.rows[index, 0])


def trimmed(full: History, count: int) -> History:
    """The first ``count`` steps; those without derivatives as NumPy arrays: cutting them compiles nothing."""
    return jax.tree.map(lambda x: (x if isinstance(x, jax.core.Tracer) else np.asarray(x))[:count], full)
