"""A step of Dormand and Prince's method of order 8, its error and its interpolant of order 7, compiled for a model.

The tableau is SciPy's. Row 0 of the stages ``k`` (16 rows) holds the slope at the step's start, row 12 that at its end.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate._ivp import dop853_coefficients as tableau

from ..parameters import Matrix, Vector
from .method import Method
from .sums import weighted

ORDER = 8
STAGES = tableau.N_STAGES
ROWS = tableau.N_STAGES_EXTENDED
TERMS = tableau.INTERPOLATOR_POWER
FAST = {"contract", "reassoc", "nsz"}


def dop853_of(states: int, slope_into: Any) -> Method:
    """The method for a model of so many ``states``, whose slope ``slope_into(y, out, context)`` writes."""
    room = (ROWS + 1) * states

    @njit
    def workspace():
        # Row after row, of one array of fixed rows a compiler makes vector code; the last is room for one state.
        return np.zeros(room)

    return Method(
        order=ORDER,
        stages=STAGES,
        terms=TERMS,
        workspace=workspace,
        step=_step_of(states, slope_into),
        interpolant=_interpolant_of(states, slope_into),
        at=_at_of(states),
    )


def _stage_of(states: int, slope_into: Any, number: int):
    """One compiled stage, worked out from those before it."""
    total, row, trial = weighted(tableau.A[number], states), number * states, ROWS * states

    @njit(error_model="numpy", fastmath=FAST)
    def stage(y, h, context, k):
        for i in range(states):
            k[trial + i] = y[i] + h * total(k, i)
        slope_into(k[trial:], k[row : row + states], context)

    return stage


def _step_of(states: int, slope_into: Any):
    """A compiled step."""
    s2, s3, s4, s5, s6, s7, s8, s9, s10, s11, s12 = (
        _stage_of(states, slope_into, number) for number in range(1, STAGES)
    )
    advance, fifth_error, third_error = (weighted(row, states) for row in (tableau.B, tableau.E5, tableau.E3))

    @njit(error_model="numpy", fastmath=FAST)
    def step(y, slope, h, rtol, atol, anew, context, new, new_slope, k) -> float:
        """Write the state ``h`` [s] later and its slope into ``new`` and ``new_slope``; error over that allowed."""
        for i in range(states):
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
        for i in range(states):
            new[i] = y[i] + h * advance(k, i)
        slope_into(new, new_slope, context)
        for i in range(states):
            k[STAGES * states + i] = new_slope[i]
        fifth, third = 0.0, 0.0
        for i in range(states):
            allowed = 1.0 / (atol[i] + rtol * max(abs(y[i]), abs(new[i])))
            five = fifth_error(k, i) * allowed
            three = third_error(k, i) * allowed
            fifth += five * five
            third += three * three
        if fifth == 0.0:
            return 0.0
        return h * fifth / math.sqrt((fifth + 0.01 * third) * states)

    return step


def _interpolant_of(states: int, slope_into: Any):
    """What writes an interpolant's terms."""
    extra_1, extra_2, extra_3 = (_stage_of(states, slope_into, number) for number in range(STAGES + 1, ROWS))
    d3, d4, d5, d6 = (weighted(row, states) for row in tableau.D)

    @njit(error_model="numpy", fastmath=FAST)
    def interpolant(y, h, new, context, terms, k) -> None:
        """Write what `at` needs of the step just taken into ``terms`` (7, states)."""
        extra_1(y, h, context, k)
        extra_2(y, h, context, k)
        extra_3(y, h, context, k)
        for i in range(states):
            rise = new[i] - y[i]
            terms[0, i] = rise
            terms[1, i] = h * k[i] - rise
            terms[2, i] = 2.0 * rise - h * (k[STAGES * states + i] + k[i])
            terms[3, i] = h * d3(k, i)
            terms[4, i] = h * d4(k, i)
            terms[5, i] = h * d5(k, i)
            terms[6, i] = h * d6(k, i)

    return interpolant


def _at_of(states: int):
    """What evaluates an interpolant."""

    @njit
    def at(x: float, y: Vector, new: Vector, terms: Matrix, out: Vector) -> None:
        """Write the state at the fraction ``x`` of the step into ``out``."""
        for i in range(states):
            total = 0.0
            for row in range(TERMS - 1, -1, -1):
                total = (total + terms[row, i]) * (x if row % 2 == 0 else 1.0 - x)
            out[i] = y[i] + total

    return at
