"""What the latches exert once they close: they hold the tip's centre in its seat and the probe along the cone's axis.

Their forces grow with the share c of M175, from 0 where the tip crosses the capture plane to 1 when they are closed.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar
from ...multibody import Block, Kinematics, Load, MaterialPoint, System, load_at
from ...plane import Vector
from ..linearisation import SpringTerm
from .assembly import P, T
from .design import Design
from .parts import Latch


class LatchPosture(NamedTuple):
    """The latches at one instant.

    - ``share``: c, how far they are closed [-].
    - ``share_rate``: ċ [1/s].
    - ``off_seat``: r, from the seat to the tip's centre [m].
    - ``velocity``: u of the tip's centre less that of T's material point there [m/s].
    - ``angle``, ``spin``: of the probe against T [rad, rad/s].
    - ``tip``, ``opposite``: the tip's centre on the probe, and T's material point there.
    """

    share: Scalar
    share_rate: Scalar
    off_seat: Vector
    velocity: Vector
    angle: Scalar
    spin: Scalar
    tip: MaterialPoint
    opposite: MaterialPoint


class LatchForce(eqx.Module):
    """The latches of a design, which has some; ``seat``: K in the axes of T [m] (M175)."""

    latch: Latch
    seat: Vector

    def __init__(self, design: Design):
        self.latch = design.latch
        plane = -design.cone.offset - design.probe.tip_radius * jnp.sin(design.cone.half_angle)
        self.seat = Vector(plane + design.latch.depth, 0.0)

    def posture(self, kin: Kinematics, tip: MaterialPoint, since: Scalar) -> LatchPosture:
        """Return where the latches are, ``since`` [s] after the tip crossed the capture plane."""
        cone, probe = kin.frame(T), kin.frame(P)
        off_cone = tip.place - cone.origin
        local = cone.unturn(off_cone)
        opposite = kin.point(T, (local.x, local.y))
        share, rate = self._share(jnp.asarray(since, float))
        return LatchPosture(
            share=share,
            share_rate=rate,
            off_seat=off_cone - cone.turn(self.seat),
            velocity=tip.velocity - opposite.velocity,
            angle=probe.angle - cone.angle,
            spin=probe.spin - cone.spin,
            tip=tip,
            opposite=opposite,
        )

    def _share(self, since: Float[Array, ""]) -> tuple[Scalar, Scalar]:
        """c and ċ [1/s]: with a closing time of zero the latches are closed at once."""
        time = jnp.asarray(self.latch.closing_time, float)
        at_once = time == 0.0
        rate = 1.0 / jnp.where(at_once, 1.0, time)
        x = jnp.clip(since * rate, 0.0, 1.0)
        share = jnp.where(at_once, 1.0, x * x * (3.0 - 2.0 * x))
        return share, jnp.where(at_once, 0.0, 6.0 * x * (1.0 - x) * rate)

    def force(self, at: LatchPosture) -> Vector:
        """Return the force on the tip [N] (M175)."""
        length = self.latch.preload_length
        pull = self.latch.preload / jnp.sqrt(at.off_seat.dot(at.off_seat) + length * length)
        elastic = at.off_seat * (self.latch.stiffness + pull)
        return (elastic + at.velocity * self.latch.damping) * -at.share

    def size(self, at: LatchPosture) -> Scalar:
        """Return the size of that force [N]."""
        force = self.force(at)
        return jnp.sqrt(force.dot(force) + 1e-24)

    def moment(self, at: LatchPosture) -> Scalar:
        """Return the moment on the probe [N m] (M176)."""
        return -at.share * (self.latch.turn_stiffness * at.angle + self.latch.turn_damping * at.spin)

    def loads(self, at: LatchPosture) -> tuple[Load, ...]:
        """Return what acts on probe and passive vehicle, at the same point."""
        force, moment = self.force(at), self.moment(at)
        none = Vector(0.0, 0.0)
        on_tip, on_cone = load_at(at.tip, force), load_at(at.opposite, -force)
        return on_tip, on_cone, Load(P, none, moment), Load(T, none, -moment)

    def _closed_energy(self, at: LatchPosture) -> Scalar:
        """What closed latches would store [J]."""
        square, length = at.off_seat.dot(at.off_seat), self.latch.preload_length
        spring = 0.5 * self.latch.stiffness * square + 0.5 * self.latch.turn_stiffness * at.angle**2
        return spring + self.latch.preload * (jnp.sqrt(square + length * length) - length)

    def stored(self, at: LatchPosture) -> Scalar:
        """Return the energy that the latches store [J]."""
        return at.share * self._closed_energy(at)

    def closing_power(self, at: LatchPosture) -> Scalar:
        """Return what closing them puts in [W]."""
        return at.share_rate * self._closed_energy(at)

    def loss(self, at: LatchPosture) -> Scalar:
        """Return the power lost in the latches [W]."""
        sliding = self.latch.damping * at.velocity.dot(at.velocity)
        return at.share * (sliding + self.latch.turn_damping * at.spin**2)

    def terms(self, system: System, at: LatchPosture, spins: int) -> list[SpringTerm]:
        """Return their share of the linearisation: along x, along y and about the tip's centre. ``spins``: how many
        velocities follow the coordinates'."""
        length = self.latch.preload_length
        square = at.off_seat.dot(at.off_seat) + length * length
        pull = self.latch.preload / jnp.sqrt(square)
        stiffness, damping = at.share * (self.latch.stiffness + pull), at.share * self.latch.damping
        axes = (Vector(1.0, 0.0), Vector(0.0, 1.0))
        blocks: list[dict[int, Block]] = [{P: at.tip.along(axis), T: at.opposite.along(-axis)} for axis in axes]
        turning: dict[int, Block] = {P: (0.0, 0.0, 1.0), T: (0.0, 0.0, -1.0)}
        directions = [jnp.pad(system.direction(block), (0, spins)) for block in (*blocks, turning)]
        turn = (at.share * self.latch.turn_stiffness, at.share * self.latch.turn_damping)
        slopes = ((stiffness, damping), (stiffness, damping), turn)
        return [SpringTerm(along, *slope) for along, slope in zip(directions, slopes, strict=True)]
