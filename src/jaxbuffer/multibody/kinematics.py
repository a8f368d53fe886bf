"""Where every body is and how it moves.

Coordinates are stored body by body, ``q = (u_1, v_1, θ_1, u_2, …)`` [m, m, rad], velocities in the same order (M4). A
body is an index into that order; ``GROUND`` is the inertial frame.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..plane import Frame, Vector, cos_sin

GROUND: int = -1


class Kinematics(eqx.Module):
    """Frames of all bodies at one instant, each made once; a frame that is not asked for is not compiled.

    - ``q``: (coordinates,) positions [m, m, rad, …].
    - ``v``: (coordinates,) velocities [m/s, m/s, rad/s, …].
    - ``frames``: one for each body.
    """

    q: Float[Array, " coordinates"]
    v: Float[Array, " coordinates"]
    frames: tuple[Frame, ...]

    def __init__(self, q: Float[Array, " coordinates"], v: Float[Array, " coordinates"]):
        self.q, self.v = q, v
        cos, sin = cos_sin(q[2::3])
        self.frames = tuple(
            Frame(Vector(q[k], q[k + 1]), q[k + 2], cos[body], sin[body], Vector(v[k], v[k + 1]), v[k + 2])
            for body, k in enumerate(range(0, q.shape[0], 3))
        )

    def frame(self, body: int) -> Frame:
        """The frame of one body. ``body``: its index, or ``GROUND``."""
        if body == GROUND:
            zero, one = jnp.zeros(()), jnp.ones(())
            return Frame(Vector(zero, zero), zero, one, zero, Vector(zero, zero), zero)
        return self.frames[body]
