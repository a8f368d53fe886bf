"""The tank's wall in felupe, under a load on its top: its own mesh of nine-node elements, neo-Hookean, plane strain."""

import felupe as fem
import numpy as np
from scipy.sparse import diags

from .bent_tank import BED, Bent, balanced, mises


def outline(tank, fine):
    """Positions (columns, 2) and outward normals of the outside, two columns an element, and columns of its parts."""
    width, height, radius = float(tank.width), float(tank.height), float(tank.corner_radius)
    flat, side = 0.5 * width - radius, height - 2.0 * radius
    counts = [2 * fine * n for n in (12, 5, 10, 5, 12)]
    x, y, turned = [np.zeros(1)], [np.zeros(1)], [np.zeros(1)]
    share = [np.linspace(0.0, 1.0, n + 1)[1:] for n in counts]
    quarter = 0.5 * np.pi
    x += [flat * share[0], flat + radius * np.sin(quarter * share[1]), np.full(counts[2], flat + radius)]
    y += [np.zeros(counts[0]), radius * (1.0 - np.cos(quarter * share[1])), radius + side * share[2]]
    turned += [np.zeros(counts[0]), quarter * share[1], np.full(counts[2], quarter)]
    x += [flat + radius * np.cos(quarter * share[3]), flat * (1.0 - share[4])]
    y += [height - radius * (1.0 - np.sin(quarter * share[3])), np.full(counts[4], height)]
    turned += [quarter * (1.0 + share[3]), np.full(counts[4], np.pi)]
    turned = np.concatenate(turned)
    face = np.stack([np.concatenate(x), np.concatenate(y)], axis=1)
    return face, np.stack([np.sin(turned), -np.cos(turned)], axis=1), counts


def mesh_of(tank, thickness, fine):
    """A mesh of nine-node elements, ``fine`` of them across; its points, column by column, and columns a part."""
    face, normal, counts = outline(tank, fine)
    inward = thickness * np.linspace(1.0, 0.0, 2 * fine + 1)
    points = face[:, None] - inward[None, :, None] * normal[:, None]
    node = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    near, far, middle = slice(0, -1, 2), slice(2, None, 2), slice(1, None, 2)
    along = [near, near, far, far, near, middle, far, middle, middle]  # corners, sides, middle
    across = [near, far, far, near, middle, far, middle, near, middle]
    cells = np.stack([node[i, j] for i, j in zip(along, across, strict=True)], axis=-1).reshape(-1, 9)
    return fem.Mesh(points.reshape(-1, 2), cells, "quad9"), node, counts


def bent(design, load, fine):
    """As `bent_tank.bent` of one load, with ``fine`` elements across the wall."""
    tank, thickness, material = design.tank, float(design.wall.bottom), design.material
    mesh, node, counts = mesh_of(tank, thickness, fine)
    field = fem.FieldContainer([fem.FieldPlaneStrain(fem.RegionBiQuadraticQuad(mesh), dim=2)])
    hooke = fem.LinearElasticLargeStrain(E=float(material.young_modulus), nu=float(material.poisson_ratio))
    body = fem.SolidBody(hooke, field)
    held = np.zeros(mesh.points.shape, bool)
    held[node[[0, -1]].ravel(), 0] = True
    bed = BED * strips(mesh.points, node[: counts[0] + 1, -1])
    pushed = -strips(mesh.points, node[-counts[4] - 1 :, -1][::-1])

    def forces(moved):
        field[0].values[:] = moved
        return body.assemble.vector(field).toarray().reshape(moved.shape) + bed * moved

    def tangent(moved):
        field[0].values[:] = moved
        return body.assemble.matrix(field).tocsr() + diags(bed.ravel())

    moved = balanced(forces, tangent, np.flatnonzero(~held.ravel()), load * pushed)
    field[0].values[:] = moved
    side = node[counts[0] + counts[1] + counts[2] // 2]
    stress = fem.tools.extrapolate(body.evaluate.cauchy_stress(field), field.region).reshape(-1, 3, 3)
    return Bent(-float(moved[node[-1, -1], 1]), float(moved[side, 0].mean()), float(mises(stress).max()))


def strips(points, line):
    """As `bent_tank.strips`, by Simpson's rule along a ``line`` of points that starts in the middle."""
    x = points[line, 0]
    width = np.zeros(points.shape)
    for k in range(0, len(line) - 1, 2):
        width[line[k : k + 3], 1] += (x[k + 2] - x[k]) / 6.0 * np.array([1.0, 4.0, 1.0])
    width[line, 1] *= np.cos(0.5 * np.pi * x / x[-1]) ** 2
    return width
