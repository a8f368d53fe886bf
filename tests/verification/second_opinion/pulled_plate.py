"""A quarter of a plate with a round hole that is pulled until it yields around the hole, pushed back and beyond: our
elements against felupe's material of von Mises with isotropic hardening. Plane strain, strains so small that neither's
measure of them counts."""

from typing import NamedTuple

import felupe as fem
import jax
import jax.numpy as jnp
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import spsolve

from jaxbuffer.structures import Plane, Plastic, Quads

from .felupe_tank import cells_of, plastic_work, yielding

HOLE, SIDE = 0.1, 0.3  # m: radius, and half of the plate
YOUNG, POISSON, YIELD, HARDENING = 1e9, 0.4, 1e5, 5e7
PULLED = 6e-5 * np.concatenate([np.linspace(0.0, 1.0, 7)[1:], np.linspace(1.0, -1.0, 11)[1:]])  # m, of the upper side
LIMIT = 1e-7  # of the largest force: what may be left unbalanced
ROUNDS = 30  # of Newton's method


class Pulled(NamedTuple):
    """What a program finds.

    - ``force``: (steps,) with which the upper side is pulled [N]; ``narrowed``: (steps,) by which the side's middle has
      come in [m].
    - ``work``: of plastic flow until the end [J].
    """

    force: np.ndarray
    narrowed: np.ndarray
    work: float


def points_of(around, out):
    """(around + 1, out + 1, 2) from the hole outwards, by rays."""
    angle = np.linspace(0.0, 0.5 * np.pi, around + 1)[:, None]
    share = np.linspace(0.0, 1.0, out + 1)[None] ** 1.5
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    edge = SIDE / np.maximum(np.cos(angle), np.sin(angle))[..., None]
    return ray * (HOLE + share[..., None] * (edge - HOLE))


def sides(points):
    """Directions that are held; the upper side's nodes; the node in the middle of the outer side."""
    x, y = points.T
    held = np.stack([np.isclose(x, 0.0), np.isclose(y, 0.0) | np.isclose(y, SIDE)], axis=1)
    return np.flatnonzero(~held.ravel()), np.flatnonzero(np.isclose(y, SIDE)), int(np.argmin(np.abs(x - SIDE) + y))


def pulled(fine, hardening=HARDENING):
    """By our elements, ``fine`` of them from the hole outwards."""
    points = points_of(fine, fine)
    node = np.arange((fine + 1) ** 2).reshape(fine + 1, -1)
    corners = np.stack([node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]], axis=-1).reshape(-1, 4)
    points = points.reshape(-1, 2)
    wall = Plane(Quads.of(jnp.asarray(points), corners), Plastic(1.0, YOUNG, POISSON, YIELD, hardening, 1e9))
    free, upper, middle = sides(points)

    i, j, k = np.indices((fine + 1, fine + 1, 2)).reshape(3, -1)  # of each direction
    colour = 6 * (i % 3) + 2 * (j % 3) + k  # two directions of one colour share no element
    near = (np.abs(i[:, None] - i) <= 1) & (np.abs(j[:, None] - j) <= 1)
    row, column = np.nonzero(near)

    @jax.jit
    def both(moved, history):
        seeds = jnp.asarray(colour == np.arange(18)[:, None], float).reshape(18, *moved.shape)
        slope = lambda seed: jax.jvp(lambda u: wall.resist(u, history).forces, (moved,), (seed,))[1].ravel()  # noqa: E731
        return wall.resist(moved, history), jax.vmap(slope)(seeds)

    history, moved, seen = wall.start(), np.zeros(points.shape), []
    _, elastic = both(jnp.asarray(moved), history)
    for pull in PULLED:
        moved[upper, 1] = pull
        for turn in range(ROUNDS):
            found, slopes = both(jnp.asarray(moved), history)
            slopes = slopes if turn else elastic  # all that yielded may turn back
            left = np.asarray(found.forces).ravel()
            if np.abs(left[free]).max() < LIMIT * np.abs(left).max():
                break
            matrix = csr_matrix((np.asarray(slopes)[colour[column], row], (row, column)))
            moved.ravel()[free] -= spsolve(matrix[free][:, free], left[free])
        else:
            raise AssertionError("Newton's method did not settle")
        history = found.history
        seen.append((float(found.forces[upper, 1].sum()), -moved[middle, 0]))
    force, narrowed = np.array(seen).T
    return Pulled(force, narrowed, float(found.plastic))


def pulled_by_felupe(fine):
    """By nine-node elements of felupe, ``fine`` of them from the hole outwards."""
    grid = points_of(2 * fine, 2 * fine)
    points, node = grid.reshape(-1, 2), np.arange(grid.shape[0] * grid.shape[1]).reshape(grid.shape[:2])
    mesh = fem.Mesh(points, cells_of(node), "quad9")
    field = fem.FieldContainer([fem.FieldPlaneStrain(fem.RegionBiQuadraticQuad(mesh), dim=2)])
    body = fem.SolidBody(yielding(YOUNG, POISSON, YIELD, HARDENING), field)
    with np.errstate(divide="ignore", invalid="ignore"):  # of felupe's return where no stress is
        force, narrowed = np.array(_followed(body, field, *sides(points))).T
    return Pulled(force, narrowed, plastic_work(body, YIELD, HARDENING))


def _followed(body, field, free, upper, middle):
    """(steps, 2) force and narrowing of felupe's plate."""
    values, seen = field[0].values, []
    for pull in PULLED:
        values[upper, 1] = pull
        for _ in range(ROUNDS):
            forces = body.assemble.vector(field).toarray().ravel()
            if np.abs(forces[free]).max() < LIMIT * np.abs(forces).max():
                break
            matrix = body.assemble.matrix(field).tocsr()[free][:, free]
            values.ravel()[free] -= spsolve(matrix, forces[free])
        else:
            raise AssertionError("Newton's method did not settle")
        body.results.update_statevars()
        seen.append((forces.reshape(-1, 2)[upper, 1].sum(), -values[middle, 0]))
    return seen


def deviations(found, reference):
    """Of each figure, the furthest over the reference's largest [-]."""
    apart = (np.max(np.abs(a - b)) / np.max(np.abs(b)) for a, b in zip(found, reference, strict=True))
    return Pulled(*map(float, apart))
