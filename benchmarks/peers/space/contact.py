"""Where the ball meets the cone of revolution, and with what force, in the axes of the passive vehicle T."""

from __future__ import annotations

import math

from numba import njit

from ..contact import SLOWEST_TOUCHDOWN as SLOWEST_TOUCHDOWN
from . import parameters as at
from .chain import MOVES_T, PLACE_T, SPIN_T, axes_at, tip_motion, triple
from .vectors import cross, dot, inside, minus, plus, size, times

LEAST = 1e-300


@njit(inline="always")
def relative(y, p):
    """Axes of T; in them the tip's place from T's centre [m], its velocity less that of the point of T there [m/s], its
    spin less that of T, and the spin of T [rad/s]."""
    place, velocity, spin = tip_motion(y, p)
    axes, turn = axes_at(y, PLACE_T), triple(y, SPIN_T)
    arm = minus(place, triple(y, PLACE_T))
    moves = minus(minus(velocity, triple(y, MOVES_T)), cross(turn, arm))
    return axes, inside(axes, arm), inside(axes, moves), inside(axes, minus(spin, turn)), inside(axes, turn)


@njit(inline="always")
def foot_of(x, rho, p):
    """Distance [m] of the tip's centre from the cone in the meridian half plane, the normal there (2), and 1 where the
    foot is on a rim, which is met as a circle."""
    slant = -(x + p[at.CONE_OFFSET]) * p[at.COSINE] + (rho - p[at.THROAT_RADIUS]) * p[at.SINE]
    kept = min(max(slant, 0.0), p[at.CONE_LENGTH])
    dx = x + p[at.CONE_OFFSET] + kept * p[at.COSINE]
    dr = rho - p[at.THROAT_RADIUS] - kept * p[at.SINE]
    distance = math.sqrt(dx * dx + dr * dr)
    return distance, dx / distance, dr / distance, 0.0 if kept == slant else 1.0


@njit(inline="always")
def meridian(place):
    """Distance from the axis [m], and the direction away from it (2)."""
    rho = math.sqrt(place[1] * place[1] + place[2] * place[2])
    out = 1.0 / max(rho, LEAST)
    return rho, out * place[1], out * place[2]


@njit(inline="always")
def normal_force(gap, rate, memory, p):
    """Lankarani and Nikravesh's force [N] of a gap [m] and its rate [m/s]."""
    if gap >= 0.0:
        return 0.0
    return p[at.STIFFNESS] * -gap * math.sqrt(-gap) * max(0.0, 1.0 - p[at.HYSTERESIS] * rate / memory)


@njit(inline="always")
def gap_and_rate(place, moves, p):
    """Gap [m] and its rate [m/s]."""
    rho, out_y, out_z = meridian(place)
    distance, nx, nr, _ = foot_of(place[0], rho, p)
    return distance - p[at.RADIUS], nx * moves[0] + nr * (out_y * moves[1] + out_z * moves[2])


@njit(inline="always")
def push(place, moves, spin, memory, p):
    """Force on the tip [N], its moment about the tip's centre and about T's centre [N m], all in the axes of T."""
    rho, out_y, out_z = meridian(place)
    distance, nx, nr, _ = foot_of(place[0], rho, p)
    normal = (nx, nr * out_y, nr * out_z)
    rate = dot(normal, moves)
    pressing = normal_force(distance - p[at.RADIUS], rate, memory, p)
    arm = times(-distance, normal)
    slip = minus(plus(moves, cross(spin, arm)), times(rate, normal))
    speed = size(slip)
    brake = p[at.FRICTION] * pressing * math.tanh(speed / p[at.SLIP_SPEED]) / max(speed, LEAST)
    force = minus(times(pressing, normal), times(brake, slip))
    return force, cross(arm, force), cross(plus(place, arm), force)
