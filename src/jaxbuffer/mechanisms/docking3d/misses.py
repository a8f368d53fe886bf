"""By how much the probe misses the cone's axis in space: aside, by its direction, and by its whole rotation."""

from typing import Any

import jax.numpy as jnp

from ..._types import Scalar
from ...space import AXES, Vector
from ..assembled import Assembled
from ..layout import EvaluatedState
from ..probe_cone.bodies import P, T
from ..probe_cone.reading import tip_motion

LEAST = 1e-30  # of a square: keeps the slope of its root finite where nothing is missed


def misses(mechanism: Assembled, at: EvaluatedState) -> dict[str, Scalar]:
    """Return each miss and its rate, by its name in `Docking3D`."""
    tip, moves = map(_in_space, tip_motion(mechanism, at))
    aside, aside_rate = _size(Vector(0.0, tip.y, tip.z), Vector(0.0, moves.y, moves.z))
    cone, probe = (_in_space(at.kin.frame(body)) for body in (T, P))
    spin = probe.spin - cone.spin
    along, axis = probe.turn(AXES[0]), cone.turn(AXES[0])
    across = axis.cross(along)
    sine = jnp.sqrt(across.dot(across) + LEAST)
    # The rotation vector lies along the axis of the rotation, about which the spin turns it on.
    rotation = at.kin.basis.relative_rotation(cone, probe)
    angle = jnp.sqrt(rotation.dot(rotation) + LEAST)
    return {
        "lateral_miss": aside,
        "lateral_miss_rate": aside_rate,
        "attitude_miss": angle,
        "attitude_miss_rate": spin.dot(rotation) / angle,
        "swing_miss": jnp.arctan2(sine, along.dot(axis)),
        "swing_miss_rate": spin.dot(across) / sine,
    }


def _in_space(it: Any) -> Any:
    """Return a vector or a frame as one of space, which its type does not say."""
    return it


def _size(vector: Vector, rate: Vector) -> tuple[Scalar, Scalar]:
    """Return the size of a vector and how fast it grows."""
    size = jnp.sqrt(vector.dot(vector) + LEAST)
    return size, vector.dot(rate) / size
