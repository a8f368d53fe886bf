"""Where the tip meets the two flanks of the cone, and with what force (M29 to M59 of docs/model.md), compiled.

Flank 0 is the lower one (sigma = +1), flank 1 the upper one (sigma = -1). All of it is worked out in the frame of the
passive vehicle T, where the cone is at rest: x along the axis, away from the mouth.
"""

from __future__ import annotations

import math

from numba import njit

from . import parameters as at
from .parameters import Vector

SLOWEST_TOUCHDOWN = 1e-5  # [m/s] least approach speed that a touchdown remembers
SPIN = 24  # place of the tip's angular velocity in the state


@njit(inline="always")
def tip_motion(y, p, cos_P, sin_P, cos_T, sin_T):
    """Tip centre (x, y) [m] in T's frame and its velocity relative to r_T's, turned into that frame [m/s]."""
    l_t = p[at.FRONT]
    dx = y[6] + l_t * cos_P - y[9]
    dy = y[7] + l_t * sin_P - y[10]
    du = y[18] - l_t * sin_P * y[20] - y[21]
    dv = y[19] + l_t * cos_P * y[20] - y[22]
    return (
        cos_T * dx + sin_T * dy,
        cos_T * dy - sin_T * dx,
        cos_T * du + sin_T * dv,
        cos_T * dv - sin_T * du,
    )


@njit(inline="always")
def foot_of(sigma, x, y, p):
    """Distance [m] of the tip centre from flank ``sigma``, normal (2) and foot (2) [m] in T's frame."""
    tx = p[at.COSINE]
    ty = sigma * p[at.SINE]
    ex = -p[at.CONE_OFFSET]
    ey = -sigma * p[at.THROAT_RADIUS]
    slant = -((x - ex) * tx + (y - ey) * ty)
    slant = min(max(slant, 0.0), p[at.CONE_LENGTH])  # the rims are met as points
    fx = ex - slant * tx
    fy = ey - slant * ty
    nx = x - fx
    ny = y - fy
    distance = math.sqrt(nx * nx + ny * ny)
    return distance, nx / distance, ny / distance, fx, fy


@njit(inline="always")
def speeds(sigma, distance, nx, ny, fx, fy, u, v, spin, turn):
    """Gap rate and slip [m/s] of the material points at the foot, tip minus cone; slip counts towards the throat.

    ``spin`` and ``turn`` [rad/s] are the angular velocities of the tip and of T, ``u, v`` [m/s] the tip centre's
    velocity relative to r_T's.
    """
    ru = u + spin * distance * ny + turn * fy
    rv = v - spin * distance * nx - turn * fx
    return ru * nx + rv * ny, sigma * (ru * ny - rv * nx)


@njit(inline="always")
def normal_force(gap, gap_rate, memory, p):
    """Lankarani and Nikravesh's force [N]; ``memory`` [m/s] is the approach speed of the flank's latest touchdown."""
    if gap >= 0.0:
        return 0.0
    return p[at.STIFFNESS] * -gap * math.sqrt(-gap) * max(0.0, 1.0 - p[at.HYSTERESIS] * gap_rate / memory)


@njit
def both_gaps(y: Vector, p: Vector) -> tuple[float, float, float, float, float]:
    """Gaps [m] of the lower and upper flank, their rates [m/s], and the tip centre's x [m] in T's frame."""
    cos_T = math.cos(y[11])
    sin_T = math.sin(y[11])
    ax, ay, u, v = tip_motion(y, p, math.cos(y[8]), math.sin(y[8]), cos_T, sin_T)
    spin = y[SPIN] if p[at.ROLLING] != 0.0 else y[20]
    d0, nx0, ny0, fx0, fy0 = foot_of(1.0, ax, ay, p)
    d1, nx1, ny1, fx1, fy1 = foot_of(-1.0, ax, ay, p)
    rate0, _ = speeds(1.0, d0, nx0, ny0, fx0, fy0, u, v, spin, y[23])
    rate1, _ = speeds(-1.0, d1, nx1, ny1, fx1, fy1, u, v, spin, y[23])
    return d0 - p[at.RADIUS], d1 - p[at.RADIUS], rate0, rate1, ax


@njit
def both_forces(y: Vector, p: Vector, active: Vector, memory: Vector) -> tuple[float, float]:
    """Normal forces [N] of the lower and upper flank; none from a flank that is not ``active``."""
    g0, g1, r0, r1, _ = both_gaps(y, p)
    f0 = normal_force(g0, r0, memory[0], p) if active[0] != 0.0 else 0.0
    f1 = normal_force(g1, r1, memory[1], p) if active[1] != 0.0 else 0.0
    return f0, f1
