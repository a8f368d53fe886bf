"""The Jacobian d(dy/dt)/dy of `model.rhs_into`, written out by hand and compiled.

With M a = F - Phi_q^T lambda and Phi_q a = gamma (M16 of docs/model.md), accelerations change with the state
by M da = dF - d(Phi_q^T) lambda - Phi_q^T dlambda, and Phi_q da = dgamma - d(Phi_q) a.
"""

from __future__ import annotations

import math

from numba import njit

from . import parameters as at
from .contact import SPIN, tip_motion
from .force_slopes import FAST, buffer_columns, contact_columns, twist_columns
from .forces import flank_load
from .model import joints, rhs_into, solve_four
from .parameters import Matrix, Vector
from .start import STATES

FORCES = 12  # first row of the accelerations


@njit(fastmath=FAST)
def force_columns(y: Vector, matrix: Matrix, p: Vector, active: Vector, memory: Vector) -> None:
    """Add d(generalised force)/dy to the rows 12 to 24."""
    cos_B = math.cos(y[5])
    sin_B = math.sin(y[5])
    cos_P = math.cos(y[8])
    sin_P = math.sin(y[8])
    twist_columns(matrix, p)
    buffer_columns(matrix, y, p, cos_B, sin_B, cos_P, sin_P)
    for flank in range(2):
        if active[flank] != 0.0:
            x, z, u, v = tip_motion(y, p, cos_P, sin_P, math.cos(y[11]), math.sin(y[11]))
            spin = y[SPIN] if p[at.ROLLING] != 0.0 else y[20]
            sigma = 1.0 - 2.0 * flank
            fx, fy, _, _ = flank_load(sigma, x, z, u, v, spin, y[23], memory[flank], p)
            contact_columns(matrix, y, p, sigma, memory[flank], (fx, fy), cos_P, sin_P)


@njit(fastmath=FAST)
def joint_columns(y: Vector, matrix: Matrix, p: Vector, slope: Vector, reactions: Vector) -> None:
    """Add -d(Phi_q^T) lambda to the rows 12 to 24, and d(gamma - Phi_q a) to the rows 0 to 3.

    ``slope`` holds dy/dt (25,), ``reactions`` the multipliers (4,) [N, N, N m, N].
    """
    cos_B = math.cos(y[5])
    sin_B = math.sin(y[5])
    w, asx, asy, hbx, hby, _, _, _, _ = joints(y, p, math.cos(y[2]), math.sin(y[2]), cos_B, sin_B)
    spin_S, spin_B, a_S, a_B = y[14], y[17], slope[14], slope[17]
    vx, vy = y[18] - y[15], y[19] - y[16]
    offset = cos_B * (y[7] - y[4]) - sin_B * (y[6] - y[3])
    along, across = cos_B * vx + sin_B * vy, cos_B * vy - sin_B * vx
    two, square = 2.0 * p[at.GAIN], p[at.GAIN] * p[at.GAIN]
    r1, r2, r4 = reactions[0], reactions[1], reactions[3]

    matrix[14, 2] += asx * r1 + asy * r2
    matrix[15, 5] -= cos_B * r4
    matrix[16, 5] -= sin_B * r4
    matrix[17, 5] += offset * r4 - hbx * r1 - hby * r2
    matrix[18, 5] += cos_B * r4
    matrix[19, 5] += sin_B * r4

    matrix[0, 0], matrix[0, 3], matrix[0, 12], matrix[0, 15] = -square, square, -two, two
    matrix[0, 2] = asy * (square - spin_S * spin_S) + asx * (two * spin_S + a_S)
    matrix[0, 5] = hby * (spin_B * spin_B - square) - hbx * (two * spin_B + a_B)
    matrix[0, 14] = 2.0 * asx * spin_S + two * asy
    matrix[0, 17] = -2.0 * hbx * spin_B - two * hby

    matrix[1, 1], matrix[1, 4], matrix[1, 13], matrix[1, 16] = -square, square, -two, two
    matrix[1, 2] = asx * (spin_S * spin_S - square) + asy * (two * spin_S + a_S)
    matrix[1, 5] = hbx * (square - spin_B * spin_B) - hby * (two * spin_B + a_B)
    matrix[1, 14] = 2.0 * asy * spin_S - two * asx
    matrix[1, 17] = two * hbx - 2.0 * hby * spin_B

    matrix[2, 5], matrix[2, 8], matrix[2, 17], matrix[2, 20] = -square, square, -two, two

    pull = slope[18] - slope[15]
    push = slope[19] - slope[16]
    # along the rod's and across it: how the fourth joint's distance and arm w change with P's place against B's
    by_offset, by_arm = spin_B * spin_B - square, two * spin_B + a_B
    by_x, by_y = cos_B * by_arm - sin_B * by_offset, sin_B * by_arm + cos_B * by_offset
    matrix[3, 5] = 2.0 * spin_B * across - by_offset * w + two * along + offset * by_arm + cos_B * pull + sin_B * push
    for column, sign in ((3, -1.0), (6, 1.0)):
        matrix[3, column] = sign * by_x
        matrix[3, column + 1] = sign * by_y
    for column, sign in ((15, -1.0), (18, 1.0)):
        matrix[3, column] = sign * (2.0 * spin_B * cos_B + two * sin_B)
        matrix[3, column + 1] = sign * (2.0 * spin_B * sin_B - two * cos_B)
    matrix[3, 17] = 2.0 * (along + spin_B * offset) + two * w
    for column in (3, 4, 6, 7):  # the moment w lambda_4 on B
        matrix[17, column] += r4 * (cos_B if column % 3 == 0 else sin_B) * (-1.0 if column < 5 else 1.0)


@njit(fastmath=FAST)
def accelerations(y: Vector, rows: Vector, p: Vector) -> None:
    """Replace forces in the rows 12 to 24 and what the joints lack in the rows 0 to 3 by accelerations.

    ``rows`` is the matrix, row after row: with rows of a fixed length a compiler makes vector code of the loop.
    """
    cos_B = math.cos(y[5])
    sin_B = math.sin(y[5])
    w, asx, asy, hbx, hby, _, _, _, _ = joints(y, p, math.cos(y[2]), math.sin(y[2]), cos_B, sin_B)
    i_mS, i_IS = 1.0 / p[at.MASS_S], 1.0 / p[at.INERTIA_S]
    i_mB, i_IB = 1.0 / p[at.MASS_B], 1.0 / p[at.INERTIA_B]
    i_mP, i_IP = 1.0 / p[at.MASS_P], 1.0 / p[at.INERTIA_P]
    i_mT, i_IT, i_tip = 1.0 / p[at.MASS_T], 1.0 / p[at.INERTIA_T], 1.0 / p[at.INERTIA_TIP]
    for j in range(STATES):
        a_S = rows[14 * STATES + j] * i_IS
        a_Bx = rows[15 * STATES + j] * i_mB
        a_By = rows[16 * STATES + j] * i_mB
        a_B = rows[17 * STATES + j] * i_IB
        a_Px = rows[18 * STATES + j] * i_mP
        a_Py = rows[19 * STATES + j] * i_mP
        a_P = rows[20 * STATES + j] * i_IP
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
            -asy * a_S - a_Bx + hby * a_B - rows[j],
            asx * a_S - a_By - hbx * a_B - rows[1 * STATES + j],
            a_B - a_P - rows[2 * STATES + j],
            cos_B * (a_Py - a_By) - sin_B * (a_Px - a_Bx) - w * a_B - rows[3 * STATES + j],
        )
        rows[12 * STATES + j] = -r1 * i_mS
        rows[13 * STATES + j] = -r2 * i_mS
        rows[14 * STATES + j] = a_S + (asy * r1 - asx * r2) * i_IS
        rows[15 * STATES + j] = a_Bx + (r1 - sin_B * r4) * i_mB
        rows[16 * STATES + j] = a_By + (r2 + cos_B * r4) * i_mB
        rows[17 * STATES + j] = a_B - (hby * r1 - hbx * r2 + r3 - w * r4) * i_IB
        rows[18 * STATES + j] = a_Px + sin_B * r4 * i_mP
        rows[19 * STATES + j] = a_Py - cos_B * r4 * i_mP
        rows[20 * STATES + j] = a_P + r3 * i_IP
        rows[21 * STATES + j] *= i_mT
        rows[22 * STATES + j] *= i_mT
        rows[23 * STATES + j] *= i_IT
        rows[24 * STATES + j] *= i_tip


@njit
def jacobian_into(
    y: Vector, matrix: Matrix, p: Vector, active: Vector, memory: Vector, slope: Vector, reactions: Vector
) -> None:
    """Write d(dy/dt)/dy (25, 25) into ``matrix``; ``slope`` (25,) and ``reactions`` (4,) are overwritten."""
    rhs_into(y, slope, p, active, memory, reactions)
    matrix[:, :] = 0.0
    force_columns(y, matrix, p, active, memory)
    joint_columns(y, matrix, p, slope, reactions)
    accelerations(y, matrix.reshape(STATES * STATES), p)
    matrix[0:FORCES, :] = 0.0
    for place in range(12):
        matrix[place, 12 + place] = 1.0
