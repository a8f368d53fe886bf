"""The `exact_model` with a probe that bends and play in the hinge, from Lagrange's equations.

The probe's frame lies at its rear end (the program's at the centre of mass), its rod is 40 Gauss points with mass, its
shapes are ξ², ξ³ and the closed-form modes of a beam clamped at both ends (the program's come from finite elements).
The welded tip only.
"""

import numpy as np
from scipy.optimize import brentq

from .exact_model import B, ExactModel, S, cross, e, n

GAUSS = 40


def clamped(k, xi, derivative):
    """The k-th mode of a beam clamped at both ends, or a derivative of it by ξ, from its textbook form."""
    beta = brentq(lambda b: np.cos(b) - 1 / np.cosh(b), np.pi * (k + 0.5) - 0.3, np.pi * (k + 0.5) + 0.3, xtol=1e-15)
    sigma = (np.cosh(beta) - np.cos(beta)) / (np.sinh(beta) - np.sin(beta))
    c, s, ch, sh = np.cos(beta * xi), np.sin(beta * xi), np.cosh(beta * xi), np.sinh(beta * xi)
    forms = [
        ch - c - sigma * (sh - s),
        sh + s - sigma * (ch - c),
        ch + c - sigma * (sh + s),
    ]
    return beta**derivative * forms[derivative]


def shapes(count, xi, derivative):
    """(points, count): ξ², ξ³, then modes clamped at both ends."""
    xi = np.atleast_1d(xi)
    powers = [[xi**2, xi**3], [2.0 * xi, 3.0 * xi**2], [2.0 * np.ones_like(xi), 6.0 * xi]][derivative]
    return np.stack([*powers, *(clamped(k, xi, derivative) for k in range(1, count - 1))], axis=1)


class BendingModel(ExactModel):
    """State [q, v]: q of S, B, the probe's rear end and angle, T, then the shapes' amplitudes [m]."""

    def __init__(self, design, scenario):
        super().__init__(design, scenario)
        probe, hinge = design.probe, design.hinge
        assert not probe.free_tip
        self.rear, self.front = 0.0, probe.length
        self.modes = 0 if probe.bending_stiffness is None else probe.bending_modes
        self.size = 12 + self.modes
        self.mine = [6, 7, 8, *range(12, self.size)]  # the probe's coordinates
        points, weights = np.polynomial.legendre.leggauss(GAUSS)
        xi, weights = 0.5 * (points + 1), 0.5 * weights
        count = max(self.modes, 2)
        keep = slice(0, self.modes)
        self.along = np.append(xi, 1.0) * probe.length
        self.mass = np.append(weights * probe.rod_mass, probe.tip_mass)
        self.phi = np.concatenate([shapes(count, xi, 0), shapes(count, 1.0, 0)])[:, keep]
        self.slope = shapes(count, 1.0, 1)[0, keep] / probe.length
        curvature = shapes(count, xi, 2)[:, keep]
        self.bending = (curvature.T * weights) @ curvature * ((probe.bending_stiffness or 0.0) / probe.length**3)
        self.play = hinge.play
        if self.play is not None:
            pin = hinge.bush_radius - hinge.play
            modulus = hinge.young_modulus / (2 * (1 - hinge.poisson_ratio**2))
            self.socket = 4 / 3 * modulus * np.sqrt(pin * hinge.bush_radius / hinge.play)

    def frequencies(self):
        """Of the probe clamped at its rear end [Hz]."""
        mass = (self.phi.T * self.mass) @ self.phi + self.tip_inertia * np.outer(self.slope, self.slope)
        return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, self.bending)).real)) / (2 * np.pi)

    def jacobian(self, q, points=slice(None)):
        """Of the places of the rod's points by x, y, θ and the shapes; how far they are bent away."""
        along, across, w = e(q[8]), n(q[8]), self.phi[points] @ q[12:]
        jacobian = np.zeros((len(w), 2, 3 + self.modes))
        jacobian[:, :, :2] = np.eye(2)
        jacobian[:, :, 2] = np.outer(self.along[points], across) - np.outer(w, along)
        jacobian[:, :, 3:] = across[None, :, None] * self.phi[points][:, None, :]
        return jacobian, w

    def turning(self):
        """The tip's angle by x, y, θ and the shapes."""
        return np.concatenate([[0, 0, 1], self.slope])

    def tip(self, q, v):
        jacobian, (w,) = self.jacobian(q, slice(-1, None))
        rates = np.concatenate([v[6:9], v[12:]])
        return q[6:8] + self.along[-1] * e(q[8]) + w * n(q[8]), jacobian[0] @ rates, self.turning() @ rates

    def own(self, q, v):
        """Also the forces of squared velocities, of the bending and of a pin in its bush."""
        along, across, eta, rates, spin = e(q[8]), n(q[8]), q[12:], v[12:], v[8]
        jacobian, w = self.jacobian(q)
        moves = self.phi @ rates
        bias = -(spin**2) * (np.outer(self.along, along) + np.outer(w, across)) - 2 * spin * np.outer(moves, along)
        rod = np.einsum("p,pai,paj->ij", self.mass, jacobian, jacobian)
        rod += self.tip_inertia * np.outer(self.turning(), self.turning())
        bent = -np.einsum("p,pai,pa->i", self.mass, jacobian, bias)
        bent[3:] -= self.bending @ (eta + self.design.probe.bending_damping * rates)
        matrix, force = np.diag(np.concatenate([self.masses, np.zeros(self.modes)])), np.zeros(self.size)
        matrix[np.ix_(self.mine, self.mine)] = rod
        force[self.mine] = bent
        if self.play is not None:
            _, _, size, out = self.pin(q, v)
            push = -size * out
            force[S] += [*push, cross(self.design.active.hinge_offset * e(q[2]), push)]
            force[B] -= [*push, cross(self.design.buffer.cylinder_length / 2 * e(q[5]), push)]
        return matrix, force

    def carry(self, force, q, push, moment):
        force[self.mine] += self.jacobian(q, slice(-1, None))[0][0].T @ push + self.turning() * moment

    def pin(self, q, v):
        """Depth of the pin in its bush, its rate, force, and unit vector from bush to pin."""
        a, half = self.design.active.hinge_offset, self.design.buffer.cylinder_length / 2
        off = q[S][:2] + a * e(q[2]) - q[B][:2] - half * e(q[5])
        move = v[S][:2] + a * v[2] * n(q[2]) - v[B][:2] - half * v[5] * n(q[5])
        far = np.hypot(*off)
        out = off / far if far > 0 else np.array([1.0, 0.0])
        depth, rate = far - self.play, move @ out
        force = self.socket * max(depth, 0.0) ** 1.5 * max(0.0, 1 + self.design.hinge.damping * rate)
        return depth, rate, force, out

    def constraints(self, q, v):
        """A hinge with play holds nothing."""
        held = slice(None) if self.play is None else slice(2, None)
        return tuple(part[held] for part in super().constraints(q, v))

    def depths(self, y):
        """Also of the pin, where there is play."""
        pin = [] if self.play is None else [self.pin(y[: self.size], y[self.size :])[0]]
        return super().depths(y) + pin

    def impacts(self, until, rtol=1e-10, max_step=5e-5):
        """Largest contact force and largest hinge force (m_S a_S) [N] up to a time [s]."""
        lower, upper, hinge, *_ = self.maxima(until, rtol, max_step)[0]
        return max(lower, upper), hinge
