"""The equations of motion by Kane's method, every joint's force eliminated by hand.

The speed of S is eliminated by the momentum of the chain, whose masses then count with what is left of them
(`weights`). The cross's rates and the buffer's are coupled with the spin of S alone, so that three equations remain.
"""

from __future__ import annotations

from numba import njit

from ..parameters import Vector
from . import parameters as at
from .chain import (
    ALPHA,
    ALPHA_RATE,
    BETA,
    BETA_RATE,
    EXTENT,
    EXTENT_RATE,
    MOVES_S,
    MOVES_T,
    PLACE_S,
    PLACE_T,
    SPIN_S,
    SPIN_T,
    SPIN_TIP,
    axes_at,
    bending,
    directions,
    places,
    triple,
    turning,
)
from .contact import push, relative
from .vectors import cross, dot, inertia_times, inside, minus, outside, plus, times

NOTHING = (0.0, 0.0, 0.0)


@njit(inline="always")
def weights(p, behind_B, behind_P):
    """Moments of the masses of B and P about the hinge, along B, less what moves with the centre of mass of all:
    orders 0, 1 and 2 of both, and orders 0 and 1 of P against both; then the shares of the whole mass in them of orders
    0 and 1, and of P."""
    whole = p[at.MASS_S] + p[at.MASS_B] + p[at.MASS_P]
    first = p[at.MASS_B] * behind_B + p[at.MASS_P] * behind_P
    both = p[at.MASS_B] + p[at.MASS_P]
    share, share_1, share_P = both / whole, first / whole, p[at.MASS_P] / whole
    second = p[at.MASS_B] * behind_B * behind_B + p[at.MASS_P] * behind_P * behind_P
    return (
        (both * (1.0 - share), first * (1.0 - share), second - first * share_1),
        (p[at.MASS_P] * (1.0 - share), p[at.MASS_P] * (behind_P - share_1), p[at.MASS_P] * (1.0 - share_P)),
        (share, share_1, share_P),
    )


@njit(inline="always")
def contact_load(y, p, pressing, memory):
    """Force on the tip [N], its moment about the tip's centre and about the centre of T [N m], in inertial axes."""
    if pressing == 0.0:
        return NOTHING, NOTHING, NOTHING
    axes, place, moves, spin, _ = relative(y, p)
    force, about_tip, about_T = push(place, moves, spin, memory, p)
    return outside(axes, force), outside(axes, about_tip), outside(axes, about_T)


@njit(inline="always")
def spin_block(p, axis, hinge, along, m):
    """The six numbers of the spin's symmetric block (xx, xy, xz, yy, yz, zz): inertias of S and of B with P, and the
    masses' m₀ (h² - h hᵀ) + m₁ (2 h·e - h eᵀ - e hᵀ) + m₂ (1 - e eᵀ)."""
    in_S, in_B = p[at.ALONG_S] - p[at.ACROSS_S], p[at.ALONG] - p[at.ACROSS]
    round_ = p[at.ACROSS_S] + p[at.ACROSS] + m[0] * dot(hinge, hinge) + 2.0 * m[1] * dot(hinge, along) + m[2]
    u, e, h = axis, along, hinge
    xx = round_ + in_S * u[0] * u[0] + (in_B - m[2]) * e[0] * e[0] - m[0] * h[0] * h[0] - 2.0 * m[1] * h[0] * e[0]
    yy = round_ + in_S * u[1] * u[1] + (in_B - m[2]) * e[1] * e[1] - m[0] * h[1] * h[1] - 2.0 * m[1] * h[1] * e[1]
    zz = round_ + in_S * u[2] * u[2] + (in_B - m[2]) * e[2] * e[2] - m[0] * h[2] * h[2] - 2.0 * m[1] * h[2] * e[2]
    xy = in_S * u[0] * u[1] + (in_B - m[2]) * e[0] * e[1] - m[0] * h[0] * h[1] - m[1] * (h[0] * e[1] + e[0] * h[1])
    xz = in_S * u[0] * u[2] + (in_B - m[2]) * e[0] * e[2] - m[0] * h[0] * h[2] - m[1] * (h[0] * e[2] + e[0] * h[2])
    yz = in_S * u[1] * u[2] + (in_B - m[2]) * e[1] * e[2] - m[0] * h[1] * h[2] - m[1] * (h[1] * e[2] + e[1] * h[2])
    return xx, xy, xz, yy, yz, zz


@njit(inline="always")
def less_square(block, q, over):
    """A symmetric block less q qᵀ / over."""
    s = 1.0 / over
    return (
        block[0] - s * q[0] * q[0],
        block[1] - s * q[0] * q[1],
        block[2] - s * q[0] * q[2],
        block[3] - s * q[1] * q[1],
        block[4] - s * q[1] * q[2],
        block[5] - s * q[2] * q[2],
    )


@njit(inline="always")
def solve_three(block, b):
    """Solution of a symmetric 3x3 system, by cofactors."""
    xx, xy, xz, yy, yz, zz = block
    c_xx, c_xy, c_xz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    c_yy, c_yz, c_zz = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    over = 1.0 / (xx * c_xx + xy * c_xy + xz * c_xz)
    return (
        over * (c_xx * b[0] + c_xy * b[1] + c_xz * b[2]),
        over * (c_xy * b[0] + c_yy * b[1] + c_yz * b[2]),
        over * (c_xz * b[0] + c_yz * b[1] + c_zz * b[2]),
    )


@njit(inline="always")
def chain_rates(y, p, force, moment):
    """Accelerations of S, its spin, α, β and the buffer's length under a force at the tip's centre [N] and a moment on
    the probe [N m]."""
    hinge, axis, second, third, along = directions(y, p)
    spin, spin_B, turn = turning(y, second, third)
    behind_B, behind_P, reach = places(y, p)
    m, m_P, shares = weights(p, behind_B, behind_P)
    at_hinge, a_metre, sliding = bending(spin, spin_B, turn, hinge, along, y[EXTENT_RATE])
    swing_2, swing_3 = cross(second, along), cross(third, along)

    # How the spin of S is coupled with α, β and the length, and what these weigh themselves: the cross's axes are
    # perpendicular, and so are the probe's swings about them, to each other and to the probe.
    lever = plus(times(m[1], hinge), times(m[2], along))
    with_2 = plus(cross(lever, swing_2), inertia_times(p[at.ACROSS], p[at.ALONG], along, second))
    with_3 = plus(cross(lever, swing_3), times(p[at.ACROSS], third))
    with_s = times(m_P[0], cross(hinge, along))
    tilt = dot(second, along)
    own_2 = (m[2] + p[at.ACROSS]) * (1.0 - tilt * tilt) + p[at.ALONG] * tilt * tilt
    own_3, own_s = m[2] + p[at.ACROSS], m_P[2]

    # Generalised forces.
    gyro_S = cross(spin, inertia_times(p[at.ACROSS_S], p[at.ALONG_S], axis, spin))
    gyro_B = plus(
        inertia_times(p[at.ACROSS], p[at.ALONG], along, turn),
        cross(spin_B, inertia_times(p[at.ACROSS], p[at.ALONG], along, spin_B)),
    )
    on_probe = minus(moment, gyro_B)
    by_hinge = plus(plus(times(m[0], at_hinge), times(m[1], a_metre)), times(m_P[0], sliding))
    by_metre = plus(plus(times(m[1], at_hinge), times(m[2], a_metre)), times(m_P[1], sliding))
    at_tip, at_root = minus(times(reach - shares[1], force), by_metre), minus(times(1.0 - shares[0], force), by_hinge)
    on_spin = minus(plus(on_probe, plus(cross(hinge, at_root), cross(along, at_tip))), gyro_S)
    on_2 = dot(second, on_probe) + dot(swing_2, at_tip) - p[at.SPRING_T] * y[ALPHA] - p[at.DAMPER_T] * y[ALPHA_RATE]
    on_3 = dot(third, on_probe) + dot(swing_3, at_tip) - p[at.SPRING_T] * y[BETA] - p[at.DAMPER_T] * y[BETA_RATE]
    spring = p[at.SPRING_A] * (y[EXTENT] - p[at.FREE_LENGTH]) + p[at.DAMPER_A] * y[EXTENT_RATE]
    inert = plus(times(m_P[0], at_hinge), times(m_P[1], a_metre))
    on_s = dot(along, minus(times(1.0 - shares[2], force), inert)) - spring

    block = spin_block(p, axis, hinge, along, m)
    block = less_square(less_square(less_square(block, with_2, own_2), with_3, own_3), with_s, own_s)
    rest = minus(minus(on_spin, times(on_2 / own_2, with_2)), times(on_3 / own_3, with_3))
    faster = solve_three(block, minus(rest, times(on_s / own_s, with_s)))
    alpha = (on_2 - dot(with_2, faster)) / own_2
    beta = (on_3 - dot(with_3, faster)) / own_3
    extent = (on_s - dot(with_s, faster)) / own_s

    whole = 1.0 / (p[at.MASS_S] + p[at.MASS_B] + p[at.MASS_P])
    turned = plus(faster, plus(times(alpha, second), times(beta, third)))
    moves = minus(times(whole, force), times(shares[0], plus(cross(faster, hinge), at_hinge)))
    moves = minus(moves, times(shares[1], plus(cross(turned, along), a_metre)))
    moves = minus(moves, times(shares[2], plus(times(extent, along), sliding)))
    return moves, faster, alpha, beta, extent


@njit(inline="always")
def passive_spin_rate(y, p, moment):
    """Rate of the spin of T under a moment about its centre [N m], in inertial axes."""
    axes = axes_at(y, PLACE_T)
    spin, on = inside(axes, triple(y, SPIN_T)), inside(axes, moment)
    apart = p[at.ALONG_T] - p[at.ACROSS_T]
    across = 1.0 / p[at.ACROSS_T]
    rate = (
        on[0] / p[at.ALONG_T],
        across * (on[1] - apart * spin[0] * spin[2]),
        across * (on[2] + apart * spin[0] * spin[1]),
    )
    return outside(axes, rate)


@njit(inline="always")
def enter(out, place, a):
    """Write a vector into the state's rates."""
    out[place], out[place + 1], out[place + 2] = a


@njit(inline="always")
def enter_turn(y, out, place, spin):
    """Write the rate of the quaternion behind a place: half the spin's product with it."""
    w, x, z, v = y[place + 3], y[place + 4], y[place + 5], y[place + 6]
    out[place + 3] = -0.5 * (spin[0] * x + spin[1] * z + spin[2] * v)
    out[place + 4] = 0.5 * (spin[0] * w + spin[1] * v - spin[2] * z)
    out[place + 5] = 0.5 * (spin[1] * w + spin[2] * x - spin[0] * v)
    out[place + 6] = 0.5 * (spin[2] * w + spin[0] * z - spin[1] * x)


@njit
def rhs_into(y: Vector, out: Vector, p: Vector, pressing: float, memory: float) -> None:
    """Write dy/dt (35,) into ``out``; whether the cone presses, and the approach speed that it remembers [m/s]."""
    force, about_tip, about_T = contact_load(y, p, pressing, memory)
    rolling = p[at.ROLLING] != 0.0
    moves, faster, alpha, beta, extent = chain_rates(y, p, force, NOTHING if rolling else about_tip)
    enter(out, PLACE_S, triple(y, MOVES_S))
    enter_turn(y, out, PLACE_S, triple(y, SPIN_S))
    out[ALPHA], out[BETA], out[EXTENT] = y[ALPHA_RATE], y[BETA_RATE], y[EXTENT_RATE]
    enter(out, PLACE_T, triple(y, MOVES_T))
    enter_turn(y, out, PLACE_T, triple(y, SPIN_T))
    enter(out, MOVES_S, moves)
    enter(out, SPIN_S, faster)
    out[ALPHA_RATE], out[BETA_RATE], out[EXTENT_RATE] = alpha, beta, extent
    enter(out, MOVES_T, times(-1.0 / p[at.MASS_T], force))
    enter(out, SPIN_T, passive_spin_rate(y, p, times(-1.0, about_T)))
    enter(out, SPIN_TIP, times(1.0 / p[at.INERTIA_TIP], about_tip) if rolling else NOTHING)
