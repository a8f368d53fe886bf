"""A flexible body in a floating frame of reference (Shabana, Dynamics of Multibody Systems, ch. 5, in the plane)."""

import jax.numpy as jnp

from .._types import Scalar
from ..plane import Factors, Frame, Vector
from .body import Body
from .flexible.modes import ComponentModes, Marker, Modal, ModalMatrix
from .forces import SpringDirection


class FlexibleBody(Body):
    """A body whose deformation is a sum of modes.

    - ``mass``: [kg].
    - ``inertia``: of the undeformed body about its frame's origin [kg m²].
    - ``modes``: its mode shapes' integrals, stiffness and damping.
    """

    inertia: Scalar
    modes: ComponentModes

    def __init__(self, modes: ComponentModes):
        # As a rigid body has them, so that whatever asks only for these takes either.
        self.mass, self.inertia, self.modes = modes.mass, modes.inertia, modes

    @property
    def size(self) -> int:
        """Return the number of modes."""
        return self.modes.size

    @property
    def centre_of_mass(self) -> Marker:
        """Return where its weight acts: a marker that moves as the centre of mass of the deformed body does."""
        modes, none = self.modes, jnp.zeros(self.size)
        x, y = (0.0, 0.0) if modes.static_moment is None else modes.static_moment / modes.mass
        along, across = (none, none) if modes.translation is None else modes.translation / modes.mass
        return Marker(x, y, along, across, none)

    def mass_block(self, frame: Frame, q: Modal) -> list[list[Scalar]]:
        """Return the lower half of its mass matrix, rows for the modal coordinates, then u, v, θ (M121): in this order
        few entries fill in when it is factorised. Python's 0 stands for what vanishes always."""
        modes, n = self.modes, self.size
        block: list[list[Scalar]] = [[modes.mass_matrix[i, j] for j in range(i + 1)] for i in range(n)]
        # The entries beside the diagonal are Python's 0, so that nothing is computed with them.
        if modes.orthogonal:
            block = [[*[0.0] * i, row[i]] for i, row in enumerate(block)]
        moment = self._static_moment(frame, q)
        linear_x: list[Scalar] = [0.0] * n
        linear_y: list[Scalar] = [0.0] * n
        if modes.translation is not None:
            turned = [frame.turn(Vector(x, y)) for x, y in zip(*modes.translation, strict=True)]
            linear_x, linear_y = [t.x for t in turned], [t.y for t in turned]
        about_x, about_y = (0.0, 0.0) if moment is None else (-moment.y, moment.x)
        block.append([*linear_x, self.mass])
        block.append([*linear_y, 0.0, self.mass])
        block.append([*self._angular(q), about_x, about_y, self._inertia(q)])
        return block

    def velocity_force(self, frame: Frame, q: Modal, rate: Modal) -> tuple[Vector, Scalar, tuple[Scalar, ...]]:
        """Return what acts besides loads (M122): terms of squared velocities, elastic and damping forces on the frame's
        origin [N], about it [N m], and on each modal coordinate [N]."""
        modes, spin = self.modes, frame.spin
        radial = self._radial(q)
        # The centrifugal force on the modes, less what stiffness and damping hold against it.
        modal = radial * (spin * spin) - _times(modes.stiffness, q) - _times(modes.damping, rate)
        if modes.gyroscopic is not None:
            modal = modal + _times(modes.gyroscopic, rate) * (2.0 * spin)
        moment = self._static_moment(frame, q)
        force = Vector(jnp.zeros(()), jnp.zeros(()))
        if moment is not None:
            force = moment * (spin * spin)
        if modes.translation is not None:
            # Coriolis's force of what moves in the turning frame.
            force = force - self._momentum(frame, rate).perp() * (2.0 * spin)
        return force, -2.0 * spin * jnp.sum(radial * rate), tuple(modal)

    def kinetic_energy(self, frame: Frame, q: Modal, rate: Modal) -> Scalar:
        """Return the kinetic energy [J] (M123)."""
        spin, velocity = frame.spin, frame.velocity
        squares = self.mass * velocity.dot(velocity) + self._inertia(q) * spin * spin
        squares = squares + jnp.sum(rate * _times(self.modes.mass_matrix, rate))
        return 0.5 * squares + self._coupling(frame, q, rate)

    def _coupling(self, frame: Frame, q: Modal, rate: Modal) -> Scalar:
        """Return the kinetic energy's mixed terms [J]."""
        mixed = frame.spin * sum((a * r for a, r in zip(self._angular(q), rate, strict=True)), jnp.zeros(()))
        return mixed + frame.velocity.dot(self._relative_momentum(frame, q, rate))

    def linear_momentum(self, frame: Frame, q: Modal, rate: Modal) -> Vector:
        """Return the linear momentum [kg m/s] (M124)."""
        return frame.velocity * self.mass + self._relative_momentum(frame, q, rate)

    def angular_momentum(self, frame: Frame, q: Modal, rate: Modal) -> Scalar:
        """Return the angular momentum about the inertial origin [kg m²/s] (M124)."""
        own = self._inertia(q) * frame.spin
        own = own + sum((a * r for a, r in zip(self._angular(q), rate, strict=True)), jnp.zeros(()))
        moment = self._static_moment(frame, q)
        if moment is not None:
            own = own + moment.cross(frame.velocity)
        return own + frame.origin.cross(self.linear_momentum(frame, q, rate))

    def elastic_energy(self, q: Modal) -> Scalar:
        """Return ½ qᵀ K q [J]."""
        return 0.5 * jnp.sum(q * _times(self.modes.stiffness, q))

    def dissipation(self, rate: Modal) -> Scalar:
        """Return the power turned into heat [W]."""
        return jnp.sum(rate * _times(self.modes.damping, rate))

    def springs(self, body: int) -> tuple[SpringDirection, ...]:
        """Return the spring-dampers that stand for stiffness and damping in implicit steps: along the columns of L of K
        = L D Lᵀ.

        The damping along one of these that another causes is left out; there is none if C is a multiple of K, or if the
        modes are orthogonal. ``body``: its index.
        """
        n, stiffness, damping = self.size, self.modes.stiffness, self.modes.damping
        units: list[list[Scalar]] = [[float(k == j) for j in range(n)] for k in range(n)]
        numbers: list[tuple[Scalar, Scalar]] = [(stiffness[k, k], damping[k, k]) for k in range(n)]
        if not self.modes.orthogonal:
            factors = Factors.of(stiffness)
            # In the coordinates Lᵀ q the stiffness is diagonal, so each of them is a spring by itself.
            half = jnp.stack(factors.forward(damping))  # L⁻¹ C, and then L⁻¹ C L⁻ᵀ
            across = jnp.stack(factors.forward(half.T))
            units = [[*[0.0] * k, 1.0, *(factors.lower[j][k] for j in range(k + 1, n))] for k in range(n)]
            numbers = [(factors.pivot[k], across[k, k]) for k in range(n)]
        blocks = [{body: (0.0, 0.0, 0.0, *unit)} for unit in units]
        return tuple(SpringDirection(block, *pair) for block, pair in zip(blocks, numbers, strict=True))

    def _static_moment(self, frame: Frame, q: Modal) -> Vector | None:
        """Return ∫ (x + Φ q) dm in inertial axes [kg m]; None means that it is always zero."""
        modes = self.modes
        if modes.static_moment is None and modes.translation is None:
            return None
        x, y = (0.0, 0.0) if modes.static_moment is None else modes.static_moment
        if modes.translation is not None:
            x, y = x + jnp.sum(modes.translation[0] * q), y + jnp.sum(modes.translation[1] * q)
        return frame.turn(Vector(x, y))

    def _momentum(self, frame: Frame, rate: Modal) -> Vector:
        """Return ∫ Φ q̇ dm in inertial axes [kg m/s]."""
        assert self.modes.translation is not None
        x, y = self.modes.translation
        return frame.turn(Vector(jnp.sum(x * rate), jnp.sum(y * rate)))

    def _relative_momentum(self, frame: Frame, q: Modal, rate: Modal) -> Vector:
        """Return the momentum that the body has while its frame's origin rests [kg m/s]."""
        moment = self._static_moment(frame, q)
        total = Vector(jnp.zeros(()), jnp.zeros(())) if moment is None else moment.perp() * frame.spin
        return total if self.modes.translation is None else total + self._momentum(frame, rate)

    def _radial(self, q: Modal) -> Modal:
        """Return half of what the moment of inertia grows by with each modal coordinate [kg m]."""
        modes = self.modes
        grows = _times(modes.mass_matrix, q)
        grows = grows if modes.geometric is None else grows - _times(modes.geometric, q)
        return grows if modes.radial is None else grows + modes.radial

    def _inertia(self, q: Modal) -> Scalar:
        """Return the moment of inertia about the frame's origin as deformed [kg m²]."""
        radial = self._radial(q)
        linear = radial if self.modes.radial is None else radial + self.modes.radial
        return self.inertia + jnp.sum(linear * q)

    def _angular(self, q: Modal) -> list[Scalar]:
        """Return how the angular momentum about the frame's origin goes with each modal coordinate's rate [kg m]."""
        modes, total = self.modes, list[Scalar]([0.0] * self.size)
        if modes.rotation is not None:
            total = list(modes.rotation)
        if modes.gyroscopic is not None:
            total = [t - g for t, g in zip(total, _times(modes.gyroscopic, q), strict=True)]
        return total


def _times(matrix: ModalMatrix, vector: Modal) -> Modal:
    """Multiply a matrix by a vector, as sums of products."""
    return jnp.sum(matrix * vector[None, :], axis=1)
