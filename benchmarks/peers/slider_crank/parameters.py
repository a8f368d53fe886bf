"""The numbers of a slider-crank with clearance: the reference set of the design notes by default."""

from __future__ import annotations

import math
from typing import NamedTuple

YOUNG_MODULUS = 207e9  # [Pa] of pins and bushes
POISSON_RATIO = 0.3  # [-]
RPM = math.pi / 30.0  # [rad/s] in one turn a minute


class SliderCrank(NamedTuple):
    """Crank about the origin, rod, slider on the x-axis; a tuple of numbers, since that is what Numba takes.

    In each joint with clearance a pin (radius ``bush_radius - clearance``) moves in a bush (``bush_radius``); the
    bush is on the rod, the pin on the slider, or on the crank. Start: crank angle 0, rod in line, centres of pins and
    bushes coincide, velocities as without clearance. The crank is balanced: its weight has no moment.
    """

    speed: float = 5000.0 * RPM  # [rad/s] of the crank; a torque-driven one starts with it
    crank_radius: float = 0.05  # [m]
    rod_length: float = 0.12  # [m]
    rod_centre: float = 0.06  # [m] of mass, from the crank pin
    rod_mass: float = 0.21  # [kg]
    rod_inertia: float = 2.5e-4  # [kg m^2] about its centre of mass
    slider_mass: float = 0.14  # [kg]
    gravity: float = 0.0  # [m/s^2] along -y
    bush_radius: float = 0.01  # [m]
    clearance: float = 5e-4  # [m] radial
    stiffness: float = 0.0  # [N/m^1.5] 0: of a sphere in a hollow sphere of steel, see `contact_stiffness`
    restitution: float = 0.9  # [-]
    friction: float = 0.0  # [-]
    slip_speed: float = 1e-3  # [m/s]
    ramp: float = 0.0  # 0: friction grows with tanh(slip/slip_speed); 1: linearly up to the slip speed
    overlap_share: float = 0.0  # 0: forces act at the bush's surface; 1/2: midway to the pin's, as in Exudyn
    crank_pin: float = 0.0  # 1: clearance there
    piston_pin: float = 1.0  # 1: clearance there
    torque_driven: float = 0.0  # 1: by stall_torque (1 - speed / no_load_speed); 0: at constant speed
    crank_inertia: float = 0.0  # [kg m^2] about the pivot; matters to a torque-driven crank only
    stall_torque: float = 0.0  # [N m]
    no_load_speed: float = 1.0  # [rad/s]


def contact_stiffness(bush_radius: float, clearance: float) -> float:
    """Stiffness K [N/m^1.5] of a steel sphere in a hollow one (Lankarani and Nikravesh): 4/(3π·2σ) √(R_B R_J/c)."""
    sigma = (1.0 - POISSON_RATIO**2) / (math.pi * YOUNG_MODULUS)
    return 4.0 / (6.0 * math.pi * sigma) * math.sqrt(bush_radius * (bush_radius - clearance) / clearance)


def completed(crank: SliderCrank) -> SliderCrank:
    """The same with its stiffness written out."""
    if crank.stiffness > 0.0:
        return crank
    return crank._replace(stiffness=contact_stiffness(crank.bush_radius, crank.clearance))
