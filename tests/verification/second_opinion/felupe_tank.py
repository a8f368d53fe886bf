"""The tank's wall in felupe, under a load on its top: its own mesh of nine-node elements, neo-Hookean, plane strain."""

from typing import NamedTuple

import felupe as fem
import numpy as np
from scipy.sparse import diags

from .bent_tank import BED, Bent, balanced, mises

BEFORE, UPRIGHT = 7, 14  # elements from the middle of the bottom to a plate, and along it, times those across the wall


class Section(NamedTuple):
    """Half of the section in nine-node elements.

    - ``mesh``: felupe's; ``node``: (columns, across) the wall's points from the inside out, column by column.
    - ``ends``: columns where flat bottom, lower corner, wetted side, side and upper corner end.
    """

    mesh: fem.Mesh
    node: np.ndarray
    ends: list[int]


def outline(design, fine, level):
    """Positions (columns, 2) and outward normals of the outside, two columns an element, and the columns where its
    parts end. There is a column on each face of a plate and at the ``level`` [m]."""
    width, height, radius = (float(getattr(design.tank, name)) for name in ("width", "height", "corner_radius"))
    flat, quarter = 0.5 * width - radius, 0.5 * np.pi
    across = [(flat, 12)]
    if design.plates.kind != "none":
        at, half = float(design.plates.position), 0.5 * float(design.plates.thickness)
        across = [(at - half, BEFORE), (at + half, 1), (flat, 12 - BEFORE)]
    below = 5 if level is None else round(10.0 * (level - radius) / (height - 2.0 * radius))
    middle = 0.5 * height if level is None else level

    def spread(start, parts):
        pieces = [np.zeros(1) + start]
        for end, count in parts:
            pieces.append(np.linspace(pieces[-1][-1], end, 2 * fine * count + 1)[1:])
        return np.concatenate(pieces)

    bottom, arc = spread(0.0, across), spread(0.0, [(quarter, 5)])[1:]
    side = spread(radius, [(middle, below), (height - radius, 10 - below)])[1:]
    x = [bottom, flat + radius * np.sin(arc), np.full(len(side), flat + radius)]
    x += [flat + radius * np.cos(arc), bottom[-2::-1]]
    y = [0.0 * bottom, radius * (1.0 - np.cos(arc)), side, height - radius * (1.0 - np.sin(arc))]
    y += [np.full(len(bottom) - 1, height)]
    turned = [0.0 * bottom, arc, np.full(len(side), quarter), quarter + arc, np.full(len(bottom) - 1, np.pi)]
    x, y, turned = map(np.concatenate, (x, y, turned))
    ends = np.cumsum([len(bottom) - 1, len(arc), 2 * fine * below, len(side) - 2 * fine * below, len(arc)])
    return np.stack([x, y], axis=1), np.stack([np.sin(turned), -np.cos(turned)], axis=1), ends.tolist()


def cells_of(node):
    """(elements, 9) points of the elements of a grid of points, counter-clockwise."""
    near, far, middle = slice(0, -1, 2), slice(2, None, 2), slice(1, None, 2)
    along = [near, near, far, far, near, middle, far, middle, middle]  # corners, sides, middle
    across = [near, far, far, near, middle, far, middle, near, middle]
    return np.stack([node[i, j] for i, j in zip(along, across, strict=True)], axis=-1).reshape(-1, 9)


def section_of(design, fine, level=None):
    """A mesh of nine-node elements, ``fine`` of them across wall and plate."""
    face, normal, ends = outline(design, fine, level)
    inward = float(design.wall.bottom) * np.linspace(1.0, 0.0, 2 * fine + 1)
    points = (face[:, None] - inward[None, :, None] * normal[:, None]).reshape(-1, 2)
    node = np.arange(len(points)).reshape(len(face), -1)
    cells = [cells_of(node)]
    if design.plates.kind != "none":
        foot = slice(2 * fine * BEFORE, 2 * fine * (BEFORE + 1) + 1)
        lower, upper = node[foot, 0], node[::-1][foot, 0]
        share = np.linspace(0.0, 1.0, 2 * fine * UPRIGHT + 1)[1:-1, None, None]
        between = ((1.0 - share) * points[lower] + share * points[upper]).reshape(-1, 2)
        plate = len(points) + np.arange(len(between)).reshape(-1, 2 * fine + 1)
        points, cells = np.concatenate([points, between]), [*cells, cells_of(np.vstack([lower, plate, upper]))]
    return Section(fem.Mesh(points, np.concatenate(cells), "quad9"), node, ends)


def yielding(young, poisson, yield_stress, hardening):
    """A material of von Mises with isotropic hardening, for small strains."""
    shear = 0.5 * young / (1.0 + poisson)
    numbers = {"λ": 2.0 * shear * poisson / (1.0 - 2.0 * poisson), "μ": shear, "σy": yield_stress, "K": hardening}
    return fem.MaterialStrain(fem.linear_elastic_plastic_isotropic_hardening, statevars=(1, (3, 3)), **numbers)


def plastic_work(body, yield_stress, hardening):
    """Taken so far by the flow of a body of such a material [J per m]."""
    flowed = body.results.statevars[0]
    return float(np.sum((yield_stress + 0.5 * hardening * flowed) * flowed * body.field.region.dV))


def bent(design, load, fine):
    """As `bent_tank.bent` of one load, with ``fine`` elements across the wall."""
    material, (mesh, node, ends) = design.material, section_of(design, fine)
    field = fem.FieldContainer([fem.FieldPlaneStrain(fem.RegionBiQuadraticQuad(mesh), dim=2)])
    hooke = fem.LinearElasticLargeStrain(E=float(material.young_modulus), nu=float(material.poisson_ratio))
    body = fem.SolidBody(hooke, field)
    held = np.zeros(mesh.points.shape, bool)
    held[node[[0, -1]].ravel(), 0] = True
    bed = BED * strips(mesh.points, node[: ends[0] + 1, -1])
    pushed = -strips(mesh.points, node[ends[4] :, -1][::-1])

    def forces(moved):
        field[0].values[:] = moved
        return body.assemble.vector(field).toarray().reshape(moved.shape) + bed * moved

    def tangent(moved):
        field[0].values[:] = moved
        return body.assemble.matrix(field).tocsr() + diags(bed.ravel())

    moved = balanced(forces, tangent, np.flatnonzero(~held.ravel()), load * pushed)
    field[0].values[:] = moved
    side = node[ends[2]]
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
