"""The published slider-crank once more, for comparison: SciPy, minimal coordinates, located events, nothing of ours.

Coordinates are the crank's angle, the rod's angle and the slider's place; the rod's end moves freely in a square hole
of the slider, each of whose sides pushes by IMPACT. Lengths in m, forces in N.
"""

from types import SimpleNamespace

import numpy as np
from scipy.integrate import solve_ivp

CRANK, ROD = 0.05, 0.12  # m
CRANK_INERTIA, ROD_MASS, ROD_INERTIA, SLIDER_MASS = 0.01, 0.21, 2.5e-4, 0.14  # kg m², kg, kg m², kg
CLEARANCE, DAMPING, RAMP, ONSET = 1.1e-3, 1e4, 1e-6, 1e-8  # m, N s/m, m, m
NO_LOAD_SPEED = 10.0  # rad/s


def impact(depth, rate, stiffness, exponent):
    """IMPACT of k δ (δ² + ε²)^((e-1)/2) and the damper [N]."""
    share = min(depth / RAMP, 1.0)
    spring = stiffness * depth * (depth**2 + ONSET**2) ** (0.5 * (exponent - 1.0))
    return max(0.0, spring + DAMPING * rate * share**2 * (3.0 - 2.0 * share))


class Crank:
    """``exponent`` e, ``stiffness`` k [N/mm^e], ``torque`` M_0 [N mm]."""

    def __init__(self, exponent, stiffness, torque):
        self.exponent, self.stiffness, self.torque = exponent, stiffness * 1000.0**exponent, 1e-3 * torque

    def off(self, y):
        """The rod's end from the slider's middle, and its rate."""
        theta, psi, x, spin, rod_spin, speed = y
        place = np.array([CRANK * np.cos(theta) + ROD * np.cos(psi) - x, CRANK * np.sin(theta) + ROD * np.sin(psi)])
        rate = [
            -CRANK * np.sin(theta) * spin - ROD * np.sin(psi) * rod_spin - speed,
            CRANK * np.cos(theta) * spin + ROD * np.cos(psi) * rod_spin,
        ]
        return place, np.array(rate)

    def forces(self, y, sides):
        """On the rod's end, of the sides in contact: -1, 0 or 1 for each direction."""
        place, rate = self.off(y)
        pushed = [
            -side * impact(max(side * e - CLEARANCE, 0.0), side * v, self.stiffness, self.exponent) if side else 0.0
            for side, e, v in zip(sides, place, rate, strict=True)
        ]
        return np.array(pushed)

    def rates(self, _, y, sides):
        theta, psi, _, spin, rod_spin, speed = y
        along, across = self.forces(y, sides)
        half, turn = 0.5 * ROD, theta - psi
        coupling = ROD_MASS * CRANK * half
        mass = np.array(
            [
                [CRANK_INERTIA + ROD_MASS * CRANK**2, coupling * np.cos(turn)],
                [coupling * np.cos(turn), ROD_INERTIA + ROD_MASS * half**2],
            ]
        )
        load = [
            self.torque * (1.0 - spin / NO_LOAD_SPEED)
            - coupling * np.sin(turn) * rod_spin**2
            + CRANK * (across * np.cos(theta) - along * np.sin(theta)),
            coupling * np.sin(turn) * spin**2 + ROD * (across * np.cos(psi) - along * np.sin(psi)),
        ]
        return np.array([spin, rod_spin, speed, *np.linalg.solve(mass, load), -along / SLIDER_MASS])

    def crossing(self, axis, side, direction):
        """The event that the end comes to a side, or leaves it."""

        def event(_, y, sides):
            return side * self.off(y)[0][axis] - CLEARANCE

        event.terminal, event.direction = True, direction
        return event

    def largest(self, part, sides, axis):
        """The largest force along an axis: the best of the steps, then finely around it."""
        at = lambda time: abs(self.forces(part.sol(time), sides)[axis])  # noqa: E731
        best = int(np.argmax([at(time) for time in part.t]))
        around = part.t[max(best - 1, 0)], part.t[min(best + 1, len(part.t) - 1)]
        return max(at(time) for time in np.linspace(*around, 401))

    def run(self, count, duration, rtol=1e-9):
        """The first impacts: times, approach speeds, peak forces."""
        t, y, sides, impacts = 0.0, np.array([0.0, 0.0, CRANK + ROD, 0.0, 0.0, 0.0]), [0, 0], []
        while t < duration and len(impacts) < count + 2:
            guards = []
            for axis in (0, 1):
                if sides[axis]:
                    guards.append((axis, sides[axis], self.crossing(axis, sides[axis], -1.0)))
                else:
                    guards += [(axis, side, self.crossing(axis, side, 1.0)) for side in (1, -1)]
            method = "Radau" if any(sides) else "DOP853"
            part = solve_ivp(
                self.rates,
                (t, duration),
                y,
                method=method,
                args=(sides,),
                events=[guard for *_, guard in guards],
                rtol=rtol,
                atol=1e-13,
                max_step=1e-3,
                first_step=1e-10,
                dense_output=True,
            )
            for axis in (0, 1):
                if sides[axis]:
                    force = self.largest(part, sides, axis)
                    open_one = next(one for one in reversed(impacts) if one.axis == axis)
                    open_one.peak = max(open_one.peak, force)
            t, y = part.t[-1], part.y[:, -1]
            if part.status != 1:
                break
            axis, side, _ = next(guard for guard, times in zip(guards, part.t_events, strict=True) if len(times))
            if sides[axis]:
                sides = [0 if k == axis else sides[k] for k in (0, 1)]
            else:
                impacts.append(SimpleNamespace(axis=axis, time=t, speed=side * self.off(y)[1][axis], peak=0.0))
                sides = [side if k == axis else sides[k] for k in (0, 1)]
        return np.array([(one.time, one.speed, one.peak) for one in impacts[:count]])
