"""The capture with a probe that bends and play in the hinge once more, in NumPy and SciPy, from Lagrange's equations.

The probe's frame lies at its rear end (the program's at the centre of mass), its rod is 40 Gauss points with mass, its
shapes are ξ², ξ³ and the closed-form modes of a beam clamped at both ends (the program's come from finite elements).
The welded tip only. Flanks and joints are those of `exact_model`.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

from .exact_model import B, ExactModel, S, T, cross, e, n

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
        self.modes = 0 if probe.bending_stiffness is None else probe.bending_modes
        self.size = 12 + self.modes
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

    def start(self):
        q, v, speed = super().start()
        q[6:8] -= self.rear * e(q[8])
        return np.append(q, np.zeros(self.modes)), np.append(v, np.zeros(self.modes)), speed

    def frequencies(self):
        """Of the probe clamped at its rear end [Hz]."""
        mass = (self.phi.T * self.mass) @ self.phi + self.tip_inertia * np.outer(self.slope, self.slope)
        return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, self.bending)).real)) / (2 * np.pi)

    def rod(self, q, v):
        """Mass matrix of the probe over (x, y, θ, shapes), forces of squared velocities, and of the points: places,
        velocities, Jacobians."""
        along, across, eta, rates = e(q[8]), n(q[8]), q[12:], v[12:]
        w, moves = self.phi @ eta, self.phi @ rates
        jacobian = np.zeros((len(w), 2, 3 + self.modes))
        jacobian[:, :, :2] = np.eye(2)
        jacobian[:, :, 2] = np.outer(self.along, across) - np.outer(w, along)
        jacobian[:, :, 3:] = across[None, :, None] * self.phi[:, None, :]
        spin = v[8]
        bias = -(spin**2) * (np.outer(self.along, along) + np.outer(w, across)) - 2 * spin * np.outer(moves, along)
        turning = np.concatenate([[0, 0, 1], self.slope])
        matrix = np.einsum("p,pai,paj->ij", self.mass, jacobian, jacobian) + self.tip_inertia * np.outer(
            turning, turning
        )
        force = -np.einsum("p,pai,pa->i", self.mass, jacobian, bias)
        force[3:] -= self.bending @ (eta + self.design.probe.bending_damping * rates)
        own = np.concatenate([v[6:9], rates])
        places = q[6:8] + np.outer(self.along, along) + np.outer(w, across)
        return matrix, force, places[-1], jacobian[-1] @ own, turning, jacobian[-1]

    def flanks(self, q, v, memory, rod=None):
        """`ExactModel.touches` of the tip, wherever the bending puts it."""
        _, _, place, velocity, turning, _ = rod or self.rod(q, v)
        spin = turning @ np.concatenate([v[6:9], v[12:]])
        rigid_q, rigid_v = q[:12].copy(), v[:12].copy()
        rigid_q[6:8] = place - self.front * e(q[8])
        rigid_v[6:9] = [*(velocity - self.front * spin * n(q[8])), spin]
        return self.touches(rigid_q, rigid_v, memory)

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

    def rows(self, q, v):
        """Φ_q and γ of the joints; a hinge with play has none."""
        _, jacobian, gamma = self.constraints(q[:12], v[:12])
        jacobian = np.concatenate([jacobian, np.zeros((4, self.modes))], axis=1)
        return (jacobian, gamma) if self.play is None else (jacobian[2:], gamma[2:])

    def motion(self, q, v, memory):
        """Accelerations and both flanks."""
        d, force = self.design.buffer, np.zeros(self.size)
        rod = self.rod(q, v)
        own, bent, place, _, turning, jacobian = rod
        mine = [6, 7, 8, *range(12, self.size)]
        on_b = q[B][:2] - d.cylinder_length / 2 * e(q[5])
        apart = q[6:8] - on_b
        length = np.hypot(*apart)
        along = apart / length
        rate = (v[6:8] - v[B][:2] + d.cylinder_length / 2 * v[5] * n(q[5])) @ along
        pull = (d.k_A * (length - d.free_length) + d.c_A * rate) * along
        force[B] += [*pull, cross(on_b - q[B][:2], pull)]
        force[6:8] -= pull
        torque = -d.k_T * (q[5] - q[2]) - d.c_T * (v[5] - v[2])
        force[5] += torque
        force[2] -= torque
        touches = self.flanks(q, v, memory, rod)
        for touch in touches:
            push = touch.normal_force * touch.normal + touch.friction_force * touch.tangent
            bent = bent + jacobian.T @ push + turning * cross(touch.foot - place, push)
            force[T] -= [*push, cross(touch.foot - q[T][:2], push)]
        force[mine] += bent
        if self.play is not None:
            _, _, size, out = self.pin(q, v)
            push = -size * out
            force[S] += [*push, cross(d_offset(self.design, q), push)]
            force[B] -= [*push, cross(d.cylinder_length / 2 * e(q[5]), push)]
        matrix = np.diag(np.concatenate([self.masses, np.zeros(self.modes)]))
        matrix[np.ix_(mine, mine)] = own
        jacobian, gamma = self.rows(q, v)
        rows = len(gamma)
        whole = np.block([[matrix, jacobian.T], [jacobian, np.zeros((rows, rows))]])
        return np.linalg.solve(whole, np.concatenate([force, gamma]))[: self.size], touches

    def depths(self, y):
        """Of both flanks and, if there is play, of the pin."""
        q, v = y[: self.size], y[self.size :]
        found = [touch.depth for touch in self.flanks(q, v, np.ones(2))]
        return found if self.play is None else [*found, self.pin(q, v)[0]]

    def impacts(self, until, rtol=1e-10, max_step=5e-5):
        """Largest contact force and largest hinge force (m_S a_S) up to a time [s], and the touchdowns of the flanks:
        time and peak of each."""
        q, v, speed = self.start()
        y, time, memory = np.concatenate([q, v]), 0.0, np.array([speed, 1.0])
        closed = [True, False] + [False] * (self.play is not None)
        scale = np.concatenate([np.full(12, 1e-3), np.full(self.modes, 1e-5), np.full(self.size, 0.1)])
        found, hinge = [[0.0, 0.0]], 0.0

        def field(_, y, memory):
            return np.concatenate([y[self.size :], self.motion(y[: self.size], y[self.size :], memory)[0]])

        while time < until:
            piece = solve_ivp(
                field,
                (time, until),
                y,
                "DOP853",
                args=(memory,),
                dense_output=True,
                events=[self._depth(k, is_closed) for k, is_closed in enumerate(closed)],
                rtol=rtol,
                atol=rtol * scale,
                max_step=max_step,
            )
            peak, force = self._peaks(piece, memory)
            found[-1][1], hinge = max(found[-1][1], peak), max(hinge, force)
            y, time = piece.y[:, -1], piece.t[-1]
            for k, times in enumerate(piece.t_events):
                if len(times):
                    closed[k] = not closed[k]
                    if k < 2 and closed[k]:
                        rate = self.flanks(y[: self.size], y[self.size :], memory)[k].rate
                        memory = np.where(np.arange(2) == k, max(rate, 1e-5), memory)
                        found.append([time, 0.0])
        return max(peak for _, peak in found), hinge, found

    def _depth(self, k, closed):
        def depth(_, y, memory):
            return self.depths(y)[k]

        depth.terminal, depth.direction = True, -1.0 if closed else 1.0
        return depth

    def _peaks(self, piece, memory):
        """Largest flank force and hinge force of a piece, refined on its dense output."""

        def both(time):
            y = piece.sol(time)
            acceleration, touches = self.motion(y[: self.size], y[self.size :], memory)
            size = self.design.active.mass * np.hypot(*acceleration[:2])
            return np.array([max(touch.normal_force for touch in touches), size])

        seen, best = np.array([both(t) for t in piece.t]), []
        for k in range(2):
            top = int(seen[:, k].argmax())
            low, high = piece.t[max(top - 1, 0)], piece.t[min(top + 1, len(piece.t) - 1)]
            inside = minimize_scalar(
                lambda t, k=k: -both(t)[k], bounds=(low, high), method="bounded", options={"xatol": 1e-13}
            )
            best.append(max(seen[top, k], -inside.fun))
        return best


def d_offset(design, q):
    """The pin's arm on S."""
    return design.active.hinge_offset * e(q[2])
