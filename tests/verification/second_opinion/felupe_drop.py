"""The drop onto the empty tank in felupe: its elements and their full masses, cushion and bed at Gauss points, and the
generalised-α method in time."""

from typing import NamedTuple

import felupe as fem
import numpy as np
from scipy.sparse import block_diag, csr_matrix, diags
from scipy.sparse.linalg import splu

from .dropped_tank import Dropped
from .felupe_tank import mesh_of

RADIUS = 0.9  # spectral, of steps that are much too long: 1 damps nothing
ROUNDS = 25  # of Newton's method in a step
SETTLED = 10  # rounds after which the pressed points stay as they are
LIMIT = 1e-8  # of the displacements so far: the last round's change
SOLID, HARDER = 0.8, 10.0  # the cushion is solid from that part of its thickness on; its stiffness is then so much more


class Strip(NamedTuple):
    """Gauss points along the outside that something presses on.

    - ``see``: (points, directions) matrix from displacements to depths; ``offset``: depths undeformed [m].
    - ``width``: of each point [m]; ``stiffness``, ``solid`` [Pa/m], ``damping`` [Pa s/m], ``hard``: depth from which on
      it is solid [m].
    """

    see: csr_matrix
    offset: np.ndarray
    width: np.ndarray
    stiffness: float
    damping: float = 0.0
    solid: float = 0.0
    hard: float = np.inf

    def pressure(self, moved, velocity, met=None):
        """(points,) pressures, their rise over depth and over its rate, and the points that are met."""
        depth, rate = self.see @ moved + self.offset, self.see @ velocity
        met = depth > 0.0 if met is None else met
        full = self.stiffness * depth + self.solid * np.maximum(depth - self.hard, 0.0) + self.damping * rate
        pressed = met & (full > 0.0)
        return (
            full * pressed,
            (self.stiffness + self.solid * (depth > self.hard)) * pressed,
            self.damping * pressed,
            met,
        )

    def force(self, pressure):
        """(directions,) against the displacements."""
        return self.see.T @ (self.width * pressure)

    def rise(self, slope):
        """(directions, directions) of the force with what has this ``slope``."""
        return self.see.T @ diags(self.width * slope) @ self.see


def seen_at(points, edges, size, slider=None):
    """Gauss points on ``edges`` (first, middle, last): the matrix of upward displacements there, less those of the
    ``slider``; heights [m]; how far an edge goes at each point in x and y [m]."""
    at, weight = np.polynomial.legendre.leggauss(4)
    shape = np.stack([0.5 * at * (at - 1.0), 1.0 - at**2, 0.5 * at * (at + 1.0)], axis=1)
    slope = np.stack([at - 0.5, -2.0 * at, at + 0.5], axis=1)
    place = np.einsum("qa,eai->eqi", shape, points[edges]).reshape(-1, 2)
    along = np.einsum("q,qa,eai->eqi", weight, slope, points[edges]).reshape(-1, 2)
    rows = np.repeat(np.arange(len(place)), 3)
    columns = np.repeat(2 * edges[:, None] + 1, len(at), axis=1).ravel()
    values = np.broadcast_to(shape, (len(edges), *shape.shape)).ravel()
    see = csr_matrix((values, (rows, columns)), (len(place), size))
    if slider is not None:
        see = see - csr_matrix((np.ones(len(place)), (np.arange(len(place)), np.full(len(place), slider))), see.shape)
    return see, place[:, 1], along


class Tank:
    """Half a section, a metre long, and the slider as the last direction."""

    def __init__(self, design, scenario, fine):
        tank, material, thickness = design.tank, design.material, float(design.wall.bottom)
        mesh, node, counts = mesh_of(tank, thickness, fine)
        self.field = fem.FieldContainer([fem.FieldPlaneStrain(fem.RegionBiQuadraticQuad(mesh), dim=2)])
        hooke = fem.LinearElasticLargeStrain(E=float(material.young_modulus), nu=float(material.poisson_ratio))
        self.body = fem.SolidBody(hooke, self.field, density=float(material.density))
        self.shape, size = mesh.points.shape, mesh.points.size + 1
        wall = self.body.assemble.mass().tocsr()
        self.mass = block_diag([wall, [[float(design.slider.mass) / (2.0 * float(tank.length))]]]).tocsr()
        down = np.zeros(size)
        down[1::2] = down[-1] = -float(scenario.gravity)
        self.weight = self.mass @ down
        held = np.zeros(size, bool)
        held[2 * node[[0, -1]].ravel()] = True
        self.free = np.flatnonzero(~held)
        self.top = 2 * node[-1, -1] + 1
        edges = np.stack([node[:-2:2, -1], node[1::2, -1], node[2::2, -1]], axis=1)
        self.cushion = self._cushion(design, scenario, mesh.points, edges, size)
        self.bed = self._bed(design, mesh.points, edges[: sum(counts[:2]) // 2], size)

    def _cushion(self, design, scenario, points, edges, size):
        """Over what is higher than the level; only what goes sideways has a width."""
        height, soft = float(design.tank.height), design.cushion
        see, above, along = seen_at(points, edges, size, slider=size - 1)
        bottom, top = float(design.wall.bottom), float(design.wall.top)
        level = bottom + float(scenario.fill) * (height - bottom - top)
        width = np.where(above >= level, np.abs(along[:, 0]), 0.0)
        stiffness, damping, thickness = float(soft.stiffness), float(soft.damping), float(soft.thickness)
        return Strip(see, above - height, width, stiffness, damping, HARDER * stiffness, SOLID * thickness)

    def _bed(self, design, points, edges, size):
        """Under the bottom and the lower corner, along the outside."""
        see, above, along = seen_at(points, edges, size)
        return Strip(-see, -above, np.hypot(*along.T), float(design.support.stiffness))

    def resist(self, moved, velocity, met=(None, None)):
        """Forces against displacements and velocities; how they rise with each; the points that are met."""
        self.field[0].values[:] = moved[:-1].reshape(self.shape)
        force = np.append(self.body.assemble.vector(self.field).toarray().ravel(), 0.0)
        stiffness = block_diag([self.body.assemble.matrix(self.field), [[0.0]]]).tocsr()
        damping, touched = csr_matrix(stiffness.shape), []
        for strip, known in zip((self.cushion, self.bed), met, strict=True):
            pressure, over_depth, over_rate, points = strip.pressure(moved, velocity, known)
            force = force + strip.force(pressure)
            stiffness, damping = stiffness + strip.rise(over_depth), damping + strip.rise(over_rate)
            touched.append(points)
        return force, stiffness, damping, touched

    def change(self, matrix, left):
        """What takes away what is ``left`` unbalanced, for the free directions."""
        inside = matrix[self.free][:, self.free].tocsc()
        moves = np.zeros(len(left))
        moves[self.free] = splu(inside, "NATURAL", diag_pivot_thresh=0.0).solve(left[self.free])
        return moves

    def at_rest(self):
        """Displacements in equilibrium with gravity on the bed; the slider stays where the undeformed top would be."""
        moved, still = np.zeros(len(self.weight)), np.zeros(len(self.weight))
        moved[1:-1:2] = self.weight[1:-1:2].sum() / (self.bed.stiffness * self.bed.width.sum())
        held = diags(np.append(np.zeros(len(moved) - 1), 1.0))
        for _ in range(10 * ROUNDS):
            force, stiffness, _, _ = self.resist(moved, still)
            left = self.weight - force
            left[-1] = 0.0
            moves = self.change(stiffness + held, left)
            moved = moved + moves
            if np.abs(moves).max() < 1e-10 * np.abs(moved).max():
                return moved
        raise AssertionError("no equilibrium on the bed was found")


def dropped(design, scenario, duration, fine, steps):
    """What felupe finds, with ``fine`` elements across the wall and as many ``steps``."""
    tank, step = Tank(design, scenario, fine), duration / steps
    moved = tank.at_rest()
    velocity = np.zeros(len(moved))
    velocity[-1] = -np.sqrt(2.0 * float(scenario.gravity) * float(scenario.height))
    force, _, _, _ = tank.resist(moved, velocity)
    acceleration = tank.change(tank.mass, tank.weight - force)
    rows = [_row(tank, moved, velocity)]
    for _ in range(steps):
        moved, velocity, acceleration = _next(tank, step, moved, velocity, acceleration)
        rows.append(_row(tank, moved, velocity))
    force, travel, deflection = np.array(rows).T
    factor = 2.0 * float(design.tank.length)
    impulse = factor * step * (force.sum() - 0.5 * (force[0] + force[-1]))
    return Dropped(factor * force.max(), travel.max(), deflection.max(), impulse, velocity[-1])


def _row(tank, moved, velocity):
    """Force of the cushion, travel of the slider, deflection of the top."""
    pressure, _, _, _ = tank.cushion.pressure(moved, velocity)
    return tank.cushion.width @ pressure, -moved[-1], -moved[tank.top]


def _next(tank, step, moved, velocity, acceleration):
    """The state a step later (Chung and Hulbert)."""
    alpha_m, alpha_f = (2.0 * RADIUS - 1.0) / (RADIUS + 1.0), RADIUS / (RADIUS + 1.0)
    gamma = 0.5 - alpha_m + alpha_f
    beta = 0.25 * (1.0 - alpha_m + alpha_f) ** 2
    fixed = moved + step * velocity + step**2 * (0.5 - beta) * acceleration
    fixed_velocity = velocity + step * (1.0 - gamma) * acceleration
    after = fixed + step**2 * beta * acceleration
    met = (None, None)
    for turn in range(ROUNDS):
        later = (after - fixed) / (step**2 * beta)
        faster = fixed_velocity + step * gamma * later
        between = [alpha_f * old + (1.0 - alpha_f) * new for old, new in ((moved, after), (velocity, faster))]
        force, stiffness, damping, touched = tank.resist(*between, met)
        met = touched if turn == SETTLED else met
        inert = tank.mass @ ((1.0 - alpha_m) * later + alpha_m * acceleration)
        matrix = (1.0 - alpha_m) / (step**2 * beta) * tank.mass
        matrix = matrix + (1.0 - alpha_f) * (stiffness + gamma / (step * beta) * damping)
        moves = tank.change(matrix, tank.weight - inert - force)
        after = after + moves
        if np.abs(moves).max() < LIMIT * np.abs(after).max():
            later = (after - fixed) / (step**2 * beta)
            return after, fixed_velocity + step * gamma * later, later
    raise AssertionError("Newton's method did not settle")
