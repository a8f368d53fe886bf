"""The docking in space in MuJoCo (Todorov 2012), from the bodies, joints and springs that `jb.mjcf` writes.

MuJoCo says how all accelerates in minimal coordinates: a free body, two hinges, a slide, a ball joint of a free tip.
Its own contacts are soft constraints of another law, so that the contact is ours, a force from outside; so is the
stepping, SciPy's DOP853 with located events, because steps of one size know none.
"""

import math
from typing import NamedTuple

import mujoco
import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar
from scipy.spatial.transform import Rotation

from jaxbuffer import Design3D, Scenario3D, mjcf

SLOWEST = 1e-5  # m/s, the least memory of a touchdown
SAMPLES = np.array([0.0, 1e-4, 1e-3, 1e-2, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0])  # of each step, where events are looked for
FIRST_STEP = 1e-6  # s, after each event


class Found(NamedTuple):
    """What MuJoCo found: ``outcome``, ``impacts``, and ``values`` by the quantities' names in jaxbuffer."""

    outcome: str
    impacts: int
    values: dict[str, float]


class Touching(NamedTuple):
    """The tip in the cone: its ``gap`` [m], ``approach`` speed and slip vector ``slip`` [m/s], ``normal`` and ``foot``
    in inertial axes; how far the tip's centre is ``beyond`` the capture plane [m]."""

    gap: float
    approach: float
    slip: np.ndarray
    normal: np.ndarray
    foot: np.ndarray
    beyond: float


class Docking:
    """A docking between two events: its rate of change, and what is watched. ``memory``: approach speed of the last
    touchdown [m/s], None where nothing touches."""

    def __init__(self, design: Design3D, scenario: Scenario3D):
        self.design, self.scenario = design, scenario
        cone, probe, contact = design.cone, design.probe, design.contact
        self.cos, self.sin = math.cos(cone.half_angle), math.sin(cone.half_angle)
        self.offset, self.throat, self.slant = map(float, (cone.offset, cone.throat_radius, cone.length))
        self.radius = float(probe.tip_radius)
        self.stiffness = 2 / 3 * contact.young_modulus / (1 - contact.poisson_ratio**2) * math.sqrt(self.radius)
        self.loss = 0.75 * (1 - contact.restitution**2)
        self.friction, self.slip_speed = float(contact.friction), float(contact.slip_speed)
        self.model = mujoco.MjModel.from_xml_string(mjcf(design, scenario))
        self.data = mujoco.MjData(self.model)
        self.cone, self.probe = (self.model.body(name).id for name in ("passive", "probe"))
        # A welded tip is part of the probe, before its centre of mass.
        self.tip, before = self.probe, probe.length / 2 * probe.rod_mass / (probe.rod_mass + probe.tip_mass)
        self.arm = np.array([float(before), 0.0, 0.0])
        if probe.free_tip:
            self.tip, self.arm = self.model.body("tip").id, np.zeros(3)
        self.memory: float | None = None

    def start(self) -> np.ndarray:
        """Positions and velocities at t = 0: S, B and P in line behind the tip."""
        given, free = self.scenario, self.scenario.start == "free"
        x, y, z = -self.offset - self.slant * self.cos - self.radius - given.standoff, given.offset_y, given.offset_z
        if not free:
            slant = given.contact_distance
            x = -self.offset - slant * self.cos - self.radius * self.sin
            rho, azimuth = self.throat + slant * self.sin - self.radius * self.cos, given.azimuth - math.pi / 2
            y, z = rho * math.sin(azimuth), rho * math.cos(azimuth)
        cone, active = (
            Rotation.from_euler("ZY", angles)
            for angles in ((given.passive_yaw, given.passive_pitch), (given.active_yaw, given.active_pitch))
        )
        design = self.design
        behind = (
            design.active.hinge_offset - design.buffer.cylinder_length + design.buffer.free_length + design.probe.length
        )
        place = cone.apply([x, y, z]) - active.apply([float(behind), 0.0, 0.0])
        speeds = [given.approach_speed, given.lateral_speed_y, given.lateral_speed_z]
        spins = (
            rotation.inv().apply([getattr(given, f"{body}_rate_{axis}") for axis in "xyz"])
            for body, rotation in (("active", active), ("passive", cone))
        )
        between, turning = np.zeros(3), next(spins)
        ball = self.model.nq > 17  # the tip's own quaternion
        q = [*place, *active.as_quat(scalar_first=True), *between, *[1.0, 0.0, 0.0, 0.0] * ball]
        q += [0.0, 0.0, 0.0, *cone.as_quat(scalar_first=True)]
        v = [*speeds, *turning, *between, *[0.0] * 3 * ball, 0.0, 0.0, 0.0, *next(spins)]
        return np.array([*q, *v], float)

    def _set(self, y: np.ndarray) -> None:
        self.data.qpos[:], self.data.qvel[:] = y[: self.model.nq], y[self.model.nq :]
        mujoco.mj_fwdPosition(self.model, self.data)
        mujoco.mj_fwdVelocity(self.model, self.data)

    def _moving(self, body: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Place, velocity and spin of a body in inertial axes."""
        moves = np.zeros(6)
        mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_BODY, body, moves, 0)
        return self.data.xpos[body].copy(), moves[3:], moves[:3]

    def _tip(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Place, velocity and spin of the tip's centre in inertial axes."""
        place, velocity, spin = self._moving(self.tip)
        arm = self.data.xmat[self.tip].reshape(3, 3) @ self.arm
        return place + arm, velocity + np.cross(spin, arm), spin

    def touching(self, y: np.ndarray) -> Touching:
        self._set(y)
        centre, velocity, spin = self._tip()
        origin, carried, turning = self._moving(self.cone)
        axes = self.data.xmat[self.cone].reshape(3, 3)
        off = axes.T @ (centre - origin)
        rho = math.hypot(off[1], off[2])
        along = -(off[0] + self.offset) * self.cos + (rho - self.throat) * self.sin
        along = min(max(along, 0.0), self.slant)  # the rims are met as circles
        x, out = -self.offset - along * self.cos, self.throat + along * self.sin
        foot = np.array([x, *(out / rho * off[1:])])
        distance = float(np.linalg.norm(off - foot))
        normal = axes @ ((off - foot) / distance)
        arm = axes @ foot
        slips = velocity + np.cross(spin, -distance * normal) - carried - np.cross(turning, arm)
        approach = -float(slips @ normal)
        beyond = float(off[0]) + self.offset + self.radius * self.sin
        return Touching(distance - self.radius, approach, slips + approach * normal, normal, origin + arm, beyond)

    def normal_force(self, at: Touching) -> float:
        if self.memory is None or at.gap >= 0.0:
            return 0.0
        return self.stiffness * (-at.gap) ** 1.5 * max(0.0, 1.0 + self.loss * at.approach / self.memory)

    def rate(self, _time: float, y: np.ndarray) -> np.ndarray:
        return self.evaluated(y)[0]

    def evaluated(self, y: np.ndarray) -> tuple[np.ndarray, float]:
        """The rate of change of positions and velocities, and the normal force [N]."""
        at = self.touching(y)
        normal, size = self.normal_force(at), float(np.linalg.norm(at.slip))
        along = at.slip / size if size > 0.0 else at.slip
        push = normal * at.normal - self.friction * normal * math.tanh(size / self.slip_speed) * along
        for body, force in ((self.tip, push), (self.cone, -push)):
            arm = at.foot - self.data.xipos[body]
            self.data.xfrc_applied[body] = [*force, *np.cross(arm, force)]
        mujoco.mj_fwdAcceleration(self.model, self.data)
        return np.concatenate([self._position_rate(y), self.data.qacc_smooth]), normal

    def _position_rate(self, y: np.ndarray) -> np.ndarray:
        """The rate of the positions: of a quaternion half its product with the spin in the body's axes."""
        rate, position, velocity = np.zeros(self.model.nq), y[: self.model.nq], y[self.model.nq :]
        for joint in range(self.model.njnt):
            kind, at, of = self.model.jnt_type[joint], self.model.jnt_qposadr[joint], self.model.jnt_dofadr[joint]
            if kind == mujoco.mjtJoint.mjJNT_FREE:
                rate[at : at + 3] = velocity[of : of + 3]
                at, of = at + 3, of + 3
            elif kind != mujoco.mjtJoint.mjJNT_BALL:
                rate[at] = velocity[of]
                continue
            (w, *u), spin = position[at : at + 4], velocity[of : of + 3]
            rate[at : at + 4] = 0.5 * np.array([-np.dot(u, spin), *(w * spin + np.cross(u, spin))])
        return rate

    def watched(self, y: np.ndarray) -> dict[str, float]:
        """What largest values are of."""
        rate, normal = self.evaluated(y)
        acceleration = rate[self.model.nq : self.model.nq + 3]
        return {
            "peak_force": normal,
            "stroke": -y[9],
            "hinge_angle": math.hypot(y[7], y[8]),
            "peak_hinge_force": float(self.design.active.mass) * float(np.linalg.norm(acceleration)),
        }

    def misses(self, y: np.ndarray) -> dict[str, float]:
        """By how much the probe misses the cone's axis."""
        self._set(y)
        axes, probe = (self.data.xmat[body].reshape(3, 3) for body in (self.cone, self.probe))
        off = axes.T @ (self._tip()[0] - self.data.xpos[self.cone])
        return {
            "lateral_miss": math.hypot(off[1], off[2]),
            "swing_miss": math.acos(float(axes[:, 0] @ probe[:, 0])),
            "attitude_miss": Rotation.from_matrix(axes.T @ probe).magnitude(),
        }


def simulate(design: Design3D, scenario: Scenario3D, rtol: float, duration: float = 3.0) -> Found:
    """Follow a docking without latches to its capture, with MuJoCo's accelerations."""
    docking = Docking(design, scenario)
    time, y, impacts, largest = 0.0, docking.start(), 0, dict[str, tuple]()
    if scenario.start == "contact":
        docking.memory, impacts = max(docking.touching(y).approach, SLOWEST), 1
    while True:
        # SciPy's own first step, found where the force is still zero, would lead far into the cone's metal.
        solver = DOP853(docking.rate, time, y, duration, first_step=FIRST_STEP, rtol=rtol, atol=1e-3 * rtol)
        event = None
        while event is None and solver.status == "running":
            solver.step()
            dense = solver.dense_output()
            event = _event(docking, dense, solver.t_old, solver.t, fresh=solver.t_old == time)
            _note(docking, dense, solver.t_old, solver.t if event is None else event[1], largest)
        if event is None:
            return Found("timeout", impacts, {})
        kind, time = event
        y = dense(time)
        if kind == "captured":
            values = {name: found[0] for name, found in largest.items()} | docking.misses(y)
            return Found(kind, impacts, values | {"end_time": time, "peak_time": largest["peak_force"][1]})
        impacts += kind == "touchdown"
        docking.memory = max(docking.touching(y).approach, SLOWEST) if kind == "touchdown" else None


def _event(docking: Docking, dense, start: float, end: float, fresh: bool) -> tuple[str, float] | None:
    """The first event within a step, and its time. One that has just happened lies at the start of a ``fresh`` step,
    and counts no more."""
    side, kind = (-1.0, "touchdown") if docking.memory is None else (1.0, "release")
    of = {
        kind: lambda time: side * docking.touching(dense(time)).gap,
        "captured": lambda time: docking.touching(dense(time)).beyond,
    }
    times = start + (end - start) * SAMPLES
    seen = [docking.touching(dense(time)) for time in times]
    values, found = {kind: [side * at.gap for at in seen], "captured": [at.beyond for at in seen]}, []
    for name, each in values.items():
        for k in range(2 if fresh else 1, len(times)):
            if each[k - 1] < 0.0 <= each[k]:
                found.append((brentq(of[name], times[k - 1], times[k], xtol=1e-15), name))
                break
    return min(found)[::-1] if found else None


def _note(docking: Docking, dense, start: float, end: float, largest: dict[str, tuple]) -> None:
    """Keep the largest values of a step and when they are reached [s]."""
    times = np.linspace(start, end, 6)
    values = [docking.watched(dense(time)) for time in times]
    for name in values[0]:
        k = int(np.argmax([at[name] for at in values]))
        if values[k][name] <= largest.get(name, (0.0,))[0] * (1.0 - 1e-3) or values[k][name] == 0.0:
            continue
        low, high = times[max(k - 1, 0)], times[min(k + 1, len(times) - 1)]
        top = minimize_scalar(
            lambda time, name=name: -docking.watched(dense(time))[name],
            bounds=(low, high), method="bounded", options={"xatol": 1e-9 * (high - low)},
        )  # fmt: skip
        best = max((values[k][name], float(times[k])), (-float(top.fun), float(top.x)))
        largest[name] = max(largest.get(name, (0.0, 0.0)), best)
