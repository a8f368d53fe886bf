"""What a solver has to watch for: touchdown, release, capture, escape and the top of each contact force, compiled.

Six numbers, each of which falls through zero when its event happens:

0, 1   lower, upper flank: the gap [m] of a flank that is free, minus the gap of one that presses
2, 3   distance [m] in front of the capture plane, before the escape plane
4, 5   rate [N/s] of the force of the lower, upper flank; 1 for a flank that is free

``context`` (38,) is all that a compiled function needs besides the state: the parameter vector, active flanks,
remembered approach speeds, joint reactions. It is one array because each array argument costs a call from Python 50 ns.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from . import parameters as at
from .contact import both_forces
from .force_slopes import gap_slope, normal_slope, tip_course
from .jacobian import jacobian_into
from .model import rhs_into
from .parameters import Matrix, Parameters, Vector, vector
from .start import STATES, start

EVENTS = 6
PARAMETERS = slice(0, 30)
ACTIVE = slice(30, 32)
MEMORY = slice(32, 34)
CONTEXT = 38
CAPTURE, ESCAPE, TOP = 2, 3, 4


def context_of(parameters: Parameters) -> tuple[Vector, Vector]:
    """State at t = 0 (25,) and the context (38,) to start with."""
    y, active, memory = start(parameters)
    context = np.zeros(CONTEXT)
    context[PARAMETERS] = vector(parameters)
    context[ACTIVE] = active
    context[MEMORY] = memory
    return y, context


@njit
def slope_into(y: Vector, out: Vector, context: Vector) -> None:
    """Write dy/dt (25,) into ``out``."""
    rhs_into(y, out, context[0:30], context[30:32], context[32:34], context[34:38])


@njit
def slope(y: Vector, context: Vector) -> Vector:
    """dy/dt (25,)."""
    out = np.empty(STATES)
    slope_into(y, out, context)
    return out


@njit
def slope_jacobian(y: Vector, context: Vector) -> Matrix:
    """d(dy/dt)/dy (25, 25)."""
    matrix = np.empty((STATES, STATES))
    jacobian_into(y, matrix, context[0:30], context[30:32], context[32:34], np.empty(STATES), np.empty(4))
    return matrix


@njit
def slope_jacobian_into(y: Vector, matrix: Matrix, context: Vector) -> None:
    """Write d(dy/dt)/dy into ``matrix`` (25, 25), in whatever order that lies."""
    matrix[:, :] = slope_jacobian(y, context)


@njit
def forces(y: Vector, context: Vector) -> tuple[float, float]:
    """Normal forces [N] of the lower and upper flank."""
    return both_forces(y, context[0:30], context[30:32], context[32:34])


@njit
def watch_along(y: Vector, flow: Vector, values: Vector, context: Vector) -> None:
    """Write the six watched numbers into ``values``, given dy/dt, the ``flow`` (25,); that counts for 4 and 5 alone."""
    p = context[0:30]
    motion, rates = tip_course(y, flow, p)
    for flank in range(2):
        now, change = gap_slope(1.0 - 2.0 * flank, motion, rates, p)
        gap, gap_rate = now[0] - p[at.RADIUS], now[5]
        if context[30 + flank] == 0.0:
            values[flank], values[TOP + flank] = gap, 1.0
            continue
        values[flank] = -gap
        if gap < 0.0:
            values[TOP + flank] = normal_slope(-gap, gap_rate, -change[0], change[5], context[32 + flank], p)[1]
        else:  # there is no force yet: it is about to rise where the gap closes
            values[TOP + flank] = -gap_rate
    values[CAPTURE] = -p[at.CONE_OFFSET] - p[at.RADIUS] * p[at.SINE] - motion[0]
    values[ESCAPE] = motion[0] + p[at.CONE_OFFSET] + 2.0 * p[at.CONE_LENGTH]


@njit
def watch(y: Vector, values: Vector, context: Vector) -> None:
    """Write the six watched numbers into ``values``."""
    flow = np.empty(STATES)
    if context[30] != 0.0 or context[31] != 0.0:
        slope_into(y, flow, context)
    watch_along(y, flow, values, context)


@njit
def crossings(y: Vector, before: Vector, now: Vector, context: Vector) -> int:
    """Watch at the end of a step: bit k of the result is set where number k fell through zero since ``before``."""
    watch(y, now, context)
    count = 0
    for event in range(EVENTS):
        if before[event] > 0.0 and now[event] <= 0.0:
            count |= 1 << event
    return count


@njit
def watched(y: Vector, event: int, context: Vector) -> float:
    """One of the six numbers, for a root finder."""
    values = np.empty(EVENTS)
    watch(y, values, context)
    return values[event]
