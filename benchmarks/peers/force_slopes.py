"""Derivatives of the forces of `forces` by the state, written out by hand: one column for each number they depend on.

Each function adds to the rows 14 to 24 of ``matrix``, d(generalised force)/dy, in the order of the velocities.
"""

from __future__ import annotations

import math

from numba import njit

from . import parameters as at
from .contact import SPIN, foot_of, speeds, tip_motion

FAST = {"contract", "reassoc", "nsz", "arcp"}


@njit(inline="always", fastmath=FAST)
def twist_columns(matrix, p) -> None:
    """The torsional spring and damper between S and B."""
    for column, slope in ((2, -p[at.SPRING_T]), (5, p[at.SPRING_T]), (14, -p[at.DAMPER_T]), (17, p[at.DAMPER_T])):
        matrix[14, column] += slope
        matrix[17, column] -= slope


@njit(fastmath=FAST)
def buffer_columns(matrix, y, p, cos_B, sin_B, cos_P, sin_P) -> None:
    """The axial spring and damper between B and P."""
    h = p[at.HALF_CYLINDER]
    l_r = p[at.REAR]
    dx = y[6] - l_r * cos_P - y[3] + h * cos_B
    dy = y[7] - l_r * sin_P - y[4] + h * sin_B
    du = y[18] + l_r * sin_P * y[20] - y[15] - h * sin_B * y[17]
    dv = y[19] - l_r * cos_P * y[20] - y[16] + h * cos_B * y[17]
    inverse = 1.0 / math.sqrt(dx * dx + dy * dy)
    ex = dx * inverse
    ey = dy * inverse
    k = p[at.SPRING_A]
    c = p[at.DAMPER_A]
    rate = du * ex + dv * ey
    pull = k * (1.0 / inverse - p[at.FREE_LENGTH]) + c * rate
    gx = k * ex + c * inverse * (du - rate * ex)  # d pull/d(dx, dy)
    gy = k * ey + c * inverse * (dv - rate * ey)
    side = pull * inverse
    for column, ax, ay, au, av in (
        (3, -1.0, 0.0, 0.0, 0.0),
        (4, 0.0, -1.0, 0.0, 0.0),
        (5, -h * sin_B, h * cos_B, -h * y[17] * cos_B, -h * y[17] * sin_B),
        (6, 1.0, 0.0, 0.0, 0.0),
        (7, 0.0, 1.0, 0.0, 0.0),
        (8, l_r * sin_P, -l_r * cos_P, l_r * y[20] * cos_P, l_r * y[20] * sin_P),
        (15, 0.0, 0.0, -1.0, 0.0),
        (16, 0.0, 0.0, 0.0, -1.0),
        (17, 0.0, 0.0, -h * sin_B, h * cos_B),
        (18, 0.0, 0.0, 1.0, 0.0),
        (19, 0.0, 0.0, 0.0, 1.0),
        (20, 0.0, 0.0, l_r * sin_P, -l_r * cos_P),
    ):
        along = gx * ax + gy * ay + c * (ex * au + ey * av)
        across = side * (ex * ay - ey * ax)
        fx = along * ex - across * ey
        fy = along * ey + across * ex
        matrix[15, column] += fx
        matrix[16, column] += fy
        matrix[17, column] -= h * (cos_B * fy - sin_B * fx)
        matrix[18, column] -= fx
        matrix[19, column] -= fy
        matrix[20, column] += l_r * (cos_P * fy - sin_P * fx)
    matrix[17, 5] += h * pull * (sin_B * ey + cos_B * ex)  # the arms turn
    matrix[20, 8] -= l_r * pull * (sin_P * ey + cos_P * ex)


@njit(inline="always", fastmath=FAST)
def gap_slope(sigma, motion, seed, p):
    """Distance, normal (2), foot (2), gap rate and slip of a flank, and the change of each with a ``seed`` of motion.

    ``motion`` (6) is tip centre (2) and velocity (2) in T's frame, the spin of the tip and of T; ``seed`` its change.
    """
    x, z, u, v, spin, turn = motion
    ax, az, au, av, a_spin, a_turn = seed
    distance, nx, ny, fx, fy = foot_of(sigma, x, z, p)
    rate, slip = speeds(sigma, distance, nx, ny, fx, fy, u, v, spin, turn)
    tx = p[at.COSINE]
    ty = sigma * p[at.SINE]
    slant = -((x + p[at.CONE_OFFSET]) * tx + (z + sigma * p[at.THROAT_RADIUS]) * ty)
    a_distance = nx * ax + ny * az
    if 0.0 < slant < p[at.CONE_LENGTH]:  # on the flank: the foot slides, the normal stays
        slide = tx * ax + ty * az
        a_fx, a_fy, a_nx, a_ny = slide * tx, slide * ty, 0.0, 0.0
    else:  # on a rim: the normal turns about it
        a_fx, a_fy = 0.0, 0.0
        a_nx, a_ny = (ax - nx * a_distance) / distance, (az - ny * a_distance) / distance
    ru = u + spin * distance * ny + turn * fy
    rv = v - spin * distance * nx - turn * fx
    a_ru = au + a_spin * distance * ny + spin * (a_distance * ny + distance * a_ny) + a_turn * fy + turn * a_fy
    a_rv = av - a_spin * distance * nx - spin * (a_distance * nx + distance * a_nx) - a_turn * fx - turn * a_fx
    a_rate = a_ru * nx + ru * a_nx + a_rv * ny + rv * a_ny
    a_slip = sigma * (a_ru * ny + ru * a_ny - a_rv * nx - rv * a_nx)
    return (distance, nx, ny, fx, fy, rate, slip), (a_distance, a_nx, a_ny, a_fx, a_fy, a_rate, a_slip)


@njit(inline="always", fastmath=FAST)
def normal_slope(depth, rate, a_depth, a_rate, memory, p):
    """Normal force [N] at a ``depth`` [m] above zero, and its change with those of depth and gap rate."""
    damped = 1.0 - p[at.HYSTERESIS] * rate / memory
    if damped <= 0.0:
        return 0.0, 0.0
    root = p[at.STIFFNESS] * math.sqrt(depth)
    return root * depth * damped, root * (1.5 * damped * a_depth - depth * p[at.HYSTERESIS] / memory * a_rate)


@njit(inline="always", fastmath=FAST)
def flank_slope(sigma, motion, seed, memory, p):
    """Changes (4) of a flank's force (2), moment about the tip and about T, all in T's frame, with a ``seed``."""
    now, change = gap_slope(sigma, motion, seed, p)
    distance, nx, ny, fx, fy, rate, slip = now
    a_distance, a_nx, a_ny, a_fx, a_fy, a_rate, a_slip = change
    depth = p[at.RADIUS] - distance
    if depth <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    normal, a_normal = normal_slope(depth, rate, -a_distance, a_rate, memory, p)
    stick = math.tanh(slip / p[at.SLIP_SPEED])
    friction = -p[at.FRICTION] * normal * stick
    a_stick = (1.0 - stick * stick) / p[at.SLIP_SPEED] * a_slip
    a_friction = -p[at.FRICTION] * (a_normal * stick + normal * a_stick)
    force_x = normal * nx + friction * sigma * ny
    force_y = normal * ny - friction * sigma * nx
    a_x = a_normal * nx + normal * a_nx + sigma * (a_friction * ny + friction * a_ny)
    a_y = a_normal * ny + normal * a_ny - sigma * (a_friction * nx + friction * a_nx)
    a_tip = sigma * (a_distance * friction + distance * a_friction)
    return a_x, a_y, a_tip, a_fx * force_y + fx * a_y - a_fy * force_x - fy * a_x


@njit(inline="always", fastmath=FAST)
def tip_course(y, flow, p):
    """``motion`` and its rate along dy/dt, the ``flow`` (25,), as `gap_slope` takes them."""
    cos_P = math.cos(y[8])
    sin_P = math.sin(y[8])
    cos_T = math.cos(y[11])
    sin_T = math.sin(y[11])
    x, z, u, v = tip_motion(y, p, cos_P, sin_P, cos_T, sin_T)
    l_t = p[at.FRONT]
    turn = y[23]
    square = y[20] * y[20]
    du = flow[18] - flow[21] - l_t * (sin_P * flow[20] + cos_P * square)
    dv = flow[19] - flow[22] + l_t * (cos_P * flow[20] - sin_P * square)
    spin = SPIN if p[at.ROLLING] != 0.0 else 20
    rates = (
        u + turn * z,
        v - turn * x,
        cos_T * du + sin_T * dv + turn * v,
        cos_T * dv - sin_T * du - turn * u,
        flow[spin],
        flow[23],
    )
    return (x, z, u, v, y[spin], turn), rates


@njit(fastmath=FAST)
def contact_columns(matrix, y, p, sigma, memory, load, cos_P, sin_P) -> None:
    """One flank's force on the tip; ``load`` (2) [N] is that force in T's frame."""
    cos_T = math.cos(y[11])
    sin_T = math.sin(y[11])
    x, z, u, v = tip_motion(y, p, cos_P, sin_P, cos_T, sin_T)
    rolling = p[at.ROLLING]
    welded = 1.0 - rolling
    motion = (x, z, u, v, rolling * y[SPIN] + welded * y[20], y[23])
    l_t = p[at.FRONT]
    # The probe's arm to the tip centre and its turn, in T's frame.
    arm_x = l_t * (cos_T * cos_P + sin_T * sin_P)
    arm_y = l_t * (cos_T * sin_P - sin_T * cos_P)
    spin = y[20]
    wx = cos_T * load[0] - sin_T * load[1]
    wy = sin_T * load[0] + cos_T * load[1]
    for column, seed in (
        (6, (cos_T, -sin_T, 0.0, 0.0, 0.0, 0.0)),
        (7, (sin_T, cos_T, 0.0, 0.0, 0.0, 0.0)),
        (8, (-arm_y, arm_x, -spin * arm_x, -spin * arm_y, 0.0, 0.0)),
        (9, (-cos_T, sin_T, 0.0, 0.0, 0.0, 0.0)),
        (10, (-sin_T, -cos_T, 0.0, 0.0, 0.0, 0.0)),
        (11, (z, -x, v, -u, 0.0, 0.0)),
        (18, (0.0, 0.0, cos_T, -sin_T, 0.0, 0.0)),
        (19, (0.0, 0.0, sin_T, cos_T, 0.0, 0.0)),
        (20, (0.0, 0.0, -arm_y, arm_x, welded, 0.0)),
        (21, (0.0, 0.0, -cos_T, sin_T, 0.0, 0.0)),
        (22, (0.0, 0.0, -sin_T, -cos_T, 0.0, 0.0)),
        (23, (0.0, 0.0, 0.0, 0.0, 0.0, 1.0)),
        (24, (0.0, 0.0, 0.0, 0.0, rolling, 0.0)),
    ):
        a_x, a_y, a_tip, a_T = flank_slope(sigma, motion, seed, memory, p)
        fx = cos_T * a_x - sin_T * a_y
        fy = sin_T * a_x + cos_T * a_y
        if column == 11:  # the force turns with T
            fx -= wy
            fy += wx
        matrix[18, column] += fx
        matrix[19, column] += fy
        matrix[20, column] += l_t * (cos_P * fy - sin_P * fx) + welded * a_tip
        matrix[21, column] -= fx
        matrix[22, column] -= fy
        matrix[23, column] -= a_T
        matrix[24, column] += rolling * a_tip
    matrix[20, 8] -= l_t * (sin_P * wy + cos_P * wx)
