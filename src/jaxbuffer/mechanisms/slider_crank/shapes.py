"""Rods and sliders of any planar shape, from meshes whose boundaries name what is attached."""

import dataclasses
import functools
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._types import Scalar
from ...errors import InputError
from ...fields import mesh_of
from ...multibody import Body
from ...multibody.flexible import ComponentModes, Marker

POISSONS_RATIO = 0.3  # of a shape, in plane stress
LEAST_MODES = 3  # of a shape that bends: with these its two attachments move and turn
ROD = ("crank_pin", "piston_pin")  # boundaries of a rod's mesh
SLIDER = ("guide", "piston_pin")  # and of a slider's

Places = tuple[tuple[Scalar, Scalar], tuple[Scalar, Scalar]]


class PlanarBody(NamedTuple):
    """A body of a planar shape.

    - ``modes``: what the equations of motion need.
    - ``first``, ``second``: its attachments.
    - ``deflection``: (modes,) of its middle, off the line through both, per unit of each modal coordinate [-].
    - ``stress``: (2, modes) along that line on both surfaces of its middle, per unit of each [Pa/m].
    """

    modes: ComponentModes
    first: Marker
    second: Marker
    deflection: Float[Array, " modes"]
    stress: Float[Array, "2 modes"]


def check_modes(section: str, modes: int) -> None:
    """Raise `InputError` for a number of modes that a shape with two attachments can not have."""
    if 0 < modes < LEAST_MODES:
        raise InputError(
            f"{section}.modes = {modes}: both attachments of a shape move and turn, which takes {LEAST_MODES} modes;"
            f" give 0, or {LEAST_MODES} or more"
        )


def shaped(part: Any, names: tuple[str, str], size: Scalar) -> PlanarBody:
    """Return a rod or slider in its modes. ``names``: of the boundaries; ``size``: the mesh's unit of length [m]."""
    planar = reduced(part.shape, names, part.modes)
    material = part.width, part.density, part.young_modulus
    component, (first, second) = planar.body(*material, size, damping_ratio=part.damping_ratio)
    deflection, stress = map(jnp.asarray, _middle(part.shape, names, part.modes))
    return PlanarBody(component, first, second, deflection, stress * (part.young_modulus / size))


def places(part: Any, names: tuple[str, str], size: Scalar) -> Places:
    """Return the attachments of a rod or slider, from the undeformed body's centre of mass [m]."""
    (x0, y0), (x1, y1) = reduced(part.shape, names, 0).points
    return (size * x0, size * y0), (size * x1, size * y1)


def rigid(part: Any, names: tuple[str, str], size: Scalar) -> Body:
    """Return a rod or slider as a rigid body; arrays broadcast."""
    planar, areal = reduced(part.shape, names, 0), part.width * part.density * size**2
    return Body(areal * planar.area, areal * size**2 * planar.inertia)


def length_in_mesh(text: str) -> float:
    """Return how far a rod's pins are apart in its mesh, in the mesh's unit."""
    points = reduced(text, ROD, 0).points
    return float(points[1, 0] - points[0, 0])


def highest_period(part: Any, names: tuple[str, str], size: Any) -> Any:
    """Return the period of the highest mode of a rod or slider [s]; arrays broadcast."""
    squared = np.asarray(part.young_modulus / part.density) * reduced(part.shape, names, part.modes).eigenvalues[-1]
    return 2.0 * np.pi * np.asarray(size) / np.sqrt(squared)


@functools.lru_cache(maxsize=32)
def reduced(text: str, names: tuple[str, str], modes: int) -> Any:
    """Return the mesh in so many modes, at least those that the attachments take, as `PlanarModes`."""
    from ...multibody.flexible import boundary, planar_modes  # scikit-fem takes long to import

    # Modes are kept in the mesh's own units: dimensions and materials only scale them.
    mesh = placed_mesh(text, names)
    return planar_modes(mesh, [boundary(mesh, name) for name in names], max(modes - LEAST_MODES, 0), POISSONS_RATIO)


@functools.lru_cache(maxsize=32)
def placed_mesh(text: str, names: tuple[str, str]) -> Any:
    """Return the mesh, that of a rod turned so that its pins lie along the x-axis."""
    from ...multibody.flexible import boundary  # scikit-fem takes long to import

    mesh = mesh_of(text)
    # A slider does not turn: its mesh stays as it is, along the slider's line.
    if names != ROD:
        return mesh
    (x0, y0), (x1, y1) = (boundary(mesh, name).point for name in names)
    cos, sin = np.array([x1 - x0, y1 - y0]) / np.hypot(x1 - x0, y1 - y0)
    return dataclasses.replace(mesh, doflocs=np.array([[cos, sin], [-sin, cos]]) @ mesh.doflocs)


def _middle(text: str, names: tuple[str, str], modes: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (modes,) deflection of the node nearest to the middle between the attachments, off the line through them,
    and (2, modes) stress of unit modulus where the mesh's boundary is highest and lowest there."""
    planar, mesh = reduced(text, names, modes), placed_mesh(text, names)
    (x0, y0), (x1, y1) = planar.points
    middle = np.array([0.5 * (x0 + x1), 0.5 * (y0 + y1)])
    node = int(np.argmin(np.linalg.norm(planar.nodes - middle[:, None], axis=0)))
    # A rod's pins lie along x; a slider's attachments may lie above each other, with no share of x between them.
    share = (planar.nodes[0, node] - x0) / (x1 - x0) if names == ROD else 0.5
    ends = planar.motions[:, 1]
    deflection = planar.shapes[1, node] - (1.0 - share) * ends[0] - share * ends[1]
    vertices = mesh.facets[:, mesh.boundary_facets()]
    x, y = planar.nodes[:, vertices] - middle[:, None, None]
    across = np.flatnonzero((x.min(axis=0) <= 0.0) & (x.max(axis=0) >= 0.0))
    width = x[1, across] - x[0, across]
    # How far along the edge, from its first vertex to its second, it crosses the middle.
    second = np.where(width == 0.0, 0.0, -x[0, across] / np.where(width == 0.0, 1.0, width))
    height = (1.0 - second) * y[0, across] + second * y[1, across]
    rows = [
        (1.0 - second[k]) * planar.stress[vertices[0, across[k]]] + second[k] * planar.stress[vertices[1, across[k]]]
        for k in (np.argmax(height), np.argmin(height))
    ]
    return deflection, np.stack(rows)


def outlines(text: str, names: tuple[str, str], size: float) -> list[np.ndarray]:
    """Return the closed lines around the mesh, (corners, 2) from the centre of mass [m]."""
    mesh, centre = placed_mesh(text, names), reduced(text, names, 0).centre
    follows: dict[int, list[int]] = {}
    for first, second in mesh.facets[:, mesh.boundary_facets()].T:
        follows.setdefault(int(first), []).append(int(second))
        follows.setdefault(int(second), []).append(int(first))
    lines = []
    # Edges are followed from vertex to vertex until a line closes; those that are left belong to further lines.
    while any(follows.values()):
        start = here = next(vertex for vertex, others in follows.items() if others)
        line = [start]
        while follows[here]:
            there = follows[here].pop()
            follows[there].remove(here)
            line.append(here := there)
        lines.append(size * (mesh.p[:, line].T - centre))
    return lines
