"""A liquid with a free surface in felupe: nine-node elements of a displacement potential ψ, joined to the wall.

The liquid moves by -∇ψ, so that its pressure is -ρ ψ̈: M_f ψ̈ + K_f ψ = Aᵀ u is M147 integrated twice, and its unknown
another one than ours.
"""

from typing import NamedTuple

import felupe as fem
import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags

from .felupe_tank import Section, cells_of


class Liquid(NamedTuple):
    """Of half the section, a metre long.

    - ``mass``, ``stiffness``: M_f [s²] and K_f [-]; ``join``: (wall's directions, points) A [m²].
    - ``free``: points beside the surface; ``bottom``: the point in the middle of the bottom.
    - ``density`` [kg/m³]; ``pushed``: (wall's directions,) what the static pressure does [N].
    """

    mass: csr_matrix
    stiffness: csr_matrix
    join: csr_matrix
    free: np.ndarray
    bottom: int
    density: float
    pushed: np.ndarray

    def energy(self, rate, second):
        """Of motion and of compression [J], from ψ̇ and ψ̈."""
        return 0.5 * self.density * (rate @ (self.stiffness @ rate) + second @ (self.mass @ second))


def liquid_of(design, scenario, section: Section, level):
    """The liquid below the ``level`` [m], at which the wall has a column."""
    corner = 2 * ((section.ends[0] + section.ends[1]) // 4)  # half way round: the corner of the liquid's block
    inside = section.node[: section.ends[2] + 1, 0]
    x = section.mesh.points[inside]
    points, grid = block(x[: corner + 1], x[corner:], level)
    mesh = fem.Mesh(points.reshape(-1, 2), cells_of(grid), "quad9")
    region, count = fem.RegionBiQuadraticQuad(mesh), grid.size
    volume, slope = region.dV, region.dhdX
    shape = np.broadcast_to(region.h, (*region.h.shape[:-1], volume.shape[-1]))
    mass = np.einsum("aqc,bqc,qc->cab", shape, shape, volume) / float(design.contents.sound_speed) ** 2
    stiffness = np.einsum("aiqc,biqc,qc->cab", slope, slope, volume)
    rows = (
        np.broadcast_to(mesh.cells[:, :, None], mass.shape).ravel(),
        np.broadcast_to(mesh.cells[:, None], mass.shape).ravel(),
    )
    mass, stiffness = (coo_matrix((part.ravel(), rows), (count, count)).tocsr() for part in (mass, stiffness))
    wet = np.concatenate([grid[0], grid[1:, -1]])
    join = joined(x, inside, wet, section.mesh.points.size, count)
    density = float(design.contents.density)
    static = density * float(scenario.gravity) * (level - points.reshape(-1, 2)[:, 1])
    return Liquid(mass, stiffness, join, np.setdiff1d(grid, grid[-1]), int(grid[0, 0]), density, join @ static)


def block(bottom, right, level):
    """(up, across, 2) points between the wall's ``bottom`` and ``right``, the middle and the surface, by transfinite
    interpolation, and their numbers."""
    s, t = np.linspace(0.0, 1.0, len(bottom))[None, :, None], np.linspace(0.0, 1.0, len(right))[:, None, None]
    left = np.stack([np.zeros(len(right)), bottom[0, 1] + t[:, 0, 0] * (level - bottom[0, 1])], axis=1)[:, None]
    top = np.stack([s[0, :, 0] * right[-1, 0], np.full(len(bottom), level)], axis=1)[None]
    below, right = bottom[None], right[:, None]
    points = (1.0 - s) * left + s * right + (1.0 - t) * below + t * top
    points = points - (1.0 - s) * ((1.0 - t) * below[:, :1] + t * top[:, :1])
    points = points - s * ((1.0 - t) * below[:, -1:] + t * top[:, -1:])
    return points, np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])


def joined(x, wall, wet, directions, count):
    """A = ∫ N_wall N_wet n ds along the path ``x`` [m] of three-point edges, n out of the liquid on its left."""
    at, weight = np.polynomial.legendre.leggauss(4)
    shape = np.stack([0.5 * at * (at - 1.0), 1.0 - at**2, 0.5 * at * (at + 1.0)], axis=1)
    slope = np.stack([at - 0.5, -2.0 * at, at + 0.5], axis=1)
    edges = np.stack([np.arange(0, len(x) - 2, 2) + k for k in range(3)], axis=1)
    along = np.einsum("q,qa,eai->eqi", weight, slope, x[edges]).reshape(-1, 2)
    place = np.repeat(np.arange(len(along)), 3)
    values = np.broadcast_to(shape, (len(edges), *shape.shape)).ravel()
    seen = lambda numbers, size: csr_matrix(  # noqa: E731
        (values, (place, np.repeat(numbers[edges][:, None], len(at), axis=1).ravel())), (len(along), size)
    )
    liquid = seen(wet, count)
    across = seen(2 * wall, directions).T @ diags(along[:, 1]) @ liquid
    return (across - seen(2 * wall + 1, directions).T @ diags(along[:, 0]) @ liquid).tocsr()
