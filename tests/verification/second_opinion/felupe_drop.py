"""Drops onto the tank in felupe: its elements and their full masses, cushion and bed at Gauss points, a liquid by its
potential, and the generalised-α method in time. A wall that yields does so under small strains."""

from typing import NamedTuple

import felupe as fem
import numpy as np
from scipy.sparse import block_diag, bmat, csr_matrix, diags, hstack, vstack
from scipy.sparse.linalg import splu

from .dropped_tank import CASES, NEVER, Dropped, design_of, summed
from .felupe_liquid import liquid_of
from .felupe_tank import plastic_work, section_of, yielding

RADIUS = 0.9  # spectral, of steps that are much too long: 1 damps nothing
ROUNDS = 25  # of Newton's method in a step
ORDER = "MMD_AT_PLUS_A"  # of the unknowns, for SuperLU
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


def history_at(points, edges, size, slider=None):
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
    """Half a section, a metre long: the wall's directions, the slider, and the liquid's potential."""

    def __init__(self, design, scenario, fine):
        tank, material, wet = design.tank, design.material, design.contents.kind != "none"
        bottom, top = float(design.wall.bottom), float(design.wall.top)
        self.level = bottom + float(scenario.fill) * (float(tank.height) - bottom - top)
        section = section_of(design, fine, self.level if wet else None)
        mesh, node, ends = section
        self.field = fem.FieldContainer([fem.FieldPlaneStrain(fem.RegionBiQuadraticQuad(mesh), dim=2)])
        elastic = float(material.young_modulus), float(material.poisson_ratio)
        self.flow = float(material.yield_stress), float(material.hardening)
        self.yields = self.flow[0] < NEVER
        law = yielding(*elastic, *self.flow) if self.yields else fem.LinearElasticLargeStrain(*elastic)
        self.body = fem.SolidBody(law, self.field, density=float(material.density))
        self.shape, self.slider = mesh.points.shape, mesh.points.size
        self.liquid = liquid_of(design, scenario, section, self.level) if wet else None
        size = self.slider + 1 + (len(self.liquid.free) if wet else 0)
        wall = block_diag([self.body.assemble.mass(), [[float(design.slider.mass) / (2.0 * float(tank.length))]]])
        down = np.zeros(size)
        down[1 : self.slider : 2] = down[self.slider] = -float(scenario.gravity)
        self.mass, self.linear = wall.tocsr(), csr_matrix((size, size))
        self.weight = np.append(wall @ down[: self.slider + 1], np.zeros(size - self.slider - 1))
        if wet:
            self._filled(size)
        held = np.zeros(size, bool)
        held[2 * node[[0, -1]].ravel()] = True
        self.free = np.flatnonzero(~held)
        self.top, self.rest = 2 * node[-1, -1] + 1, np.zeros(size)
        edges = np.stack([node[:-2:2, -1], node[1::2, -1], node[2::2, -1]], axis=1)
        self.cushion = self._cushion(design, mesh.points, edges, size)
        self.bed = self._bed(design, mesh.points, edges[: ends[1] // 2], size)

    def _filled(self, size):
        """The liquid's rows: M_f ψ̈ + K_f ψ - Aᵀ u, and its push on the wall: ρ A ψ̈."""
        liquid, slider = self.liquid, csr_matrix((1, size - self.slider - 1))
        inside = np.ix_(liquid.free, liquid.free)
        join = liquid.join[:, liquid.free]
        self.mass = bmat([
            [self.mass, vstack([liquid.density * join, slider])], [None, liquid.mass[inside]]
        ]).tocsr()  # fmt: skip
        self.linear = bmat([
            [csr_matrix(self.mass.shape)[: self.slider + 1, : self.slider + 1], None],
            [hstack([-join.T, slider.T]), liquid.stiffness[inside]],
        ]).tocsr()  # fmt: skip
        self.weight[: self.slider] += liquid.pushed

    def _cushion(self, design, points, edges, size):
        """Over what is higher than the level; only what goes sideways has a width."""
        height, soft = float(design.tank.height), design.cushion
        see, above, along = history_at(points, edges, size, slider=self.slider)
        width = np.where(above >= self.level, np.abs(along[:, 0]), 0.0)
        stiffness, damping, thickness = float(soft.stiffness), float(soft.damping), float(soft.thickness)
        return Strip(see, above - height, width, stiffness, damping, HARDER * stiffness, SOLID * thickness)

    def _bed(self, design, points, edges, size):
        """Under the bottom and the lower corner, along the outside."""
        see, above, along = history_at(points, edges, size)
        return Strip(-see, -above, np.hypot(*along.T), float(design.support.stiffness))

    def resist(self, moved, velocity, met=(None, None)):
        """Forces against displacements and velocities; how they rise with each; the points that are met."""
        self.field[0].values[:] = moved[: self.slider].reshape(self.shape)
        others = np.zeros(len(moved) - self.slider)
        force = np.append(self.body.assemble.vector(self.field).toarray().ravel(), others)
        force = force + self.linear @ (moved - self.rest)
        elastic = self.body.assemble.matrix(self.field)
        stiffness = block_diag([elastic, csr_matrix((len(others),) * 2)]).tocsr() + self.linear
        damping, touched = csr_matrix(stiffness.shape), []
        for strip, known in zip((self.cushion, self.bed), met, strict=True):
            pressure, over_depth, over_rate, points = strip.pressure(moved, velocity, known)
            force = force + strip.force(pressure)
            stiffness, damping = stiffness + strip.rise(over_depth), damping + strip.rise(over_rate)
            touched.append(points)
        return force, stiffness, damping, touched

    def change(self, matrix, left, free=None):
        """What takes away what is ``left`` unbalanced, for the free directions."""
        free = self.free if free is None else free
        moves = np.zeros(len(left))
        moves[free] = splu(matrix[free][:, free].tocsc(), ORDER, diag_pivot_thresh=0.0).solve(left[free])
        return moves

    def at_rest(self):
        """Displacements in equilibrium with gravity and static pressure on the bed; the slider stays where the
        undeformed top would be, and the liquid still."""
        moved, still = np.zeros(len(self.weight)), np.zeros(len(self.weight))
        wall = self.free[self.free < self.slider]
        moved[1 : self.slider : 2] = self.weight[1 : self.slider : 2].sum() / (
            self.bed.stiffness * self.bed.width.sum()
        )
        for _ in range(10 * ROUNDS):
            force, stiffness, _, _ = self.resist(moved, still)
            moves = self.change(stiffness, self.weight - force, wall)
            moved = moved + moves
            if np.abs(moves).max() < 1e-10 * np.abs(moved).max():
                self.rest = moved
                return moved
        raise AssertionError("no equilibrium on the bed was found")


@np.errstate(divide="ignore", invalid="ignore")  # of felupe's flow where no stress is
def dropped(name, fine, steps):
    """What felupe finds of one of `CASES`, with ``fine`` elements across the wall and as many ``steps``."""
    design, scenario, duration = design_of(name, 1), CASES[name].scenario, CASES[name].duration
    tank, step = Tank(design, scenario, fine), duration / steps
    moved = tank.at_rest()
    velocity = np.zeros(len(moved))
    velocity[tank.slider] = -np.sqrt(2.0 * float(scenario.gravity) * float(scenario.height))
    force, _, _, _ = tank.resist(moved, velocity)
    acceleration = tank.change(tank.mass, tank.weight - force)
    rows = [_row(tank, moved, velocity, acceleration)]
    for _ in range(steps):
        moved, velocity, acceleration = _next(tank, step, moved, velocity, acceleration)
        rows.append(_row(tank, moved, velocity, acceleration))
    force, travel, deflection, pressure, energy = np.array(rows).T
    factor = 2.0 * float(design.tank.length)
    impulse = factor * step * (force.sum() - 0.5 * (force[0] + force[-1]))
    found = factor * force.max(), travel.max(), deflection.max(), impulse, velocity[tank.slider]
    time = np.linspace(0.0, duration, steps + 1)
    work = factor * plastic_work(tank.body, *tank.flow) if tank.yields else 0.0
    return Dropped(*found, factor * (energy.max() - energy[0]), work, time, summed(time, pressure))


def _row(tank, moved, velocity, acceleration):
    """Force of the cushion, travel of the slider, deflection of the top, pressure in the middle of the bottom beyond
    the static one, energy of the liquid with the work of the static pressure."""
    pressure, _, _, _ = tank.cushion.pressure(moved, velocity)
    seen = tank.cushion.width @ pressure, -moved[tank.slider], -moved[tank.top]
    if (liquid := tank.liquid) is None:
        return *seen, 0.0, 0.0
    rate, second = (np.zeros(liquid.mass.shape[0]) for _ in range(2))
    rate[liquid.free], second[liquid.free] = velocity[tank.slider + 1 :], acceleration[tank.slider + 1 :]
    own = liquid.energy(rate, second) - liquid.pushed @ moved[: tank.slider]
    return *seen, -liquid.density * second[liquid.bottom], own


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
            tank.body.results.update_statevars()
            return after, fixed_velocity + step * gamma * later, later
    raise AssertionError("Newton's method did not settle")
