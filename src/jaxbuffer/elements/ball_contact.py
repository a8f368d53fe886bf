"""A ball or a pin on one body of a system, against the segments of a shape, or a hole, on another (M29 to M36).

In space the shape is a surface of revolution.
"""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar
from ..basis import AnyBasis, components, turn_array
from ..contact import Approach, BallPair, Revolved, Segment
from ..errors import InputError, concrete
from ..multibody import Kinematics, Load, MaterialPoint, Point, System, load_at
from ..plane import PLANE, Vector
from ..space.either import Turn
from ..space.either import Vector as AnyVector
from .element import ROUNDED_LENGTH, Closed, ContactForces, Element, Magnitudes, Own, Switch
from .report import Report
from .stiff_terms import ContactTerm, SpringTerm, contact_directions, contact_slopes

SLIP_SPEEDS = 10.0  # the largest slip, in slip speeds, that its error may be relative to (docs/decisions.md)
SLOWEST_TOUCHDOWN, SLOWEST_SHARE = 1e-5, 1e-3  # m/s, and of a typical speed: the least δ̇⁻ is the smaller one (M36)
ONSET = 1e-8  # m, over which a smooth memory is let go where a contact opens (M61)
HYSTERESIS, FRICTION = "hysteresis", "friction"  # where contacts lose energy
DEEPEST = 0.99  # of a ball's radius

Segments = Float[Array, " segments"]
FirstContact = Callable[[Segments, Scalar], tuple[Segments, Segments]]


class BallState(NamedTuple):
    """A ball and its shape at one instant.

    - ``approach``: geometry and relative motion, an entry a segment.
    - ``centre``: the ball's centre on its body.
    - ``origin``: the origin of the shape's axes on its carrier.
    - ``spin``: of the ball [rad/s], in space a vector.
    - ``memory``: δ̇⁻, the approach speed of each segment at its last touchdown [m/s].
    - ``forces``: where they are known already.
    """

    approach: Approach
    centre: MaterialPoint
    origin: MaterialPoint
    spin: Turn
    memory: Segments
    forces: ContactForces | None = None


def slowest_touchdown(speed: Scalar) -> Scalar:
    """Return the least memory of a touchdown [m/s] (M36), of a mechanism whose speeds are of the order of ``speed``:
    small beside these, however slow it is."""
    # It bounds a division and is no part of the physics, so nothing is differentiated through it.
    return jnp.minimum(SLOWEST_TOUCHDOWN, SLOWEST_SHARE * jax.lax.stop_gradient(speed))


class BallContact(Element):
    """A ball on ``body``, its centre at ``point``, against a shape on ``carrier`` (or the ground).

    Each segment is a switch that closes by an impact and opens again. The contact remembers the approach speed of each
    one's last touchdown, on which its damping depends.

    - ``body``, ``carrier``: indices of the bodies.
    - ``pair``: the shape (segments, or a hole), law and friction.
    - ``point``: the ball's centre on its body.
    - ``carrier_point``: the origin of the shape's axes; on a flexible carrier the shape moves and turns with the
      material there.
    - ``name``: of the contact, and in space part of the names of the force on the ball in a history, "tip_force_x" say,
      in inertial axes [N].
    - ``names``: of the segments, whose contact forces are watched; empty: the one segment has the contact's name.
    - ``spin_inertia``: of a ball that spins freely on its body, with velocities of its own, one or in space three
      [kg m²]; None: it is fixed.
    - ``onset_length``: over which the force of a contact without events sets in, open or closed (M60) [m]; None: the
      contact opens and closes by events.
    - ``fixed_foot``: where along its segment the force acts on the carrier, wherever the foot is, as the paper has it
      [m]; None: at the foot. That conserves no angular momentum; it is there for comparison, in the plane.
    - ``memory_time``: [s]; if given, no event sets the memory: it follows the approach speed while the contact is open
      (M61).
    - ``first_contact``: which segments are closed at t = 0, unless the mechanism says it, and their memory there [m/s],
      from their approach speeds and the least memory [m/s]; None: they are open, and the memory is the approach speed,
      of an open segment no less than the typical speed.
    - ``typical_speed``: that the mechanism's velocities are of the order of [m/s]; None: the mechanism says it.
    - ``basis``: of the mechanism, which says it.
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
    memory_time: Scalar | None = None
    first_contact: FirstContact | None = eqx.field(static=True, default=None)
    typical_speed: Scalar | None = None
    basis: AnyBasis = PLANE
    name: str = eqx.field(static=True, default="contact")

    def __check_init__(self) -> None:
        """Raise `InputError` for a memory that follows the approach speed in no time, or in one that is no number."""
        time = None if self.memory_time is None else concrete(self.memory_time)
        if time is not None and not np.all((time > 0.0) & np.isfinite(time)):
            raise InputError(f"memory_time of the contact {self.name!r} is {time} s: give a time above zero")

    @property
    def report(self) -> "BallReport":
        return BallReport(self)

    def in_mechanism(self, speed: Scalar, basis: AnyBasis) -> "BallContact":
        shape = self.pair.shape
        if isinstance(shape, Revolved) != (basis.dimensions == 3):
            raise InputError(
                f"the shape of the contact {self.name!r} is a {type(shape).__name__}: in the plane give a Segment or a"
                " Hole, in space a Revolved segment"
            )
        speed = speed if self.typical_speed is None else self.typical_speed
        return dataclasses.replace(self, typical_speed=speed, basis=basis)

    @property
    def segments(self) -> int:
        """Return the number of segments, each of which has impacts of its own."""
        return len(self.names) or 1

    @property
    def spins(self) -> bool:
        """Return whether the ball spins by itself."""
        return self.spin_inertia is not None

    @property
    def segment_names(self) -> tuple[str, ...]:
        """Return the name of each segment."""
        return self.names or (self.name,)

    @property
    def spin_inertias(self) -> tuple[Scalar, ...]:
        return () if self.spin_inertia is None else (self.spin_inertia,) * len(self.basis.unit_turns)

    @property
    def variables(self) -> tuple[str, ...]:
        spins = ("spin",) if len(self.spin_inertias) == 1 else ("spin_x", "spin_y", "spin_z")
        return (*spins * self.spins, *(f"touchdown_speed_{name}" for name in self.segment_names))

    def start(self, kin: Kinematics) -> Own:
        # Which segments are closed does not depend on the memory, which `after_start` sets.
        memory = jnp.ones(self.segments)
        # A ball that spins freely begins with the spin of its body.
        return jnp.append(turn_array(kin.point(self.body, self.point).spin), memory) if self.spins else memory

    def closed_at_start(self, at: BallState) -> list[Scalar]:
        if self.first_contact is None:
            return [jnp.zeros(self.segments)]
        return [self.first_contact(at.approach.approach_speed, self.slowest_touchdown)[0]]

    def after_start(self, at: BallState, own: Own, closed: Closed) -> tuple[BallState, Own]:
        speeds = at.approach.approach_speed
        if self.first_contact is None:
            # An open contact's memory only says how fast the first impact may be.
            memory = jnp.maximum(speeds, jnp.where(closed > 0.5, self.slowest_touchdown, self._speed))
        else:
            memory = self.first_contact(speeds, self.slowest_touchdown)[1]
        return at._replace(memory=memory), self._with_memory(own, memory)

    def _with_memory(self, own: Own, memory: Segments) -> Own:
        return jnp.concatenate([own[: len(self.spin_inertias)], memory]) if self.spins else memory

    def touchdown_speeds(self, own: Own) -> Segments:
        return own[len(self.spin_inertias) :] if self.spins else own

    @property
    def _speed(self) -> Scalar:
        assert self.typical_speed is not None, "a mechanism says it"
        return self.typical_speed

    @property
    def slowest_touchdown(self) -> Scalar:
        """Return the least memory of a touchdown [m/s] (M36)."""
        return slowest_touchdown(self._speed)

    @property
    def resets(self) -> bool:
        return self.memory_time is None

    def after_closing(self, at: BallState, own: Own, closing: Closed, speed: Scalar) -> Own:
        if not self.resets:
            return own
        touched = jnp.maximum(speed, self.slowest_touchdown)
        return self._with_memory(own, jnp.where(closing > 0.5, touched, self.touchdown_speeds(own)))

    def scales(self, size: Magnitudes) -> list[Scalar]:
        # A ball that rolls at the typical speed spins at that over its radius.
        return [size.speed / self.pair.radius] * len(self.spin_inertias) + [size.speed] * self.segments

    def scale_limits(self) -> list[Scalar] | None:
        limits = [self.spin_scale_limit] * len(self.spin_inertias)
        return [*limits, *[jnp.inf] * self.segments] if self.spins else None

    @property
    def switches(self) -> tuple[Switch, ...]:
        return tuple(Switch(name, force=name, impact=True) for name in self.segment_names)

    @property
    def jumps(self) -> bool:
        return self.pair.law.jumps

    def gap_depths(self) -> list[Scalar]:
        # Farther than its radius behind a flank the ball's centre is on the other side of it.
        flank = isinstance(self.pair.shape, Segment | Revolved)
        return [jnp.asarray(self.pair.radius) if flank else jnp.inf] * self.segments

    def gaps(self, at: BallState) -> list[tuple[Array, Array]]:
        return [(at.approach.gap, at.approach.approach_speed)]

    def roundoff(self) -> dict[str, Scalar]:
        if self.onset_length is None:
            return {}
        # Even a flank far away exerts something, which is rounding.
        return dict.fromkeys(self.segment_names, self.pair.law.elastic(jnp.asarray(ROUNDED_LENGTH)))

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

    def evaluate(self, kin: Kinematics, own: Own | None = None) -> BallState:
        """Return geometry and relative motion. Without ``own`` numbers the ball turns with its body, and its memory
        means nothing."""
        centre, origin = kin.point(self.body, self.point), kin.point(self.carrier, self.carrier_point)
        turning = centre.spin
        if own is not None and self.spins:
            turning = kin.basis.turn(*(own[k] for k in range(len(kin.basis.unit_turns))))
        approach = self.pair.approach(centre.frame._replace(spin=turning), origin.frame)
        # One segment has an axis too, so that all that follows treats one and several alike; so has what no segment
        # changes.
        approach = jax.tree.map(lambda part: jnp.broadcast_to(jnp.asarray(part), (self.segments,)), approach)
        memory = jnp.ones(self.segments) if own is None else self.touchdown_speeds(own)
        return BallState(approach, centre, origin, turning, memory)

    def contact_forces(self, at: BallState, closed: Closed) -> ContactForces:
        if at.forces is not None:
            return at.forces
        normal = self._exerting(closed) * self.pair.normal_force(self._onset(at.approach), at.memory)
        return ContactForces(normal, self.pair.friction_force(at.approach, normal))

    def recorded(self, at: BallState, closed: Closed) -> dict[str, Scalar]:
        if self.basis.dimensions == PLANE.dimensions:
            return {}  # there normal force and friction say all
        push = _sum(self._force_of_segments(at.approach, self.contact_forces(at, closed)))
        return {f"{self.name}_force_{axis}": entry for axis, entry in zip("xyz", components(push), strict=True)}

    def with_forces(self, at: BallState, closed: Closed) -> BallState:
        return at._replace(forces=self.contact_forces(at, closed))

    def slips(self, at: BallState) -> Segments:
        return at.approach.slip

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

    def loads(self, at: BallState, closed: Closed) -> tuple[Load, ...]:
        return self.loads_of(at, self.contact_forces(at, closed))

    def loads_of(self, at: BallState, forces: ContactForces) -> tuple[Load, Load]:
        """Return the loads on both bodies at the foot (M33)."""
        each, foot = self._force_of_segments(at.approach, forces), at.approach.foot
        push = _sum(each)
        if self.fixed_foot is not None:
            # The paper's arm is fixed in the carrier, where the first contact was (M34).
            shape, axes = self.pair.shape, at.origin
            assert isinstance(shape, Segment)
            along = Vector(shape.direction_x, shape.direction_y) * self.fixed_foot
            foot = axes.turn(Vector(shape.start_x, shape.start_y) + along)
        on_carrier = -_sum(foot.cross(each))
        # A ball that spins freely takes this moment by itself (M8); its body feels the force alone.
        on_ball = 0.0 if self.spins else self.spin_moment(at, forces)
        return load_at(at.centre, push, on_ball), load_at(at.origin, -push, on_carrier)

    def _force_of_segments(self, a: Approach, forces: ContactForces) -> AnyVector:
        """Return the force on the ball in inertial axes, an entry a segment [N]."""
        return a.normal * forces.normal + a.tangent * forces.friction

    def spin_moment(self, at: BallState, forces: ContactForces) -> Turn:
        """Return the moment on the ball about its centre [N m] (M34)."""
        if self.fixed_foot is not None:
            return jnp.zeros(())
        # About the ball's centre the foot's arm is -distance · normal, so only friction turns the ball.
        arm = at.approach.normal
        return -_sum(arm.cross(self._force_of_segments(at.approach, forces)) * at.approach.distance)

    def rates(self, at: BallState, closed: Closed) -> list[Scalar]:
        moment = components(self.spin_moment(at, self.contact_forces(at, closed))) if self.spins else ()
        spins = [entry / inertia for entry, inertia in zip(moment, self.spin_inertias, strict=True)]
        if self.memory_time is None:
            return [*spins, *[0.0] * self.segments]
        follows = self._memory_decay(at) * (jnp.maximum(at.approach.approach_speed, self.slowest_touchdown) - at.memory)
        return [*spins, *follows]

    def _memory_decay(self, at: BallState) -> Segments:
        """Return how fast the memory follows the approach speed [1/s]."""
        # It follows while the contact is open and stays while it is closed, with a smooth change between the two (M61),
        # over the length over which the force sets in, if there is one.
        assert self.memory_time is not None
        onset = ONSET if self.onset_length is None else self.onset_length
        return 0.5 * (1.0 + jnp.tanh(at.approach.gap / onset)) / self.memory_time

    def decays(self, at: BallState) -> list[Scalar] | None:
        return None if self.memory_time is None else [*[0.0] * len(self.spin_inertias), *self._memory_decay(at)]

    def elastic_energy(self, at: BallState, closed: Closed) -> Scalar:
        """Return the energy that the contact stores [J]."""
        return jnp.sum(self._exerting(closed) * self.pair.stored_energy(self._onset(at.approach)))

    def stored(self, at: BallState, closed: Closed) -> dict[str, Scalar]:
        return {"contact": self.elastic_energy(at, closed)}

    @property
    def loss_names(self) -> tuple[str, ...]:
        return (HYSTERESIS, FRICTION)

    def losses(self, at: BallState, closed: Closed) -> dict[str, Scalar]:
        forces = self.contact_forces(at, closed)
        power = self.pair.hysteresis_power(self._onset(at.approach), forces.normal)
        lost = jnp.sum(self._exerting(closed) * power)
        return {HYSTERESIS: lost, FRICTION: -jnp.sum(forces.friction * at.approach.slip)}

    @property
    def outcomes(self) -> tuple[str, ...]:
        return ("failed_penetration",)

    def guards(self, at: BallState) -> list[Scalar]:
        # Where the ball's centre comes to its flank, the contact's normal turns over.
        return [jnp.max(-at.approach.gap) - DEEPEST * jnp.asarray(self.pair.radius)]

    def penetration(self, force: Scalar) -> Scalar:
        return jnp.asarray(self.pair.law.depth(force))

    def directions(self, system: System, at: BallState) -> tuple[Array, Array]:
        """Return columns b with δ̇ = b·w and columns b with v_t = b·w, one a segment."""
        normals, tangents, _ = self._directions(system, at)
        return normals, tangents

    def _directions(self, system: System, at: BallState) -> tuple[Array, Array, Array]:
        side = jnp.reshape(jnp.asarray(self.pair.side, float), (self.segments,))
        return contact_directions(system, at.approach, side, at.centre, at.origin, self.spins)

    def closing_directions(self, system: System, at: BallState) -> Array:
        # A ball's own spin does not change how fast its contact closes: its row is zero, and left out.
        return self.directions(system, at)[0][: system.velocities]

    @property
    def reversing(self) -> int:
        return self.segments

    def reversals(self, at: BallState, closed: Closed) -> Float[Array, "reversing axes"]:
        slip = jnp.stack(components(at.approach.tangent * at.approach.slip), axis=1)
        rubs = self._exerting(closed) * jnp.where(jnp.asarray(self.pair.friction.coefficient) > 0.0, 1.0, 0.0)
        return (rubs / self.pair.friction.slip_speed)[:, None] * slip

    def stiff_force(self, at: BallState, closed: Closed) -> Scalar:
        return jnp.sum(self.contact_forces(at, closed).normal)

    def impact_step(self, system: System, own: Own) -> Scalar:
        # A lossless Hertz impact lasts 3.2 of its law's time scales (M58, M80): a fifth of one is about a fifteenth of
        # it.
        speed = jnp.max(self.touchdown_speeds(own))
        # At its floor, as before the first touchdown of a free start, the memory says nothing of the impact.
        speed = jnp.where(speed > self.slowest_touchdown, speed, self._speed)
        return 0.2 * jnp.asarray(self.pair.law.time_scale(system.bodies[self.body].mass, speed))

    def contact_term(self, system: System, at: BallState, closed: Closed) -> ContactTerm:
        approach, exerting = self._onset(at.approach), self._exerting(closed)
        depth, speed, slip = contact_slopes(self.pair, approach, at.memory, exerting)
        normals, tangents, across = self._directions(system, at)
        turning: tuple[SpringTerm, ...] = ()
        if across.shape[1]:
            # The slip may change its direction: friction resists that by its size over the slip (M218).
            friction = self.pair.friction_force(approach, exerting * self.pair.normal_force(approach, at.memory))
            resisting = -friction / approach.slip
            turning = tuple(SpringTerm(across[:, k], 0.0, resisting[k]) for k in range(self.segments))
        return ContactTerm(normals, tangents, per_depth=depth, per_speed=speed, per_slip=slip, across=turning)


class BallReport(Report[BallContact]):
    """What is drawn of a ball; its forces and impacts are listed with those of all contacts."""

    @property
    def balls(self) -> tuple[BallContact, ...]:
        return (self.element,)


def _sum(of_segments: Any) -> Any:
    """Return the sum over the segments of a vector or a turn."""
    return jax.tree.map(jnp.sum, of_segments)
