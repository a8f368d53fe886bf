"""The chain of active vehicle S, cylinder B and probe P: its axes, velocities, and accelerations that velocities alone
cause.

The state is y (35,): place of S and its quaternion (7), the cross's angles α and β and the buffer's length (3), place
of T and its quaternion (7); then the rates: velocity and spin of S (6), of α, β and the length (3), velocity and spin
of T (6), spin of the free tip (3), at rest for ever when the tip is welded. Vectors stand in inertial axes.
"""

from __future__ import annotations

import math

from numba import njit

from . import parameters as at
from .vectors import axes_of, cross, outside, plus, times

STATES = 35
PLACE_S, ALPHA, BETA, EXTENT, PLACE_T = 0, 7, 8, 9, 10
MOVES_S, SPIN_S, ALPHA_RATE, BETA_RATE, EXTENT_RATE, MOVES_T, SPIN_T, SPIN_TIP = 17, 20, 23, 24, 25, 26, 29, 32


@njit(inline="always")
def triple(y, place):
    return y[place], y[place + 1], y[place + 2]


@njit(inline="always")
def axes_at(y, place):
    """Axes of the body whose place stands there, its quaternion behind it."""
    return axes_of(y[place + 3], y[place + 4], y[place + 5], y[place + 6])


@njit(inline="always")
def directions(y, p):
    """From the centre of S to the hinge [m]; the axis x of S, the cross's axes of α and β, the axis of B and P."""
    axes = axes_at(y, PLACE_S)
    ca, sa, cb, sb = math.cos(y[ALPHA]), math.sin(y[ALPHA]), math.cos(y[BETA]), math.sin(y[BETA])
    third = outside(axes, (sa, 0.0, ca))
    along = outside(axes, (ca * cb, sb, -sa * cb))
    return times(p[at.HINGE], axes[0]), axes[0], axes[1], third, along


@njit(inline="always")
def places(y, p):
    """How far behind the hinge, along B, the centres of B and P and the tip are [m], forward counting positive."""
    length = y[EXTENT] - p[at.CYLINDER]
    return -0.5 * p[at.CYLINDER], length + p[at.REAR], length + p[at.LENGTH]


@njit(inline="always")
def turning(y, second, third):
    """Spins of S and of B [rad/s], and the part of B's angular acceleration that rates alone cause [rad/s²]."""
    spin = triple(y, SPIN_S)
    first_turn, second_turn = times(y[ALPHA_RATE], second), times(y[BETA_RATE], third)
    between = plus(spin, first_turn)
    return spin, plus(between, second_turn), plus(cross(spin, first_turn), cross(between, second_turn))


@njit(inline="always")
def bending(spin, spin_B, turn, hinge, along, rate):
    """Accelerations that rates alone cause [m/s²]: at the hinge, of a metre of B, and of what slides along B."""
    at_hinge = cross(spin, cross(spin, hinge))
    a_metre = plus(cross(turn, along), cross(spin_B, cross(spin_B, along)))
    return at_hinge, a_metre, times(2.0 * rate, cross(spin_B, along))


@njit(inline="always")
def tip_motion(y, p):
    """Place [m], velocity [m/s] and spin [rad/s] of the tip; a welded one turns with B."""
    hinge, _, second, third, along = directions(y, p)
    spin, spin_B, _ = turning(y, second, third)
    reach = places(y, p)[2]
    place = plus(plus(triple(y, PLACE_S), hinge), times(reach, along))
    swing = plus(times(y[EXTENT_RATE], along), times(reach, cross(spin_B, along)))
    velocity = plus(plus(triple(y, MOVES_S), cross(spin, hinge)), swing)
    return place, velocity, triple(y, SPIN_TIP) if p[at.ROLLING] != 0.0 else spin_B
