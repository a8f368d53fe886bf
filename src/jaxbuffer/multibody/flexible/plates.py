"""Plates that rest on supports and are struck. Numbers may be traced.

Their frame stays where the supports are.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar
from .bar import Bar, FlexibleBar
from .bar_integrals import component_modes, with_damping_ratio
from .bar_shapes import clamped_shapes, supported_shapes

SHAPES = {"supported": supported_shapes, "clamped": clamped_shapes}


def plate_strip(
    bar: Bar, modes: int | tuple[int, ...] = 8, *, support: str = "supported", damping_ratio: Scalar = 0.0
) -> FlexibleBar:
    """Make a strip in bending between two supports, in its analytic modes of ∫ φ² dξ = 1 (M119).

    Simple supports: φ_i = √2 sin(iπx/L), which is √(2/ρAL) sin(iπx/L) for a modal mass of 1.

    **Arguments:**

    - ``bar``: length between the supports, section, material. For a plate much wider than long E/(1 - ν²) replaces E.
    - ``modes``: how many, from the first; or which, counted from 1: (1, 3, 5) for a load at mid-span.
    - ``support``: "supported" (free to turn) or "clamped" at both ends.
    - ``damping_ratio``: ζ of every mode [-].

    >>> plate = plate_strip(Bar.rectangle(0.3, 0.1, 0.006, 7850.0, 2.07e11), 8, damping_ratio=0.01)
    >>> [round(float(f), 2) for f in plate.modes.frequencies()[:2]]
    [155.23, 620.94]
    """
    chosen = tuple(range(1, modes + 1)) if isinstance(modes, int) else modes
    if support not in SHAPES:
        raise ValueError(f"support: {support!r} is none of {', '.join(SHAPES)}")
    shapes = SHAPES[support](chosen)
    return FlexibleBar(bar, with_damping_ratio(component_modes(bar, shapes, 0.5), damping_ratio), 0.5, shapes)


class RectangularPlate(eqx.Module):
    """A thin rectangular plate on simple supports all around, struck across its plane (Kirchhoff, M120).

    - ``length``, ``width``, ``thickness``: [m].
    - ``density``: [kg/m³].
    - ``youngs_modulus``: E [Pa].
    - ``poissons_ratio``: ν [-].

    >>> plate = RectangularPlate(0.6, 0.6, 0.005, 7800.0, 2.1e11, 0.3)
    >>> round(float(plate.frequencies((1,))[0, 0]), 3)
    68.512
    """

    length: Scalar
    width: Scalar
    thickness: Scalar
    density: Scalar
    youngs_modulus: Scalar
    poissons_ratio: Scalar

    @property
    def rigidity(self) -> Scalar:
        """Return D = E h³/(12 (1 - ν²)) [N m]."""
        return self.youngs_modulus * self.thickness**3 / (12.0 * (1.0 - self.poissons_ratio**2))

    @property
    def mobility(self) -> Scalar:
        """Return the speed per force of a point of the infinite plate, 1/(8 √(D ρ h)) [m/(N s)]; until waves come
        back."""
        return 1.0 / (8.0 * jnp.sqrt(self.rigidity * self.density * self.thickness))

    def frequencies(self, waves: tuple[int, ...]) -> Float[Array, "waves waves"]:
        """Return the (waves, waves) natural frequencies [Hz] of i half waves along and j across. ``waves``: which i and
        j."""
        half = jnp.asarray(waves, float) * jnp.pi
        squared = ((half / self.length) ** 2)[:, None] + ((half / self.width) ** 2)[None, :]
        return squared * jnp.sqrt(self.rigidity / (self.density * self.thickness)) / (2.0 * jnp.pi)

    def shapes(self, x: Scalar, y: Scalar, waves: tuple[int, ...]) -> Float[Array, "waves waves"]:
        """Return the (waves, waves) mass-normalised shapes 2/√(ρ h L W) sin(iπx/L) sin(jπy/W) at a point [1/√kg].

        **Arguments:** ``x``, ``y``: from a corner [m]; ``waves``: which i and j.
        """
        mass = self.density * self.thickness * self.length * self.width
        half = jnp.asarray(waves, float) * jnp.pi
        along, across = jnp.sin(half * (x / self.length)), jnp.sin(half * (y / self.width))
        return along[:, None] * across[None, :] * (2.0 / jnp.sqrt(mass))
