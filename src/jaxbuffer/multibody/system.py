"""A multibody system: bodies, joints, force elements, and its augmented index-1 equations of motion (M16)."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..basis import AnyBasis, PositionRate, components, plus
from ..errors import InputError, concrete
from ..plane import PLANE
from .augmented import MassMatrix, SparseRows, solve_augmented
from .body import Body
from .coordinates import Coordinates
from .flexible_body import FlexibleBody
from .forces import ForceElement, Load, SpringDirection
from .joints import Joint
from .kinematics import GROUND, Block, Frame, Kinematics
from .primitives import Row
from .scalars import with_scalars


class ConstraintRows(NamedTuple):
    """All joints' rows at one instant (M9).

    - ``phi``: (rows,) Φ [m, rad].
    - ``jacobian``: (rows, velocities) Φ_q; in space how Φ̇ goes with the velocities.
    - ``gamma``: (rows,) γ [m/s², rad/s²].
    - ``rate``: (rows,) Φ_t, zero but for drives [m/s, rad/s].
    """

    phi: Float[Array, " rows"]
    jacobian: Float[Array, "rows velocities"]
    gamma: Float[Array, " rows"]
    rate: Float[Array, " rows"]


class Motion(NamedTuple):
    """The solution of the augmented system (M16).

    - ``acceleration``: (velocities,) v̇, in the plane q̈ [m/s², m/s², rad/s², …].
    - ``multipliers``: (rows,) λ, the joints' reactions [N, N m].
    """

    acceleration: Float[Array, " velocities"]
    multipliers: Float[Array, " rows"]


class System(eqx.Module):
    """Bodies held by joints and moved by force elements.

    - ``bodies``: their order fixes the order of the coordinates.
    - ``joints``, ``forces``: elements that refer to bodies by index.
    - ``stabilisation``: Baumgarte's gain α = β [1/s] (M16). It should be near the fastest motion of interest and far
      below the frequency of any contact: errors of the constraints then decay in 1/α and do not disturb the motion.
    - ``basis``: `plane.PLANE` or `space.SPACE`.
    - ``inverse_masses``: (velocities,) of rigid bodies the diagonal of M⁻¹ [1/kg, 1/kg, 1/(kg m²), …].
    """

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    forces: tuple[ForceElement, ...]
    stabilisation: Scalar
    basis: AnyBasis
    inverse_masses: Float[Array, " velocities"]

    def __init__(
        self,
        bodies: tuple[Body, ...],
        joints: tuple[Joint, ...] = (),
        forces: tuple[ForceElement, ...] = (),
        stabilisation: Scalar = 20.0,
        basis: AnyBasis = PLANE,
    ):
        self.bodies, self.joints, self.forces = with_scalars((bodies, joints, forces))
        self.stabilisation, self.basis = stabilisation, basis
        self._check_bodies()
        masses = self.masses()
        # What of a mass is a block has entries here that are not used; they must be finite all the same.
        blocks = self.modes or basis.inertia_turns
        self.inverse_masses = 1.0 / (jnp.where(masses == 0.0, 1.0, masses) if blocks else masses)

    def _check_bodies(self) -> None:
        """Raise `InputError` for bodies that the basis does not have."""
        if not self.basis.inertia_turns:
            return
        for k, body in enumerate(self.bodies):
            if isinstance(body, FlexibleBody):
                raise InputError(f"body {k} is flexible: flexible bodies are of the plane")
            if not (isinstance(body.inertia, tuple) and len(body.inertia) == 3):
                raise InputError(f"body {k}: inertia = {body.inertia}: in space give (x, y, z), its principal moments")
            moments = [concrete(moment) for moment in body.inertia]
            if any(moment is not None and not moment > 0.0 for moment in moments):
                raise InputError(
                    f"body {k}: inertia = {body.inertia}: moments must be above 0 kg m²; give a slender rod a share of"
                    " that of the body which it turns with"
                )

    @property
    def coordinates(self) -> int:
        """Return the number of coordinates: in the plane three, in space seven for each body, and one for each mode."""
        return self.order.count

    @property
    def velocities(self) -> int:
        """Return the number of velocities: in the plane three, in space six for each body, and one for each mode."""
        return self.velocity_order.count

    @property
    def order(self) -> Coordinates:
        """Return the order of the positions."""
        return Coordinates(len(self.bodies), self.modes, self.basis.positions)

    @property
    def velocity_order(self) -> Coordinates:
        """Return the order of the velocities, and so of accelerations and forces."""
        return Coordinates(len(self.bodies), self.modes, self.basis.velocities)

    def translation(self, values: Float[Array, " velocities"], body: int) -> Any:
        """Return the vector of a body's translation, of what has an entry for each velocity, as accelerations."""
        first = self.basis.velocities * body
        return self.basis.vector(*(values[k] for k in range(first, first + self.basis.dimensions)))

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
        self, q: Float[Array, " coordinates"], v: Float[Array, " velocities"], time: Scalar = 0.0
    ) -> Kinematics:
        """Return the frames of all bodies. ``q``: (coordinates,); ``v``: (velocities,); ``time``: for drives [s]."""
        return Kinematics(q, v, time, self.modes, self.basis)

    def position_rate(self, q: Float[Array, " coordinates"]) -> PositionRate:
        """Return how positions change with velocities at ``q``: in the plane q̇ is v itself (M209)."""
        return self.basis.position_rate(q, len(self.bodies))

    def columns(self, body: int) -> tuple[int, ...]:
        """Return which velocities are a body's: u, v, θ, in space its six, then its modal ones."""
        return self.velocity_order.columns(body)

    def masses(self) -> Float[Array, " velocities"]:
        """Return the (velocities,) diagonal of M of rigid bodies, zero for blocks [kg, kg, kg m², …] (M4)."""
        of = self.basis.diagonal
        rigid = [of(0.0, 0.0) if isinstance(b, FlexibleBody) else of(b.mass, b.inertia) for b in self.bodies]
        diagonal = jnp.stack([jnp.asarray(m, float) for each in rigid for m in each])
        return jnp.pad(diagonal, (0, sum(self.modes))) if self.modes else diagonal

    def _turning(self, kin: Kinematics) -> list[tuple[int, Frame, Any]]:
        """Return the rigid bodies whose inertia turns with them: index, frame and inertia."""
        if not self.basis.inertia_turns:
            return []
        return [(k, kin.frame(k), body.inertia) for k, body in enumerate(self.bodies)]

    def mass_matrix(self, kin: Kinematics) -> MassMatrix:
        """Return M (M16), with a block for each flexible body (M121), and for what turns of each body (M211)."""
        blocks: list[tuple[tuple[int, ...], list[list[Scalar]]]] = []
        for k, frame, inertia in self._turning(kin):
            blocks.append((self.columns(k)[self.basis.dimensions :], self.basis.inertia_block(frame, inertia)))
        for k, body in self.flexible:
            u, v, angle, *modal = self.columns(k)
            blocks.append(((*modal, u, v, angle), body.mass_block(kin.frame(k), kin.modal(k)[0])))
        return MassMatrix.of(self.inverse_masses, blocks)

    def constraints(self, kin: Kinematics) -> ConstraintRows:
        """Return Φ, Φ_q and γ of all joints, in their order."""
        rows = self._rows(kin)
        jacobian = jnp.zeros((len(rows), self.velocities))
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

    def generalised_force(self, kin: Kinematics, extra: tuple[Load, ...] = ()) -> Float[Array, " velocities"]:
        """Return the (velocities,) F: the loads of the force elements and ``extra`` ones, such as contacts', by body
        [N, N, N m, …] (M19), what deformation and its rate exert in flexible bodies (M122), and gyroscopic moments
        (M211)."""
        # Python's sums, coordinate by coordinate: adding into an array would be a scatter, which splits the loop's
        # kernel.
        total: list[Scalar] = [0.0] * self.velocities
        loads = [load for element in self.forces for load in element.loads(kin)] + list(extra)
        # Elastic and velocity forces are loads like all others: one sum takes them in.
        loads += [Load(k, *body.velocity_force(kin.frame(k), *kin.modal(k))) for k, body in self.flexible]
        for k, frame, inertia in self._turning(kin):
            loads.append(Load(k, self.basis.vector(0.0, 0.0), self.basis.gyroscopic_moment(frame, inertia)))
        for load in loads:
            if load.body != GROUND:
                entries = (*load.force, *components(load.moment), *load.modal)
                for column, entry in zip(self.columns(load.body), entries, strict=False):
                    total[column] = plus(total[column], entry)
        return stacked(total)

    def motion(self, kin: Kinematics, extra: tuple[Load, ...] = ()) -> Motion:
        """Return accelerations and multipliers (M16). ``kin``: frames; ``extra``: loads besides the force elements'."""
        return Motion(*solve_augmented(*self._augmented(kin, extra)))

    def motion_and_masses(
        self, kin: Kinematics, extra: tuple[Load, ...], directions: Float[Array, "coordinates rank"]
    ) -> tuple[Motion, Float[Array, " rank"]]:
        """Return `motion` and `effective_masses`, of one system of equations with several right-hand sides."""
        mass, jacobian, force, rhs = self._augmented(kin, extra)
        forces = jnp.concatenate([force[:, None], directions], axis=1)
        sides = jnp.pad(rhs[:, None], ((0, 0), (0, directions.shape[1])))
        solve = lambda force, side: solve_augmented(mass, jacobian, force, side)  # noqa: E731
        answers, multipliers = jax.vmap(solve, in_axes=1, out_axes=1)(forces, sides)
        return Motion(answers[:, 0], multipliers[:, 0]), _masses(directions, answers[:, 1:])

    def _augmented(
        self, kin: Kinematics, extra: tuple[Load, ...]
    ) -> tuple[MassMatrix, SparseRows, Float[Array, " coordinates"], Float[Array, " rows"]]:
        """Return M, Φ_q and the right-hand sides of M16."""
        rows, alpha = self._rows(kin), self.stabilisation
        jacobian = SparseRows.of(self._entries(rows))
        drift = zip(rows, jacobian.times(kin.v), strict=True)
        # Holding Φ̈ = 0 alone would let Φ drift: Baumgarte's terms, critically damped, draw it back.
        rhs = [row.gamma - 2.0 * alpha * (row.rate + rate) - alpha * alpha * row.phi for row, rate in drift]
        force = self.generalised_force(kin, extra)
        return self.mass_matrix(kin), jacobian, force, stacked(rhs) if rhs else jnp.zeros(0)

    def solve(
        self, kin: Kinematics, force: Float[Array, " velocities"], rhs: Float[Array, " rows"]
    ) -> Float[Array, " velocities"]:
        """Return the (velocities,) x with M x + Φ_qᵀ λ = ``force`` and Φ_q x = ``rhs`` (M17)."""
        return solve_augmented(self.mass_matrix(kin), SparseRows.of(self._entries(self._rows(kin))), force, rhs)[0]

    def with_joints(self, joints: tuple[Joint, ...]) -> "System":
        """Return the system with further joints, behind its own."""
        return System(self.bodies, (*self.joints, *joints), self.forces, self.stabilisation, self.basis)

    def direction(self, blocks: Mapping[int, Block]) -> Float[Array, " velocities"]:
        """Join blocks by body into one vector, zero for all other bodies."""
        entries: list[Scalar] = [0.0] * self.velocities
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

    def response(self, kin: Kinematics, directions: Float[Array, "velocities rank"]) -> Float[Array, "velocities rank"]:
        """Return the accelerations that generalised forces of unit size cause, the joints holding (M_c⁻¹ of M21).

        **Arguments:** ``kin``: frames; ``directions``: (velocities, rank), a force a column. **Returns:** the same
        shape.
        """
        rows, mass = self._rows(kin), self.mass_matrix(kin)
        jacobian, rest = SparseRows.of(self._entries(rows)), jnp.zeros(len(rows))  # the joints hold: Φ_q x is zero
        one = lambda direction: solve_augmented(mass, jacobian, direction, rest)[0]  # noqa: E731
        return jax.vmap(one, in_axes=1, out_axes=1)(directions)

    def effective_mass(self, kin: Kinematics, direction: Float[Array, " velocities"]) -> Float[Array, ""]:
        """Return the mass that a force along a direction meets [kg] (M21).

        **Arguments:** ``kin``: frames; ``direction``: d, (velocities,), with d·q̇ a speed [m/s].
        """
        return self.effective_masses(kin, direction[:, None])[0]

    def effective_masses(self, kin: Kinematics, directions: Float[Array, "coordinates rank"]) -> Float[Array, " rank"]:
        """Return the mass that a force along each of several directions meets, a direction a column [kg] (M21)."""
        return _masses(directions, self.response(kin, directions))

    def kinetic_energy(self, kin: Kinematics) -> Float[Array, ""]:
        """Return ½ vᵀ M v [J] (M76, M123, M211)."""
        total = 0.5 * jnp.sum(self.masses() * kin.v * kin.v)
        for _, frame, inertia in self._turning(kin):
            pairs = zip(components(frame.spin), components(self.basis.spin_momentum(frame, inertia)), strict=True)
            total = total + 0.5 * sum(spin * momentum for spin, momentum in pairs)
        return total + sum(body.kinetic_energy(kin.frame(k), *kin.modal(k)) for k, body in self.flexible)

    def stored_energy(self, kin: Kinematics) -> Scalar:
        """Return the energy stored in force elements and flexible bodies [J]."""
        elastic = [body.elastic_energy(kin.modal(k)[0]) for k, body in self.flexible]
        return sum([element.energy(kin) for element in self.forces] + elastic, start=jnp.zeros(()))

    def dissipation(self, kin: Kinematics) -> Scalar:
        """Return the power turned into heat in force elements and flexible bodies [W]."""
        damped = [body.dissipation(kin.modal(k)[1]) for k, body in self.flexible]
        return sum([element.dissipation(kin) for element in self.forces] + damped, start=jnp.zeros(()))

    def linear_momentum(self, kin: Kinematics) -> Float[Array, " dimensions"]:
        """Return the (dimensions,) Σ m ṙ [kg m/s] (M77, M124)."""
        total = self.basis.vector(*(jnp.sum(entries) for entries in self._momenta(kin)[: self.basis.dimensions]))
        for k, body in self.flexible:
            total = total + body.linear_momentum(kin.frame(k), *kin.modal(k))
        return jnp.stack(total)

    def angular_momentum(self, kin: Kinematics) -> Float[Array, "..."]:
        """Return Σ (r × m ṙ + I ω) about the inertial origin [kg m²/s], in space a vector (M77, M124, M211)."""
        each, n, vector = self.basis.positions, self.basis.dimensions, self.basis.vector
        momenta, end = self._momenta(kin), each * len(self.bodies)
        orbital = vector(*(kin.q[k:end:each] for k in range(n))).cross(vector(*momenta[:n]))
        own = zip(components(orbital), momenta[n:], strict=True)
        total = [jnp.sum(entries + spin) for entries, spin in own]
        for k, body in self.flexible:
            total[0] = total[0] + body.angular_momentum(kin.frame(k), *kin.modal(k))
        for _, frame, inertia in self._turning(kin):
            spins = components(self.basis.spin_momentum(frame, inertia))
            total = [entry + spin for entry, spin in zip(total, spins, strict=True)]
        return jnp.stack(total) if len(total) > 1 else total[0]

    def _momenta(self, kin: Kinematics) -> list[Float[Array, " bodies"]]:
        """Return what each velocity of rigid bodies has of momentum, body by body, blocks left out."""
        each = self.basis.velocities
        rigid = (self.masses() * kin.v)[: each * len(self.bodies)]
        return [rigid[k::each] for k in range(each)]

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


def _masses(
    directions: Float[Array, "coordinates rank"], response: Float[Array, "coordinates rank"]
) -> Float[Array, " rank"]:
    """Return the mass that a force along each direction meets [kg], from the accelerations that unit forces cause."""
    # The acceleration along a direction by a unit force along it is one over the mass.
    return 1.0 / jnp.sum(directions * response, axis=0)
