"""What the equations of motion know of a flexible body: its mode shapes at markers and their integrals over its mass.

A material point at x in the body's axes is displaced by Φ(x) q there, with the mode shapes Φ (2, n) and the modal
coordinates q (n,). Its place is r + A(θ)(x + Φ(x) q) with the frame's origin r and angle θ (M110). All builders of this
package put the origin at the centre of mass of the undeformed body.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar
from ...plane import Vector

Modal = Float[Array, " modes"]
ModalMatrix = Float[Array, "modes modes"]


class Marker(eqx.Module):
    """A point of a flexible body to which joints, forces and contacts attach.

    - ``x``, ``y``: its place on the undeformed body, in the body's axes [m].
    - ``displacement_x``, ``displacement_y``: (modes,) Φ there: displacement per unit of each modal coordinate [-].
    - ``rotation``: (modes,) rotation of the material there per unit of each modal coordinate [rad/m].
    """

    x: Scalar
    y: Scalar
    displacement_x: Modal
    displacement_y: Modal
    rotation: Modal

    @staticmethod
    def on_frame(x: Scalar, y: Scalar, modes: int) -> "Marker":
        """Make a point that is fixed to the frame of a body with so many ``modes`` and does not deform with it."""
        still = jnp.zeros(modes)
        return Marker(x, y, still, still, still)

    def displacement(self, q: Modal) -> Vector:
        """Return Φ q in the body's axes [m]. ``q``: (modes,) modal coordinates; with their rates it is a velocity
        [m/s]."""
        return Vector(jnp.sum(self.displacement_x * q), jnp.sum(self.displacement_y * q))

    def place(self, q: Modal) -> Vector:
        """Return the point's place in the body's axes [m]. ``q``: (modes,) modal coordinates."""
        moved = self.displacement(q)
        return Vector(self.x + moved.x, self.y + moved.y)

    def turn(self, q: Modal) -> Scalar:
        """Return by how much the material there is turned against the body's axes [rad]. ``q``: (modes,) modal
        coordinates."""
        return jnp.sum(self.rotation * q)


class ComponentModes(eqx.Module):
    """A flexible body reduced to n modes: everything that its equations of motion need (M111 to M114).

    Modal coordinates q are lengths [m], shapes φ_k = (φ_x,k, φ_y,k) have no dimension. None stands for zero and spares
    the terms.

    - ``mass``: m [kg].
    - ``inertia``: J of the undeformed body about the frame's origin [kg m²].
    - ``mass_matrix``: (modes, modes) M = ∫ φ_k·φ_l dm [kg].
    - ``stiffness``: (modes, modes) K; the elastic energy is ½ qᵀ K q [N/m].
    - ``damping``: (modes, modes) C; the force -C q̇ acts on q [N s/m].
    - ``static_moment``: (2,) ∫ x dm [kg m]. None: the frame's origin is the undeformed body's centre of mass.
    - ``translation``: (2, modes) ∫ φ_k dm [kg]. None: the modes keep the centre of mass (mean axes).
    - ``rotation``: (modes,) ∫ (x φ_y,k - y φ_x,k) dm [kg m]. None: the modes have no angular momentum (mean axes).
    - ``radial``: (modes,) ∫ (x φ_x,k + y φ_y,k) dm [kg m]. None: bending of a straight bar alone.
    - ``gyroscopic``: (modes, modes) ∫ (φ_x,k φ_y,l - φ_y,k φ_x,l) dm in row k, column l, antisymmetric [kg]. None: all
      shapes along one axis.
    - ``geometric``: (modes, modes) G, the stiffness per squared spin that comes from the centrifugal tension: in a
      steady spin ω the matrix K + ω² (G - M) restores q [kg]. It belongs to the kinetic energy -½ ω² qᵀ G q (M114), so
      a moment of inertia J + 2 radial·q + qᵀ (M - G) q keeps the energy balance. None: not modelled; then the spin
      must stay far below the lowest frequency.
    - ``orthogonal``: mass matrix and stiffness are diagonal.
    """

    mass: Scalar
    inertia: Scalar
    mass_matrix: ModalMatrix
    stiffness: ModalMatrix
    damping: ModalMatrix
    static_moment: Float[Array, "2"] | None = None
    translation: Float[Array, "2 modes"] | None = None
    rotation: Modal | None = None
    radial: Modal | None = None
    gyroscopic: ModalMatrix | None = None
    geometric: ModalMatrix | None = None
    orthogonal: bool = eqx.field(static=True, default=False)

    @property
    def size(self) -> int:
        """Return the number of modes n."""
        return self.mass_matrix.shape[0]

    def with_damping(self, damping: ModalMatrix) -> "ComponentModes":
        """Return the same body with other damping. ``damping``: (modes, modes) C, of `modal_damping` or
        `rayleigh_damping`."""
        return eqx.tree_at(lambda modes: modes.damping, self, damping)

    def frequencies(self, spin: Scalar = 0.0) -> Modal:
        """Return the (modes,) natural frequencies [Hz] with the body's frame held, in ascending order.

        With a spin they are those of a steadily spinning frame without its gyroscopic terms; an unstable mode has the
        frequency nan. LAPACK solves the eigenproblem: not for use inside a run.

        **Arguments:** ``spin``: ω of the frame [rad/s].
        """
        stiffness = self.stiffness - spin**2 * self.mass_matrix
        if self.geometric is not None:
            stiffness = stiffness + spin**2 * self.geometric
        # By the Cholesky factor the general eigenproblem becomes a symmetric one.
        lower = jnp.linalg.cholesky(self.mass_matrix)
        half = jnp.linalg.solve(lower, stiffness)
        values = jnp.linalg.eigvalsh(jnp.linalg.solve(lower, half.T))
        return jnp.sqrt(values) / (2.0 * jnp.pi)
