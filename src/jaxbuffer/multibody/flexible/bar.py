"""A uniform bar: its length, section and material, and the bar with its modes."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from ..._types import Scalar
from .bar_shapes import BarShapes
from .modes import ComponentModes, Marker, Modal


class Bar(eqx.Module):
    """A uniform, straight, slender bar along its body's x axis, after Euler and Bernoulli. Numbers may be traced.

    - ``length``: L [m].
    - ``area``: A of the section [m²].
    - ``second_moment``: I of the section's area about the axis of bending [m⁴].
    - ``density``: ρ [kg/m³].
    - ``youngs_modulus``: E [Pa].
    - ``rotary_inertia``: count ρ I L, which slenderness neglects, in the rigid body's moment of inertia.

    >>> bar = Bar.rectangle(length=0.3, width=0.008, depth=0.008, density=7870.0, youngs_modulus=2e11)
    >>> round(bar.mass, 6)
    0.151104
    """

    length: Scalar
    area: Scalar
    second_moment: Scalar
    density: Scalar
    youngs_modulus: Scalar
    rotary_inertia: bool = eqx.field(static=True, default=False)

    @classmethod
    def rectangle(cls, length: Scalar, width: Scalar, depth: Scalar, density: Scalar, youngs_modulus: Scalar) -> "Bar":
        """Make a bar of rectangular section. ``width``: across the plane of motion [m]; ``depth``: in it [m]; others as
        fields."""
        return cls(length, width * depth, width * depth**3 / 12.0, density, youngs_modulus)

    @classmethod
    def circle(cls, length: Scalar, diameter: Scalar, density: Scalar, youngs_modulus: Scalar) -> "Bar":
        """Make a bar of solid round section. ``diameter``: [m]; others as fields."""
        return cls(length, np.pi * diameter**2 / 4.0, np.pi * diameter**4 / 64.0, density, youngs_modulus)

    @classmethod
    def tube(cls, length: Scalar, diameter: Scalar, wall: Scalar, density: Scalar, youngs_modulus: Scalar) -> "Bar":
        """Make a bar from a round tube. ``diameter``: outside [m]; ``wall``: its thickness [m]; others as fields."""
        inside = diameter - 2.0 * wall
        area, second_moment = diameter**2 - inside**2, diameter**4 - inside**4
        return cls(length, np.pi * area / 4.0, np.pi * second_moment / 64.0, density, youngs_modulus)

    @property
    def mass(self) -> Scalar:
        """Return ρ A L [kg]."""
        return self.density * self.area * self.length

    @property
    def bending_stiffness(self) -> Scalar:
        """Return E I [N m²]."""
        return self.youngs_modulus * self.second_moment

    @property
    def axial_stiffness(self) -> Scalar:
        """Return E A [N]."""
        return self.youngs_modulus * self.area


class FlexibleBar(eqx.Module):
    """A bar with its modes: lateral ones first, then those along the bar.

    - ``bar``: length, section, material.
    - ``modes``: what the equations of motion need.
    - ``centre``: ξ of the frame's origin, the centre of mass of the undeformed body [-].
    - ``shapes``: of the modes, over the station ξ = x/L from the bar's start, 0…1.
    """

    bar: Bar
    modes: ComponentModes
    centre: Scalar
    shapes: BarShapes = eqx.field(static=True)

    @property
    def lateral(self) -> int:
        """Return the number of lateral modes; the others are along the bar."""
        return self.shapes.lateral(np.zeros(1), 0).shape[1]

    def marker(self, station: float) -> Marker:
        """Return the material point on the bar's axis at ``station``: ξ = 0 at the start, 1 at the end."""
        return marker_on(self.bar, self.shapes, self.centre, station)

    @property
    def start(self) -> Marker:
        """Return the marker at ξ = 0."""
        return self.marker(0.0)

    @property
    def middle(self) -> Marker:
        """Return the marker at ξ = ½."""
        return self.marker(0.5)

    @property
    def end(self) -> Marker:
        """Return the marker at ξ = 1."""
        return self.marker(1.0)


def marker_on(bar: Bar, shapes: BarShapes, centre: Scalar, station: float) -> Marker:
    """Return the marker at a station of a bar whose frame has its origin at the station ``centre``; ξ = 0…1."""
    if not 0.0 <= station <= 1.0:
        raise ValueError(f"station: {station} is not between 0 and 1")
    place = np.array([station])
    lateral, slope, axial = (
        rows[0] for rows in (shapes.lateral(place, 0), shapes.lateral(place, 1), shapes.axial(place, 0))
    )
    return Marker(
        bar.length * (station - centre),
        0.0,
        _vector(np.zeros_like(lateral), axial),
        _vector(lateral, np.zeros_like(axial)),
        _vector(slope, np.zeros_like(axial)) / bar.length,
    )


def _vector(lateral: np.ndarray, axial: np.ndarray) -> Modal:
    return jnp.asarray(np.concatenate([lateral, axial]))
