"""A step of the Rosenbrock method RODAS of order 4 with its error and its interpolant of order 3, compiled.

Coefficients: Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.7. Positions follow from
velocities, so that a 13 x 13 matrix serves where a user who does not look closer factorises one of 25 x 25.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ..parameters import Matrix, Vector
from ..start import STATES
from ..watch import slope_into, slope_jacobian_into

ORDER = 4
GAMMA = 0.25
STAGES = 6
POSITIONS = 12
RATES = STATES - POSITIONS
A = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [1.544, 0.0, 0.0, 0.0, 0.0],
        [0.9466785280815826, 0.2557011698983284, 0.0, 0.0, 0.0],
        [3.314825187068521, 2.896124015972201, 0.9986419139977817, 0.0, 0.0],
        [1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 0.0],
        [1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0],
    ]
)
C = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [-5.6688, 0.0, 0.0, 0.0, 0.0],
        [-2.430093356833875, -0.2063599157091915, 0.0, 0.0, 0.0],
        [-0.1073529058151375, -9.594562251023355, -20.47028614809616, 0.0, 0.0],
        [7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160, 0.0],
        [8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054],
    ]
)
D = np.array(
    [
        [10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823, 1.025137723295662],
        [-0.6762803392806898, 6.087714651680015, 16.43084320892478, 24.76722511418386, -6.594389125716872],
    ]
)
TERMS = 2


@njit
def workspace():
    """Room for the stages, the Jacobian, its factors, pivots and one state."""
    square = np.zeros((RATES, RATES))
    return np.zeros((STAGES, STATES)), np.zeros((STATES, STATES)), square, np.zeros(RATES, np.int64), np.zeros(STATES)


@njit(error_model="numpy")
def factorise(matrix: Matrix, pivots) -> None:
    """Gaussian elimination in place, rows exchanged."""
    for column in range(RATES):
        best = column
        for row in range(column + 1, RATES):
            if abs(matrix[row, column]) > abs(matrix[best, column]):
                best = row
        pivots[column] = best
        if best != column:
            for j in range(RATES):
                matrix[column, j], matrix[best, j] = matrix[best, j], matrix[column, j]
        inverse = 1.0 / matrix[column, column]
        for row in range(column + 1, RATES):
            share = matrix[row, column] * inverse
            matrix[row, column] = share
            for j in range(column + 1, RATES):
                matrix[row, j] -= share * matrix[column, j]
        matrix[column, column] = inverse


@njit(error_model="numpy")
def solve(r: Vector, g: float, work) -> None:
    """Replace ``r`` (25,) by the solution u of (I/g - J) u = r."""
    _, jacobian, factors, pivots, _ = work
    b = r[POSITIONS:]
    for i in range(RATES):
        total = 0.0
        for j in range(POSITIONS):
            total += jacobian[POSITIONS + i, j] * r[j]
        b[i] += g * total
    for i in range(RATES):
        best = pivots[i]
        b[i], b[best] = b[best], b[i]
    for i in range(1, RATES):
        total = 0.0
        for j in range(i):
            total += factors[i, j] * b[j]
        b[i] -= total
    for i in range(RATES - 1, -1, -1):
        total = 0.0
        for j in range(i + 1, RATES):
            total += factors[i, j] * b[j]
        b[i] = (b[i] - total) * factors[i, i]
    for i in range(POSITIONS):
        r[i] = g * (r[i] + b[i])


@njit(error_model="numpy", fastmath={"contract", "reassoc"})
def step(y, slope, h, rtol, atol, anew, context, new, new_slope, work) -> float:
    """Write the state ``h`` [s] later and its slope into ``new`` and ``new_slope`` (25,); error over what is allowed.

    ``anew``: whether the Jacobian at ``y`` is still to be found.
    """
    u, jacobian, factors, pivots, point = work
    g = GAMMA * h
    if anew:
        slope_jacobian_into(y, jacobian, context)
    for i in range(RATES):
        for j in range(RATES):
            own = 1.0 / g if i == j else 0.0
            through = g * jacobian[POSITIONS + i, j] if j < POSITIONS else 0.0
            factors[i, j] = own - jacobian[POSITIONS + i, POSITIONS + j] - through
    factorise(factors, pivots)
    for number in range(STAGES):
        point[:] = y
        for j in range(number):
            for i in range(STATES):
                point[i] += A[number, j] * u[j, i]
        if number == 0:
            u[0, :] = slope
        else:
            slope_into(point, u[number], context)
        for j in range(number):
            share = C[number, j] / h
            for i in range(STATES):
                u[number, i] += share * u[j, i]
        solve(u[number], g, work)
    total = 0.0
    for i in range(STATES):
        new[i] = point[i] + u[STAGES - 1, i]
        total += (u[STAGES - 1, i] / (atol[i] + rtol * max(abs(y[i]), abs(new[i])))) ** 2
    slope_into(new, new_slope, context)
    return math.sqrt(total / STATES)


@njit
def interpolant(y, h, new, context, terms, work) -> None:
    """Write what `at` needs of the step just taken into ``terms`` (2, 25)."""
    u = work[0]
    for row in range(TERMS):
        for i in range(STATES):
            total = 0.0
            for j in range(STAGES - 1):
                total += D[row, j] * u[j, i]
            terms[row, i] = total


@njit
def at(x: float, y: Vector, new: Vector, terms: Matrix, out: Vector) -> None:
    """Write the state at the fraction ``x`` of the step into ``out``."""
    for i in range(STATES):
        out[i] = (1.0 - x) * y[i] + x * (new[i] + (1.0 - x) * (terms[0, i] + x * terms[1, i]))
