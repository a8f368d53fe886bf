"""The slider-crank once more, by SciPy alone: absolute coordinates, multipliers for ideal joints, events of solve_ivp.

It shares the list of numbers with the other programs of this folder and nothing else: another choice of coordinates,
another integrator's driver, peaks searched on the dense output. Slow: a second or so for each millisecond.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from .parameters import SliderCrank

Vector = NDArray[np.float64]
CRANK_PIN, PISTON_PIN = 0, 1


class Impact(NamedTuple):
    """One impact; ``release_time`` [s] is nan while it lasts."""

    joint: int  # 0 crank pin, 1 piston pin
    time: float  # [s]
    approach_speed: float  # [m/s]
    peak_force: float = 0.0  # [N]
    peak_time: float = np.nan  # [s]
    release_time: float = np.nan  # [s]


def along(angle: float) -> Vector:
    return np.array([np.cos(angle), np.sin(angle)])


def across(a: Vector) -> Vector:
    """The vector turned by a right angle."""
    return np.array([-a[1], a[0]])


class Mechanism:
    """q: crank angle, rod's centre of mass x and y, rod's angle, slider's x; constraints as the joints ask for."""

    def __init__(self, numbers: SliderCrank):
        p = self.numbers = numbers
        hollow = p.bush_radius * (p.bush_radius - p.clearance) / p.clearance
        modulus = 207e9 / (2.0 * (1.0 - 0.3**2))  # of steel on steel
        self.stiffness = p.stiffness or 4.0 / 3.0 * modulus * np.sqrt(hollow)
        self.loss = 0.75 * (1.0 - p.restitution**2)
        self.loose = [joint for joint, has in ((CRANK_PIN, p.crank_pin), (PISTON_PIN, p.piston_pin)) if has]
        inertia = p.crank_inertia or 1.0  # of no effect where the crank is driven at constant speed
        self.masses = np.array([inertia, p.rod_mass, p.rod_mass, p.rod_inertia, p.slider_mass])

    def start(self) -> Vector:
        p = self.numbers
        swing = -p.speed * p.crank_radius / p.rod_length
        rise = p.speed * p.crank_radius + swing * p.rod_centre
        return np.array(
            [0, p.crank_radius + p.rod_centre, 0, 0, p.crank_radius + p.rod_length, p.speed, 0, rise, swing, 0]
        )

    def arms(self, joint: int, q: Vector) -> tuple[Vector, Vector]:
        """Pin's centre and bush's centre [m]."""
        p = self.numbers
        centre, rod = q[1:3], along(q[3])
        if joint == CRANK_PIN:
            return p.crank_radius * along(q[0]), centre - p.rod_centre * rod
        return np.array([q[4], 0.0]), centre + (p.rod_length - p.rod_centre) * rod

    def apart(self, joint: int, q: Vector) -> tuple[Vector, NDArray[np.float64]]:
        """Pin less bush [m] and its Jacobian (2, 5)."""
        pin, bush = self.arms(joint, q)
        jacobian = np.zeros((2, 5))
        if joint == CRANK_PIN:
            jacobian[:, 0] = across(pin)
        else:
            jacobian[0, 4] = 1.0
        jacobian[:, 1:3] = -np.eye(2)
        jacobian[:, 3] = -across(bush - q[1:3])
        return pin - bush, jacobian

    def depth(self, joint: int, y: Vector) -> tuple[float, float]:
        """Depth [m] and its rate [m/s]."""
        gap, jacobian = self.apart(joint, y[:5])
        far = np.hypot(*gap)
        return far - self.numbers.clearance, float(gap @ (jacobian @ y[5:])) / far if far > 0.0 else 0.0

    def normal_force(self, joint: int, y: Vector, memory: float) -> float:
        depth, rate = self.depth(joint, y)
        return self.stiffness * max(depth, 0.0) ** 1.5 * max(0.0, 1.0 + self.loss * rate / memory)

    def contact(self, joint: int, y: Vector, memory: float) -> Vector:
        """Generalised forces (5,) of a pin that presses on its bush, by the Jacobians of the points of contact."""
        p, q, v = self.numbers, y[:5], y[5:]
        pin, bush = self.arms(joint, q)
        normal = (pin - bush) / np.hypot(*(pin - bush))
        overlap = max(self.depth(joint, y)[0], 0.0)
        point = bush + (p.bush_radius + p.overlap_share * overlap) * normal
        on_bush, on_pin = np.zeros((2, 5)), np.zeros((2, 5))
        on_bush[:, 1:3] = np.eye(2)
        on_bush[:, 3] = across(point - q[1:3])
        if joint == CRANK_PIN:
            on_pin[:, 0] = across(point)
        else:
            on_pin[0, 4] = 1.0
        force, tangent = self.normal_force(joint, y, memory), across(normal)
        ratio = tangent @ (on_pin - on_bush) @ v / p.slip_speed
        share = np.clip(ratio, -1.0, 1.0) if p.ramp else np.tanh(ratio)
        return (on_bush - on_pin).T @ (force * normal + p.friction * force * share * tangent)

    def motion(self, y: Vector, pressing: dict[int, float]) -> tuple[Vector, float]:
        """dy/dt (10,) and the torque of the drive [N m]; ``pressing``: joints in contact and their memory [m/s]."""
        p, q, v = self.numbers, y[:5], y[5:]
        force = np.array([0.0, 0.0, -p.rod_mass * p.gravity, 0.0, 0.0])
        for joint, memory in pressing.items():
            force += self.contact(joint, y, memory)
        torque = p.stall_torque * (1.0 - v[0] / p.no_load_speed) if p.torque_driven else 0.0
        force[0] += torque
        rows, right = [], []
        if not p.torque_driven:
            rows.append(np.array([[1.0, 0.0, 0.0, 0.0, 0.0]]))
            right.append(np.zeros(1))
        for joint in (CRANK_PIN, PISTON_PIN):
            if joint not in self.loose:
                pin, bush = self.arms(joint, q)
                rows.append(self.apart(joint, q)[1])
                right.append((pin * v[0] ** 2 if joint == CRANK_PIN else 0.0) - (bush - q[1:3]) * v[3] ** 2)
        jacobian, bias = np.concatenate(rows), np.concatenate(right)
        matrix = np.block([[np.diag(self.masses), jacobian.T], [jacobian, np.zeros((len(bias), len(bias)))]])
        solution = np.linalg.solve(matrix, np.concatenate([force, bias]))
        return np.concatenate([v, solution[:5]]), torque if p.torque_driven else -solution[5]


def simulate(numbers: SliderCrank, duration: float, rtol: float = 1e-13) -> list[Impact]:
    """All impacts of a run of ``duration`` [s]."""
    mechanism = Mechanism(numbers)
    y, t = mechanism.start(), 0.0
    pressing: dict[int, float] = {}
    impacts: list[Impact] = []
    latest: dict[int, int] = {}
    scale = np.array([1e-2, 1e-3, 1e-3, 1e-2, 1e-3, 10.0, 1.0, 1.0, 10.0, 1.0])
    while t < duration:
        piece = solve_ivp(
            lambda _, y: mechanism.motion(y, pressing)[0],  # used up within this turn
            (t, duration),
            y,
            "DOP853",
            events=[_crossing(mechanism, joint, joint in pressing) for joint in mechanism.loose],
            dense_output=True,
            rtol=max(rtol, 3e-14),
            atol=rtol * scale,
            first_step=min(1e-7, duration - t),
            max_step=2e-5,
        )
        t, y = piece.t[-1], piece.y[:, -1]
        for joint, memory in pressing.items():
            force, time = _largest(mechanism, joint, memory, piece)
            impact = impacts[latest[joint]]
            if force > impact.peak_force:
                impacts[latest[joint]] = impact._replace(peak_force=force, peak_time=time)
        for joint, times in zip(mechanism.loose, piece.t_events, strict=True):
            if len(times) == 0:
                continue
            if joint in pressing:
                del pressing[joint]
                impacts[latest[joint]] = impacts[latest[joint]]._replace(release_time=t)
            else:
                pressing[joint] = max(mechanism.depth(joint, y)[1], 1e-5)
                latest[joint] = len(impacts)
                impacts.append(Impact(joint, t, pressing[joint]))
    return impacts


def _crossing(mechanism: Mechanism, joint: int, pressing: bool):
    def depth(_, y):
        return mechanism.depth(joint, y)[0]

    depth.terminal, depth.direction = True, -1.0 if pressing else 1.0
    return depth


def _largest(mechanism: Mechanism, joint: int, memory: float, piece) -> tuple[float, float]:
    """Largest force [N] on the dense output, and its time [s]."""
    forces = [mechanism.normal_force(joint, y, memory) for y in piece.y.T]
    top = int(np.argmax(forces))
    low, high = piece.t[max(top - 1, 0)], piece.t[min(top + 1, len(piece.t) - 1)]
    inside = minimize_scalar(
        lambda t: -mechanism.normal_force(joint, piece.sol(t), memory),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-13},
    )
    return max((forces[top], piece.t[top]), (-inside.fun, inside.x))
