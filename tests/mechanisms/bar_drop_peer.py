"""The bar dropped on a plate once more, for comparison: SciPy, minimal coordinates, located events, nothing of ours.

The bar's angle φ about the hinge and modal coordinates: p of the bar in modes that are zero at the hinge and have no
moment of momentum about it, q of the plate at its middle. The bar's shapes are those that Craig and Bampton's reduction
spans (cubic displacements of the end nodes and modes of a bar clamped at both), by Gauss's quadrature.
"""

from types import SimpleNamespace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq, minimize_scalar

GRAVITY = 9.81  # m/s²
DEFAULTS = {
    **{"length": 0.24, "diameter": 0.004, "density": 7850.0, "height": 0.194},
    **{"stiffness": 48_049.0 * 1000.0**2.2, "exponent": 2.2, "damping": 1000.0, "ramp": 1e-5},
    **{"bar_modes": 0, "bar_ratio": 0.01, "bar_modulus": 2.07e11},
    **{"plate_modes": 0, "plate_ratio": 0.01, "plate_modulus": 2.07e11, "plate_density": 7850.0},
    **{"span": 0.3, "width": 0.1, "thickness": 0.006, "support": "supported"},
}


def plate(d):
    """Frequencies [rad/s] of the modes that move the middle, and their mass-normalised displacement there [1/√kg]."""
    which = np.arange(1, d.plate_modes + 1, 2)
    wave = np.sqrt(d.plate_modulus * d.thickness**2 / (12.0 * d.plate_density)) / d.span**2
    mass = d.plate_density * d.width * d.thickness * d.span
    if d.support == "supported":
        return (which * np.pi) ** 2 * wave, np.sqrt(2.0 / mass) * np.sin(0.5 * which * np.pi)
    beta = np.array([clamped_root(i) for i in which])
    return beta**2 * wave, np.array([clamped_shape(b, np.array([0.5]))[0][0] for b in beta]) / np.sqrt(mass)


def clamped_root(i):
    """β of the i-th mode of a bar clamped at both ends: cosh β cos β = 1."""
    return brentq(lambda b: np.cos(b) - 1.0 / np.cosh(b), (i + 0.5) * np.pi - 0.3, (i + 0.5) * np.pi + 0.3, xtol=1e-14)


def clamped_shape(beta, x):
    """Mode with ∫φ² = 1 and its second derivative, written without the cancellation of cosh - sinh."""
    ratio = (np.cosh(beta) - np.cos(beta)) / (np.sinh(beta) - np.sin(beta))
    grown, fallen = np.exp(beta * (x - 1.0)), np.exp(-beta * x)
    hyperbolic = 0.5 * (1.0 - ratio) * np.exp(beta) * grown + 0.5 * (1.0 + ratio) * fallen
    circular = np.cos(beta * x) - ratio * np.sin(beta * x)
    return hyperbolic - circular, beta**2 * (hyperbolic + circular)


def bar(d):
    """The bar's modes about its hinge: stiffness and damping matrix, ∫ψ dm, ψ at the ball; mass-normalised."""
    x, weight = np.polynomial.legendre.leggauss(200)
    x, weight = 0.5 * (x + 1.0), 0.5 * weight
    cubic = [(x - 2 * x**2 + x**3, 6 * x - 4), (3 * x**2 - 2 * x**3, 6 - 12 * x), (x**3 - x**2, 6 * x - 2)]
    shapes = [*cubic, *(clamped_shape(clamped_root(i), x) for i in range(1, d.bar_modes - 1))]
    first = [(1.0 - 3 * x**2 + 2 * x**3, 12 * x - 6)]
    area = np.pi / 4.0 * d.diameter**2
    mass = d.density * area * d.length
    rigidity = d.bar_modulus * np.pi / 64.0 * d.diameter**4 / d.length**3

    def modes(basis, rigid):
        values, bends = (np.array(part) for part in zip(*basis, strict=True))
        m, k = mass * (values * weight) @ values.T, rigidity * (bends * weight) @ bends.T
        squared, vectors = eigh(k, m)
        return squared[rigid:], vectors[:, rigid:].T @ values, vectors[:, rigid:]

    squared, hinged, vectors = modes(shapes, 1)
    free_squared, free, _ = modes([*first, *shapes], 2)
    rates = mass * (free * weight) @ hinged.T  # of the free bar's modes per rate of the hinged bar's
    damping = rates.T @ (2.0 * d.bar_ratio * np.sqrt(free_squared)[:, None] * rates)
    return np.diag(squared), damping, mass * (hinged * weight).sum(axis=1), vectors[1]  # only 3x² - 2x³ is 1 at the end


def force(d, gap, rate):
    """IMPACT."""
    if gap >= 0.0:
        return 0.0
    share = min(-gap / d.ramp, 1.0)
    return max(0.0, d.stiffness * (-gap) ** d.exponent - d.damping * rate * share**2 * (3.0 - 2.0 * share))


class Drop:
    """The equations of motion; the state is (φ, p, q) and its rate."""

    def __init__(self, **changes):
        self.d = d = SimpleNamespace(**{**DEFAULTS, **changes})
        self.mass = d.density * np.pi / 4.0 * d.diameter**2 * d.length
        self.inertia = self.mass * d.length**2 / 3.0
        none = np.zeros((0, 0)), np.zeros((0, 0)), np.zeros(0), np.zeros(0)
        self.k, self.c, self.s, self.end = bar(d) if d.bar_modes else none
        self.omega, self.middle = plate(d) if d.plate_modes else (np.zeros(0), np.zeros(0))
        self.n = len(self.end)
        self.size = 1 + self.n + len(self.omega)

    def start(self):
        y = np.zeros(2 * self.size)
        y[0] = np.arcsin(self.d.height / self.d.length)
        return y

    def gap(self, y):
        phi, p, q = y[0], y[1 : 1 + self.n], y[1 + self.n : self.size]
        return self.d.length * np.sin(phi) + np.cos(phi) * (self.end @ p) - self.middle @ q

    def gap_rate(self, y):
        phi, p, u = y[0], y[1 : 1 + self.n], y[self.size :]
        turning = (self.d.length * np.cos(phi) - np.sin(phi) * (self.end @ p)) * u[0]
        return turning + np.cos(phi) * (self.end @ u[1 : 1 + self.n]) - self.middle @ u[1 + self.n :]

    def force(self, y):
        return force(self.d, self.gap(y), self.gap_rate(y))

    def rate(self, _, y, contact):
        n, size = self.n, self.size
        phi, p, q = y[0], y[1 : 1 + n], y[1 + n : size]
        u = y[size:]
        spin, pdot, qdot = u[0], u[1 : 1 + n], u[1 + n :]
        f, cos, sin = self.force(y) if contact else 0.0, np.cos(phi), np.sin(phi)
        moment = -GRAVITY * (cos * self.mass * self.d.length / 2.0 - sin * (self.s @ p))
        moment += f * (self.d.length * cos - sin * (self.end @ p)) - 2.0 * spin * (p @ pdot)
        along = spin**2 * p - self.k @ p - self.c @ pdot - GRAVITY * cos * self.s + f * cos * self.end
        across = -(self.omega**2) * q - 2.0 * self.d.plate_ratio * self.omega * qdot - f * self.middle
        return np.concatenate([u, [moment / (self.inertia + p @ p)], along, across])

    def run(self, duration, rtol=1e-10):
        """Impacts as (time, peak, its time, release), largest deflection of the plate under the ball and its time."""
        t, y, contact, impacts, deflection = 0.0, self.start(), False, [], (0.0, 0.0)

        def crossing(_, y, contact):
            return self.gap(y)

        crossing.terminal = True
        while t < duration:
            crossing.direction = 1.0 if contact else -1.0
            arguments = {"method": "DOP853", "rtol": rtol, "atol": 1e-15, "events": crossing, "dense_output": True}
            part = solve_ivp(self.rate, (t, duration), y, args=(contact,), max_step=2e-3, **arguments)
            bent = lambda s, part=part: self.middle @ part.sol(s)[1 + self.n : self.size]  # noqa: E731
            deflection = min(deflection, smallest(bent, t, part.t[-1]))
            if contact:
                found, at = smallest(lambda s, part=part: -self.force(part.sol(s)), t, part.t[-1])
                impacts.append((t, -found, at, part.t[-1] if part.t[-1] < duration else np.nan))
            t, y, contact = part.t[-1], part.y[:, -1], not contact
            if t < duration:  # from the crossing on, on its other side
                y = y.copy()
                slope = self.gap_rate(y)
                y[0] += (-self.gap(y) + np.sign(slope) * 1e-17) / self.d.length
        return SimpleNamespace(impacts=np.array(impacts), deflection=-deflection[0], deflection_time=deflection[1])


def smallest(function, start, end):
    """The smallest value of a function and where it is: on a grid, then refined."""
    early = start + (end - start) * np.geomspace(1e-5, 1.0, 300)
    grid = np.unique(np.concatenate([np.linspace(start, end, 2000), early]))
    values = [function(s) for s in grid]
    k = int(np.argmin(values))
    ends = grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)]
    found = minimize_scalar(function, bounds=ends, method="bounded", options={"xatol": 1e-14})
    return min((values[k], grid[k]), (found.fun, found.x))
