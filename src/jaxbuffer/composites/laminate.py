"""Classical laminate theory: plies bonded to a thin plate (M156 to M158)."""

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .failure import Criterion, Strength, tsai_hill
from .ply import Ply, in_ply_axes


class Stiffness(NamedTuple):
    """[N; M] = [A B; B D] [ε0; κ] (M157).

    - ``a``: (3, 3) A, of the membrane [N/m].
    - ``b``: (3, 3) B, the coupling, zero for a symmetric lay-up [N].
    - ``d``: (3, 3) D, of bending [N m].
    """

    a: Float[Array, "3 3"]
    b: Float[Array, "3 3"]
    d: Float[Array, "3 3"]


class Laminate(NamedTuple):
    """Plies of one kind, each at its angle.

    - ``ply``: the kind.
    - ``angles``: of the fibres [°], from the lowest ply up.

    **Example:** a symmetric lay-up does not bend when it is stretched.

    >>> cross_ply = Laminate(Ply(130e9, 4.65e9, 4.65e9, 0.35, 0.13e-3), (0.0, 90.0, 90.0, 0.0))
    >>> bool(jnp.all(jnp.abs(cross_ply.stiffness().b) < 1e-6))
    True
    """

    ply: Ply
    angles: Sequence[float]

    @property
    def thickness(self) -> Float[Array, ""]:
        """Return the thickness of all plies [m]."""
        return jnp.asarray(self.ply.thickness, float) * len(self.angles)

    @property
    def interfaces(self) -> Float[Array, " surfaces"]:
        """Return the (plies + 1,) heights of the plies' surfaces above the middle surface [m]."""
        return jnp.asarray(np.arange(len(self.angles) + 1) - len(self.angles) / 2.0) * self.ply.thickness

    def stiffness(self) -> Stiffness:
        """Return A, B and D."""
        z = self.interfaces
        turned = jnp.stack([self.ply.stiffness(angle) for angle in self.angles])
        # A, B and D are one integral over the thickness, of the stiffness times z to the power 0, 1 and 2.
        weighed = lambda n: jnp.einsum("kij,k->ij", turned, (z[1:] ** n - z[:-1] ** n) / n)  # noqa: E731
        return Stiffness(weighed(1), weighed(2), weighed(3))

    def strains(
        self, forces: Float[Array, " 3"], moments: Float[Array, " 3"]
    ) -> tuple[Float[Array, " 3"], Float[Array, " 3"]]:
        """Return the strains of the middle surface and the curvatures.

        **Arguments:** ``forces``: (Nx, Ny, Nxy) per width [N/m]; ``moments``: (Mx, My, Mxy) per width [N].

        **Returns:** (εx, εy, γxy) [-] and (κx, κy, κxy) [1/m].
        """
        a, b, d = self.stiffness()
        # Together, since an unsymmetric lay-up couples stretching and bending.
        whole = jnp.block([[a, b], [b, d]])
        both = jnp.linalg.solve(whole, jnp.concatenate([forces, moments]))
        return both[:3], both[3:]

    def stresses(self, strain: Float[Array, " 3"], curvature: Float[Array, " 3"]) -> Float[Array, "plies 2 3"]:
        """Return σ1, σ2, τ12 [Pa] in each ply's own axes, at its lower and at its upper surface (M158).

        **Arguments:** ``strain``: (3,) of the middle surface [-]; ``curvature``: (3,) [1/m].
        """
        z, own = self.interfaces, self.ply.stiffness()
        heights = jnp.stack([z[:-1], z[1:]], axis=1)
        strains = strain[None, None] + heights[:, :, None] * curvature[None, None]
        turns = jnp.stack([in_ply_axes(angle) for angle in self.angles])
        return jnp.einsum("ij,pjk,psk->psi", own, turns, strains)

    def reserve_factors(
        self,
        forces: Float[Array, " 3"],
        moments: Float[Array, " 3"],
        strength: Strength,
        criterion: Criterion = tsai_hill,
    ) -> Float[Array, " plies"]:
        """Return the (plies,) lesser reserve factor of each ply's two surfaces [-].

        **Arguments:** ``forces`` [N/m] and ``moments`` [N]: as for `strains`; ``strength``: of the ply;
        ``criterion``: one of `CRITERIA`.

        **Example:** Aerospatiale's lay-up (MTS 006) under 308.3, -22.2 and 449.2 N/mm, of which the manual prints 1.42
        for the 45° plies.

        >>> half = (45.0, -45.0, 0.0, 90.0, 0.0, 90.0, 45.0, -45.0, 0.0, 90.0)
        >>> panel = Laminate(Ply(130e9, 4.65e9, 4.65e9, 0.35, 0.13e-3), (*half, *half[::-1]))
        >>> strength = Strength(1200e6, 1000e6, 50e6, 120e6, 75e6)
        >>> factors = panel.reserve_factors(1e3 * jnp.array([308.3, -22.2, 449.2]), jnp.zeros(3), strength)
        >>> f"{float(factors[0]):.4f}"
        '1.4216'
        """
        strain, curvature = self.strains(forces, moments)
        return jnp.min(criterion(self.stresses(strain, curvature), strength), axis=1)
