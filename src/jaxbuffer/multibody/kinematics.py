"""Where every body and its material points are and how they move.

Coordinates are stored body by body, in the plane ``q = (u_1, v_1, θ_1, u_2, …)`` [m, m, rad] (M4), in space each body's
centre of mass and quaternion (M209); then the modal coordinates of flexible bodies, body by body [m]; velocities in the
same order. A body is an index into that order; ``GROUND`` is the inertial frame.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .. import plane, space
from .._types import Scalar, stacked
from ..basis import AnyBasis, components, less, times
from ..errors import InputError
from ..plane import PLANE, cos_sin
from ..space.either import Frame, Turn, Vector
from .coordinates import Coordinates
from .flexible.modes import Marker

GROUND: int = -1

Point = tuple[Scalar, ...] | Marker
"""A point of a body: its place (x, y), in space (x, y, z), in the body's axes [m], or a marker of a flexible body."""

Block = tuple[Scalar, ...]
"""How a speed goes with one body's velocities: (u, v, θ), in space (ẋ, ẏ, ż, ω), then its modal coordinates, if it is
flexible."""


class MaterialPoint(NamedTuple):
    """A material point of a body, in inertial axes. Vectors and turns are those of the plane or of space.

    - ``body``: its index, or ``GROUND``.
    - ``frame``: that of the material there, which turns with it; its axes are the body's while that is undeformed.
    - ``arm``: from the origin of the body's frame [m].
    - ``quadratic``: its acceleration while all coordinates' accelerations are zero [m/s²].
    - ``shapes``: displacement per unit of each modal coordinate [-]; none of a rigid body.
    - ``rotations``: rotation per unit of each modal coordinate [rad/m].
    """

    body: int
    frame: Frame
    arm: Vector
    quadratic: Vector
    shapes: tuple[Vector, ...] = ()
    rotations: tuple[Scalar, ...] = ()

    @property
    def place(self) -> Vector:
        """Return where it is [m]."""
        return self.frame.origin

    @property
    def velocity(self) -> Vector:
        """Return its velocity [m/s]."""
        return self.frame.velocity

    @property
    def angle(self) -> Scalar:
        """Return the angle of the material there [rad], in the plane."""
        if not isinstance(self.frame, plane.Frame):
            raise InputError(
                "this part takes a body's angle, which is of the plane; in space use TorsionalSpringDamper,"
                " CrossSpringDamper, or a joint with an axis"
            )
        return self.frame.angle

    @property
    def cos(self) -> Scalar:
        """Return the cosine of the angle."""
        return self.frame.cos

    @property
    def sin(self) -> Scalar:
        """Return the sine of the angle."""
        return self.frame.sin

    @property
    def spin(self) -> Turn:
        """Return the spin of the material there [rad/s]."""
        return self.frame.spin

    def turn(self, local: Vector) -> Vector:
        """Turn a direction fixed to the material there into inertial axes. ``local``: in axes that are the body's while
        it is undeformed."""
        return self.frame.turn(local)

    def along(self, direction: Vector) -> Block:
        """Return how the point's speed along a ``direction`` goes with the body's velocities."""
        turn = components(self.arm.cross(direction))
        return (*direction, *turn, *(direction.dot(shape) for shape in self.shapes))

    def turning(self, turn: Scalar | space.Vector = 1.0) -> Block:
        """Return how the material's spin times a ``turn`` goes with the body's velocities; in the plane of the spin
        itself, unless one is given."""
        about = components(turn)
        return (*[0.0] * len(self.arm), *about, *(times(rotation, about[-1]) for rotation in self.rotations))


def block_difference(a: Block, b: Block) -> Block:
    """Return a block less another one of the same body."""
    return tuple(less(x, y) for x, y in zip(a, b, strict=True))


class Kinematics(eqx.Module):
    """Frames of all bodies at one instant, each made once; a frame that is not asked for is not compiled.

    - ``q``: (coordinates,) positions [m, m, rad, …, m].
    - ``v``: (velocities,) [m/s, m/s, rad/s, …, m/s].
    - ``time``: for drives [s].
    - ``frames``: one for each body.
    - ``modes``: number of modes of each body; empty: all bodies are rigid.
    - ``basis``: `plane.PLANE` or `space.SPACE`.
    """

    q: Float[Array, " coordinates"]
    v: Float[Array, " velocities"]
    time: Scalar
    frames: tuple[Frame, ...]
    modes: tuple[int, ...] = eqx.field(static=True)
    basis: AnyBasis

    def __init__(
        self,
        q: Float[Array, " coordinates"],
        # As many fewer as each body has velocities fewer than positions.
        v: Float[Array, "{q.shape[0]-(basis.positions-basis.velocities)*(q.shape[0]//basis.positions)}"],
        time: Scalar = 0.0,
        modes: tuple[int, ...] = (),
        basis: AnyBasis = PLANE,
    ):
        self.q, self.v, self.time, self.modes, self.basis = q, v, time, modes, basis
        self.frames = basis.frames(q, v, len(modes) if modes else q.shape[0] // basis.positions)

    def moving(self, v: Float[Array, " velocities"]) -> "Kinematics":
        """Return the same positions with other velocities."""
        basis, frames = self.basis, list[Frame]()
        for body, frame in enumerate(self.frames):
            first, end = basis.velocities * body, basis.velocities * (body + 1)
            velocity = basis.vector(*(v[k] for k in range(first, first + basis.dimensions)))
            spin = basis.turn(*(v[k] for k in range(first + basis.dimensions, end)))
            frames.append(frame._replace(velocity=velocity, spin=spin))
        return eqx.tree_at(lambda kin: (kin.v, kin.frames), self, (v, tuple(frames)))

    @property
    def order(self) -> Coordinates:
        """Return the order of the positions."""
        return Coordinates(len(self.frames), self.modes, self.basis.positions)

    @property
    def velocity_order(self) -> Coordinates:
        """Return the order of the velocities."""
        return Coordinates(len(self.frames), self.modes, self.basis.velocities)

    def frame(self, body: int) -> Frame:
        """Return the frame of one body. ``body``: its index, or ``GROUND``."""
        return self.basis.ground() if body == GROUND else self.frames[body]

    def poses(self) -> Float[Array, "bodies numbers"]:
        """Return where each body is and how it is turned: in the plane x, y and angle, in space x, y, z and the
        rotation vector [m, rad]."""
        if self.basis.dimensions == 2:
            return self.order.placements(self.q)
        turns = [self.basis.relative_rotation(self.basis.ground(), frame) for frame in self.frames]
        return jnp.stack([stacked([*frame.origin, *turn]) for frame, turn in zip(self.frames, turns, strict=True)])

    def modal(self, body: int) -> tuple[Float[Array, " modes"], Float[Array, " modes"]]:
        """Return the (modes,) modal coordinates of a flexible body [m], and their rates [m/s]. ``body``: its index."""
        return self.q[self.order.modal(body)], self.v[self.velocity_order.modal(body)]

    def point(self, body: int, point: Point) -> MaterialPoint:
        """Return a material point of a body. ``body``: its index, or ``GROUND``; ``point``: which one."""
        frame = self.frame(body)
        if not isinstance(point, Marker):
            # A place says nothing of how the material there deforms.
            if body != GROUND and self.modes and self.modes[body]:
                raise ValueError(f"body {body} is flexible: give a marker instead of {point}, such as Marker.on_frame")
            arm = frame.turn(self.basis.vector(*point))
            material = frame._replace(origin=frame.origin + arm, velocity=frame.velocity_at(arm))
            return MaterialPoint(body, material, arm, frame.centripetal(arm))
        return self._marker(body, frame, point)

    def _marker(self, body: int, frame: Frame, marker: Marker) -> MaterialPoint:
        """Return the material point at a marker of a flexible body (M125)."""
        q, rate = self.modal(body)
        arm, moving = frame.turn(marker.place(q)), frame.turn(marker.displacement(rate))
        turned = marker.turn(q)
        # The frame's cosine and sine are known already: only the deformation's angle is evaluated, and added to it.
        cos, sin = cos_sin(jnp.reshape(turned, (1,)))
        shapes = zip(marker.displacement_x, marker.displacement_y, strict=True)
        material = plane.Frame(
            origin=frame.origin + arm,
            angle=frame.angle + turned,
            cos=frame.cos * cos[0] - frame.sin * sin[0],
            sin=frame.sin * cos[0] + frame.cos * sin[0],
            velocity=frame.velocity_at(arm) + moving,
            spin=frame.spin + marker.turn(rate),
        )
        return MaterialPoint(
            body=body,
            frame=material,
            arm=arm,
            # Centripetal and Coriolis acceleration.
            quadratic=frame.centripetal(arm) + moving.perp() * (2.0 * frame.spin),
            shapes=tuple(frame.turn(plane.Vector(x, y)) for x, y in shapes),
            rotations=tuple(marker.rotation),
        )
