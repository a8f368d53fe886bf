"""Bodies of any planar shape: plane stress on a scikit-fem mesh, reduced after Craig and Bampton to mean-axis modes.

The mesh is reduced once, with NumPy; the shape's size, thickness, density and Young's modulus scale what comes out and
may be traced.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from scipy.sparse import csr_array

from ..._types import Scalar
from .craig_bampton import craig_bampton, uncoupled
from .damping import uncoupled_damping
from .modes import ComponentModes, Marker

try:
    from skfem import (
        Basis,
        BilinearForm,
        ElementQuad1,
        ElementQuad2,
        ElementTriP1,
        ElementTriP2,
        ElementVector,
        MeshTri,
    )
    from skfem.helpers import dot
    from skfem.models.elasticity import linear_elasticity, plane_stress
except ImportError as missing:
    raise ImportError("planar shapes need scikit-fem: pip install scikit-fem") from missing


class Attachment(NamedTuple):
    """Where something is attached: nodes that are tied rigidly to a point.

    - ``point``: (x, y) in the mesh's coordinates, to which the nodes are tied; it need not lie on the mesh.
    - ``nodes``: tells of (2, nodes) coordinates which belong to it, as scikit-fem's ``mesh.nodes_satisfying`` asks.
    """

    point: tuple[float, float]
    nodes: Callable[[np.ndarray], np.ndarray]


class PlanarModes(NamedTuple):
    """A reduced shape of unit thickness, density and Young's modulus, in the mesh's unit of length.

    - ``area``, ``inertia``: of the shape, about its centre of area.
    - ``centre``: (2,) the centre of area in the mesh's coordinates.
    - ``eigenvalues``: (modes,) squared circular frequencies.
    - ``radial``: (modes,) ∫ x·φ dA; ``gyroscopic``: (modes, modes) ∫ φ_k × φ_l dA; ∫ φ_k·φ_l dA is ``area`` for k = l
      and zero otherwise.
    - ``points``: (markers, 2) attachments from the centre; ``motions``: (markers, 3, modes) displacement along x and y
      and rotation there.
    - ``nodes``: (2, nodes) places from the centre, the mesh's vertices first; ``shapes``: (2, nodes, modes) there.
    - ``stress``: (vertices, modes) σ_x per unit of each modal coordinate.
    """

    area: float
    inertia: float
    centre: np.ndarray
    eigenvalues: np.ndarray
    radial: np.ndarray
    gyroscopic: np.ndarray
    points: np.ndarray
    motions: np.ndarray
    nodes: np.ndarray
    shapes: np.ndarray
    stress: np.ndarray

    def body(
        self,
        thickness: Scalar,
        density: Scalar,
        youngs_modulus: Scalar,
        size: Scalar = 1.0,
        *,
        damping_ratio: Scalar = 0.0,
    ) -> tuple[ComponentModes, tuple[Marker, ...]]:
        """Return the body's modes, and a marker for each attachment.

        **Arguments:** ``thickness``: [m]; ``density``: [kg/m³]; ``youngs_modulus``: [Pa]; ``size``: the mesh's unit of
        length [m]; ``damping_ratio``: ζ of every mode [-].
        """
        areal = density * thickness * size**2  # the mass of a unit of the mesh's area
        mass = jnp.asarray(areal * self.area * np.ones_like(self.eigenvalues))
        stiffness = jnp.asarray(youngs_modulus * thickness * self.area * self.eigenvalues)
        modes = ComponentModes(
            mass=areal * self.area,
            inertia=areal * size**2 * self.inertia,
            mass_matrix=jnp.diag(mass),
            stiffness=jnp.diag(stiffness),
            damping=uncoupled_damping(mass, stiffness, damping_ratio),
            radial=jnp.asarray(areal * size * self.radial),
            gyroscopic=jnp.asarray(areal * self.gyroscopic),
            orthogonal=True,
        )
        return modes, tuple(self._marker(k, size) for k in range(len(self.points)))

    def _marker(self, which: int, size: Scalar) -> Marker:
        (x, y), (along, across, turning) = self.points[which], self.motions[which]
        return Marker(size * x, size * y, jnp.asarray(along), jnp.asarray(across), jnp.asarray(turning) / size)


def planar_modes(mesh: Any, attachments: Sequence[Attachment], interior: int, poissons_ratio: float) -> PlanarModes:
    """Reduce a planar shape in plane stress to its mean-axis modes (M115, M116).

    Elements are quadratic: `MeshTri` and `MeshQuad` alike. There are 3 (attachments - 1) + interior modes.

    **Arguments:**

    - ``mesh``: a scikit-fem mesh, triangles or quadrilaterals, at any place.
    - ``attachments``: what is tied to markers.
    - ``interior``: number of modes with all attachments fixed.
    - ``poissons_ratio``: ν [-].
    """
    if not attachments:
        raise ValueError("attachments: give at least one")
    basis = Basis(mesh, ElementVector(ElementTriP2() if isinstance(mesh, MeshTri) else ElementQuad2()))
    mass, stiffness, places, order = _elasticity(basis, poissons_ratio)
    # Rigid translations, unknown by unknown: with the mass matrix they give area and centre.
    ones, other = np.tile([1.0, 0.0], places.shape[1]), np.tile([0.0, 1.0], places.shape[1])
    area = float(ones @ mass @ ones)
    centre = np.array([ones @ mass @ places.T.ravel(), other @ mass @ places.T.ravel()]) / area
    arms = (places - centre[:, None]).T.ravel()
    rigid = np.stack([ones, other, _turned(arms)], axis=1)
    tie, points = _tied(places, centre, attachments)
    reduction = craig_bampton(tie.T @ mass @ tie, tie.T @ stiffness @ tie, range(3 * len(attachments)), interior)
    modes = uncoupled(reduction, tie.T @ (mass @ rigid))
    # From shapes of unit modal mass to shapes without dimension, of which ∫ φ·φ dA is the area.
    motions = np.sqrt(area) * modes.shapes[: 3 * len(attachments)].reshape(len(attachments), 3, -1)
    shapes = np.sqrt(area) * (tie @ modes.shapes)
    return PlanarModes(
        area=area,
        inertia=float(arms @ mass @ arms),
        centre=centre,
        eigenvalues=modes.eigenvalues,
        radial=shapes.T @ (mass @ arms),
        gyroscopic=-shapes.T @ (mass @ _turned(shapes)),
        points=points,
        motions=motions,
        nodes=places - centre[:, None],
        shapes=np.stack([shapes[0::2], shapes[1::2]]),
        stress=_stress(basis, shapes[np.argsort(order)], poissons_ratio),
    )


def boundary(mesh: Any, name: str) -> Attachment:
    """Tie all nodes of a named boundary of a mesh to its middle, as of a pin's bush."""
    facets = np.asarray(mesh.boundaries[name])
    vertices = mesh.facets[:, facets]
    first, last = mesh.p[:, vertices[0]], mesh.p[:, vertices[1]]
    lengths = np.linalg.norm(last - first, axis=0)

    def nodes(places: np.ndarray) -> np.ndarray:
        mine = np.zeros(places.shape[1], bool)
        mine[vertices] = mine[mesh.nvertices + facets] = True  # a node on each facet follows the vertices
        return mine

    x, y = 0.5 * (first + last) @ lengths / lengths.sum()
    return Attachment((float(x), float(y)), nodes)


def _stress(basis: Basis, shapes: np.ndarray, poissons_ratio: float) -> np.ndarray:
    """Return the (vertices, modes) σ_x of unit modulus at the mesh's vertices, of (unknowns, modes) displacements in
    the order of the basis: projected onto linear elements."""
    corners = basis.with_element(ElementTriP1() if isinstance(basis.mesh, MeshTri) else ElementQuad1())
    columns = []
    for shape in shapes.T:
        gradient = basis.interpolate(shape).grad
        along = (gradient[0, 0] + poissons_ratio * gradient[1, 1]) / (1.0 - poissons_ratio**2)
        columns.append(corners.project(along)[corners.nodal_dofs[0]])
    return np.stack(columns, axis=1)


def _elasticity(basis: Basis, poissons_ratio: float) -> tuple[Any, Any, np.ndarray, np.ndarray]:
    """Return mass and stiffness of unit density, thickness and modulus, (2, nodes) places, and where each unknown is in
    the basis; unknowns (u_x, u_y) by node: vertices, then those on facets and inside."""
    mass = BilinearForm(lambda u, v, w: dot(u, v)).assemble(basis)
    stiffness = linear_elasticity(*plane_stress(1.0, poissons_ratio)).assemble(basis)
    order = np.concatenate([dofs.T.ravel() for dofs in (basis.nodal_dofs, basis.facet_dofs, basis.interior_dofs)])
    return mass[order][:, order], stiffness[order][:, order], basis.doflocs[:, order[0::2]], order


def _turned(vectors: np.ndarray) -> np.ndarray:
    """Turn vectors (x, y), node by node along the first axis, by +90° to (-y, x)."""
    turned = np.empty_like(vectors)
    turned[0::2], turned[1::2] = -vectors[1::2], vectors[0::2]
    return turned


def _tied(places: np.ndarray, centre: np.ndarray, attachments: Sequence[Attachment]) -> tuple[Any, np.ndarray]:
    """Return the matrix that gives all unknowns from the attachments' (u_x, u_y, rotation) and those of free nodes, and
    the attachments' points from the centre."""
    count = places.shape[1]
    owner = np.full(count, -1)
    for which, attachment in enumerate(attachments):
        nodes = np.asarray(attachment.nodes(places), bool)
        if not nodes.any() or (owner[nodes] >= 0).any():
            raise ValueError(f"attachments[{which}]: its nodes are {'shared' if nodes.any() else 'none'}")
        owner[nodes] = which
    points = np.array([attachment.point for attachment in attachments], float)
    tied, free = np.flatnonzero(owner >= 0), np.flatnonzero(owner < 0)
    arms, first, ones = places[:, tied] - points[owner[tied]].T, 3 * owner[tied], np.ones(tied.size)
    unknowns = 3 * len(attachments)
    inner, own = np.stack([2 * free, 2 * free + 1], 1).ravel(), unknowns + np.arange(2 * free.size)
    rows = np.concatenate([2 * tied, 2 * tied, 2 * tied + 1, 2 * tied + 1, inner])
    columns = np.concatenate([first, first + 2, first + 1, first + 2, own])
    values = np.concatenate([ones, -arms[1], ones, arms[0], np.ones(inner.size)])
    return csr_array((values, (rows, columns)), shape=(2 * count, unknowns + inner.size)), points - centre[None, :]
