"""Where a capture starts: the tip just touches the lower flank (M62 of docs/model.md)."""

from __future__ import annotations

import math

import numpy as np

from .contact import SLOWEST_TOUCHDOWN, both_gaps
from .parameters import FRONT, HALF_CYLINDER, REAR, Parameters, Vector, vector

STATES = 25  # 12 positions, 12 velocities, the spin of the tip


def start(parameters: Parameters) -> tuple[Vector, Vector, Vector]:
    """State (25,), active flanks (2,) and remembered approach speeds (2,) [m/s] at t = 0."""
    s, p = parameters, vector(parameters)
    tangent = np.array([math.cos(s.half_angle), math.sin(s.half_angle)])
    normal = np.array([-tangent[1], tangent[0]])
    throat_edge = np.array([-s.cone_offset, -s.throat_radius])
    c, d = math.cos(s.misalignment), math.sin(s.misalignment)
    tip = np.array([[c, -d], [d, c]]) @ (throat_edge - s.contact_distance * tangent + s.tip_radius * normal)
    probe = tip[0] - p[FRONT]
    cylinder = probe - p[REAR] - s.free_length + p[HALF_CYLINDER]
    active_vehicle = cylinder + p[HALF_CYLINDER] - s.hinge_offset
    y = np.zeros(STATES)
    y[0:12] = (active_vehicle, tip[1], 0.0, cylinder, tip[1], 0.0, probe, tip[1], 0.0, 0.0, 0.0, s.misalignment)
    y[[12, 15, 18]] = s.approach_speed
    y[23] = s.passive_rate
    approach = -both_gaps(y, p)[2]
    active = np.array([1.0, 0.0])
    memory = np.array([max(approach, SLOWEST_TOUCHDOWN), SLOWEST_TOUCHDOWN])
    return y, active, memory
