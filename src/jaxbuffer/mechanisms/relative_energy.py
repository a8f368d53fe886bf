"""The energy of relative motion: kinetic energy beyond that of the whole moving as one rigid body (M177).

With what springs and contacts store it is what the parts between the vehicles have to take before these are at rest
together.
"""

from collections.abc import Sequence

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..multibody import Kinematics, System


def rigid_energy(system: System, kin: Kinematics, spins: Sequence[tuple[Scalar, Scalar]] = ()) -> Scalar:
    """Return ½ P²/M + ½ H²/J [J]: the energy of the whole as one rigid body that has its momenta.

    Mass, centre of mass and inertia are read off the momenta of rigid motions, so that bodies may be flexible.

    **Arguments:** ``system``; ``kin``; ``spins``: inertia [kg m²] and spin [rad/s] of each ball that turns by itself.
    """
    linear = system.linear_momentum(kin)
    angular = system.angular_momentum(kin) + sum(inertia * spin for inertia, spin in spins)
    turning = kin.moving(_turning(system, kin))
    arm = system.linear_momentum(turning)  # M times (-Y, X), of the centre of mass
    # About the origin.
    inertia = system.angular_momentum(turning) + sum(inertia for inertia, _ in spins)
    mass = sum((body.mass for body in system.bodies), start=jnp.zeros(()))
    centre_x, centre_y = arm[1] / mass, -arm[0] / mass
    # From the origin to the centre of mass (Steiner).
    angular = angular - (centre_x * linear[1] - centre_y * linear[0])
    inertia = inertia - mass * (centre_x**2 + centre_y**2)
    return 0.5 * jnp.sum(linear**2) / mass + 0.5 * angular**2 / inertia


def _turning(system: System, kin: Kinematics) -> Float[Array, " coordinates"]:
    """Return the velocities of a turn of the whole about the origin, at 1 rad/s."""
    entries: list[Scalar] = []
    for body in range(len(system.bodies)):
        origin = kin.frame(body).origin
        entries += [-origin.y, origin.x, 1.0]
    # Nothing bends in a rigid motion: the rates of all modes are zero.
    return stacked([*entries, *[0.0] * (system.coordinates - len(entries))])
