"""The numbers of one capture: Table 2 of "Efficient buffering mechanism for mechanical capturing systems" by default.

Every peer reads the same flat float64 vector, so that none pays for attribute look-ups inside its right-hand side. The
names ``MASS_S`` ... below are the places in that vector.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

YOUNG_MODULUS = 71.7e9  # [Pa] aluminium, the paper's section 7
POISSON_RATIO = 0.3  # [-]
DENSITY = 2740.0  # [kg/m^3]
TIP_RADIUS = 0.015  # [m] Table 2, R_tip
ROD_RADIUS = 0.009  # [m] Table 2, r_p
PROBE_LENGTH = 0.2  # [m] Table 2, L_P
STABILISATION = 20.0  # [1/s] Baumgarte's alpha = beta: the speed of the mechanism, far below that of a contact


def hertz_stiffness(radius: float, young_modulus: float = YOUNG_MODULUS, poisson_ratio: float = POISSON_RATIO) -> float:
    """Stiffness K [N/m^1.5] of a ball of ``radius`` [m] on a wall of the same material, the paper's eqs. 3 and 4."""
    sigma = (1.0 - poisson_ratio**2) / young_modulus
    return 4.0 * math.sqrt(radius) / (3.0 * (sigma + sigma))


@dataclass(frozen=True)
class Parameters:
    """Design, scenario and duration of one capture; defaults are those of docs/model.md."""

    m_S: float = 21.9706  # [kg] active vehicle
    I_S: float = 0.445  # [kg m^2]
    hinge_offset: float = 0.1365  # [m] a
    m_T: float = 23.5731  # [kg] passive vehicle
    I_T: float = 0.5206  # [kg m^2]
    k_A: float = 500.0  # [N/m] axial spring
    c_A: float = 5.0  # [N s/m] axial damper
    k_T: float = 300.0  # [N m/rad] torsional spring
    c_T: float = 2.0  # [N m s/rad] torsional damper
    free_length: float = 0.1365  # [m] l_0
    m_B: float = 1.0  # [kg] cylinder
    cylinder_length: float = 0.1365  # [m] L_C
    probe_length: float = PROBE_LENGTH  # [m] L_P
    rod_mass: float = DENSITY * math.pi * ROD_RADIUS**2 * PROBE_LENGTH  # [kg] m_r
    tip_radius: float = TIP_RADIUS  # [m] R
    tip_mass: float = 4.0 / 3.0 * math.pi * TIP_RADIUS**3 * DENSITY  # [kg] m_t
    rolling: bool = False  # the tip spins freely about its centre
    half_angle: float = math.pi / 4.0  # [rad] beta
    cone_offset: float = 0.096  # [m] L_T
    throat_radius: float = 0.015  # [m] R_c
    cone_length: float = 0.0735  # [m] L_c, along the flank
    stiffness: float = hertz_stiffness(TIP_RADIUS)  # [N/m^1.5] K
    restitution: float = 0.9  # [-] e
    friction: float = 0.33  # [-] mu
    slip_speed: float = 1e-3  # [m/s] v_s
    approach_speed: float = 0.1  # [m/s] v0
    contact_distance: float = 0.0435  # [m] b
    misalignment: float = 0.0  # [rad] theta_T at the start
    passive_rate: float = 0.0  # [rad/s] its rate at the start
    duration: float = 8.0  # [s]

    @classmethod
    def from_inputs(cls, inputs: Mapping[str, float]) -> Parameters:
        """Table 2 with the ``inputs`` of a reference capture in place of its own (the names of the reference file)."""
        known = {field.name for field in fields(cls)}
        unknown = set(inputs) - known
        if unknown:
            raise ValueError(f"no such parameters: {sorted(unknown)}; known are {sorted(known)}")
        return cls(**{name: bool(value) if name == "rolling" else float(value) for name, value in inputs.items()})


(
    MASS_S, INERTIA_S, MASS_B, INERTIA_B, MASS_P, INERTIA_P, MASS_T, INERTIA_T, INERTIA_TIP, HINGE, HALF_CYLINDER,
    REAR, FRONT, SPRING_A, DAMPER_A, SPRING_T, DAMPER_T, FREE_LENGTH, RADIUS, COSINE, SINE, CONE_OFFSET, THROAT_RADIUS,
    CONE_LENGTH, STIFFNESS, HYSTERESIS, FRICTION, SLIP_SPEED, ROLLING, GAIN,
) = range(30)  # fmt: skip


def vector(parameters: Parameters) -> Vector:
    """The parameter vector (30,) every compiled function reads; the probe with its tip is composed here (M6)."""
    p = parameters
    mass = p.rod_mass + p.tip_mass
    ahead = p.tip_mass * (p.probe_length / 2.0) / mass  # [m] c, centre of mass ahead of the rod's middle
    rear = p.probe_length / 2.0 + ahead
    front = p.probe_length / 2.0 - ahead
    spin = 0.4 * p.tip_mass * p.tip_radius**2
    inertia = p.rod_mass * (p.probe_length**2 / 12.0 + ahead**2) + p.tip_mass * front**2
    values = {
        MASS_S: p.m_S,
        INERTIA_S: p.I_S,
        MASS_B: p.m_B,
        INERTIA_B: p.m_B * p.cylinder_length**2 / 12.0,
        MASS_P: mass,
        INERTIA_P: inertia if p.rolling else inertia + spin,
        MASS_T: p.m_T,
        INERTIA_T: p.I_T,
        INERTIA_TIP: spin,
        HINGE: p.hinge_offset,
        HALF_CYLINDER: p.cylinder_length / 2.0,
        REAR: rear,
        FRONT: front,
        SPRING_A: p.k_A,
        DAMPER_A: p.c_A,
        SPRING_T: p.k_T,
        DAMPER_T: p.c_T,
        FREE_LENGTH: p.free_length,
        RADIUS: p.tip_radius,
        COSINE: math.cos(p.half_angle),
        SINE: math.sin(p.half_angle),
        CONE_OFFSET: p.cone_offset,
        THROAT_RADIUS: p.throat_radius,
        CONE_LENGTH: p.cone_length,
        STIFFNESS: p.stiffness,
        HYSTERESIS: 0.75 * (1.0 - p.restitution**2),  # Lankarani and Nikravesh, the paper's eq. 2
        FRICTION: p.friction,
        SLIP_SPEED: p.slip_speed,
        ROLLING: float(p.rolling),
        GAIN: STABILISATION,
    }
    return np.array([values[place] for place in range(len(values))])
