"""The rules by which latch and stops are made, of a study to begin with as of one that is sized (docs/docking.md)."""

import math

from ....value_text import percent_text

GROWING = 0.3  # ∫ċ t² dt/τ² = 6 (1/4 - 1/5) of M175's share c
TIP_WAY = 8.0 / 15.0  # of the tip's radius, that it goes on while the latch closes
STIFFEST_TURN = 312.5  # N m/rad for each J of μ v²: 20 N m/rad where 10 kg come at 8 cm/s

REBOUND, REBOUND_DAMPING = 20.0, 2.0  # of k_A and c_A: a rebound stop, with which the spring does not pull


def closing_time(radius: float, slowest: float) -> float:
    """Return the closing time of a latch in which the slowest tip goes on by half of its ``radius`` [s]."""
    return TIP_WAY * radius / slowest


def pull_stiffness(mass: float, speed: float, miss: float, closing: float, share: float) -> float:
    """Return the stiffness of a latch whose pull puts in at most a share of ½ μ v² [N/m] (M185).

    While the share c of M175 grows, a tip at rest that far off its seat comes nearer, and one that passes the seat at v
    is nowhere farther from it than v t: both for any damping, because E/c falls where nothing but the closing puts in.

    **Arguments:** ``mass``: μ [kg]; ``speed``: v [m/s]; ``miss``: r [m]; ``closing``: τ [s]; ``share`` [-].
    """
    return share * mass * speed**2 / (miss**2 + GROWING * (speed * closing) ** 2)


def turn_stiffness(mass: float, speed: float, angle: float, share: float) -> tuple[float, str]:
    """Return the turn stiffness of a latch that puts in at most a share of ½ μ v² by turning the probe [N m/rad], and
    the rule in words. ``angle``: φ [rad]."""
    stiffest = STIFFEST_TURN * mass * speed**2
    if angle > 0.0 and (most := share * mass * speed**2 / angle**2) < stiffest:
        return most, f"½ k φ² is {percent_text(share)} of the slow approach's energy"
    return stiffest, "μ v² of the slow approach"


def damping_for(ratio: float, stiffness: float, mass: float) -> float:
    """Return the damping of a damping ratio: 2 ζ √(k m)."""
    return 2.0 * ratio * math.sqrt(stiffness * mass)
