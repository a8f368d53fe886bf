"""The tank's wall under a load on its top, in equilibrium, by our elements; felupe's answer: `felupe_tank`."""

from functools import partial
from typing import NamedTuple

import jax
import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import spsolve

import jaxbuffer as jb
from jaxbuffer.mechanisms.tank_drop.assembly import assembled
from jaxbuffer.structures import Plane, at_faces

ROUNDS = 20  # of Newton's method
SHARES = (0.5, 1.0)  # of the load, one after the other
LIMIT = 1e-7  # of the load: what may be left unbalanced
BED = 1e7  # Pa/m: of the springs on which the bottom stands, in its middle


class Bent(NamedTuple):
    """What a program finds.

    - ``deflection``: of the middle of the top downwards [m]; ``bulge``: of the middle of the side outwards [m].
    - ``stress``: largest after von Mises on either face [Pa].
    """

    deflection: float
    bulge: float
    stress: float


def mises(stress):
    """The equivalent stress after von Mises [Pa] of (…, 3, 3)."""
    deviator = stress - np.trace(stress, axis1=-2, axis2=-1)[..., None, None] / 3.0 * np.eye(3)
    return np.sqrt(1.5 * np.sum(deviator**2, axis=(-2, -1)))


def empty_tank(fine):
    """An elastic tank without contents, its mesh ``fine`` times as fine as the coarsest."""
    return jb.replace(jb.TankDrop(), {"contents.kind": "none", "material.yield_stress": 1e12, "mesh.refinement": fine})


def bent(design, loads):
    """Half a section under each of the ``loads`` [N/m²] downwards in the middle of the top, cos² over it; the bottom
    stands on springs, as stiff as `BED` in its middle, cos² over it."""
    parts = assembled(design, jb.TankDropScenario())
    wall, section = parts.wall, parts.section
    x = np.asarray(parts.system.positions)
    held = np.zeros(x.shape, bool)
    held[parts.slider :] = True
    held[[*range(section.numbers.inner[1]), *range(section.numbers.inner[-1], parts.slider)], 0] = True
    free = np.flatnonzero(~held.ravel())
    start = wall.start()
    resist, stiffness = jax.jit(lambda u: wall.resist(u, start)), jax.jit(partial(Plane.stiffness, wall))
    corners = (2 * wall.quads.incidence.corners[:, :, None] + np.arange(2)).reshape(-1, 8)
    at = [places.ravel() for places in np.broadcast_arrays(corners[:, :, None], corners[:, None])]
    edge = 0.5 * float(design.tank.width) - float(design.tank.corner_radius)
    high = x[section.numbers.outer, 1] > 0.5 * float(design.tank.height)
    bed = BED * strips(x, section.numbers.outer[~high & (x[section.numbers.outer, 0] <= edge)], edge)
    pushed = -strips(x, section.numbers.outer[high & (x[section.numbers.outer, 0] <= edge)], edge)

    def forces(moved):
        return np.asarray(resist(moved).forces) + bed * moved

    def tangent(moved):
        size = (moved.size, moved.size)
        return coo_matrix((np.asarray(stiffness(moved)).ravel(), at), size).tocsr() + diags(bed.ravel())

    found = []
    for load in loads:
        moved = balanced(forces, tangent, free, load * pushed)
        found.append(seen(design, section, x, moved, np.asarray(at_faces(resist(moved).stress))))
    return found


def strips(x, nodes, edge):
    """(nodes, 2) areas that belong to ``nodes`` along a face [m²], in y, times cos² that falls to 0 at the ``edge``."""
    width = np.zeros(x.shape)
    half = 0.5 * np.abs(np.diff(x[nodes, 0]))
    width[nodes[:-1], 1] += half
    width[nodes[1:], 1] += half
    return width * np.cos(0.5 * np.pi * x[:, :1] / edge) ** 2


def balanced(forces, tangent, free, pushed):
    """Displacements (nodes, 2) under which the ``free`` directions are in equilibrium, by Newton's method."""
    moved = np.zeros(pushed.shape)
    for share in SHARES:
        for _ in range(ROUNDS):
            left = (forces(moved) - share * pushed).ravel()[free]
            if np.abs(left).max() < LIMIT * np.abs(pushed).max():
                break
            moved.ravel()[free] -= spsolve(tangent(moved)[free][:, free], left)
        else:
            raise AssertionError("Newton's method did not settle")
    return moved


def seen(design, section, x, moved, stress):
    """What is compared. ``stress``: on the faces (elements, 4, 4)."""
    s11, s22, s12, s33 = np.moveaxis(stress, -1, 0)
    zero = np.zeros(s11.shape)
    rows = [[s11, s12, zero], [s12, s22, zero], [zero, zero, s33]]
    tensor = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    middle = 0.5 * (x[section.numbers.inner] + x[section.numbers.outer])
    sideways = 0.5 * (moved[section.numbers.inner, 0] + moved[section.numbers.outer, 0])
    side = slice(section.numbers.flat + 1, section.numbers.level)
    bulge = np.interp(0.5 * float(design.tank.height), middle[side, 1], sideways[side])
    return Bent(-float(moved[section.numbers.outer[-1], 1]), float(bulge), float(mises(tensor).max()))
