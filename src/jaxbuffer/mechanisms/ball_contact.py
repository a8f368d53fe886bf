"""A ball or a pin fixed on one body of a system, against a shape fixed on another."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array

from ..contact import Approach, Ball, BallPair, Carrier
from ..multibody import Kinematics, Load, MaterialPoint, Point, load_at
from ..plane import Vector


class BallContact(eqx.Module):
    """A ball fixed on ``body``, its centre at ``point``, against a shape on ``carrier`` (or the ground).

    ``pair``: the shape (one segment, or a hole), law and friction. The shape's axes have their origin at
    ``carrier_point``; on a flexible carrier the shape moves and turns with the material there.
    """

    body: int = eqx.field(static=True)
    carrier: int = eqx.field(static=True)
    pair: BallPair
    point: Point = (0.0, 0.0)
    carrier_point: Point = (0.0, 0.0)

    def approach(self, kin: Kinematics) -> tuple[Approach, MaterialPoint, MaterialPoint]:
        """Geometry and relative motion, an entry long; the ball's centre and the origin of the shape's axes."""
        centre, origin = kin.point(self.body, self.point), kin.point(self.carrier, self.carrier_point)
        ball = Ball(*centre.place, *centre.velocity, centre.spin)
        carrier = Carrier(*origin.place, origin.cos, origin.sin, *origin.velocity, origin.spin)
        approach = Approach(*(jnp.reshape(part, (1,)) for part in self.pair.approach(ball, carrier)))
        return approach, centre, origin

    def loads(
        self, at: Approach, centre: MaterialPoint, origin: MaterialPoint, normal: Array, friction: Array
    ) -> tuple[Load, Load]:
        """Loads on both bodies at the foot, of the forces F_n and F_t [N]."""
        x, y = normal * at.normal_x + friction * at.tangent_x, normal * at.normal_y + friction * at.tangent_y
        push = Vector(x[0], y[0])
        to_foot = Vector(-(at.distance * at.normal_x)[0], -(at.distance * at.normal_y)[0])
        foot = Vector(at.foot_x[0], at.foot_y[0])
        return load_at(centre, push, to_foot.cross(push)), load_at(origin, -push, -foot.cross(push))
