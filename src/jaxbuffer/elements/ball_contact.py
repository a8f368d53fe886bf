"""A ball or a pin on one body of a system, against the segments of a shape, or a hole, on another."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from ..contact import Approach, Ball, BallPair, Carrier, Segment
from ..multibody import Kinematics, Load, MaterialPoint, Point, System, load_at
from ..plane import Vector
from .stiff_terms import ContactTerm, contact_directions, contact_slopes

SLIP_SPEEDS = 10.0  # the largest slip, in slip speeds, that its error may be relative to (docs/decisions.md)

Segments = Float[Array, " segments"]


class BallState(NamedTuple):
    """A ball and its shape at one instant.

    - ``approach``: geometry and relative motion, an entry a segment.
    - ``centre``: the ball's centre on its body.
    - ``origin``: the origin of the shape's axes on its carrier.
    - ``spin``: of the ball [rad/s].
    """

    approach: Approach
    centre: MaterialPoint
    origin: MaterialPoint
    spin: Scalar


class ContactForces(NamedTuple):
    """``normal``: F_n, and ``friction``: F_t along the tangent, an entry a segment [N]."""

    normal: Segments
    friction: Segments


class BallContact(eqx.Module):
    """A ball on ``body``, its centre at ``point``, against a shape on ``carrier`` (or the ground).

    - ``body``, ``carrier``: indices of the bodies.
    - ``pair``: the shape (segments, or a hole), law and friction.
    - ``point``: the ball's centre on its body.
    - ``carrier_point``: the origin of the shape's axes; on a flexible carrier the shape moves and turns with the
      material there.
    - ``names``: of the segments, whose contact forces are watched; empty: "contact 1" and so on.
    - ``spin_inertia``: of a ball that spins freely on its body, with a velocity of its own [kg m²]; None: it is fixed.
    - ``onset_length``: over which the force of a contact without events sets in, open or closed (M60) [m]; None: the
      contact opens and closes by events.
    - ``fixed_foot``: where along its segment the force acts on the carrier, wherever the foot is, as the paper has it
      [m]; None: at the foot. That conserves no angular momentum; it is there for comparison.
    """

    body: int = eqx.field(static=True)
    carrier: int = eqx.field(static=True)
    pair: BallPair
    point: Point = (0.0, 0.0)
    carrier_point: Point = (0.0, 0.0)
    names: tuple[str, ...] = eqx.field(static=True, default=())
    spin_inertia: Scalar | None = None
    onset_length: Scalar | None = None
    fixed_foot: Scalar | None = None

    @property
    def segments(self) -> int:
        """Return the number of segments, each of which has impacts of its own."""
        return len(self.names) or 1

    @property
    def spins(self) -> bool:
        """Return whether the ball spins by itself."""
        return self.spin_inertia is not None

    @property
    def spin_scale_limit(self) -> Scalar:
        """Return the largest magnitude that errors of the spin of a ball that spins freely may be relative to [rad/s].

        A ball that sticks slips by less than the slip speed, so an error of that size, however small beside its spin,
        changes the sign of its friction: the hinge force is then off by up to half, and steps chatter about sticking.
        """
        return SLIP_SPEEDS * self.pair.friction.slip_speed / self.pair.radius

    @property
    def balanced(self) -> bool:
        """Return whether `stored` and `losses` hold the work of its forces: not that of a force that sets in without an
        event, nor of one that acts elsewhere than where the bodies touch."""
        return self.onset_length is None and self.fixed_foot is None

    def evaluate(self, kin: Kinematics, spin: Scalar | None = None) -> BallState:
        """Return geometry and relative motion. ``spin``: of a ball that spins freely [rad/s]."""
        centre, origin = kin.point(self.body, self.point), kin.point(self.carrier, self.carrier_point)
        turning = centre.spin if spin is None else spin
        ball = Ball(*centre.place, *centre.velocity, turning)
        carrier = Carrier(*origin.place, origin.cos, origin.sin, *origin.velocity, origin.spin)
        approach = self.pair.approach(ball, carrier)
        if self.segments == 1:
            # One segment has an axis too, so that all that follows treats one and several alike.
            approach = Approach(*(jnp.reshape(part, (1,)) for part in approach))
        return BallState(approach, centre, origin, turning)

    def forces(self, at: BallState, memory: Segments, closed: Segments) -> ContactForces:
        """Return F_n and F_t. ``memory``: δ̇⁻ of each segment [m/s]; ``closed``: 1 where the contact is closed."""
        normal = self._exerting(closed) * self.pair.normal_force(self._onset(at.approach), memory)
        return ContactForces(normal, self.pair.friction_force(at.approach, normal))

    def _exerting(self, closed: Segments) -> Segments:
        """Return 1 for segments whose force follows the gap, 0 for open ones."""
        # Without events nothing says that a contact has closed: the rounded penetration alone does (M60).
        return closed if self.onset_length is None else jnp.ones(self.segments)

    def _onset(self, approach: Approach) -> Approach:
        """Return the approach with its penetration rounded over the onset length, if there is one (M60)."""
        if self.onset_length is None:
            return approach
        gap, onset = approach.gap, self.onset_length
        return approach._replace(gap=0.5 * (gap - jnp.sqrt(gap * gap + onset * onset)))

    def loads(self, at: BallState, forces: ContactForces) -> tuple[Load, Load]:
        """Return the loads on both bodies at the foot (M33)."""
        a = at.approach
        x, y = self._force_of_segments(a, forces)
        push = Vector(jnp.sum(x), jnp.sum(y))
        foot_x: Array | float = a.foot_x
        foot_y: Array | float = a.foot_y
        if self.fixed_foot is not None:
            # The paper's arm is fixed in the carrier, where the first contact was (M34).
            shape, axes = self.pair.shape, at.origin
            assert isinstance(shape, Segment)
            frozen_x = shape.start_x + self.fixed_foot * shape.direction_x
            frozen_y = shape.start_y + self.fixed_foot * shape.direction_y
            foot_x, foot_y = axes.cos * frozen_x - axes.sin * frozen_y, axes.sin * frozen_x + axes.cos * frozen_y
        on_carrier = -jnp.sum(foot_x * y - foot_y * x)
        # A ball that spins freely takes this moment by itself (M8); its body feels the force alone.
        on_ball = 0.0 if self.spins else self.spin_moment(at, forces)
        return load_at(at.centre, push, on_ball), load_at(at.origin, -push, on_carrier)

    def _force_of_segments(self, a: Approach, forces: ContactForces) -> tuple[Segments, Segments]:
        """Return the force on the ball in inertial axes, an entry a segment [N]."""
        x = forces.normal * a.normal_x + forces.friction * a.tangent_x
        return x, forces.normal * a.normal_y + forces.friction * a.tangent_y

    def spin_moment(self, at: BallState, forces: ContactForces) -> Scalar:
        """Return the moment on the ball about its centre [N m] (M34)."""
        if self.fixed_foot is not None:
            return jnp.zeros(())
        a = at.approach
        x, y = self._force_of_segments(a, forces)
        # About the ball's centre the foot's arm is -distance · normal, so only friction turns the ball.
        return -jnp.sum(a.distance * (a.normal_x * y - a.normal_y * x))

    def stored(self, at: BallState, closed: Segments) -> Scalar:
        """Return the energy that the contact stores [J]."""
        return jnp.sum(self._exerting(closed) * self.pair.stored_energy(self._onset(at.approach)))

    def losses(self, at: BallState, forces: ContactForces, closed: Segments) -> tuple[Scalar, Scalar]:
        """Return the powers lost in hysteresis and in friction [W]."""
        power = self.pair.hysteresis_power(self._onset(at.approach), forces.normal)
        return jnp.sum(self._exerting(closed) * power), -jnp.sum(forces.friction * at.approach.slip)

    def directions(self, system: System, at: BallState) -> tuple[Array, Array]:
        """Return columns b with δ̇ = b·w and columns b with v_t = b·w, one a segment."""
        side = jnp.reshape(jnp.asarray(self.pair.side, float), (self.segments,))
        return contact_directions(system, at.approach, side, at.centre, at.origin, self.spins)

    def term(self, system: System, at: BallState, memory: Segments, closed: Segments) -> ContactTerm:
        """Return the contact's share of the stiff part."""
        slopes = contact_slopes(self.pair, self._onset(at.approach), memory, self._exerting(closed))
        return ContactTerm(*self.directions(system, at), *slopes)
