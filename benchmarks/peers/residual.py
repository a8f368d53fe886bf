"""The capture as the differential-algebraic system M16 of docs/model.md, for a solver that takes one.

Unknowns z (29,): the state (25,) and the joints' multipliers (4,) [N, N, N m, N]. Index 1: the joints are stated for
the accelerations, with the same stabilisation as everywhere else.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from . import parameters as at
from .model import rhs_into, terms
from .parameters import Matrix, Vector
from .start import STATES

UNKNOWNS = STATES + 4


@njit
def residual_into(z: Vector, dz: Vector, out: Vector, context: Vector) -> None:
    """Write q' - v [m/s, rad/s], M v' + Phi_q^T lambda - F [N, N m] and Phi_q v' - gamma [m/s^2, rad/s^2] (29,)."""
    p = context[0:30]
    loads, links, cos_B, sin_B = terms(z, p, context[30:32], context[32:34])
    m_S, bx, by, m_B, px, py, m_P, tx, ty, m_T, m_tip = loads
    w, asx, asy, hbx, hby, g1, g2, g3, g4 = links
    for place in range(12):
        out[place] = dz[place] - z[12 + place]
    r1 = z[25]
    r2 = z[26]
    r3 = z[27]
    r4 = z[28]
    out[12] = p[at.MASS_S] * dz[12] + r1
    out[13] = p[at.MASS_S] * dz[13] + r2
    out[14] = p[at.INERTIA_S] * dz[14] - asy * r1 + asx * r2 - m_S
    out[15] = p[at.MASS_B] * dz[15] - r1 + sin_B * r4 - bx
    out[16] = p[at.MASS_B] * dz[16] - r2 - cos_B * r4 - by
    out[17] = p[at.INERTIA_B] * dz[17] + hby * r1 - hbx * r2 + r3 - w * r4 - m_B
    out[18] = p[at.MASS_P] * dz[18] - sin_B * r4 - px
    out[19] = p[at.MASS_P] * dz[19] + cos_B * r4 - py
    out[20] = p[at.INERTIA_P] * dz[20] - r3 - m_P
    out[21] = p[at.MASS_T] * dz[21] - tx
    out[22] = p[at.MASS_T] * dz[22] - ty
    out[23] = p[at.INERTIA_T] * dz[23] - m_T
    out[24] = p[at.INERTIA_TIP] * dz[24] - m_tip
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
