"""A step of the Rosenbrock method RODAS of order 4 with its error and its interpolant of order 3, compiled.

Coefficients: Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.7. Positions follow from
velocities, so that a 13 x 13 matrix serves where a user who does not look closer factorises one of 25 x 25.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ..jacobian import jacobian_into
from ..parameters import Matrix, Vector
from ..start import STATES
from ..watch import slope_into
from .method import Method
from .sums import weighted

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
WIDE = 16  # numbers in a row of a matrix of 13 columns: two or four vector registers
FAST = {"contract", "reassoc", "nsz", "arcp"}


@njit
def workspace():
    """Room for the stages and one state (7 x 25), the Jacobian and its rates' rows turned (25 x 16), the inverse
    (14 x 16), what positions add (12 x 16), a slope, reactions and three rows."""
    stages, jacobian, turned = np.zeros((STAGES + 1) * STATES), np.zeros((STATES, STATES)), np.zeros(STATES * WIDE)
    inverse, through = np.zeros((RATES + 1) * WIDE), np.zeros(POSITIONS * WIDE)
    rows = (np.zeros(WIDE), np.zeros(WIDE), np.zeros(RATES, np.int64))
    return stages, jacobian, turned, inverse, through, np.zeros(STATES), np.zeros(4), rows


@njit(error_model="numpy", fastmath=FAST)
def eliminate(matrix, shares) -> None:
    """Take ``shares`` (13,) of the row that follows the 13 of ``matrix`` from them."""
    for j in range(WIDE):
        for row in range(RATES):
            matrix[row * WIDE + j] -= shares[row] * matrix[RATES * WIDE + j]


@njit(error_model="numpy", fastmath=FAST)
def invert(matrix, shares, exchanged) -> None:
    """Invert the 13 x 13 matrix in the first rows of ``matrix`` (14 x 16) in place: Gauss and Jordan, rows exchanged.

    Rows are updated as a whole, so that the loops are of fixed length. Six solutions by an inverse are quicker than
    six by factors, whose every line waits for the one before.
    """
    pivot = RATES * WIDE
    for place in range(RATES):
        for row in range(RATES):
            shares[row] = matrix[row * WIDE + place]
            matrix[row * WIDE + place] = 0.0
        best, largest = place, abs(shares[place])
        for row in range(place + 1, RATES):
            if abs(shares[row]) > largest:
                best, largest = row, abs(shares[row])
        exchanged[place] = best
        inverse = 1.0 / shares[best]
        for j in range(WIDE):
            matrix[pivot + j] = matrix[best * WIDE + j] * inverse
        matrix[pivot + place] = inverse
        if best != place:
            shares[best] = shares[place]
            for j in range(WIDE):
                matrix[best * WIDE + j] = matrix[place * WIDE + j]
        eliminate(matrix, shares)
        for j in range(WIDE):
            matrix[place * WIDE + j] = matrix[pivot + j]
    for place in range(RATES - 1, -1, -1):
        best = exchanged[place]
        if best != place:
            for row in range(RATES):
                one, other = matrix[row * WIDE + place], matrix[row * WIDE + best]
                matrix[row * WIDE + place], matrix[row * WIDE + best] = other, one


@njit(error_model="numpy", fastmath=FAST)
def turn(jacobian: Matrix, turned: Vector) -> None:
    """The rates' rows of the Jacobian as columns."""
    for j in range(STATES):
        for i in range(RATES):
            turned[j * WIDE + i] = jacobian[POSITIONS + i, j]


@njit(error_model="numpy", fastmath=FAST)
def prepare(h: float, work) -> None:
    """The inverse of I/g - J_v - g J_q from the Jacobian, turned as that is."""
    _, _, turned, inverse, through, _, _, rows = work
    g = GAMMA * h
    for i in range(POSITIONS * WIDE):
        through[i] = g * turned[i]
    for i in range(POSITIONS * WIDE):
        inverse[i] = -turned[POSITIONS * WIDE + i] - through[i]
    for i in range(POSITIONS * WIDE, RATES * WIDE):
        inverse[i] = -turned[POSITIONS * WIDE + i]
    for i in range(RATES):
        inverse[i * WIDE + i] += 1.0 / g
    invert(inverse, rows[0], rows[2])


@njit(error_model="numpy", fastmath=FAST)
def solve(u: Vector, g: float, work) -> None:
    """Replace the right-hand side ``u`` (25,) by the solution of (I/g - J) u = r."""
    _, _, _, inverse, through, _, _, rows = work
    right, pivot, _ = rows
    for i in range(RATES):
        right[i] = u[POSITIONS + i]
    for i in range(WIDE):
        total = right[i]
        for j in range(POSITIONS):
            total += u[j] * through[j * WIDE + i]
        right[i] = total
    for i in range(WIDE):
        total = 0.0
        for j in range(RATES):
            total += right[j] * inverse[j * WIDE + i]
        pivot[i] = total
    for i in range(RATES):
        u[POSITIONS + i] = pivot[i]
    for i in range(POSITIONS):
        u[i] = g * (u[i] + pivot[i])


def stage_of(number: int):
    """One compiled stage, worked out from those before it."""
    point_of, drift_of = weighted(A[number], STATES), weighted(C[number], STATES)
    row, place = number * STATES, STAGES * STATES

    @njit(error_model="numpy", fastmath=FAST)
    def stage(y, h, context, work):
        u = work[0]
        for i in range(STATES):
            u[place + i] = y[i] + point_of(u, i)
        slope_into(u[place:], u[row : row + STATES], context)
        inverse = 1.0 / h
        for i in range(STATES):
            u[row + i] += inverse * drift_of(u, i)
        solve(u[row : row + STATES], GAMMA * h, work)

    return stage


second, third, fourth, fifth, sixth = (stage_of(number) for number in range(1, STAGES))
dense_1, dense_2 = (weighted(row, STATES) for row in D)


@njit(error_model="numpy", fastmath=FAST)
def step(y, slope, h, rtol, atol, anew, context, new, new_slope, work) -> float:
    """Write the state ``h`` [s] later and its slope into ``new`` and ``new_slope`` (25,); error over what is allowed.

    ``anew``: whether the Jacobian at ``y`` is still to be found.
    """
    u, jacobian, turned, _, _, base, reactions, _ = work
    if anew:
        jacobian_into(y, jacobian, context[0:30], context[30:32], context[32:34], base, reactions)
        turn(jacobian, turned)
    prepare(h, work)
    for i in range(STATES):
        u[i] = slope[i]
    solve(u[0:STATES], GAMMA * h, work)
    second(y, h, context, work)
    third(y, h, context, work)
    fourth(y, h, context, work)
    fifth(y, h, context, work)
    sixth(y, h, context, work)
    total = 0.0
    for i in range(STATES):
        last = u[(STAGES - 1) * STATES + i]
        new[i] = u[STAGES * STATES + i] + last
        off = last / (atol[i] + rtol * max(abs(y[i]), abs(new[i])))
        total += off * off
    slope_into(new, new_slope, context)
    return math.sqrt(total / STATES)


@njit(error_model="numpy", fastmath=FAST)
def interpolant(y, h, new, context, terms, work) -> None:
    """Write what `at` needs of the step just taken into ``terms`` (2, 25)."""
    u = work[0]
    for i in range(STATES):
        terms[0, i] = dense_1(u, i)
        terms[1, i] = dense_2(u, i)


@njit
def at(x: float, y: Vector, new: Vector, terms: Matrix, out: Vector) -> None:
    """Write the state at the fraction ``x`` of the step into ``out``."""
    for i in range(STATES):
        out[i] = (1.0 - x) * y[i] + x * (new[i] + (1.0 - x) * (terms[0, i] + x * terms[1, i]))


RODAS4 = Method(order=ORDER, stages=STAGES, terms=TERMS, workspace=workspace, step=step, interpolant=interpolant, at=at)
