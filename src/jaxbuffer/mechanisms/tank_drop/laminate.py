"""The composite wall: Aerospatiale's lay-up as thick as the wall, as elements and ply by ply (M156 to M158)."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import stacked
from ...composites import CRITERIA, Laminate, Ply, Strength
from ...fields import POSITIVE, Number, Part, choice, chosen, number
from ...structures import Orthotropic, at_faces

LAMINATE = chosen("material.kind", "composite")
HALF = (45.0, -45.0, 0.0, 90.0, 0.0, 90.0, 45.0, -45.0, 0.0, 90.0)  # °, from either face inwards
# A symmetric lay-up does not bend when it is stretched: its membrane stiffness alone gives the elements' moduli.
ANGLES = (*HALF, *HALF[::-1])  # from the direction along the wall


class Composite(Part):
    """The plies of a composite wall, carbon fibres in epoxy (T300/BSL914) unless said otherwise."""

    section: ClassVar[str] = "composite"
    density: Number = number(1580.0, "kg/m³", **POSITIVE, needs=LAMINATE, doc="density of the plies")
    along: Number = number(130e9, "Pa", **POSITIVE, needs=LAMINATE, doc="Young's modulus along the fibres")
    across: Number = number(4.65e9, "Pa", **POSITIVE, needs=LAMINATE, doc="Young's modulus across the fibres")
    shear: Number = number(4.65e9, "Pa", **POSITIVE, needs=LAMINATE, doc="shear modulus in the ply's plane")
    poisson: Number = number(
        0.35, "-", low=0.0, high=1.0, high_open=True, needs=LAMINATE, doc="Poisson's ratio in the ply's plane"
    )
    along_tension: Number = number(1200e6, "Pa", **POSITIVE, needs=LAMINATE, doc="strength along the fibres in tension")
    along_compression: Number = number(
        1000e6, "Pa", **POSITIVE, needs=LAMINATE, doc="strength along the fibres in compression"
    )
    across_tension: Number = number(50e6, "Pa", **POSITIVE, needs=LAMINATE, doc="strength across the fibres in tension")
    across_compression: Number = number(
        120e6, "Pa", **POSITIVE, needs=LAMINATE, doc="strength across the fibres in compression"
    )
    shear_strength: Number = number(75e6, "Pa", **POSITIVE, needs=LAMINATE, doc="strength in shear in the ply's plane")
    criterion: str = choice("tsai-hill", *CRITERIA, needs=LAMINATE, doc="failure criterion of a ply")

    @property
    def laminate(self) -> Laminate:
        """Return the laminate, a metre thick: strains and stresses depend on the share of the thickness alone."""
        return Laminate(Ply(self.along, self.across, self.shear, self.poisson, 1.0 / len(ANGLES)), ANGLES)

    @property
    def strength(self) -> Strength:
        """Return the strength of a ply."""
        return Strength(
            self.along_tension,
            self.along_compression,
            self.across_tension,
            self.across_compression,
            self.shear_strength,
        )


def equivalent(composite: Composite) -> Orthotropic:
    """Return the material of the wall's elements: in their plane as stiff as the laminate's membrane, across as a ply
    across its fibres."""
    # Moduli are those of a stretch along one axis with the other one free, which the compliance has.
    compliance = jnp.linalg.inv(composite.laminate.stiffness().a)
    along_wall, along_tank = 1.0 / compliance[0, 0], 1.0 / compliance[1, 1]
    contraction = -compliance[0, 1] * along_wall
    return Orthotropic(
        composite.density,
        stacked([along_wall, composite.across, along_tank]),
        # The last one by Maxwell's reciprocity, ν23/E2 = ν32/E3: stretched along the tank, a wall narrows as a ply
        # does.
        stacked([composite.poisson, contraction, composite.poisson * composite.across / along_tank]),
        composite.shear,
    )


def least_reserve(
    composite: Composite, across: int, stress: Float[Array, "elements points 4"], material: Orthotropic
) -> Float[Array, ""]:
    """Return the least reserve factor of any ply [-].

    **Arguments:** ``across``: how many elements the wall is thick; ``stress``: at their integration points [Pa], of
    their ``material``.

    Between the faces the strain along the wall is linear: that of the middle, and what bending adds.
    """
    strain = at_faces(material.strain_along(stress)).reshape(-1, across, 4)
    # A column's elements go from the inside out, and the side 1-2 of each, whose values come first, is its outer one.
    outer, inner = strain[:, -1, :2], strain[:, 0, 2:]
    middle, change = 0.5 * (outer + inner), inner - outer
    along, none = jnp.array([1.0, 0.0, 0.0]), jnp.zeros(3)
    laminate = composite.laminate
    of_middle, of_change = laminate.stresses(along, none), laminate.stresses(none, along)
    plies = jnp.tensordot(middle, of_middle, axes=0) + jnp.tensordot(change, of_change, axes=0)
    return jnp.min(CRITERIA[composite.criterion](plies, composite.strength))
