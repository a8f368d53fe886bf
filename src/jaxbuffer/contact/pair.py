"""A ball, or a pin, against a shape fixed on another body: from two bodies' motion to contact forces.

Everything here may be an array over the segments of the pair, so that a cone's flanks are treated together.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp

from .._types import Scalar, Values
from ..duplication import evaluated_once
from ..space.either import Frame, Vector
from .friction import RegularisedCoulomb
from .laws import ContactLaw
from .shapes import Shape


class Approach(NamedTuple):
    """Geometry and relative motion of the pair before any force (M31, M32), an entry a segment; axes are inertial.

    - ``gap``: from the ball's surface to the shape, negative in contact [m].
    - ``approach_speed``: δ̇ of the material points at the foot [m/s].
    - ``slip``: v_t of the same points along the tangent [m/s].
    - ``normal``: unit normal, from the foot to the ball's centre [-].
    - ``tangent``: unit tangent, in space the direction of the slip [-].
    - ``foot``: arm of the foot from the origin of the shape's axes [m].
    - ``distance``: from the foot to the ball's centre [m].
    """

    gap: Values
    approach_speed: Values
    slip: Values
    normal: Vector
    tangent: Vector
    foot: Vector
    distance: Values


class BallPair(eqx.Module):
    """A ball on segments, or a pin in a hole, with a normal law and friction.

    - ``radius``: of the ball or pin [m].
    - ``shape``: `Segment` or `Hole`, in space `Revolved`, in the axes of the body that carries it.
    - ``side``: an entry a segment: where its front is, +1 to the right of its direction, -1 to the left. The tangent is
      opposite to the direction; on a cone both tangents then point along their flanks towards the throat. Of a hole
      only the tangent's sign; of a surface of revolution that of its meridian.
    - ``law``: of the normal force.
    - ``friction``: of the tangential force.
    """

    radius: Scalar
    shape: Shape
    side: Values | Scalar
    law: ContactLaw
    friction: RegularisedCoulomb

    def approach(self, ball: Frame, body: Frame) -> Approach:
        """Return the gap, speeds and directions of the pair (M31, M32).

        **Arguments:** ``ball``: its centre, and how it turns; ``body``: the origin of the shape's axes, and how they
        turn.
        """
        # All that is known of a contact is computed from these two, in many loops of the compiled program.
        place = evaluated_once(body.unturn(ball.origin - body.origin))
        near = evaluated_once(self.shape.nearest(place, self.side, self.radius))
        normal, foot = body.turn(near.normal), body.turn(near.foot)
        # Material points at the foot; seen from the ball's centre the foot lies at -distance · normal.
        turning = ball._replace(spin=ball.spin * -near.distance).rate_of(normal)
        relative = ball.velocity + turning - body.velocity_at(foot)
        tangent, slip = self.shape.slip(relative, normal, self.side)
        return Approach(
            gap=near.distance - self.radius,
            approach_speed=-jnp.asarray(relative.dot(normal)),
            slip=slip,
            normal=normal,
            tangent=tangent,
            foot=foot,
            distance=near.distance,
        )

    def normal_force(self, approach: Approach, touchdown_speed: Values) -> Values:
        """Return F_n of each segment [N], as if all were in contact.

        **Arguments:** ``approach``; ``touchdown_speed``: δ̇⁻ of each segment [m/s] (M36).
        """
        return self.law.force(-approach.gap, approach.approach_speed, touchdown_speed)

    def friction_force(self, approach: Approach, normal_force: Values) -> Values:
        """Return F_t of each segment along its tangent [N] (M59).

        **Arguments:** ``approach``; ``normal_force``: F_n of each segment [N].
        """
        return self.friction.force(normal_force, approach.slip)

    def stored_energy(self, approach: Approach) -> Values:
        """Return the energy stored in each contact [J], as if all were in contact (M37)."""
        return self.law.energy(-approach.gap)

    def hysteresis_power(self, approach: Approach, normal_force: Values) -> Values:
        """Return the power lost in each contact [W]: what the force takes less what the spring in it takes (M37).

        **Arguments:** ``approach``; ``normal_force``: F_n of each segment [N].
        """
        return (normal_force - self.law.elastic(-approach.gap)) * approach.approach_speed
