"""A ball against segments fixed on another body: from two bodies' motion to contact forces.

Everything here may be an array over the segments of the pair, so that a cone's flanks are treated together.
"""

from typing import NamedTuple

import equinox as eqx

from .._types import Scalar, Values
from .friction import RegularisedCoulomb
from .laws import ContactLaw
from .shapes import Segment


class Ball(NamedTuple):
    """The ball's centre and motion in the axes of the inertial frame [m, m/s, rad/s]."""

    x: Scalar
    y: Scalar
    velocity_x: Scalar
    velocity_y: Scalar
    spin: Scalar


class Carrier(NamedTuple):
    """Pose and motion of the body that carries the segments [m, rad, m/s, rad/s]."""

    x: Scalar
    y: Scalar
    cos: Scalar
    sin: Scalar
    velocity_x: Scalar
    velocity_y: Scalar
    spin: Scalar


class Approach(NamedTuple):
    """The pair's geometry and relative motion, before any force.

    ``gap`` [m], ``approach_speed`` δ̇ [m/s] and ``slip`` v_t [m/s] of the material points at the foot; ``slant`` of the
    foot along the segment [m]; unit normal (segment → ball) and tangent, and the foot's arm from the body's origin, in
    inertial axes; ``distance`` foot - centre [m].
    """

    gap: Values
    approach_speed: Values
    slip: Values
    slant: Values
    normal_x: Values
    normal_y: Values
    tangent_x: Values
    tangent_y: Values
    foot_x: Values
    foot_y: Values
    distance: Values


class BallOnSegments(eqx.Module):
    """A ball of ``radius`` [m] against ``segments`` with a normal law and friction.

    ``side``: +1 where the tangent is the normal turned by -90°, -1 where by +90°, so that it points along the flank
    towards the throat on either side of a cone.
    """

    radius: Scalar
    segments: Segment
    side: Values
    law: ContactLaw
    friction: RegularisedCoulomb

    def approach(self, ball: Ball, body: Carrier) -> Approach:
        """Gap, speeds and directions of the pair."""
        off_x, off_y = ball.x - body.x, ball.y - body.y
        local_x = body.cos * off_x + body.sin * off_y
        local_y = body.cos * off_y - body.sin * off_x
        foot = self.segments.foot(local_x, local_y)
        normal_x = body.cos * foot.normal_x - body.sin * foot.normal_y
        normal_y = body.sin * foot.normal_x + body.cos * foot.normal_y
        foot_x = body.cos * foot.x - body.sin * foot.y
        foot_y = body.sin * foot.x + body.cos * foot.y
        tangent_x, tangent_y = self.side * normal_y, -self.side * normal_x
        # Material points at the foot; seen from the ball's centre the foot lies at -distance · normal.
        relative_x = ball.velocity_x + ball.spin * foot.distance * normal_y - (body.velocity_x - body.spin * foot_y)
        relative_y = ball.velocity_y - ball.spin * foot.distance * normal_x - (body.velocity_y + body.spin * foot_x)
        return Approach(
            gap=foot.distance - self.radius,
            approach_speed=-(relative_x * normal_x + relative_y * normal_y),
            slip=relative_x * tangent_x + relative_y * tangent_y,
            slant=foot.slant,
            normal_x=normal_x,
            normal_y=normal_y,
            tangent_x=tangent_x,
            tangent_y=tangent_y,
            foot_x=foot_x,
            foot_y=foot_y,
            distance=foot.distance,
        )

    def normal_force(self, approach: Approach, touchdown_speed: Values) -> Values:
        """F_n [N] of each segment, as if all were in contact."""
        return self.law.force(-approach.gap, approach.approach_speed, touchdown_speed)

    def friction_force(self, approach: Approach, normal_force: Values) -> Values:
        """F_t [N] along each tangent."""
        return self.friction.force(normal_force, approach.slip)

    def stored_energy(self, approach: Approach) -> Values:
        """Elastic energy of each contact [J], as if all were in contact."""
        return self.law.energy(-approach.gap)

    def hysteresis_power(self, approach: Approach, normal_force: Values) -> Values:
        """Power lost inside each contact, (F_n - K δ^{3/2}) δ̇ [W]: what the force takes less than the spring in it."""
        return (normal_force - self.law.elastic(-approach.gap)) * approach.approach_speed
