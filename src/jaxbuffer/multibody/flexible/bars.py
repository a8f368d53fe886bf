"""Flexible bars: a free one, a cantilever, one between two pins. Length, section and material may be traced.

The numbers of modes are Python's integers. The frame's x axis lies along the undeformed bar; its origin is the centre
of mass of the undeformed body, with the tip's mass where there is one.
"""

import jax.numpy as jnp

from ..._types import Scalar
from .bar import Bar, FlexibleBar, marker_on
from .bar_integrals import component_modes, with_damping_ratio, with_geometric, with_mean_axes, with_tip
from .bar_shapes import BarShapes, cantilever_shapes, free_shapes, sine_shapes
from .modes import ModalMatrix


def free_bar(
    bar: Bar,
    interior: int = 4,
    axial_interior: int | None = None,
    *,
    damping_ratio: Scalar = 0.0,
    geometric: bool = False,
) -> FlexibleBar:
    """Make a free bar in mean axes, after Craig and Bampton with both end nodes kept (M115): a rod between two joints.

    Without traces of rigid-body motion its modes couple to the frame by radial and gyroscopic terms only, and by these
    only if it stretches, too.

    **Arguments:**

    - ``bar``: length, section, material.
    - ``interior``: number of fixed-interface modes in bending; the body gets interior + 2 lateral modes.
    - ``axial_interior``: the same along the bar, which adds axial_interior + 1 modes. None: it does not stretch.
    - ``damping_ratio``: ζ of every mode [-].
    - ``geometric``: stiffen by the centrifugal tension of a bar that spins about its middle (M114).

    Craig and Bampton 1968; table of β in docs/flexible.md.

    >>> rod = free_bar(Bar.circle(0.24, 0.004, 7850.0, 2.07e11), interior=6)
    >>> [round(float(f), 2) for f in rod.modes.frequencies()[:2]]
    [317.48, 875.3]
    """
    shapes = free_shapes(interior, axial_interior)
    modes = with_damping_ratio(with_mean_axes(component_modes(bar, shapes, 0.5)), damping_ratio)
    if geometric:
        tension = 0.5 * (shapes.integrals.slopes[1] - shapes.integrals.slopes[2])  # N / (ρ A L² ω²) = ½ ξ (1 - ξ)
        modes = with_geometric(modes, jnp.asarray(bar.mass * tension))
    return FlexibleBar(bar, modes, 0.5, shapes)


def cantilever_bar(
    bar: Bar,
    interior: int = 2,
    axial_interior: int | None = None,
    *,
    tip_mass: Scalar | None = None,
    tip_inertia: Scalar | None = None,
    hub_radius: Scalar = 0.0,
    damping_ratio: Scalar = 0.0,
    geometric: bool = False,
) -> FlexibleBar:
    """Make a bar clamped to its frame at its start, after Craig and Bampton with the end node kept (M115): a boom, a
    blade.

    The start neither moves nor turns in the body's axes: what is welded or hinged there carries the frame.

    **Arguments:**

    - ``bar``, ``interior``, ``axial_interior``, ``damping_ratio``: as `free_bar` has them, and as many modes.
    - ``tip_mass``: of a body on the end [kg]. None: there is none.
    - ``tip_inertia``: of that body about the bar's end [kg m²]. Its share of the geometric stiffness is always there:
      an inertia that only turns feels no centrifugal force, though it is in the mass matrix.
    - ``hub_radius``: from the axis of the spin to the start, for ``geometric`` [m].
    - ``geometric``: stiffen by the centrifugal tension of a bar that spins about that axis (M114).

    >>> blade = cantilever_bar(Bar(10.0, 1.0, 5e-4, 1.2, 2.8e7), geometric=True)
    >>> [round(float(blade.modes.frequencies(spin)[0]), 4) for spin in (0.0, 6.0)]
    [0.6045, 0.719]
    """
    shapes = cantilever_shapes(interior, axial_interior)
    tip = 0.0 if tip_mass is None else tip_mass
    # With the origin in the centre of mass, static moments vanish.
    centre = (0.5 * bar.mass + tip) / (bar.mass + tip)
    modes, end = component_modes(bar, shapes, centre), marker_on(bar, shapes, centre, 1.0)
    if tip_mass is not None or tip_inertia is not None:
        modes = with_tip(modes, end, tip, 0.0 if tip_inertia is None else tip_inertia)
    modes = with_damping_ratio(modes, damping_ratio)
    if geometric:
        modes = with_geometric(modes, _tension_of_a_spin(bar, shapes, tip, hub_radius))
    if tip_inertia is not None:
        # Cancels what the mass matrix has of that inertia in K + ω² (G - M).
        modes = with_geometric(modes, tip_inertia * jnp.outer(end.rotation, end.rotation))
    return FlexibleBar(bar, modes, centre, shapes)


def _tension_of_a_spin(bar: Bar, shapes: BarShapes, tip: Scalar, hub_radius: Scalar) -> ModalMatrix:
    """Return the geometric stiffness [kg] of a cantilever that spins about an axis ``hub_radius`` [m] before its start
    (M114).

    The tension is N(ξ) = ω² L (m (½ (1 - ξ²) + h (1 - ξ)) + m_tip (1 + h)), h the hub's radius over L; ``tip``: [kg].
    """
    constant, linear, quadratic = shapes.integrals.slopes
    hub = hub_radius / bar.length
    spread = bar.mass * (0.5 * (constant - quadratic) + hub * (constant - linear))
    return jnp.asarray(spread + tip * (1.0 + hub) * constant)


def pinned_bar(bar: Bar, modes: int = 2, axial_nodes: bool = False, *, damping_ratio: Scalar = 0.0) -> FlexibleBar:
    """Make a bar whose frame goes through both ends: it has sine modes, and two nodes of a quadratic shape along the
    bar.

    **Arguments:**

    - ``bar``: length, section, material.
    - ``modes``: number of lateral shapes sin(kπξ).
    - ``axial_nodes``: stretch it; the last two coordinates are the displacements along it of middle and end, while the
      start stays in its place on the frame.
    - ``damping_ratio``: ζ of every natural mode [-].

    B. Simeon, *Modelling a flexible slider crank mechanism by a mixed system of DAEs and PDEs*, 1996.

    >>> rod = pinned_bar(Bar.rectangle(0.3, 0.008, 0.008, 7870.0, 2e11), 2, axial_nodes=True)
    >>> rod.modes.size, round(float(rod.modes.mass_matrix[0, 0]), 6), round(float(rod.modes.frequencies()[0]), 2)
    (4, 0.075552, 203.19)
    """
    shapes = sine_shapes(modes, axial_nodes)
    damped = with_damping_ratio(component_modes(bar, shapes, 0.5), damping_ratio)
    return FlexibleBar(bar, damped, 0.5, shapes)
