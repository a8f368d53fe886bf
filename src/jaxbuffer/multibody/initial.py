"""Consistent initialisation: positions onto Φ = 0, velocities onto Φ_q q̇ = 0, moving as little mass as possible."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..plane import ldl_solve
from .kinematics import Kinematics
from .system import System


def assemble(
    system: System, q: Float[Array, " coordinates"], v: Float[Array, " coordinates"], iterations: int = 8
) -> tuple[Float[Array, " coordinates"], Float[Array, " coordinates"]]:
    """Project positions and velocities onto the constraints, with the least movement in the norm of the masses (M20).

    **Arguments:**

    - ``system``: bodies and joints.
    - ``q``: (coordinates,) a guess [m, m, rad, …].
    - ``v``: (coordinates,) a guess [m/s, m/s, rad/s, …].
    - ``iterations``: Newton steps on the positions.

    **Returns:** consistent ``(q, v)``. A guess too far from any assembly shows as a Φ that stays large: look at
    ``system.constraints(Kinematics(q, v)).phi``.
    """
    inverse_mass = 1.0 / system.masses()

    def correction(jacobian: Array, defect: Array) -> Array:
        weighted = jacobian * inverse_mass[None]
        schur = jnp.sum(weighted[:, None, :] * jacobian[None, :, :], axis=-1)
        return jnp.sum(ldl_solve(schur, defect)[:, None] * weighted, axis=0)

    if not system.joints:
        return q, v
    for _ in range(iterations):
        phi, jacobian, _ = system.constraints(Kinematics(q, v))
        q = q - correction(jacobian, phi)
    jacobian = system.constraints(Kinematics(q, v)).jacobian
    return q, v - correction(jacobian, jnp.sum(jacobian * v[None], axis=-1))
