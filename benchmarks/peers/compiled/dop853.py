"""A step of Dormand and Prince's method of order 8, its error and its interpolant of order 7, compiled.

The tableau is SciPy's. Row 0 of the stages ``k`` (16, 25) holds the slope at the step's start, row 12 that at its end.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from scipy.integrate._ivp import dop853_coefficients as tableau

from ..parameters import Matrix, Vector
from ..start import STATES
from ..watch import slope_into

ORDER = 8
STAGES = tableau.N_STAGES
ROWS = tableau.N_STAGES_EXTENDED
TERMS = tableau.INTERPOLATOR_POWER
A = np.ascontiguousarray(tableau.A)
B = np.ascontiguousarray(tableau.B)
E3 = np.ascontiguousarray(tableau.E3)
E5 = np.ascontiguousarray(tableau.E5)
D = np.ascontiguousarray(tableau.D)


@njit
def workspace():
    """Room for the stages and one state."""
    return np.zeros((ROWS, STATES)), np.zeros(STATES)


@njit(error_model="numpy", fastmath={"contract", "reassoc"})
def stage(number: int, y: Vector, h: float, context: Vector, work) -> None:
    """Evaluate one stage from those before it."""
    k, point = work
    for i in range(STATES):
        point[i] = y[i]
    for j in range(number):
        share = h * A[number, j]
        if share != 0.0:
            for i in range(STATES):
                point[i] += share * k[j, i]
    slope_into(point, k[number], context)


@njit(error_model="numpy", fastmath={"contract", "reassoc"})
def step(y, slope, h, rtol, atol, anew, context, new, new_slope, work) -> float:
    """Write the state ``h`` [s] later and its slope into ``new`` and ``new_slope`` (25,); error over what is allowed."""
    k, _ = work
    k[0, :] = slope
    for number in range(1, STAGES):
        stage(number, y, h, context, work)
    new[:] = y
    for j in range(STAGES):
        share = h * B[j]
        if share != 0.0:
            for i in range(STATES):
                new[i] += share * k[j, i]
    slope_into(new, new_slope, context)
    k[STAGES, :] = new_slope
    fifth, third = 0.0, 0.0
    for i in range(STATES):
        five, three = 0.0, 0.0
        for j in range(STAGES + 1):
            five += E5[j] * k[j, i]
            three += E3[j] * k[j, i]
        allowed = 1.0 / (atol[i] + rtol * max(abs(y[i]), abs(new[i])))
        fifth += (five * allowed) ** 2
        third += (three * allowed) ** 2
    if fifth == 0.0:
        return 0.0
    return h * fifth / math.sqrt((fifth + 0.01 * third) * STATES)


@njit(error_model="numpy")
def interpolant(y, h, new, context, terms, work) -> None:
    """Write what `at` needs of the step just taken into ``terms`` (7, 25)."""
    k, _ = work
    for number in range(STAGES + 1, ROWS):
        stage(number, y, h, context, work)
    for i in range(STATES):
        rise = new[i] - y[i]
        terms[0, i] = rise
        terms[1, i] = h * k[0, i] - rise
        terms[2, i] = 2.0 * rise - h * (k[STAGES, i] + k[0, i])
        for row in range(TERMS - 3):
            total = 0.0
            for j in range(ROWS):
                total += D[row, j] * k[j, i]
            terms[3 + row, i] = h * total


@njit
def at(x: float, y: Vector, new: Vector, terms: Matrix, out: Vector) -> None:
    """Write the state at the fraction ``x`` of the step into ``out``."""
    for i in range(STATES):
        total = 0.0
        for row in range(TERMS - 1, -1, -1):
            total = (total + terms[row, i]) * (x if row % 2 == 0 else 1.0 - x)
        out[i] = y[i] + total
