"""All that pushes on the bodies but the joints: buffer and contact (M22 to M59 of docs/model.md), compiled."""

from __future__ import annotations

import math

from numba import njit

from . import parameters as at
from .contact import SPIN, foot_of, normal_force, speeds, tip_motion
from .parameters import Vector


@njit(inline="always")
def buffer_pull(y, p, cos_B, sin_B, cos_P, sin_P):
    """Axial force [N], positive when it pulls its two ends together, and its unit direction from B's end to P's."""
    h = p[at.HALF_CYLINDER]
    l_r = p[at.REAR]
    dx = y[6] - l_r * cos_P - y[3] + h * cos_B
    dy = y[7] - l_r * sin_P - y[4] + h * sin_B
    du = y[18] + l_r * sin_P * y[20] - y[15] - h * sin_B * y[17]
    dv = y[19] - l_r * cos_P * y[20] - y[16] + h * cos_B * y[17]
    length = math.sqrt(dx * dx + dy * dy)
    ex = dx / length
    ey = dy / length
    return p[at.SPRING_A] * (length - p[at.FREE_LENGTH]) + p[at.DAMPER_A] * (du * ex + dv * ey), ex, ey


@njit(inline="always")
def flank_load(sigma, x, y, u, v, spin, turn, memory, p):
    """Force (2) [N] on the tip in T's frame, its moment about the tip centre and about r_T's origin [N m]."""
    distance, nx, ny, fx, fy = foot_of(sigma, x, y, p)
    gap = distance - p[at.RADIUS]
    if gap >= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    rate, slip = speeds(sigma, distance, nx, ny, fx, fy, u, v, spin, turn)
    normal = normal_force(gap, rate, memory, p)
    friction = -p[at.FRICTION] * normal * math.tanh(slip / p[at.SLIP_SPEED])
    force_x = normal * nx + friction * sigma * ny
    force_y = normal * ny - friction * sigma * nx
    return force_x, force_y, sigma * distance * friction, fx * force_y - fy * force_x


@njit(inline="always")
def load(y: Vector, p: Vector, active: Vector, memory: Vector, cos_B, sin_B, cos_P, sin_P):
    """Generalised forces [N, N m]: moment on S, force and moment on B, on P and on T, moment on the free tip (11).

    The force on S is nil: the joint carries all of it.
    """
    pull, ex, ey = buffer_pull(y, p, cos_B, sin_B, cos_P, sin_P)
    twist = p[at.SPRING_T] * (y[5] - y[2]) + p[at.DAMPER_T] * (y[17] - y[14])
    bx = pull * ex
    by = pull * ey
    moment_B = -p[at.HALF_CYLINDER] * (cos_B * by - sin_B * bx) - twist
    moment_P = p[at.REAR] * (cos_P * by - sin_P * bx)
    px = -bx
    py = -by
    tx = ty = moment_T = moment_tip = 0.0
    if active[0] != 0.0 or active[1] != 0.0:
        cos_T = math.cos(y[11])
        sin_T = math.sin(y[11])
        x, z, u, v = tip_motion(y, p, cos_P, sin_P, cos_T, sin_T)
        rolling = p[at.ROLLING] != 0.0
        spin = y[SPIN] if rolling else y[20]
        cx = cy = moment_centre = 0.0
        for flank in range(2):
            if active[flank] != 0.0:
                sigma = 1.0 - 2.0 * flank
                force_x, force_y, about_tip, about_T = flank_load(sigma, x, z, u, v, spin, y[23], memory[flank], p)
                cx += force_x
                cy += force_y
                moment_centre += about_tip
                moment_T -= about_T
        wx = cos_T * cx - sin_T * cy
        wy = sin_T * cx + cos_T * cy
        px += wx
        py += wy
        tx = -wx
        ty = -wy
        moment_P += p[at.FRONT] * (cos_P * wy - sin_P * wx)
        if rolling:
            moment_tip = moment_centre
        else:
            moment_P += moment_centre
    return twist, bx, by, moment_B, px, py, moment_P, tx, ty, moment_T, moment_tip
