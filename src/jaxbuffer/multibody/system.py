"""A planar multibody system: bodies, joints, force elements, and its augmented index-1 equations of motion (M16)."""

from collections.abc import Mapping
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..plane import Vector
from .augmented import MassMatrix, SparseRows, solve_augmented
from .body import Body
from .coordinates import Coordinates
from .flexible_body import FlexibleBody
from .forces import ForceElement, Load, SpringDirection
from .joints import Joint, Row
from .kinematics import GROUND, Block, Kinematics


class ConstraintRows(NamedTuple):
    """All joints' rows at one instant (M9).

    - ``phi``: (rows,) Φ [m, rad].
    - ``jacobian``: (rows, coordinates) Φ_q.
    - ``gamma``: (rows,) γ [m/s², rad/s²].
    - ``rate``: (rows,) Φ_t, zero but for drives [m/s, rad/s].
    """

    phi: Float[Array, " rows"]
    jacobian: Float[Array, "rows coordinates"]
    gamma: Float[Array, " rows"]
    rate: Float[Array, " rows"]


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
    - ``inverse_masses``: (coordinates,) of rigid bodies the diagonal of M⁻¹ [1/kg, 1/kg, 1/(kg m²), …].
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
        masses = self.masses()
        # A flexible body's mass is a block, and its entries here are not used; they must be finite all the same.
        self.inverse_masses = 1.0 / (jnp.where(masses == 0.0, 1.0, masses) if self.modes else masses)

    @property
    def coordinates(self) -> int:
        """Return the number of coordinates, three for each body and one for each mode."""
        return self.order.count

    @property
    def order(self) -> Coordinates:
        """Return the order of the coordinates."""
        return Coordinates(len(self.bodies), self.modes)

    @property
    def modes(self) -> tuple[int, ...]:
        """Return the number of modes of each body; empty if all are rigid."""
        if not self.flexible:
            return ()
        return tuple(body.size if isinstance(body, FlexibleBody) else 0 for body in self.bodies)

    @property
    def flexible(self) -> tuple[tuple[int, FlexibleBody], ...]:
        """Return the flexible bodies, each with its index."""
        return tuple((k, body) for k, body in enumerate(self.bodies) if isinstance(body, FlexibleBody))

    def kinematics(
        self, q: Float[Array, " coordinates"], v: Float[Array, " coordinates"], time: Scalar = 0.0
    ) -> Kinematics:
        """Return the frames of all bodies. ``q``, ``v``: (coordinates,); ``time``: for drives [s]."""
        return Kinematics(q, v, time, self.modes)

    def columns(self, body: int) -> tuple[int, ...]:
        """Return which coordinates are a body's: u, v, θ, then its modal ones."""
        return self.order.columns(body)

    def masses(self) -> Float[Array, " coordinates"]:
        """Return the (coordinates,) diagonal of M of rigid bodies, zero for flexible ones [kg, kg, kg m², …] (M4)."""
        rigid = [(0.0,) * 3 if isinstance(b, FlexibleBody) else (b.mass, b.mass, b.inertia) for b in self.bodies]
        diagonal = jnp.stack([jnp.asarray(m, float) for three in rigid for m in three])
        return jnp.pad(diagonal, (0, sum(self.modes))) if self.modes else diagonal

    def mass_matrix(self, kin: Kinematics) -> MassMatrix:
        """Return M (M16), with a block for each flexible body (M121)."""
        blocks = []
        for k, body in self.flexible:
            u, v, angle, *modal = self.columns(k)
            blocks.append(((*modal, u, v, angle), body.mass_block(kin.frame(k), kin.modal(k)[0])))
        return MassMatrix.of(self.inverse_masses, blocks)

    def constraints(self, kin: Kinematics) -> ConstraintRows:
        """Return Φ, Φ_q and γ of all joints, in their order."""
        rows = self._rows(kin)
        jacobian = jnp.zeros((len(rows), self.coordinates))
        for i, entries in enumerate(self._entries(rows)):
            for column, entry in entries.items():
                jacobian = jacobian.at[i, column].set(entry)
        phi, gamma, rate = (
            stacked([getattr(row, name) for row in rows]) if rows else jnp.zeros(0) for name in ("phi", "gamma", "rate")
        )
        return ConstraintRows(phi, jacobian, gamma, rate)

    def errors(self, kin: Kinematics) -> Float[Array, " rows"]:
        """Return the (rows,) Φ alone: how far the joints are from holding [m, rad]."""
        rows = self._rows(kin)
        return stacked([row.phi for row in rows]) if rows else jnp.zeros(0)

    def _rows(self, kin: Kinematics) -> list[Row]:
        return [row for joint in self.joints for row in joint.rows(kin)]

    def generalised_force(self, kin: Kinematics, extra: tuple[Load, ...] = ()) -> Float[Array, " coordinates"]:
        """Return the (coordinates,) F: the loads of the force elements and ``extra`` ones, such as contacts', by body
        [N, N, N m, …] (M19), and what deformation and its rate exert in flexible bodies (M122)."""
        # Python's sums, coordinate by coordinate: adding into an array would be a scatter, which splits the loop's
        # kernel.
        total: list[Scalar] = [0.0] * self.coordinates
        loads = [load for element in self.forces for load in element.loads(kin)] + list(extra)
        # Elastic and velocity forces are loads like all others: one sum takes them in.
        loads += [Load(k, *body.velocity_force(kin.frame(k), *kin.modal(k))) for k, body in self.flexible]
        for load in loads:
            if load.body != GROUND:
                entries = (load.force.x, load.force.y, load.moment, *load.modal)
                for column, entry in zip(self.columns(load.body), entries, strict=False):
                    total[column] = total[column] + entry
        return stacked(total)

    def motion(self, kin: Kinematics, extra: tuple[Load, ...] = ()) -> Motion:
        """Return accelerations and multipliers (M16). ``kin``: frames; ``extra``: loads besides the force elements'."""
        rows, alpha = self._rows(kin), self.stabilisation
        jacobian = SparseRows.of(self._entries(rows))
        drift = zip(rows, jacobian.times(kin.v), strict=True)
        # Holding Φ̈ = 0 alone would let Φ drift: Baumgarte's terms, critically damped, draw it back.
        rhs = [row.gamma - 2.0 * alpha * (row.rate + rate) - alpha * alpha * row.phi for row, rate in drift]
        force = self.generalised_force(kin, extra)
        return Motion(*solve_augmented(self.mass_matrix(kin), jacobian, force, stacked(rhs) if rhs else jnp.zeros(0)))

    def solve(
        self, kin: Kinematics, force: Float[Array, " coordinates"], rhs: Float[Array, " rows"]
    ) -> Float[Array, " coordinates"]:
        """Return the (coordinates,) x with M x + Φ_qᵀ λ = ``force`` and Φ_q x = ``rhs`` (M17)."""
        return solve_augmented(self.mass_matrix(kin), SparseRows.of(self._entries(self._rows(kin))), force, rhs)[0]

    def with_joints(self, joints: tuple[Joint, ...]) -> "System":
        """Return the system with further joints, behind its own."""
        return System(self.bodies, (*self.joints, *joints), self.forces, self.stabilisation)

    def direction(self, blocks: Mapping[int, Block]) -> Float[Array, " coordinates"]:
        """Join blocks (u, v, θ, modal coordinates) by body into one vector, zero for all other bodies."""
        entries: list[Scalar] = [0.0] * self.coordinates
        for body, block in blocks.items():
            if body != GROUND:
                for column, entry in zip(self.columns(body), block, strict=False):
                    entries[column] = entry
        return stacked(entries)

    def springs(self, kin: Kinematics) -> tuple[SpringDirection, ...]:
        """Return the spring-dampers in force elements and flexible bodies, their directions frozen: what implicit steps
        take for stiff."""
        elements = [spring for element in self.forces for spring in element.springs(kin)]
        return (*elements, *(spring for k, body in self.flexible for spring in body.springs(k)))

    def response(
        self, kin: Kinematics, directions: Float[Array, "coordinates rank"]
    ) -> Float[Array, "coordinates rank"]:
        """Return the accelerations that generalised forces of unit size cause, the joints holding (M_c⁻¹ of M21).

        **Arguments:** ``kin``: frames; ``directions``: (coordinates, rank), a force a column. **Returns:** the same
        shape.
        """
        # The joints hold, so Φ_q x is zero.
        rest = jnp.zeros(len(self._rows(kin)))
        return jax.vmap(lambda direction: self.solve(kin, direction, rest), in_axes=1, out_axes=1)(directions)

    def effective_mass(self, kin: Kinematics, direction: Float[Array, " coordinates"]) -> Float[Array, ""]:
        """Return the mass that a force along a direction meets [kg] (M21).

        **Arguments:** ``kin``: frames; ``direction``: d, (coordinates,), with d·q̇ a speed [m/s].
        """
        # The acceleration along the direction by a unit force along it is one over the mass.
        return 1.0 / jnp.sum(direction * self.response(kin, direction[:, None])[:, 0])

    def kinetic_energy(self, kin: Kinematics) -> Float[Array, ""]:
        """Return ½ q̇ᵀ M q̇ [J] (M76, M123)."""
        total = 0.5 * jnp.sum(self.masses() * kin.v * kin.v)
        return total + sum(body.kinetic_energy(kin.frame(k), *kin.modal(k)) for k, body in self.flexible)

    def stored_energy(self, kin: Kinematics) -> Scalar:
        """Return the energy stored in force elements and flexible bodies [J]."""
        elastic = [body.elastic_energy(kin.modal(k)[0]) for k, body in self.flexible]
        return sum([element.energy(kin) for element in self.forces] + elastic, start=jnp.zeros(()))

    def dissipation(self, kin: Kinematics) -> Scalar:
        """Return the power turned into heat in force elements and flexible bodies [W]."""
        damped = [body.dissipation(kin.modal(k)[1]) for k, body in self.flexible]
        return sum([element.dissipation(kin) for element in self.forces] + damped, start=jnp.zeros(()))

    def linear_momentum(self, kin: Kinematics) -> Float[Array, " 2"]:
        """Return the (2,) Σ m ṙ [kg m/s] (M77, M124)."""
        rigid = (self.masses() * kin.v)[: 3 * len(self.bodies)]
        total = Vector(jnp.sum(rigid[0::3]), jnp.sum(rigid[1::3]))
        for k, body in self.flexible:
            total = total + body.linear_momentum(kin.frame(k), *kin.modal(k))
        return jnp.stack([total.x, total.y])

    def angular_momentum(self, kin: Kinematics) -> Float[Array, ""]:
        """Return Σ (r × m ṙ + I θ̇) about the inertial origin [kg m²/s] (M77, M124)."""
        end = 3 * len(self.bodies)
        q, rigid = kin.q[:end], (self.masses() * kin.v)[:end]
        total = jnp.sum(q[0::3] * rigid[1::3] - q[1::3] * rigid[0::3] + rigid[2::3])
        return total + sum(body.angular_momentum(kin.frame(k), *kin.modal(k)) for k, body in self.flexible)

    def _entries(self, rows: list[Row]) -> list[dict[int, Scalar]]:
        """Return each row of Φ_q by column."""
        return [
            {
                column: entry
                for body, block in row.blocks.items()
                for column, entry in zip(self.columns(body), block, strict=False)
            }
            for row in rows
        ]
