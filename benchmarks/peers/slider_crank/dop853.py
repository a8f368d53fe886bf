"""One step of Dormand and Prince's eighth-order method with its controller, compiled; SciPy's tableau."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate._ivp import dop853_coefficients as tableau

from .compiled import njit
from .model import STATES, Matrix, Vector, evaluate
from .parameters import SliderCrank

STAGES = tableau.N_STAGES
A = np.ascontiguousarray(tableau.A[:STAGES, :STAGES])
B = np.ascontiguousarray(tableau.B)
E3 = np.ascontiguousarray(tableau.E3)
E5 = np.ascontiguousarray(tableau.E5)
# What counts as small: of angles [rad], lengths [m], their rates. A contact is 1e-5 m deep in a mechanism of 0.1 m.
SCALE = np.array([1e-3, 1e-3, 1e-4, 1e-4, 1e-4, 10.0, 10.0, 1.0, 1.0, 1.0])


@njit
def step(y: Vector, h: float, modes: Vector, memory: Vector, p: SliderCrank, k: Matrix, joints: Matrix) -> Vector:
    """The state a time ``h`` [s] later; ``k`` (13, 10) holds the slope at ``y`` in row 0 and gets the other stages.

    ``joints`` becomes that of the new state, whose slope lands in the last row of ``k``.
    """
    trial = np.empty(STATES)
    for stage in range(1, STAGES):
        for i in range(STATES):
            total = 0.0
            for j in range(stage):
                total += A[stage, j] * k[j, i]
            trial[i] = y[i] + h * total
        evaluate(trial, modes, memory, p, k[stage], joints)
    new = np.empty(STATES)
    for i in range(STATES):
        total = 0.0
        for j in range(STAGES):
            total += B[j] * k[j, i]
        new[i] = y[i] + h * total
    evaluate(new, modes, memory, p, k[STAGES], joints)
    return new


@njit
def error(h: float, k: Matrix, rtol: float) -> float:
    """The step's error over what ``rtol`` allows of `SCALE`."""
    fifth, third = 0.0, 0.0
    for i in range(STATES):
        five, three = 0.0, 0.0
        for j in range(STAGES + 1):
            five += E5[j] * k[j, i]
            three += E3[j] * k[j, i]
        fifth += (five / (rtol * SCALE[i])) ** 2
        third += (three / (rtol * SCALE[i])) ** 2
    if fifth == 0.0:
        return 0.0
    return abs(h) * fifth / math.sqrt((fifth + 0.01 * third) * STATES)


@njit
def factor(off: float, rejected: bool) -> float:
    """The next step over this one."""
    if off == 0.0:
        return 10.0
    most = 1.0 if rejected or off >= 1.0 else 10.0
    return min(most, max(0.2, 0.9 * off ** (-1.0 / 8.0)))
