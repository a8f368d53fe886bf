"""Where every body and its material points are and how they move.

Coordinates are stored body by body, ``q = (u_1, v_1, θ_1, u_2, …)`` [m, m, rad], then the modal coordinates of flexible
bodies, body by body [m]; velocities in the same order (M4). A body is an index into that order; ``GROUND`` is the
inertial frame.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from ..plane import Frame, Vector, cos_sin
from .coordinates import Coordinates
from .flexible.modes import Marker

GROUND: int = -1

Point = tuple[Scalar, Scalar] | Marker
"""A point of a body: its place (x, y) in the body's axes [m], or a marker of a flexible body."""

Block = tuple[Scalar, ...]
"""How a speed goes with one body's velocities: (u, v, θ), then its modal coordinates, if it is flexible."""


class MaterialPoint(NamedTuple):
    """A material point of a body, in inertial axes.

    - ``body``: its index, or ``GROUND``.
    - ``place``: [m].
    - ``arm``: from the origin of the body's frame [m].
    - ``velocity``: [m/s].
    - ``quadratic``: its acceleration while all coordinates' accelerations are zero [m/s²].
    - ``angle``: of the material there [rad], with its ``cos`` and ``sin`` [-].
    - ``spin``: of the material there [rad/s].
    - ``shapes``: displacement per unit of each modal coordinate [-]; none of a rigid body.
    - ``rotations``: rotation per unit of each modal coordinate [rad/m].
    """

    body: int
    place: Vector
    arm: Vector
    velocity: Vector
    quadratic: Vector
    angle: Scalar
    cos: Scalar
    sin: Scalar
    spin: Scalar
    shapes: tuple[Vector, ...] = ()
    rotations: tuple[Scalar, ...] = ()

    def along(self, direction: Vector) -> Block:
        """Return how the point's speed along a ``direction`` goes with the body's velocities."""
        return (
            direction.x,
            direction.y,
            self.arm.cross(direction),
            *(direction.dot(shape) for shape in self.shapes),
        )

    def turning(self) -> Block:
        """Return how the material's spin goes with the body's velocities."""
        return (0.0, 0.0, 1.0, *self.rotations)

    def turn(self, local: Vector) -> Vector:
        """Turn a direction fixed to the material there into inertial axes. ``local``: in axes that are the body's while
        it is undeformed."""
        return Vector(self.cos * local.x - self.sin * local.y, self.sin * local.x + self.cos * local.y)


class Kinematics(eqx.Module):
    """Frames of all bodies at one instant, each made once; a frame that is not asked for is not compiled.

    - ``q``: (coordinates,) positions [m, m, rad, …, m].
    - ``v``: (coordinates,) velocities [m/s, m/s, rad/s, …, m/s].
    - ``time``: for drives [s].
    - ``frames``: one for each body.
    - ``modes``: number of modes of each body; empty: all bodies are rigid.
    """

    q: Float[Array, " coordinates"]
    v: Float[Array, " coordinates"]
    time: Scalar
    frames: tuple[Frame, ...]
    modes: tuple[int, ...] = eqx.field(static=True)

    def __init__(
        self,
        q: Float[Array, " coordinates"],
        v: Float[Array, " coordinates"],
        time: Scalar = 0.0,
        modes: tuple[int, ...] = (),
    ):
        self.q, self.v, self.time, self.modes = q, v, time, modes
        end = 3 * len(modes) if modes else q.shape[0]
        # All angles in one call: as array operations they cost a few nanoseconds together (see `cos_sin`).
        cos, sin = cos_sin(q[2:end:3])
        self.frames = tuple(
            Frame(Vector(q[k], q[k + 1]), q[k + 2], cos[body], sin[body], Vector(v[k], v[k + 1]), v[k + 2])
            for body, k in enumerate(range(0, end, 3))
        )

    @property
    def order(self) -> Coordinates:
        """Return the order of the coordinates."""
        return Coordinates(len(self.frames), self.modes)

    def frame(self, body: int) -> Frame:
        """Return the frame of one body. ``body``: its index, or ``GROUND``."""
        if body == GROUND:
            zero, one = jnp.zeros(()), jnp.ones(())
            return Frame(Vector(zero, zero), zero, one, zero, Vector(zero, zero), zero)
        return self.frames[body]

    def modal(self, body: int) -> tuple[Float[Array, " modes"], Float[Array, " modes"]]:
        """Return the (modes,) modal coordinates of a flexible body [m], and their rates [m/s]. ``body``: its index."""
        mine = self.order.modal(body)
        return self.q[mine], self.v[mine]

    def point(self, body: int, point: Point) -> MaterialPoint:
        """Return a material point of a body. ``body``: its index, or ``GROUND``; ``point``: which one."""
        frame = self.frame(body)
        if not isinstance(point, Marker):
            # A place says nothing of how the material there deforms.
            if body != GROUND and self.modes and self.modes[body]:
                raise ValueError(f"body {body} is flexible: give a marker instead of {point}, such as Marker.on_frame")
            arm = frame.turn(Vector(*point))
            pull = arm * (-frame.spin * frame.spin)
            place, velocity = frame.origin + arm, frame.velocity_at(arm)
            return MaterialPoint(body, place, arm, velocity, pull, frame.angle, frame.cos, frame.sin, frame.spin)
        return self._marker(body, frame, point)

    def _marker(self, body: int, frame: Frame, marker: Marker) -> MaterialPoint:
        """Return the material point at a marker of a flexible body (M125)."""
        q, rate = self.modal(body)
        arm, moving = frame.turn(marker.place(q)), frame.turn(marker.displacement(rate))
        turned = marker.turn(q)
        # The frame's cosine and sine are known already: only the deformation's angle is evaluated, and added to it.
        cos, sin = cos_sin(jnp.reshape(turned, (1,)))
        shapes = zip(marker.displacement_x, marker.displacement_y, strict=True)
        return MaterialPoint(
            body=body,
            place=frame.origin + arm,
            arm=arm,
            velocity=frame.velocity_at(arm) + moving,
            # Centripetal and Coriolis acceleration.
            quadratic=arm * (-frame.spin * frame.spin) + moving.perp() * (2.0 * frame.spin),
            angle=frame.angle + turned,
            cos=frame.cos * cos[0] - frame.sin * sin[0],
            sin=frame.sin * cos[0] + frame.cos * sin[0],
            spin=frame.spin + marker.turn(rate),
            shapes=tuple(frame.turn(Vector(x, y)) for x, y in shapes),
            rotations=tuple(marker.rotation),
        )
