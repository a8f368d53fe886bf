"""A ball, or a pin, against a shape fixed on another body: from two bodies' motion to contact forces.

Everything here may be an array over the segments of the pair, so that a cone's flanks are treated together.
"""

from typing import NamedTuple

import equinox as eqx

from .._types import Scalar, Values
from .friction import RegularisedCoulomb
from .laws import ContactLaw
from .shapes import Shape


class Ball(NamedTuple):
    """A ball's centre and its motion, in inertial axes.

    - ``x``, ``y``: the centre [m].
    - ``velocity_x``, ``velocity_y``: of the centre [m/s].
    - ``spin``: [rad/s].
    """

    x: Scalar
    y: Scalar
    velocity_x: Scalar
    velocity_y: Scalar
    spin: Scalar


class Carrier(NamedTuple):
    """Pose and motion of the body that carries the shape, in inertial axes.

    - ``x``, ``y``: its centre of mass [m].
    - ``cos``, ``sin``: of its angle [-].
    - ``velocity_x``, ``velocity_y``: of its centre of mass [m/s].
    - ``spin``: [rad/s].
    """

    x: Scalar
    y: Scalar
    cos: Scalar
    sin: Scalar
    velocity_x: Scalar
    velocity_y: Scalar
    spin: Scalar


class Approach(NamedTuple):
    """Geometry and relative motion of the pair before any force (M31, M32), an entry a segment; axes are inertial.

    - ``gap``: from the ball's surface to the shape, negative in contact [m].
    - ``approach_speed``: δ̇ of the material points at the foot [m/s].
    - ``slip``: v_t of the same points along the tangent [m/s].
    - ``normal_x``, ``normal_y``: unit normal, from the foot to the ball's centre [-].
    - ``tangent_x``, ``tangent_y``: unit tangent [-].
    - ``foot_x``, ``foot_y``: arm of the foot from the carrier's centre of mass [m].
    - ``distance``: from the foot to the ball's centre [m].
    """

    gap: Values
    approach_speed: Values
    slip: Values
    normal_x: Values
    normal_y: Values
    tangent_x: Values
    tangent_y: Values
    foot_x: Values
    foot_y: Values
    distance: Values


class BallPair(eqx.Module):
    """A ball on segments, or a pin in a hole, with a normal law and friction.

    - ``radius``: of the ball or pin [m].
    - ``shape``: `Segment` or `Hole`, in the axes of the body that carries it.
    - ``side``: an entry a segment: where its front is, +1 to the right of its direction, -1 to the left. The tangent is
      opposite to the direction; on a cone both tangents then point along their flanks towards the throat. Of a hole
      only the tangent's sign.
    - ``law``: of the normal force.
    - ``friction``: of the tangential force.
    """

    radius: Scalar
    shape: Shape
    side: Values | Scalar
    law: ContactLaw
    friction: RegularisedCoulomb

    def approach(self, ball: Ball, body: Carrier) -> Approach:
        """Return the gap, speeds and directions of the pair (M31, M32).

        **Arguments:** ``ball``; ``body``: the one that carries the shape.
        """
        off_x, off_y = ball.x - body.x, ball.y - body.y
        local_x = body.cos * off_x + body.sin * off_y
        local_y = body.cos * off_y - body.sin * off_x
        foot = self.shape.foot(local_x, local_y, self.side)
        normal_x = body.cos * foot.normal_x - body.sin * foot.normal_y
        normal_y = body.sin * foot.normal_x + body.cos * foot.normal_y
        foot_x = body.cos * foot.x - body.sin * foot.y
        foot_y = body.sin * foot.x + body.cos * foot.y
        # With the side's sign the tangents of both flanks of a cone point to the throat, so that slips compare.
        tangent_x, tangent_y = self.side * normal_y, -self.side * normal_x
        # Material points at the foot; seen from the ball's centre the foot lies at -distance · normal.
        relative_x = ball.velocity_x + ball.spin * foot.distance * normal_y - (body.velocity_x - body.spin * foot_y)
        relative_y = ball.velocity_y - ball.spin * foot.distance * normal_x - (body.velocity_y + body.spin * foot_x)
        return Approach(
            gap=foot.distance - self.radius,
            approach_speed=-(relative_x * normal_x + relative_y * normal_y),
            slip=relative_x * tangent_x + relative_y * tangent_y,
            normal_x=normal_x,
            normal_y=normal_y,
            tangent_x=tangent_x,
            tangent_y=tangent_y,
            foot_x=foot_x,
            foot_y=foot_y,
            distance=foot.distance,
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
