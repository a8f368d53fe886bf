"""How both sides of a docking move until they touch: straight on, and turning steadily. Plain numbers, in space; of the
plane all is zero but x, y and the turns about z."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

INSTANTS = 4001  # of a flight, between which the tip moves by far less than its radius
FURTHER = 4.0  # times the way to the throat that a flight is followed

Vectors = Float[np.ndarray, "*many 3"]
Matrix = Float[np.ndarray, "3 3"]


class Approach(NamedTuple):
    """A start.

    - ``speeds``: of the active vehicle's centre of mass [m/s].
    - ``offset``: y and z of the tip from the cone's axis, in the axes of the passive vehicle [m].
    - ``active``, ``passive``: rotation matrices of the vehicles.
    - ``active_spin``, ``passive_spin`` [rad/s].
    """

    speeds: Vectors
    offset: tuple[float, float]
    active: Matrix
    passive: Matrix
    active_spin: Vectors
    passive_spin: Vectors

    @property
    def angle(self) -> float:
        """Return the angle of the rotation from the passive to the active vehicle [rad]."""
        (_, xy, xz), (yx, _, yz), (zx, zy, _) = matrix = self.passive.T @ self.active
        # The skew part is the axis times the angle's sine; an arccosine of the trace alone is rough for small angles.
        sine = 0.5 * np.linalg.norm([zy - yz, xz - zx, yx - xy])
        return float(np.arctan2(sine, 0.5 * (np.trace(matrix) - 1.0)))

    def flight(self, design: Any, scenario: Any, start: float) -> tuple[np.ndarray, np.ndarray]:
        """Return where the tip's centre is while nothing touches, at instants from 0 on: x in the axes of the passive
        vehicle and the distance from its axis [m].

        ``start``: its x at t = 0 in those axes [m] (M170).
        """
        time = np.linspace(0.0, FURTHER * abs(start) / self.speeds[0], INSTANTS)
        # The active vehicle turns about its centre of mass, which is this far behind the tip at the spring's free
        # length. The hinge is at the cylinder's front, and the spring begins at its rear.
        buffer, probe = design.buffer, float(design.probe.length)
        to_hinge = probe + float(buffer.free_length) - float(buffer.cylinder_length)
        behind = float(design.active.hinge_offset) + to_hinge
        pushed = np.zeros_like(time)
        if scenario.has("thrust"):
            for_time, push = float(scenario.thrust_time), float(scenario.thrust) / float(design.active.mass)
            pushing = np.minimum(time, for_time)
            # ½ a t² while it pushes, and from then on at the speed a τ that it has given: one formula for both.
            pushed = push * pushing * (time - 0.5 * pushing)
        axis = self.active[:, 0]
        first = self.passive @ np.array([start, *self.offset])
        swung = turned(time[:, None] * self.active_spin, axis) - axis
        tip = first + time[:, None] * self.speeds + pushed[:, None] * axis + behind * swung
        seen = turned(-time[:, None] * self.passive_spin, tip) @ self.passive
        return seen[:, 0], np.hypot(seen[:, 1], seen[:, 2])


def rotation_matrix(yaw: Any, pitch: Any = 0.0) -> Matrix:
    """Return the matrix of a rotation by a pitch about y, and after it a yaw about z [rad]."""
    cos_z, sin_z, cos_y, sin_y = (float(f(angle)) for angle in (yaw, pitch) for f in (np.cos, np.sin))
    about_z = np.array([[cos_z, -sin_z, 0.0], [sin_z, cos_z, 0.0], [0.0, 0.0, 1.0]])
    return about_z @ np.array([[cos_y, 0.0, sin_y], [0.0, 1.0, 0.0], [-sin_y, 0.0, cos_y]])


def turned(rotation: Vectors, vector: Vectors) -> Vectors:
    """Return a vector turned by a rotation vector [rad] (Rodrigues)."""
    angle = np.linalg.norm(rotation, axis=-1, keepdims=True)
    axis = rotation / np.maximum(angle, 1e-300)
    across = np.cross(axis, vector)
    return vector + np.sin(angle) * across + (1.0 - np.cos(angle)) * np.cross(axis, across)
