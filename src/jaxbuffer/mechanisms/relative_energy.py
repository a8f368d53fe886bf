"""The energy of relative motion: kinetic energy beyond that of the whole moving as one rigid body (M177).

With what springs and contacts store it is what the parts between the vehicles have to take before these are at rest
together.
"""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..basis import components, less, plus, times, turn_array
from ..multibody import Kinematics, System
from ..plane import Factors


def rigid_energy(system: System, kin: Kinematics, spins: Sequence[tuple[Scalar, Any]] = ()) -> Scalar:
    """Return ½ P²/M + ½ H·J⁻¹H [J]: the energy of the whole as one rigid body that has its momenta.

    Mass, centre of mass and inertia are read off the momenta of rigid motions, so that bodies may be flexible.

    **Arguments:** ``system``; ``kin``; ``spins``: inertia [kg m²] and spin [rad/s] of each ball that turns by itself.
    """
    linear = system.linear_momentum(kin)
    angular = system.angular_momentum(kin) + sum(inertia * turn_array(spin) for inertia, spin in spins)

    def momenta(axis: Any) -> tuple[Array, Array]:
        turning = kin.moving(_turning(system, kin, axis))
        return system.linear_momentum(turning), system.angular_momentum(turning)

    # All axes at once: one after the other, in space, they add 2000 equations to a docking's loop of 34 000.
    turns = jax.tree.map(lambda *entries: jnp.asarray(entries), *system.basis.unit_turns)
    # M times axis × R, of the centre of mass R; and the columns of the inertia about the origin
    arms, about_origin = jax.vmap(momenta)(turns)
    mass = sum((body.mass for body in system.bodies), start=jnp.zeros(()))
    # A turn about z gives R's x and y, one about x its z, which is zero in the plane.
    centre = [arms[-1, 1] / mass, -arms[-1, 0] / mass, -arms[0, 1] / mass if len(arms) > 1 else 0.0]
    # From the origin to the centre of mass (Steiner).
    basis = system.basis
    orbital = components(basis.vector(*centre[: basis.dimensions]).cross(basis.vector(*linear)))
    own = [entry - other for entry, other in zip(jnp.atleast_1d(angular), orbital, strict=True)]
    about_origin = about_origin.reshape(len(arms), -1)
    inertia = _central_inertia(about_origin, mass, centre, sum(inertia for inertia, _ in spins))
    # H·J⁻¹H by J = L D Lᵀ.
    factors = Factors.of(inertia)
    turning = [0.5 * h**2 / pivot for h, pivot in zip(factors.forward(own), factors.pivot, strict=True)]
    return 0.5 * jnp.sum(linear**2) / mass + sum(turning[1:], turning[0])


def _central_inertia(
    about_origin: Float[Array, "axes axes"], mass: Scalar, centre: Sequence[Scalar], balls: Scalar
) -> list[list[Scalar]]:
    """Return the lower half of the inertia of the whole about its centre of mass [kg m²].

    **Arguments:** ``about_origin``: the bodies' inertia about the origin [kg m²]; ``centre``: of mass [m]; ``balls``:
    inertia of what turns by itself.
    """
    axes = range(3 - len(about_origin), 3)  # those of space, or z
    square = plus(centre[0] ** 2 + centre[1] ** 2, times(centre[2], centre[2]))
    rows = list[list[Scalar]]()
    for i, a in enumerate(axes):
        rows.append([])
        for j, b in enumerate(axes[: i + 1]):
            entry = about_origin[j, i] + balls if i == j else about_origin[j, i]
            # Steiner: M (R² δ_ab - R_a R_b).
            away = less(square if i == j else 0.0, times(centre[a], centre[b]))
            rows[i].append(entry - mass * away)
    return rows


def _turning(system: System, kin: Kinematics, axis: Any) -> Float[Array, " velocities"]:
    """Return the velocities of a turn of the whole about an ``axis`` through the origin, at 1 rad/s."""
    entries: list[Scalar] = []
    for body in range(len(system.bodies)):
        frame = kin.frame(body)
        entries += [*frame._replace(spin=axis).rate_of(frame.origin), *components(axis)]
    # Nothing bends in a rigid motion: the rates of all modes are zero.
    return stacked([*entries, *[0.0] * (system.velocities - len(entries))])
