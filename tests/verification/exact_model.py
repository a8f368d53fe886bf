"""The capture mechanism once more, in NumPy and SciPy, written from the paper's equations and not from the program.

Whole augmented matrix solved by LAPACK, no stabilisation, an eighth-order integrator restarted at every touchdown and
release, maxima found on its dense output: slow, and sharing nothing with what it verifies but the design's numbers.
`exact_bending` gives it a probe that bends and play in the hinge.
"""

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

S, B, P, T = (slice(3 * body, 3 * body + 3) for body in range(4))


def e(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def n(angle):
    return np.array([-np.sin(angle), np.cos(angle)])


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


class Touch(NamedTuple):
    """One flank at one instant: penetration, its rate, slip, forces, foot, normal, tangent."""

    depth: float
    rate: float
    slip: float
    normal_force: float
    friction_force: float
    foot: np.ndarray
    normal: np.ndarray
    tangent: np.ndarray


class ExactModel:
    """Numbers of a design and a scenario, and what the paper's equations make of them (flanks: 0 lower, 1 upper)."""

    def __init__(self, design, scenario):
        d = self.design = design
        self.scenario, self.free = scenario, design.probe.free_tip
        rod, tip, length, radius = d.probe.rod_mass, d.probe.tip_mass, d.probe.length, d.probe.tip_radius
        mass = rod + tip
        centre = (rod * length / 2 + tip * length) / mass  # from the probe's rear end
        self.rear, self.front = centre, length - centre  # of the probe's frame, to either end
        self.size = 12  # coordinates
        own = 0.4 * tip * radius**2
        inertia = rod * length**2 / 12 + rod * (centre - length / 2) ** 2 + tip * self.front**2
        self.tip_inertia = own
        cylinder = d.buffer.cylinder_mass
        bodies = [
            (d.active.mass, d.active.inertia),
            (cylinder, cylinder * d.buffer.cylinder_length**2 / 12),
            (mass, inertia if self.free else inertia + own),
            (d.passive.mass, d.passive.inertia),
        ]
        self.masses = np.array([m for mass, inertia in bodies for m in (mass, mass, inertia)])
        tip, cone = (d.contact.young_modulus, d.contact.poisson_ratio), (d.cone.young_modulus, d.cone.poisson_ratio)
        cone = [of_tip if own is None else own for of_tip, own in zip(tip, cone, strict=True)]
        compliance = sum((1 - ratio**2) / young for young, ratio in (tip, cone))
        self.stiffness = 4 * np.sqrt(radius) / (3 * compliance)
        self.hysteresis = 0.75 * (1 - d.contact.restitution**2)

    def start(self):
        """Coordinates, velocities with the tip's spin last if it is free, and δ̇⁻ of the lower flank."""
        d, s, angle = self.design, self.scenario, self.design.cone.half_angle
        edge = np.array([-d.cone.offset, -d.cone.throat_radius])
        local = edge - s.contact_distance * e(angle) + d.probe.tip_radius * n(angle)
        turn = np.stack([e(s.misalignment), n(s.misalignment)], axis=1)
        x, y = turn @ local
        hinge = x - d.probe.length - d.buffer.free_length + d.buffer.cylinder_length
        q, v = np.zeros(self.size), np.zeros(self.size + self.free)
        q[:6] = [hinge - d.active.hinge_offset, y, 0, hinge - d.buffer.cylinder_length / 2, y, 0]
        q[6:12] = [x - self.front, y, 0, 0, 0, s.misalignment]
        v[:12] = [s.approach_speed, 0, 0] * 3 + [0, 0, s.passive_rate]
        return q, v, self.touches(q, v, np.ones(2))[0].rate

    def tip(self, q, v):
        """Place, velocity and spin of the tip."""
        place = q[P][:2] + self.front * e(q[8])
        return place, v[P][:2] + self.front * v[8] * n(q[8]), v[12] if self.free else v[8]

    def touches(self, q, v, memory):
        """Both flanks by M29 to M36, M41 and M59 of docs/model.md, F_n > 0 wherever δ > 0."""
        d, radius = self.design, self.design.probe.tip_radius
        tip, tip_velocity, spin = self.tip(q, v)
        turn = np.stack([e(q[11]), n(q[11])], axis=1)
        found = []
        for side, approach in zip((1.0, -1.0), memory, strict=True):
            local = turn.T @ (tip - q[T][:2])
            edge = np.array([-d.cone.offset, -side * d.cone.throat_radius])
            towards = np.array([np.cos(d.cone.half_angle), side * np.sin(d.cone.half_angle)])
            slant = min(max(-(local - edge) @ towards, 0.0), d.cone.length)
            foot = q[T][:2] + turn @ (edge - slant * towards)
            distance = np.hypot(*(tip - foot))
            normal = (tip - foot) / distance
            tangent = side * np.array([normal[1], -normal[0]])
            arm = foot - tip
            on_tip = tip_velocity + spin * np.array([-arm[1], arm[0]])
            lever = foot - q[T][:2]
            relative = on_tip - v[T][:2] - v[11] * np.array([-lever[1], lever[0]])
            depth, rate, slip = radius - distance, -relative @ normal, relative @ tangent
            force = self.stiffness * max(depth, 0.0) ** 1.5 * max(0.0, 1 + self.hysteresis * rate / approach)
            friction = -d.contact.friction * force * np.tanh(slip / d.contact.slip_speed)
            found.append(Touch(depth, rate, slip, force, friction, foot, normal, tangent))
        return found

    def buffer(self, q, v):
        """Ends of the axial element, its direction, length and rate."""
        half = self.design.buffer.cylinder_length / 2
        on_b, on_p = q[B][:2] - half * e(q[5]), q[P][:2] - self.rear * e(q[8])
        rate = v[P][:2] - self.rear * v[8] * n(q[8]) - v[B][:2] + half * v[5] * n(q[5])
        length = np.hypot(*(on_p - on_b))
        along = (on_p - on_b) / length
        return on_b, on_p, along, length, rate @ along

    def constraints(self, q, v):
        """Φ, Φ_q and γ of eq. 7."""
        a, half = self.design.active.hinge_offset, self.design.buffer.cylinder_length / 2
        apart, parting = q[P][:2] - q[B][:2], v[P][:2] - v[B][:2]
        across, along = n(q[5]), e(q[5])
        phi = np.array([*(q[S][:2] + a * e(q[2]) - q[B][:2] - half * along), q[5] - q[8], across @ apart])
        jacobian = np.zeros((4, self.size))
        jacobian[:2, S] = np.column_stack([np.eye(2), a * n(q[2])])
        jacobian[:2, B] = np.column_stack([-np.eye(2), -half * across])
        jacobian[2, 5], jacobian[2, 8] = 1.0, -1.0
        jacobian[3, B], jacobian[3, P] = [*-across, -along @ apart], [*across, 0.0]
        hinge = a * e(q[2]) * v[2] ** 2 - half * along * v[5] ** 2
        gamma = np.array([*hinge, 0.0, 2 * v[5] * along @ parting + v[5] ** 2 * across @ apart])
        return phi, jacobian, gamma

    def own(self, q, v):
        """Mass matrix, and the forces that belong to no buffer, spring or flank."""
        return np.diag(self.masses), np.zeros(12)

    def carry(self, force, q, push, moment):
        """Add the forces of a push on the tip and of a moment on the probe's end."""
        force[P] += [*push, cross(self.front * e(q[8]), push) + moment]

    def motion(self, q, v, memory):
        """Accelerations (the tip's spin last if free), multipliers and both flanks."""
        d, (matrix, force) = self.design.buffer, self.own(q, v)
        on_b, on_p, along, length, rate = self.buffer(q, v)
        pull = (d.k_A * (length - d.free_length) + d.c_A * rate) * along
        force[B] += [*pull, cross(on_b - q[B][:2], pull)]
        force[P] -= [*pull, cross(on_p - q[P][:2], pull)]
        torque = -d.k_T * (q[5] - q[2]) - d.c_T * (v[5] - v[2])
        force[5] += torque
        force[2] -= torque
        tip, turning, touches = self.tip(q, v)[0], 0.0, self.touches(q, v, memory)
        for touch in touches:
            push = touch.normal_force * touch.normal + touch.friction_force * touch.tangent
            moment = cross(touch.foot - tip, push)
            self.carry(force, q, push, 0.0 if self.free else moment)
            force[T] -= [*push, cross(touch.foot - q[T][:2], push)]
            turning += moment
        spin = [turning / self.tip_inertia] if self.free else []
        _, jacobian, gamma = self.constraints(q, v)
        matrix = np.block([[matrix, jacobian.T], [jacobian, np.zeros((len(gamma), len(gamma)))]])
        solution = np.linalg.solve(matrix, np.concatenate([force, gamma]))
        return np.concatenate([solution[: self.size], spin]), solution[self.size :], touches

    def quantities(self, y, memory):
        """Contact forces of both flanks [N], hinge force [N], |buffer force| [N], stroke [m], |hinge angle| [rad],
        extension [m]."""
        q, v = y[: self.size], y[self.size :]
        acceleration, _, touches = self.motion(q, v, memory)
        *_, length, rate = self.buffer(q, v)
        hinge = self.design.active.mass * np.hypot(*acceleration[:2])
        d = self.design.buffer
        tension = abs(d.k_A * (length - d.free_length) + d.c_A * rate)
        forces = [touch.normal_force for touch in touches]
        stroke = d.free_length - length
        return np.array([*forces, hinge, tension, stroke, abs(q[5] - q[2]), -stroke])

    def depths(self, y):
        """Of all contacts [m], the flanks first."""
        return [touch.depth for touch in self.touches(y[: self.size], y[self.size :], np.ones(2))]

    def maxima(self, until, rtol=1e-11, max_step=2e-4):
        """Largest value of each of the `quantities` up to a time [s], and the number of touchdowns on the flanks."""
        q, v, speed = self.start()
        y, time, memory = np.concatenate([q, v]), 0.0, np.array([speed, 1.0])
        closed = [True] + [False] * (len(self.depths(y)) - 1)
        scale = np.concatenate([np.full(12, 1e-3), np.full(self.size - 12, 1e-5), np.full(len(v), 0.1)])
        best, touchdowns = np.zeros(7), 1
        while time < until:
            piece = solve_ivp(
                self._rate,
                (time, until),
                y,
                "DOP853",
                args=(memory,),
                dense_output=True,
                events=[self._crossing(contact, shut) for contact, shut in enumerate(closed)],
                rtol=rtol,
                atol=rtol * scale,
                max_step=max_step,
            )
            best = np.maximum(best, self._largest(piece, memory))
            y, time = piece.y[:, -1], piece.t[-1]
            for contact, times in enumerate(piece.t_events):
                if len(times):
                    closed[contact] = not closed[contact]
                    if contact < 2 and closed[contact]:
                        touchdowns += 1
                        rate = self.touches(y[: self.size], y[self.size :], memory)[contact].rate
                        memory = np.where(np.arange(2) == contact, max(rate, 1e-5), memory)
        return best, touchdowns

    def _rate(self, _, y, memory):
        q, v = y[: self.size], y[self.size :]
        return np.concatenate([v[: self.size], self.motion(q, v, memory)[0]])

    def _crossing(self, contact, closed):
        def depth(_, y, memory):
            return self.depths(y)[contact]

        depth.terminal, depth.direction = True, -1.0 if closed else 1.0
        return depth

    def _largest(self, piece, memory):
        values = np.array([self.quantities(y, memory) for y in piece.y.T])
        largest = values.max(axis=0)
        for k, top in enumerate(values.argmax(axis=0)):
            low, high = piece.t[max(top - 1, 0)], piece.t[min(top + 1, len(piece.t) - 1)]
            if largest[k] > 0.0 and low < high:
                inside = minimize_scalar(
                    lambda t, k=k: -self.quantities(piece.sol(t), memory)[k],
                    bounds=(low, high),
                    method="bounded",
                    options={"xatol": 1e-12},
                )
                largest[k] = max(largest[k], -inside.fun)
        return largest
