"""The numbers of one capture in space: those of the plane, roll inertias, and a start that misses in two directions.

Every compiled function reads the same flat vector. The names ``MASS_S`` ... below are the places in that vector.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from ..parameters import DENSITY, PROBE_LENGTH, ROD_RADIUS, TIP_RADIUS, Vector, hertz_stiffness


@dataclass(frozen=True)
class Parameters:
    """Design, scenario and duration of one capture; the defaults are Table 2's, as docs/docking3d.md has it.

    The names are the reference file's. Angles turn about z, then about the turned y.
    """

    active_mass: float = 21.9706  # [kg]
    active_inertia: float = 0.445  # [kg m^2]
    active_roll_inertia: float = 0.2
    hinge_offset: float = 0.1365  # [m] a
    passive_mass: float = 23.5731  # [kg]
    passive_inertia: float = 0.5206  # [kg m^2]
    passive_roll_inertia: float = 0.25
    k_A: float = 500.0  # [N/m]
    c_A: float = 5.0  # [N s/m]
    k_T: float = 300.0  # [N m/rad] about either axis of the cross
    c_T: float = 2.0  # [N m s/rad]
    free_length: float = 0.1365  # [m] l_0
    cylinder_mass: float = 1.0  # [kg]
    cylinder_length: float = 0.1365  # [m] L_C
    probe_length: float = PROBE_LENGTH  # [m] L_P
    rod_mass: float = DENSITY * math.pi * ROD_RADIUS**2 * PROBE_LENGTH  # [kg] m_r
    rod_radius: float = ROD_RADIUS  # [m]
    tip_radius: float = TIP_RADIUS  # [m] R
    tip_mass: float = 4.0 / 3.0 * math.pi * TIP_RADIUS**3 * DENSITY  # [kg] m_t
    rolling: bool = False  # the tip spins freely about its centre
    half_angle: float = math.pi / 4.0  # [rad] beta
    cone_offset: float = 0.096  # [m] L_T
    throat_radius: float = 0.015  # [m] R_c
    cone_length: float = 0.0735  # [m] L_c, slant
    stiffness: float = hertz_stiffness(TIP_RADIUS)  # [N/m^1.5] K
    restitution: float = 0.9  # [-] e
    friction: float = 0.33  # [-] mu
    slip_speed: float = 1e-3  # [m/s] v_s
    start: str = "contact"  # or "free"
    approach_speed: float = 0.1  # [m/s] v0
    contact_distance: float = 0.0435  # [m] b
    azimuth: float = 0.0  # [rad]
    misalignment: float = 0.0  # [rad] yaw of T
    misalignment_y: float = 0.0  # [rad] pitch of T
    passive_rate_x: float = 0.0  # [rad/s] of T, in inertial axes
    passive_rate_y: float = 0.0
    passive_rate: float = 0.0  # about z
    active_yaw: float = 0.0  # [rad]
    active_pitch: float = 0.0
    active_rate_x: float = 0.0  # [rad/s] of S, in inertial axes
    active_rate_y: float = 0.0
    active_rate_z: float = 0.0
    offset_y: float = 0.0  # [m] of the tip from the cone's axis
    offset_z: float = 0.0
    standoff: float = 0.0  # [m]
    lateral_y: float = 0.0  # [m/s]
    lateral_z: float = 0.0
    T: float = 3.0  # [s] duration

    @classmethod
    def from_inputs(cls, inputs: Mapping[str, float | str]) -> Parameters:
        """Table 2 with the ``inputs`` of a reference capture in place of its own."""
        known = {field.name for field in fields(cls)}
        unknown = set(inputs) - known
        if unknown:
            raise ValueError(f"no such parameters: {sorted(unknown)}; known are {sorted(known)}")
        values: dict = {name: bool(value) if name == "rolling" else value for name, value in inputs.items()}
        return cls(**values)


(
    MASS_S, ACROSS_S, ALONG_S, MASS_B, MASS_P, ACROSS, ALONG, MASS_T, ACROSS_T, ALONG_T, INERTIA_TIP, HINGE, CYLINDER,
    REAR, LENGTH, SPRING_A, DAMPER_A, SPRING_T, DAMPER_T, FREE_LENGTH, RADIUS, COSINE, SINE, CONE_OFFSET, THROAT_RADIUS,
    CONE_LENGTH, STIFFNESS, HYSTERESIS, FRICTION, SLIP_SPEED, ROLLING, RETREAT,
) = range(32)  # fmt: skip
COUNT = 32


def vector(parameters: Parameters) -> Vector:
    """The parameter vector (32,). Cylinder and probe never turn against each other: their inertias are added, each
    about its own centre of mass."""
    p = parameters
    mass = p.rod_mass + p.tip_mass
    ahead = p.tip_mass * (p.probe_length / 2.0) / mass  # [m] centre of mass ahead of the rod's middle
    spin = 0.4 * p.tip_mass * p.tip_radius**2
    welded = 0.0 if p.rolling else spin
    front = p.probe_length / 2.0 - ahead
    probe = p.rod_mass * (p.probe_length**2 / 12.0 + ahead**2) + p.tip_mass * front**2 + welded
    values = {
        MASS_S: p.active_mass,
        ACROSS_S: p.active_inertia,
        ALONG_S: p.active_roll_inertia,
        MASS_B: p.cylinder_mass,
        MASS_P: mass,
        ACROSS: p.cylinder_mass * p.cylinder_length**2 / 12.0 + probe,
        ALONG: 0.5 * p.rod_mass * p.rod_radius**2 + welded,
        MASS_T: p.passive_mass,
        ACROSS_T: p.passive_inertia,
        ALONG_T: p.passive_roll_inertia,
        INERTIA_TIP: spin,
        HINGE: p.hinge_offset,
        CYLINDER: p.cylinder_length,
        REAR: p.probe_length / 2.0 + ahead,
        LENGTH: p.probe_length,
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
        HYSTERESIS: 0.75 * (1.0 - p.restitution**2),  # Lankarani and Nikravesh
        FRICTION: p.friction,
        SLIP_SPEED: p.slip_speed,
        ROLLING: float(p.rolling),
        RETREAT: 2.0 * p.cone_length + (p.standoff if p.start == "free" else 0.0),
    }
    return np.array([values[place] for place in range(COUNT)])
