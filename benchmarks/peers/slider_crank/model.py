"""Motion of the slider-crank in minimal coordinates and the forces between its pins and bushes, compiled.

The state ``y`` (10,) holds five coordinates and their rates: crank angle θ, rod angle φ [rad], slider x [m], and the
rod's crank end (x, y) [m], which counts only where both joints have clearance and stays put elsewhere.

``modes`` (2,) by joint, crank pin and piston pin: FREE, PRESSING, or PARTING: still within the other, but leaving so
fast that Lankarani and Nikravesh's force, clamped at zero, is nil. ``memory`` (2,) [m/s]: speeds of the touchdowns.

``joints`` (2, 6) by joint: depth δ [m], its rate [m/s], the law's bracket 1 + χ δ̇/δ̇⁻ [-], force F [N], its rate [N/s],
slip [m/s].
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .compiled import njit
from .parameters import SliderCrank

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

STATES = 10
FREE, PRESSING, PARTING = 0.0, 1.0, 2.0
DEPTH, RATE, BRACKET, FORCE, FORCE_RATE, SLIP = range(6)
SLOWEST_TOUCHDOWN = 1e-5  # [m/s] least approach speed that a touchdown remembers


@njit
def rod_end(y: Vector, p: SliderCrank) -> tuple[float, float, float, float]:
    """Position [m] and velocity [m/s] of the rod's crank end."""
    if p.crank_pin == 0.0:
        c, s = p.crank_radius * math.cos(y[0]), p.crank_radius * math.sin(y[0])
        return c, s, -s * y[5], c * y[5]
    if p.piston_pin == 0.0:
        c, s = p.rod_length * math.cos(y[1]), p.rod_length * math.sin(y[1])
        return y[2] - c, -s, y[7] + s * y[6], -c * y[6]
    return y[3], y[4], y[8], y[9]


@njit
def separation(joint: int, y: Vector, p: SliderCrank) -> tuple[float, float, float, float]:
    """Centre of the pin less that of the bush [m], and its rate [m/s]."""
    x, h, u, v = rod_end(y, p)
    if joint == 0:
        c, s = p.crank_radius * math.cos(y[0]), p.crank_radius * math.sin(y[0])
        return c - x, s - h, -s * y[5] - u, c * y[5] - v
    c, s = p.rod_length * math.cos(y[1]), p.rod_length * math.sin(y[1])
    return y[2] - x - c, -h - s, y[7] - u + s * y[6], -v - c * y[6]


@njit
def press(joint: int, y: Vector, mode: float, memory: float, p: SliderCrank, joints: Matrix) -> tuple[float, float]:
    """Force (2) [N] on the bush, at its surface; all but the force's rate into ``joints``."""
    ex, ey, u, v = separation(joint, y, p)
    far = math.sqrt(ex * ex + ey * ey)
    nx, ny = (ex / far, ey / far) if far > 0.0 else (1.0, 0.0)
    depth, rate = far - p.clearance, u * nx + v * ny
    bracket = 1.0 + 0.75 * (1.0 - p.restitution**2) * rate / memory
    spin = y[5] if joint == 0 else 0.0  # of the pin; the bush turns with the rod
    place = p.bush_radius + p.overlap_share * max(depth, 0.0)  # of the force, from the bush's centre
    slip = v * nx - u * ny + spin * (place - far) - y[6] * place
    force = p.stiffness * depth * math.sqrt(depth) * bracket if mode == PRESSING and depth > 0.0 else 0.0
    share = min(max(slip / p.slip_speed, -1.0), 1.0) if p.ramp != 0.0 else math.tanh(slip / p.slip_speed)
    drag = p.friction * force * share
    joints[joint, DEPTH] = depth
    joints[joint, RATE] = rate
    joints[joint, BRACKET] = bracket
    joints[joint, FORCE] = force
    joints[joint, SLIP] = slip
    return force * nx - drag * ny, force * ny + drag * nx


@njit
def evaluate(y: Vector, modes: Vector, memory: Vector, p: SliderCrank, slope: Vector, joints: Matrix) -> float:
    """Write dy/dt into ``slope`` and the contacts into ``joints``; the torque [N m] that drives the crank."""
    r, h, g = p.crank_radius, p.rod_centre, p.rod_length - p.rod_centre
    cos_c, sin_c, cos_r, sin_r = math.cos(y[0]), math.sin(y[0]), math.cos(y[1]), math.sin(y[1])
    fx, fy, moment, push, turn = 0.0, -p.rod_mass * p.gravity, 0.0, 0.0, 0.0  # on rod, about its centre; slider; crank
    joints[:] = 0.0
    if p.crank_pin != 0.0:
        ax, ay = press(0, y, modes[0], memory[0], p, joints)
        ex, ey, _, _ = separation(0, y, p)
        far = math.sqrt(ex * ex + ey * ey)
        reach = (p.bush_radius + p.overlap_share * max(far - p.clearance, 0.0)) / far if far > 0.0 else 0.0
        fx += ax
        fy += ay
        moment += (reach * ex - h * cos_r) * ay - (reach * ey - h * sin_r) * ax
        beyond = reach - 1.0  # from the pin's centre on to the bush's surface
        turn -= (r * cos_c + beyond * ex) * ay - (r * sin_c + beyond * ey) * ax
    if p.piston_pin != 0.0:
        bx, by = press(1, y, modes[1], memory[1], p, joints)
        ex, ey, _, _ = separation(1, y, p)
        far = math.sqrt(ex * ex + ey * ey)
        reach = (p.bush_radius + p.overlap_share * max(far - p.clearance, 0.0)) / far if far > 0.0 else 0.0
        fx += bx
        fy += by
        moment += (reach * ex + g * cos_r) * by - (reach * ey + g * sin_r) * bx
        push -= bx
    drive = p.stall_torque * (1.0 - y[5] / p.no_load_speed) if p.torque_driven != 0.0 else 0.0
    slope[:5] = y[5:]
    slope[5:] = 0.0
    across = fy * cos_r - fx * sin_r
    if p.crank_pin == 0.0:
        drive = _on_crank(y, p, across, r * (fy * cos_c - fx * sin_c), moment, drive, slope)
        slope[7] = push / p.slider_mass
    else:
        if p.torque_driven != 0.0:
            slope[5] = (drive + turn) / p.crank_inertia
        else:
            drive = -turn
        if p.piston_pin == 0.0:
            _on_slider(y, p, fx + push, moment - g * across, slope)
        else:
            slope[6] = moment / p.rod_inertia
            slope[7] = push / p.slider_mass
            slope[8] = fx / p.rod_mass + h * (slope[6] * sin_r + y[6] ** 2 * cos_r)
            slope[9] = fy / p.rod_mass - h * (slope[6] * cos_r - y[6] ** 2 * sin_r)
    _force_rates(y, modes, memory, p, slope, joints)
    return drive


@njit
def _on_crank(y, p, across, lever, moment, drive, slope) -> float:
    """Accelerations of crank and rod where the rod turns on the crank pin; the torque of the drive [N m]."""
    h, m, r = p.rod_centre, p.rod_mass, p.crank_radius
    coupling = m * h * r * math.cos(y[0] - y[1])
    whirl = m * h * r * math.sin(y[0] - y[1])
    rod = p.rod_inertia + m * h * h
    on_rod = moment + h * across + whirl * y[5] ** 2
    on_crank = lever - whirl * y[6] ** 2
    if p.torque_driven == 0.0:
        slope[6] = on_rod / rod
        return coupling * slope[6] - on_crank
    crank = p.crank_inertia + m * r * r
    determinant = crank * rod - coupling * coupling
    slope[5] = ((on_crank + drive) * rod - coupling * on_rod) / determinant
    slope[6] = (crank * on_rod - coupling * (on_crank + drive)) / determinant
    return drive


@njit
def _on_slider(y, p, force, moment, slope) -> None:
    """Accelerations of rod and slider where the rod turns on the piston pin."""
    g, m = p.rod_length - p.rod_centre, p.rod_mass
    coupling = m * g * math.sin(y[1])
    rod, both = p.rod_inertia + m * g * g, p.slider_mass + m
    force = force - m * g * math.cos(y[1]) * y[6] ** 2
    determinant = rod * both - coupling * coupling
    slope[6] = (both * moment - coupling * force) / determinant
    slope[7] = (rod * force - coupling * moment) / determinant


@njit
def _force_rates(y, modes, memory, p, slope, joints) -> None:
    """dF/dt of both joints into ``joints``: exact, from the accelerations."""
    r, length = p.crank_radius, p.rod_length
    cos_r, sin_r = math.cos(y[1]), math.sin(y[1])
    for joint in range(2):
        depth, rate = joints[joint, DEPTH], joints[joint, RATE]
        if modes[joint] != PRESSING or depth <= 0.0:
            continue
        ex, ey, u, v = separation(joint, y, p)
        far = math.sqrt(ex * ex + ey * ey)
        nx, ny = ex / far, ey / far
        # Accelerations of the crank pin's centre and of the rod's crank end.
        qx = -r * (slope[5] * math.sin(y[0]) + y[5] ** 2 * math.cos(y[0]))
        qy = r * (slope[5] * math.cos(y[0]) - y[5] ** 2 * math.sin(y[0]))
        bx, by = length * (slope[6] * sin_r + y[6] ** 2 * cos_r), length * (-slope[6] * cos_r + y[6] ** 2 * sin_r)
        if p.crank_pin == 0.0:
            ax, ay = qx, qy
        elif p.piston_pin == 0.0:
            ax, ay = slope[7] + bx, by
        else:
            ax, ay = slope[8], slope[9]
        if joint == 0:
            wx, wy = qx - ax, qy - ay
        else:
            wx, wy = slope[7] - ax + bx, by - ay
        swing = v * nx - u * ny
        bend = wx * nx + wy * ny + swing * swing / far
        loss = 0.75 * (1.0 - p.restitution**2) / memory[joint]
        root = math.sqrt(depth)
        joints[joint, FORCE_RATE] = p.stiffness * root * (1.5 * rate * joints[joint, BRACKET] + depth * loss * bend)


def start(p: SliderCrank) -> Vector:
    """The state (10,) at t = 0."""
    rate = -p.crank_radius / p.rod_length * p.speed
    return np.array(
        [
            *(0.0, 0.0, p.crank_radius + p.rod_length, p.crank_radius, 0.0),
            *(p.speed, rate, 0.0, 0.0, p.crank_radius * p.speed),
        ]
    )
