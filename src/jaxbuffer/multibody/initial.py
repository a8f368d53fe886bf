"""Consistent initialisation: positions onto Φ = 0, velocities onto Φ_q q̇ + Φ_t = 0, with the least mass moved."""

import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Float

from .system import System


def assemble(
    system: System, q: Float[Array, " coordinates"], v: Float[Array, " velocities"], iterations: int = 8
) -> tuple[Float[Array, " coordinates"], Float[Array, " velocities"]]:
    """Project positions and velocities onto the constraints, with the least movement in the norm of the masses (M20).

    **Arguments:**

    - ``system``: bodies and joints.
    - ``q``: (coordinates,) a guess [m, m, rad, …].
    - ``v``: (velocities,) a guess [m/s, m/s, rad/s, …].
    - ``iterations``: Newton steps on the positions.

    **Returns:** consistent ``(q, v)``. A guess too far from any assembly shows as a Φ that stays large: look at
    ``system.errors(system.kinematics(q, v))``.
    """
    if not system.joints:
        return q, v
    # Without a force, `solve` gives the x with the least xᵀ M x among those with the Φ_q x wanted.
    none = jnp.zeros_like(v)

    def newton(_: Array, q: Float[Array, " coordinates"]) -> Float[Array, " coordinates"]:
        kin = system.kinematics(q, v)
        return q + system.position_rate(q).of(system.solve(kin, none, -system.errors(kin)))

    # A fixed number of steps, through which derivatives pass in both modes.
    q = lax.fori_loop(0, iterations, newton, jnp.asarray(q, float))
    # Velocities last, since the rows that they are projected onto depend on the positions.
    kin = system.kinematics(q, v)
    constraints = system.constraints(kin)
    return q, v - system.solve(kin, none, constraints.rate + jnp.sum(constraints.jacobian * v[None], axis=-1))
