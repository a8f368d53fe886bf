"""What is watched: the gap, the capture and escape planes, the rate of the force, as `compiled.method` says.

``context`` (34,): the parameter vector, whether the cone presses, and the approach speed that it remembers.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ..parameters import Vector
from . import parameters as at
from .chain import (
    ALPHA_RATE,
    BETA_RATE,
    EXTENT_RATE,
    MOVES_S,
    MOVES_T,
    SPIN_S,
    SPIN_T,
    bending,
    directions,
    places,
    triple,
    turning,
)
from .contact import foot_of, gap_and_rate, meridian, normal_force, relative
from .model import rhs_into
from .parameters import COUNT, Parameters, vector
from .start import start
from .vectors import cross, inside, minus, plus, times

ACTIVE, MEMORY = COUNT, COUNT + 1
CONTEXT = COUNT + 2


def context_of(parameters: Parameters) -> tuple[Vector, Vector]:
    """State at t = 0 (35,) and the context (34,) to start with."""
    p = vector(parameters)
    y, context = start(parameters, p), np.zeros(CONTEXT)
    context[:COUNT], context[MEMORY] = p, 1.0
    if parameters.start == "contact":
        context[ACTIVE], context[MEMORY] = 1.0, max(approach(0, y, context), 1e-5)
    return y, context


@njit
def slope_into(y: Vector, out: Vector, context: Vector) -> None:
    """Write dy/dt (35,) into ``out``."""
    rhs_into(y, out, context[0:COUNT], context[ACTIVE], context[MEMORY])


@njit(inline="always")
def approach(_contact: int, y: Vector, context: Vector) -> float:
    """How fast the gap closes [m/s]."""
    p = context[0:COUNT]
    _, place, moves, _, _ = relative(y, p)
    return -gap_and_rate(place, moves, p)[1]


@njit
def forces(y: Vector, context: Vector) -> tuple[float]:
    """The normal force of the cone [N]."""
    if context[ACTIVE] == 0.0:
        return (0.0,)
    p = context[0:COUNT]
    _, place, moves, _, _ = relative(y, p)
    gap, rate = gap_and_rate(place, moves, p)
    return (normal_force(gap, rate, context[MEMORY], p),)


@njit(inline="always")
def tip_acceleration(y, flow, p, axes, place, moves, turn):
    """The tip's acceleration in the turning axes of T, as seen there [m/s²], given dy/dt, the ``flow``."""
    hinge, _, second, third, along = directions(y, p)
    spin, spin_B, bias = turning(y, second, third)
    at_hinge, a_metre, sliding = bending(spin, spin_B, bias, hinge, along, y[EXTENT_RATE])
    faster = triple(flow, SPIN_S)
    turned = plus(faster, plus(times(flow[ALPHA_RATE], second), times(flow[BETA_RATE], third)))
    tip = plus(triple(flow, MOVES_S), plus(cross(faster, hinge), at_hinge))
    tip = plus(tip, times(places(y, p)[2], plus(cross(turned, along), a_metre)))
    tip = plus(tip, plus(times(flow[EXTENT_RATE], along), sliding))
    seen = minus(inside(axes, minus(tip, triple(flow, MOVES_T))), cross(inside(axes, triple(flow, SPIN_T)), place))
    return minus(minus(seen, cross(turn, cross(turn, place))), times(2.0, cross(turn, moves)))


@njit(inline="always")
def force_rate(y, flow, p, memory, axes, place, moves, turn):
    """Rate of the normal force [N/s] where the gap is below zero; else minus that of the gap."""
    rho, out_y, out_z = meridian(place)
    distance, nx, nr, on_rim = foot_of(place[0], rho, p)
    away = out_y * moves[1] + out_z * moves[2]
    rate, depth = nx * moves[0] + nr * away, p[at.RADIUS] - distance
    if depth <= 0.0:
        return -rate
    ax, ay, az = tip_acceleration(y, flow, p, axes, place, moves, turn)
    round_ = moves[1] * moves[1] + moves[2] * moves[2] - away * away
    change = nx * ax + nr * (out_y * ay + out_z * az + round_ / rho)
    change += on_rim * (moves[0] * moves[0] + away * away - rate * rate) / distance
    share = p[at.HYSTERESIS] / memory
    factor = 1.0 - share * rate
    if factor <= 0.0:
        return 0.0
    root = math.sqrt(depth)
    return p[at.STIFFNESS] * root * (-1.5 * rate * factor - depth * share * change)


@njit
def watch_along(y: Vector, flow: Vector, values: Vector, context: Vector) -> None:
    """Write the four watched numbers into ``values``, given dy/dt, the ``flow`` (35,), which the last alone needs."""
    p = context[0:COUNT]
    axes, place, moves, _, turn = relative(y, p)
    gap, _ = gap_and_rate(place, moves, p)
    pressing = context[ACTIVE] != 0.0
    values[0] = -gap if pressing else gap
    values[1] = -p[at.CONE_OFFSET] - p[at.RADIUS] * p[at.SINE] - place[0]
    values[2] = place[0] + p[at.CONE_OFFSET] + p[at.RETREAT]
    mouth = -p[at.CONE_OFFSET] - p[at.CONE_LENGTH] * p[at.COSINE]
    if meridian(place)[0] > p[at.THROAT_RADIUS] + p[at.CONE_LENGTH] * p[at.SINE]:
        # Past the mouth outside the rim the tip has missed the cone.
        values[2] = min(values[2], mouth - place[0])
    values[3] = force_rate(y, flow, p, context[MEMORY], axes, place, moves, turn) if pressing else 1.0
