"""The capture mechanism between two contact events, as a competent user of a compiler would write it by hand.

The state is y (25,): positions q (12) [m, rad] as in M4 of docs/model.md, velocities (12) [m/s, rad/s], and the tip's
own angular velocity [rad/s], at rest for ever when the tip is welded. Which flanks may press (``active``, (2,), 0 or 1)
and the approach speeds they remember (``memory``, (2,) [m/s]) stay fixed between events, so that the right-hand side is
smooth there.
"""

from __future__ import annotations

import math

from numba import njit

from . import parameters as at
from .forces import load
from .parameters import Vector


@njit(inline="always")
def joints(y: Vector, p: Vector, cos_S, sin_S, cos_B, sin_B):
    """The joints as numbers: arms w, a and L_C/2 [m] turned with their bodies, and the right-hand side gamma (4).

    gamma is that of M15 in docs/model.md with Baumgarte's terms, -2 alpha Phi' - beta^2 Phi, added.
    """
    asx = p[at.HINGE] * cos_S
    asy = p[at.HINGE] * sin_S
    hbx = p[at.HALF_CYLINDER] * cos_B
    hby = p[at.HALF_CYLINDER] * sin_B
    rx = y[6] - y[3]
    ry = y[7] - y[4]
    vx = y[18] - y[15]
    vy = y[19] - y[16]
    spin_S = y[14]
    spin_B = y[17]
    w = cos_B * rx + sin_B * ry
    offset = cos_B * ry - sin_B * rx
    gain = p[at.GAIN]
    two = 2.0 * gain
    square = gain * gain
    gamma_1 = (
        asx * spin_S * spin_S
        - hbx * spin_B * spin_B
        - two * (y[12] - asy * spin_S - y[15] + hby * spin_B)
        - square * (y[0] + asx - y[3] - hbx)
    )
    gamma_2 = (
        asy * spin_S * spin_S
        - hby * spin_B * spin_B
        - two * (y[13] + asx * spin_S - y[16] - hbx * spin_B)
        - square * (y[1] + asy - y[4] - hby)
    )
    gamma_3 = -two * (spin_B - y[20]) - square * (y[5] - y[8])
    gamma_4 = (
        spin_B * (2.0 * (cos_B * vx + sin_B * vy) + spin_B * offset)
        - two * (cos_B * vy - sin_B * vx - w * spin_B)
        - square * offset
    )
    return w, asx, asy, hbx, hby, gamma_1, gamma_2, gamma_3, gamma_4


@njit(inline="always")
def terms(y: Vector, p: Vector, active: Vector, memory: Vector):
    """What both forms of the model need of a state: loads (11), joints (9), cosine and sine of B's angle."""
    cos_S = math.cos(y[2])
    sin_S = math.sin(y[2])
    cos_B = math.cos(y[5])
    sin_B = math.sin(y[5])
    loads = load(y, p, active, memory, cos_B, sin_B, math.cos(y[8]), math.sin(y[8]))
    return loads, joints(y, p, cos_S, sin_S, cos_B, sin_B), cos_B, sin_B


@njit(inline="always")
def solve_four(s11, s21, s31, s41, s22, s32, s42, s33, s43, s44, b1, b2, b3, b4):
    """Solution (4) of a symmetric positive definite 4x4 system given by its lower half, by L D L^T without a loop."""
    d1 = 1.0 / s11
    l21 = s21 * d1
    l31 = s31 * d1
    l41 = s41 * d1
    d2 = 1.0 / (s22 - l21 * s21)
    t32 = s32 - l31 * s21
    t42 = s42 - l41 * s21
    l32 = t32 * d2
    l42 = t42 * d2
    d3 = 1.0 / (s33 - l31 * s31 - l32 * t32)
    t43 = s43 - l41 * s31 - l42 * t32
    l43 = t43 * d3
    d4 = 1.0 / (s44 - l41 * s41 - l42 * t42 - l43 * t43)
    z2 = b2 - l21 * b1
    z3 = b3 - l31 * b1 - l32 * z2
    z4 = b4 - l41 * b1 - l42 * z2 - l43 * z3
    r4 = z4 * d4
    r3 = z3 * d3 - l43 * r4
    r2 = z2 * d2 - l32 * r3 - l42 * r4
    r1 = b1 * d1 - l21 * r2 - l31 * r3 - l41 * r4
    return r1, r2, r3, r4


@njit
def rhs_into(y: Vector, out: Vector, p: Vector, active: Vector, memory: Vector, reactions: Vector) -> None:
    """Write dy/dt (25,) into ``out`` and the multipliers (4,) [N, N, N m, N] of the joints into ``reactions``.

    The mass matrix is diagonal, so the augmented system (M16 of docs/model.md) shrinks to its 4x4 Schur complement
    Phi_q M^-1 Phi_q^T lambda = Phi_q M^-1 F - gamma.
    """
    loads, links, cos_B, sin_B = terms(y, p, active, memory)
    m_S, bx, by, m_B, px, py, m_P, tx, ty, m_T, m_tip = loads
    w, asx, asy, hbx, hby, g1, g2, g3, g4 = links

    i_mS = 1.0 / p[at.MASS_S]
    i_IS = 1.0 / p[at.INERTIA_S]
    i_mB = 1.0 / p[at.MASS_B]
    i_IB = 1.0 / p[at.INERTIA_B]
    i_mP = 1.0 / p[at.MASS_P]
    i_IP = 1.0 / p[at.INERTIA_P]

    # Free accelerations of the bodies, then the reactions that make up for what the joints lack of them.
    a_S = m_S * i_IS
    a_Bx = bx * i_mB
    a_By = by * i_mB
    a_B = m_B * i_IB
    a_Px = px * i_mP
    a_Py = py * i_mP
    a_P = m_P * i_IP
    r1, r2, r3, r4 = solve_four(
        i_mS + i_mB + asy * asy * i_IS + hby * hby * i_IB,
        -asx * asy * i_IS - hbx * hby * i_IB,
        hby * i_IB,
        -sin_B * i_mB - hby * w * i_IB,
        i_mS + i_mB + asx * asx * i_IS + hbx * hbx * i_IB,
        -hbx * i_IB,
        cos_B * i_mB + hbx * w * i_IB,
        i_IB + i_IP,
        -w * i_IB,
        i_mB + i_mP + w * w * i_IB,
        -asy * a_S - a_Bx + hby * a_B - g1,
        asx * a_S - a_By - hbx * a_B - g2,
        a_B - a_P - g3,
        cos_B * (a_Py - a_By) - sin_B * (a_Px - a_Bx) - w * a_B - g4,
    )

    for place in range(12):
        out[place] = y[12 + place]
    out[12] = -r1 * i_mS
    out[13] = -r2 * i_mS
    out[14] = a_S + (asy * r1 - asx * r2) * i_IS
    out[15] = a_Bx + (r1 - sin_B * r4) * i_mB
    out[16] = a_By + (r2 + cos_B * r4) * i_mB
    out[17] = a_B - (hby * r1 - hbx * r2 + r3 - w * r4) * i_IB
    out[18] = a_Px + sin_B * r4 * i_mP
    out[19] = a_Py - cos_B * r4 * i_mP
    out[20] = a_P + r3 * i_IP
    out[21] = tx / p[at.MASS_T]
    out[22] = ty / p[at.MASS_T]
    out[23] = m_T / p[at.INERTIA_T]
    out[24] = m_tip / p[at.INERTIA_TIP]
    reactions[0] = r1
    reactions[1] = r2
    reactions[2] = r3
    reactions[3] = r4
