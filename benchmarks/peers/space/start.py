"""Where a capture starts: the tip touches the cone, or is anywhere before it; S, B and P in line behind it."""

from __future__ import annotations

import math

import numpy as np

from ..parameters import Vector
from .chain import EXTENT, MOVES_S, PLACE_S, PLACE_T, SPIN_S, SPIN_T, SPIN_TIP, STATES
from .parameters import CYLINDER, HINGE, LENGTH, Parameters
from .vectors import axes_of


def start(parameters: Parameters, p: Vector) -> Vector:
    """State (35,) at t = 0."""
    s, y = parameters, np.zeros(STATES)
    cone, active = _turned(s.misalignment, s.misalignment_y), _turned(s.active_yaw, s.active_pitch)
    x_S, T = np.array(axes_of(*active)[0]), np.array(axes_of(*cone)).T
    tip = T @ _tip(s)
    y[PLACE_S : PLACE_S + 3] = tip - x_S * (p[HINGE] - p[CYLINDER] + s.free_length + p[LENGTH])
    y[PLACE_S + 3 : PLACE_S + 7], y[PLACE_T + 3 : PLACE_T + 7] = active, cone
    y[EXTENT] = s.free_length
    y[MOVES_S : MOVES_S + 3] = s.approach_speed, s.lateral_y, s.lateral_z
    y[SPIN_S : SPIN_S + 3] = y[SPIN_TIP:] = s.active_rate_x, s.active_rate_y, s.active_rate_z
    y[SPIN_T : SPIN_T + 3] = s.passive_rate_x, s.passive_rate_y, s.passive_rate
    if not s.rolling:
        y[SPIN_TIP:] = 0.0
    return y


def _turned(yaw: float, pitch: float) -> tuple[float, float, float, float]:
    """The quaternion of a turn about z, then about the turned y."""
    cz, sz, cy, sy = math.cos(yaw / 2), math.sin(yaw / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    return cz * cy, -sz * sy, cz * sy, sz * cy


def _tip(s: Parameters) -> Vector:
    """The tip's centre in the axes of T [m]."""
    cos, sin = math.cos(s.half_angle), math.sin(s.half_angle)
    if s.start == "free":
        x = -s.cone_offset - s.cone_length * cos - s.tip_radius - s.standoff
        return np.array([x, s.offset_y, s.offset_z])
    rho = s.throat_radius + s.contact_distance * sin - s.tip_radius * cos
    around = s.azimuth - math.pi / 2.0
    x = -s.cone_offset - s.contact_distance * cos - s.tip_radius * sin
    return np.array([x, rho * math.sin(around), rho * math.cos(around)])
