"""A step of Dormand and Prince's method of order 8, its error and its interpolant of order 7, compiled.

The tableau is SciPy's. Row 0 of the stages ``k`` (16 × 25) holds the slope at the step's start, row 12 that at its end.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from scipy.integrate._ivp import dop853_coefficients as tableau

from ..parameters import Matrix, Vector
from ..start import STATES
from ..watch import slope_into
from .sums import weighted

ORDER = 8
STAGES = tableau.N_STAGES
ROWS = tableau.N_STAGES_EXTENDED
TERMS = tableau.INTERPOLATOR_POWER
FAST = {"contract", "reassoc", "nsz"}


@njit
def workspace():
    """Room for the stages and one state, row after row: from one array of fixed rows a compiler makes vector code."""
    return np.zeros((ROWS + 1) * STATES)


def stage_of(number: int):
    """One compiled stage, worked out from those before it."""
    total, row = weighted(tableau.A[number]), number * STATES

    @njit(error_model="numpy", fastmath=FAST)
    def stage(y, h, context, k):
        for i in range(STATES):
            k[ROWS * STATES + i] = y[i] + h * total(k, i)
        slope_into(k[ROWS * STATES :], k[row : row + STATES], context)

    return stage


s2, s3, s4, s5, s6, s7, s8, s9, s10, s11, s12 = (stage_of(number) for number in range(1, STAGES))
extra_1, extra_2, extra_3 = (stage_of(number) for number in range(STAGES + 1, ROWS))
advance, fifth_error, third_error = weighted(tableau.B), weighted(tableau.E5), weighted(tableau.E3)
d3, d4, d5, d6 = (weighted(row) for row in tableau.D)


@njit(error_model="numpy", fastmath=FAST)
def step(y, slope, h, rtol, atol, anew, context, new, new_slope, k) -> float:
    """Write the state ``h`` [s] later and its slope into ``new`` and ``new_slope`` (25,); error over that allowed."""
    for i in range(STATES):
        k[i] = slope[i]
    s2(y, h, context, k)
    s3(y, h, context, k)
    s4(y, h, context, k)
    s5(y, h, context, k)
    s6(y, h, context, k)
    s7(y, h, context, k)
    s8(y, h, context, k)
    s9(y, h, context, k)
    s10(y, h, context, k)
    s11(y, h, context, k)
    s12(y, h, context, k)
    for i in range(STATES):
        new[i] = y[i] + h * advance(k, i)
    slope_into(new, new_slope, context)
    for i in range(STATES):
        k[STAGES * STATES + i] = new_slope[i]
    fifth, third = 0.0, 0.0
    for i in range(STATES):
        allowed = 1.0 / (atol[i] + rtol * max(abs(y[i]), abs(new[i])))
        five = fifth_error(k, i) * allowed
        three = third_error(k, i) * allowed
        fifth += five * five
        third += three * three
    if fifth == 0.0:
        return 0.0
    return h * fifth / math.sqrt((fifth + 0.01 * third) * STATES)


@njit(error_model="numpy", fastmath=FAST)
def interpolant(y, h, new, context, terms, k) -> None:
    """Write what `at` needs of the step just taken into ``terms`` (7, 25)."""
    extra_1(y, h, context, k)
    extra_2(y, h, context, k)
    extra_3(y, h, context, k)
    for i in range(STATES):
        rise = new[i] - y[i]
        terms[0, i] = rise
        terms[1, i] = h * k[i] - rise
        terms[2, i] = 2.0 * rise - h * (k[STAGES * STATES + i] + k[i])
        terms[3, i] = h * d3(k, i)
        terms[4, i] = h * d4(k, i)
        terms[5, i] = h * d5(k, i)
        terms[6, i] = h * d6(k, i)


@njit
def at(x: float, y: Vector, new: Vector, terms: Matrix, out: Vector) -> None:
    """Write the state at the fraction ``x`` of the step into ``out``."""
    for i in range(STATES):
        total = 0.0
        for row in range(TERMS - 1, -1, -1):
            total = (total + terms[row, i]) * (x if row % 2 == 0 else 1.0 - x)
        out[i] = y[i] + total
