"""The capture as the differential-algebraic system of the model's section 2, for a solver that takes one.

Unknowns z (29,): the state (25,) and the joints' multipliers (4,) [N, N, N m, N]. Index 1: the joints are stated for
the accelerations, with the same stabilisation as everywhere else.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from .forces import load
from .model import STATES, Matrix, Vector, joints, rhs_into
from .parameters import (
    INERTIA_B,
    INERTIA_P,
    INERTIA_S,
    INERTIA_T,
    INERTIA_TIP,
    MASS_B,
    MASS_P,
    MASS_S,
    MASS_T,
)

UNKNOWNS = STATES + 4


@njit
def residual_into(z: Vector, dz: Vector, out: Vector, context: Vector) -> None:
    """Write q' - v [m/s, rad/s], M v' + Phi_q^T lambda - F [N, N m] and Phi_q v' - gamma [m/s^2, rad/s^2] (29,)."""
    p = context[0:30]
    cos_S = math.cos(z[2])
    sin_S = math.sin(z[2])
    cos_B = math.cos(z[5])
    sin_B = math.sin(z[5])
    m_S, bx, by, m_B, px, py, m_P, tx, ty, m_T, m_tip = load(
        z, p, context[30:32], context[32:34], cos_B, sin_B, math.cos(z[8]), math.sin(z[8])
    )
    w, asx, asy, hbx, hby, g1, g2, g3, g4 = joints(z, p, cos_S, sin_S, cos_B, sin_B)
    for place in range(12):
        out[place] = dz[place] - z[12 + place]
    r1 = z[25]
    r2 = z[26]
    r3 = z[27]
    r4 = z[28]
    out[12] = p[MASS_S] * dz[12] + r1
    out[13] = p[MASS_S] * dz[13] + r2
    out[14] = p[INERTIA_S] * dz[14] - asy * r1 + asx * r2 - m_S
    out[15] = p[MASS_B] * dz[15] - r1 + sin_B * r4 - bx
    out[16] = p[MASS_B] * dz[16] - r2 - cos_B * r4 - by
    out[17] = p[INERTIA_B] * dz[17] + hby * r1 - hbx * r2 + r3 - w * r4 - m_B
    out[18] = p[MASS_P] * dz[18] - sin_B * r4 - px
    out[19] = p[MASS_P] * dz[19] + cos_B * r4 - py
    out[20] = p[INERTIA_P] * dz[20] - r3 - m_P
    out[21] = p[MASS_T] * dz[21] - tx
    out[22] = p[MASS_T] * dz[22] - ty
    out[23] = p[INERTIA_T] * dz[23] - m_T
    out[24] = p[INERTIA_TIP] * dz[24] - m_tip
    out[25] = dz[12] - asy * dz[14] - dz[15] + hby * dz[17] - g1
    out[26] = dz[13] + asx * dz[14] - dz[16] - hbx * dz[17] - g2
    out[27] = dz[17] - dz[20] - g3
    out[28] = cos_B * (dz[19] - dz[16]) - sin_B * (dz[18] - dz[15]) - w * dz[17] - g4


@njit
def residual_jacobian_into(z: Vector, dz: Vector, rate: float, matrix: Matrix, context: Vector) -> None:
    """Write d res/dz + ``rate`` [1/s] d res/dz' (29, 29) into ``matrix``, by forward differences."""
    base = np.empty(UNKNOWNS)
    moved = np.empty(UNKNOWNS)
    residual_into(z, dz, base, context)
    point = z.copy()
    slope = dz.copy()
    for column in range(UNKNOWNS):
        # A contact answers within 1e-5 m, so a step scaled by |z| alone would leap over it.
        step = 1e-9 * max(1.0, abs(z[column])) if column < 12 else 1e-7
        point[column] = z[column] + step
        step = point[column] - z[column]
        slope[column] = dz[column] + rate * step
        residual_into(point, slope, moved, context)
        point[column] = z[column]
        slope[column] = dz[column]
        for row in range(UNKNOWNS):
            matrix[row, column] = (moved[row] - base[row]) / step


@njit
def consistent(y: Vector, context: Vector) -> tuple[Vector, Vector]:
    """Unknowns z (29,) and their rates (29,) that satisfy the system at the state ``y`` (25,)."""
    z = np.empty(UNKNOWNS)
    dz = np.zeros(UNKNOWNS)
    z[:STATES] = y
    rhs_into(y, dz[:STATES], context[0:30], context[30:32], context[32:34], z[STATES:])
    return z, dz
