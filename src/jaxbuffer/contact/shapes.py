"""Shapes in contact: gap, foot and normal of a ball against a segment, rims included."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp

from .._types import Scalar, Values


class Foot(NamedTuple):
    """Nearest point of a shape to a ball's centre, in the shape's axes.

    ``x``, ``y``: the foot [m]; ``normal_x``, ``normal_y``: unit vector foot → centre; ``distance`` [m] between them;
    ``slant``: where along the segment the foot lies, from its start [m].
    """

    x: Values
    y: Values
    normal_x: Values
    normal_y: Values
    distance: Values
    slant: Values


class Segment(eqx.Module):
    """A straight flank from ``start`` along the unit vector ``direction``, ``length`` long [m].

    The foot is clamped to the segment, so both ends are met as points and the normal stays continuous there. The fields
    may be arrays of several segments, treated together.
    """

    start_x: Values | Scalar
    start_y: Values | Scalar
    direction_x: Values | Scalar
    direction_y: Values | Scalar
    length: Scalar

    def foot(self, x: Values | Scalar, y: Values | Scalar) -> Foot:
        """The foot of the point (x, y) in the segment's axes [m]."""
        along = (x - self.start_x) * self.direction_x + (y - self.start_y) * self.direction_y
        slant = jnp.clip(along, 0.0, self.length)
        foot_x, foot_y = self.start_x + slant * self.direction_x, self.start_y + slant * self.direction_y
        off_x, off_y = x - foot_x, y - foot_y
        distance = jnp.sqrt(off_x * off_x + off_y * off_y)
        return Foot(foot_x, foot_y, off_x / distance, off_y / distance, distance, slant)
