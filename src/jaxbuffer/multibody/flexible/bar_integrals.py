"""From the constants of mode shapes to the integrals of a bar of given length, section and material."""

import dataclasses

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._types import Scalar
from .bar import Bar
from .bar_shapes import BarShapes
from .damping import modal_damping, uncoupled_damping
from .modes import ComponentModes, Marker, ModalMatrix


def component_modes(bar: Bar, shapes: BarShapes, centre: Scalar) -> ComponentModes:
    """Return a bar's modes in the given shapes, without damping (M112, M116).

    **Arguments:** ``bar``: length, section, material; ``shapes``: lateral and axial ones; ``centre``: station of the
    frame's origin, ξ [-].
    """
    integrals, mass, length = shapes.integrals, bar.mass, bar.length
    count, axial = len(integrals.mean), len(integrals.axial_mean)
    none, no_axial = np.zeros(count), np.zeros(axial)
    bending, stretching = bar.bending_stiffness / length**3, bar.axial_stiffness / length
    moment = integrals.moment - centre * integrals.mean
    axial_moment = integrals.axial_moment - centre * integrals.axial_mean
    coupling = np.zeros((count + axial, count + axial))
    coupling[count:, :count] = integrals.coupling
    mean = np.stack([np.concatenate([none, integrals.axial_mean]), np.concatenate([integrals.mean, no_axial])])
    matrix = _blocks(mass * integrals.mass, mass * integrals.axial_mass)
    return ComponentModes(
        mass=mass,
        inertia=_inertia(bar, centre),
        mass_matrix=matrix,
        stiffness=_blocks(bending * integrals.bending, stretching * integrals.stretching),
        damping=jnp.zeros_like(matrix),
        translation=jnp.asarray(mass * mean),
        rotation=jnp.concatenate([jnp.asarray(mass * length * moment), no_axial]),
        radial=jnp.concatenate([none, jnp.asarray(mass * length * axial_moment)]) if axial else None,
        # Only a bar that stretches has shapes along two axes.
        gyroscopic=jnp.asarray(mass * (coupling - coupling.T)) if axial else None,
        orthogonal=shapes.orthogonal_axial or not axial,
    )


def with_tip(modes: ComponentModes, tip: Marker, mass: Scalar, inertia: Scalar) -> ComponentModes:
    """Add a small body to the modes of a bar, about the same origin.

    **Arguments:** ``tip``: the marker, on the x axis, that carries it; ``mass``: [kg]; ``inertia``: about the marker
    [kg m²].
    """
    along, across, turning = tip.displacement_x, tip.displacement_y, tip.rotation
    moving = jnp.outer(along, along) + jnp.outer(across, across)
    twist = jnp.outer(along, across) - jnp.outer(across, along)
    assert modes.translation is not None and modes.rotation is not None
    return ComponentModes(
        mass=modes.mass + mass,
        inertia=modes.inertia + mass * tip.x**2 + inertia,
        mass_matrix=modes.mass_matrix + mass * moving + inertia * jnp.outer(turning, turning),
        stiffness=modes.stiffness,
        damping=modes.damping,
        translation=modes.translation + mass * jnp.stack([along, across]),
        rotation=modes.rotation + mass * tip.x * across + inertia * turning,
        radial=None if modes.radial is None else modes.radial + mass * tip.x * along,
        gyroscopic=None if modes.gyroscopic is None else modes.gyroscopic + mass * twist,
    )


def with_geometric(modes: ComponentModes, added: Float[Array, "some some"]) -> ComponentModes:
    """Add to the geometric stiffness of the first modes, or of all. ``added``: [kg] (M114)."""
    others = modes.size - added.shape[0]
    matrix = _blocks(added, np.zeros((others, others)))
    matrix = matrix if modes.geometric is None else modes.geometric + matrix
    # Without `is_leaf` a field that is None is no leaf, and could not be replaced.
    return eqx.tree_at(lambda m: m.geometric, modes, matrix, is_leaf=lambda leaf: leaf is None)


def with_mean_axes(modes: ComponentModes) -> ComponentModes:
    """Drop the couplings that are zero for modes of neither momentum nor angular momentum (M115)."""
    return eqx.tree_at(lambda m: (m.translation, m.rotation), modes, (None, None))


def with_damping_ratio(modes: ComponentModes, ratio: Scalar) -> ComponentModes:
    """Give undamped modes the damping ratio ζ each [-] (M117)."""
    # Python's 0 alone: a traced ratio may become positive, so its matrix must be there.
    if isinstance(ratio, float | int) and ratio == 0:
        return modes
    # Modes that are coupled, by a tip's mass say: the ratio is that of the natural ones.
    if not modes.orthogonal:
        return modes.with_damping(modal_damping(modes.mass_matrix, modes.stiffness, ratio))
    mass, stiffness = jnp.diag(modes.mass_matrix), jnp.diag(modes.stiffness)
    return dataclasses.replace(modes, damping=uncoupled_damping(mass, stiffness, ratio), orthogonal=True)


def _inertia(bar: Bar, centre: Scalar) -> Scalar:
    """Return the moment of inertia of the rigid bar about the station ``centre`` [kg m²]."""
    inertia = bar.mass * bar.length**2 * (1.0 / 12.0 + (0.5 - centre) ** 2)
    return inertia + bar.density * bar.second_moment * bar.length if bar.rotary_inertia else inertia


def _blocks(lateral, axial) -> ModalMatrix:
    """Put two square matrices on the diagonal of one."""
    rows, columns = lateral.shape[0], axial.shape[0]
    upper = jnp.concatenate([jnp.asarray(lateral, float), jnp.zeros((rows, columns))], axis=1)
    lower = jnp.concatenate([jnp.zeros((columns, rows)), jnp.asarray(axial, float)], axis=1)
    return jnp.concatenate([upper, lower])
