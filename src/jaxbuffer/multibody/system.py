"""A planar multibody system: bodies, joints, force elements, and its augmented index-1 equations of motion (M16).

M is diagonal (see `augmented`).
"""

from collections.abc import Mapping
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from .augmented import SparseRows, solve_augmented
from .body import Body
from .forces import ForceElement, Load
from .joints import Joint, Row
from .kinematics import GROUND, Kinematics


class Constraints(NamedTuple):
    """All joints' rows at one instant (M9).

    - ``phi``: (rows,) Φ [m, rad].
    - ``jacobian``: (rows, coordinates) Φ_q.
    - ``gamma``: (rows,) γ [m/s², rad/s²].
    """

    phi: Float[Array, " rows"]
    jacobian: Float[Array, "rows coordinates"]
    gamma: Float[Array, " rows"]


class Motion(NamedTuple):
    """The solution of the augmented system (M16).

    - ``acceleration``: (coordinates,) q̈ [m/s², m/s², rad/s², …].
    - ``multipliers``: (rows,) λ, the joints' reactions [N, N m].
    """

    acceleration: Float[Array, " coordinates"]
    multipliers: Float[Array, " rows"]


class System(eqx.Module):
    """Bodies held by joints and moved by force elements.

    - ``bodies``: their order fixes the order of the coordinates.
    - ``joints``, ``forces``: elements that refer to bodies by index.
    - ``stabilisation``: Baumgarte's gain α = β [1/s] (M16). It should be near the fastest motion of interest and far
      below the frequency of any contact: errors of the constraints then decay in 1/α and do not disturb the motion.
    - ``inverse_masses``: (coordinates,) the diagonal of M⁻¹ [1/kg, 1/kg, 1/(kg m²), …].
    """

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    forces: tuple[ForceElement, ...]
    stabilisation: Scalar
    inverse_masses: Float[Array, " coordinates"]

    def __init__(
        self,
        bodies: tuple[Body, ...],
        joints: tuple[Joint, ...] = (),
        forces: tuple[ForceElement, ...] = (),
        stabilisation: Scalar = 20.0,
    ):
        self.bodies, self.joints, self.forces, self.stabilisation = bodies, joints, forces, stabilisation
        self.inverse_masses = 1.0 / self.masses()

    @property
    def coordinates(self) -> int:
        """Number of coordinates, three for each body."""
        return 3 * len(self.bodies)

    def masses(self) -> Float[Array, " coordinates"]:
        """(coordinates,) the diagonal of M [kg, kg, kg m², …] (M4)."""
        return jnp.stack([jnp.asarray(m, float) for b in self.bodies for m in (b.mass, b.mass, b.inertia)])

    def constraints(self, kin: Kinematics) -> Constraints:
        """Φ, Φ_q and γ of all joints, in their order."""
        rows = self._rows(kin)
        jacobian = jnp.zeros((len(rows), self.coordinates))
        for i, entries in enumerate(_entries(rows)):
            for column, entry in entries.items():
                jacobian = jacobian.at[i, column].set(entry)
        if not rows:
            return Constraints(jnp.zeros(0), jacobian, jnp.zeros(0))
        return Constraints(stacked([row.phi for row in rows]), jacobian, stacked([row.gamma for row in rows]))

    def errors(self, kin: Kinematics) -> Float[Array, " rows"]:
        """(rows,) Φ alone: how far the joints are from holding [m, rad]."""
        rows = self._rows(kin)
        return stacked([row.phi for row in rows]) if rows else jnp.zeros(0)

    def _rows(self, kin: Kinematics) -> list[Row]:
        return [row for joint in self.joints for row in joint.rows(kin)]

    def generalised_force(self, kin: Kinematics, extra: tuple[Load, ...] = ()) -> Float[Array, " coordinates"]:
        """(coordinates,) F: the loads of the force elements and ``extra`` ones, such as contacts', by body [N, N, N m,
        …] (M19)."""
        total: list[list[Scalar]] = [[0.0, 0.0, 0.0] for _ in self.bodies]
        for load in [load for element in self.forces for load in element.loads(kin)] + list(extra):
            if load.body != GROUND:
                row = total[load.body]
                row[0], row[1], row[2] = row[0] + load.force.x, row[1] + load.force.y, row[2] + load.moment
        return stacked([component for row in total for component in row])

    def motion(self, kin: Kinematics, extra: tuple[Load, ...] = ()) -> Motion:
        """Accelerations and multipliers (M16). ``kin``: frames; ``extra``: loads besides the force elements'."""
        rows, alpha = self._rows(kin), self.stabilisation
        jacobian = SparseRows.of(_entries(rows))
        drift = zip(rows, jacobian.times(kin.v), strict=True)
        rhs = [row.gamma - 2.0 * alpha * rate - alpha * alpha * row.phi for row, rate in drift]
        force = self.generalised_force(kin, extra)
        return Motion(*solve_augmented(self.inverse_masses, jacobian, force, stacked(rhs) if rhs else jnp.zeros(0)))

    def direction(self, blocks: Mapping[int, tuple[Scalar, Scalar, Scalar]]) -> Float[Array, " coordinates"]:
        """Blocks (u, v, θ) by body as one vector, zero for all other bodies."""
        entries: list[Scalar] = [0.0] * self.coordinates
        for body, block in blocks.items():
            if body != GROUND:
                entries[3 * body : 3 * body + 3] = block
        return stacked(entries)

    def response(
        self, kin: Kinematics, directions: Float[Array, "coordinates rank"]
    ) -> Float[Array, "coordinates rank"]:
        """Accelerations that generalised forces of unit size cause, the joints holding (M_c⁻¹ of M21).

        **Arguments:** ``kin``: frames; ``directions``: (coordinates, rank), a force a column. **Returns:** the same
        shape.
        """
        jacobian = SparseRows.of(_entries(self._rows(kin)))
        rest, inverse_mass = jnp.zeros(len(jacobian.pattern)), self.inverse_masses
        column = lambda direction: solve_augmented(inverse_mass, jacobian, direction, rest)[0]  # noqa: E731
        return jax.vmap(column, in_axes=1, out_axes=1)(directions)

    def effective_mass(self, kin: Kinematics, direction: Float[Array, " coordinates"]) -> Float[Array, ""]:
        """The mass that a force along a direction meets [kg] (M21).

        **Arguments:** ``kin``: frames; ``direction``: d, (coordinates,), with d·q̇ a speed [m/s].
        """
        return 1.0 / jnp.sum(direction * self.response(kin, direction[:, None])[:, 0])

    def kinetic_energy(self, v: Float[Array, " coordinates"]) -> Float[Array, ""]:
        """½ vᵀ M v [J] (M76). ``v``: (coordinates,)."""
        return 0.5 * jnp.sum(self.masses() * v * v)

    def stored_energy(self, kin: Kinematics) -> Scalar:
        """Energy stored in the force elements [J]."""
        return sum((element.energy(kin) for element in self.forces), start=jnp.zeros(()))

    def linear_momentum(self, v: Float[Array, " coordinates"]) -> Float[Array, " 2"]:
        """(2,) Σ m ṙ [kg m/s] (M77). ``v``: (coordinates,)."""
        momentum = self.masses() * v
        return jnp.stack([jnp.sum(momentum[0::3]), jnp.sum(momentum[1::3])])

    def angular_momentum(self, q: Float[Array, " coordinates"], v: Float[Array, " coordinates"]) -> Float[Array, ""]:
        """Σ (r × m ṙ + I θ̇) about the inertial origin [kg m²/s] (M77). ``q``, ``v``: (coordinates,)."""
        momentum = self.masses() * v
        return jnp.sum(q[0::3] * momentum[1::3] - q[1::3] * momentum[0::3] + momentum[2::3])


def _entries(rows: list[Row]) -> list[dict[int, Scalar]]:
    """Each row of Φ_q by column."""
    return [{3 * body + k: e for body, block in row.blocks.items() for k, e in enumerate(block)} for row in rows]
