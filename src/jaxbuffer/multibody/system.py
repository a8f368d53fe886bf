"""A planar multibody system: bodies, joints, force elements, and its augmented index-1 equations of motion.

``[M Φ_qᵀ; Φ_q 0] [q̈; λ] = [F; γ - 2α Φ̇ - α² Φ]`` (Efficient buffering mechanism, eq. 13, with Baumgarte's terms). M is
diagonal, so the multipliers come from the Schur complement ``Φ_q M⁻¹ Φ_qᵀ``, a few rows written out.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from .body import Body
from .forces import ForceElement, Load
from .joints import Joint
from .kinematics import GROUND, Kinematics
from .linear import ldl_solve


class Constraints(NamedTuple):
    """All joints' rows at one instant: Φ, Φ_q and γ."""

    phi: Float[Array, " rows"]
    jacobian: Float[Array, "rows coordinates"]
    gamma: Float[Array, " rows"]


class Motion(NamedTuple):
    """Accelerations q̈ [m/s², rad/s²] and multipliers λ [N, N m] of the augmented system."""

    acceleration: Float[Array, " coordinates"]
    multipliers: Float[Array, " rows"]


class System(eqx.Module):
    """Bodies held by joints and moved by force elements.

    **Arguments:** ``bodies``: their order fixes the order of the coordinates; ``joints``, ``forces``: elements that
    refer to bodies by index; ``stabilisation``: Baumgarte's α = β [1/s]. It should be near the fastest motion of
    interest and far below any contact frequency: constraint errors then decay in 1/α without touching the motion.
    """

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...] = ()
    forces: tuple[ForceElement, ...] = ()
    stabilisation: Scalar = 20.0

    @property
    def coordinates(self) -> int:
        """Number of coordinates, three a body."""
        return 3 * len(self.bodies)

    def masses(self) -> Float[Array, " coordinates"]:
        """The diagonal of M [kg, kg, kg m², …]."""
        return jnp.stack([jnp.asarray(m, float) for b in self.bodies for m in (b.mass, b.mass, b.inertia)])

    def constraints(self, kin: Kinematics) -> Constraints:
        """Φ, Φ_q and γ of all joints, in their order."""
        rows = [row for joint in self.joints for row in joint.rows(kin)]
        if not rows:
            empty = jnp.zeros((0,))
            return Constraints(empty, jnp.zeros((0, self.coordinates)), empty)
        entries = [e for row in rows for b in range(len(self.bodies)) for e in row.blocks.get(b, (0.0, 0.0, 0.0))]
        return Constraints(
            stacked([row.phi for row in rows]),
            stacked(entries).reshape(len(rows), self.coordinates),
            stacked([row.gamma for row in rows]),
        )

    def generalised_force(self, kin: Kinematics, extra: tuple[Load, ...] = ()) -> Float[Array, " coordinates"]:
        """F: force elements and ``extra`` loads (contacts, say), added up by body [N, N, N m]."""
        total: list[list[Scalar]] = [[0.0, 0.0, 0.0] for _ in self.bodies]
        for load in [load for element in self.forces for load in element.loads(kin)] + list(extra):
            if load.body != GROUND:
                row = total[load.body]
                row[0], row[1], row[2] = row[0] + load.force.x, row[1] + load.force.y, row[2] + load.moment
        return stacked([component for row in total for component in row])

    def motion(self, kin: Kinematics, extra: tuple[Load, ...] = ()) -> Motion:
        """Solve the augmented system for accelerations and multipliers."""
        phi, jacobian, gamma = self.constraints(kin)
        alpha = self.stabilisation
        rhs = gamma - 2.0 * alpha * jnp.sum(jacobian * kin.v[None], axis=-1) - alpha * alpha * phi
        return Motion(*_solve_augmented(self.masses(), jacobian, self.generalised_force(kin, extra), rhs))

    def response(
        self, kin: Kinematics, directions: Float[Array, "coordinates rank"]
    ) -> Float[Array, "coordinates rank"]:
        """Accelerations that generalised forces of unit size cause, the joints holding."""
        jacobian = self.constraints(kin).jacobian
        rest = jnp.zeros(jacobian.shape[0])
        column = lambda direction: _solve_augmented(self.masses(), jacobian, direction, rest)[0]  # noqa: E731
        return jax.vmap(column, in_axes=1, out_axes=1)(directions)

    def kinetic_energy(self, v: Float[Array, " coordinates"]) -> Float[Array, ""]:
        """½ vᵀ M v [J]."""
        return 0.5 * jnp.sum(self.masses() * v * v)

    def stored_energy(self, kin: Kinematics) -> Scalar:
        """Energy stored in the force elements [J]."""
        return sum((element.energy(kin) for element in self.forces), start=jnp.zeros(()))

    def linear_momentum(self, v: Float[Array, " coordinates"]) -> Float[Array, " 2"]:
        """Σ m ṙ [kg m/s]."""
        momentum = self.masses() * v
        return jnp.stack([jnp.sum(momentum[0::3]), jnp.sum(momentum[1::3])])

    def angular_momentum(self, q: Float[Array, " coordinates"], v: Float[Array, " coordinates"]) -> Float[Array, ""]:
        """Σ (r × m ṙ + I θ̇) about the inertial origin [kg m²/s]."""
        momentum = self.masses() * v
        return jnp.sum(q[0::3] * momentum[1::3] - q[1::3] * momentum[0::3] + momentum[2::3])


@jax.custom_jvp
def _solve_augmented(
    masses: Float[Array, " coordinates"],
    jacobian: Float[Array, "rows coordinates"],
    force: Float[Array, " coordinates"],
    rhs: Float[Array, " rows"],
) -> tuple[Float[Array, " coordinates"], Float[Array, " rows"]]:
    """Accelerations and multipliers of ``[M Φ_qᵀ; Φ_q 0] [q̈; λ] = [F; rhs]``.

    Sums of products rather than matrix products: XLA hands even tiny products to a library.
    """
    inverse_mass = 1.0 / masses
    if rhs.shape[0] == 0:
        return inverse_mass * force, rhs
    weighted = jacobian * inverse_mass[None]
    schur = jnp.sum(weighted[:, None, :] * jacobian[None, :, :], axis=-1)
    multipliers = ldl_solve(schur, jnp.sum(weighted * force[None], axis=-1) - rhs)
    return inverse_mass * (force - jnp.sum(multipliers[:, None] * jacobian, axis=0)), multipliers


@_solve_augmented.defjvp
def _solve_augmented_jvp(primals: tuple, tangents: tuple) -> tuple:
    """The same system answers a small change, with what the change does to the equations as its right-hand side:
    far cheaper than differentiating the factorisation."""
    masses, jacobian, _, _ = primals
    d_masses, d_jacobian, d_force, d_rhs = tangents
    acceleration, multipliers = _solve_augmented(*primals)
    d_force = d_force - d_masses * acceleration - jnp.sum(multipliers[:, None] * d_jacobian, axis=0)
    d_rhs = d_rhs - jnp.sum(d_jacobian * acceleration[None], axis=-1)
    return (acceleration, multipliers), _solve_augmented(masses, jacobian, d_force, d_rhs)
