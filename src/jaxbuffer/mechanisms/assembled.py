"""Any planar mechanism with ball contacts as a hybrid system: bodies, joints and force elements, and balls on flanks.

The state is ``[q, v, contact memory, integrals]``. For explicit solvers.
"""

from collections.abc import Callable

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from .._types import Scalar, stacked
from ..contact import Approach, Ball, BallOnSegments, Carrier
from ..multibody import Kinematics, Load, System, Vector, load_at
from .hybrid import HybridSystem, Linearisation

SLOWEST_TOUCHDOWN = 1e-5  # m/s
GAP = ("gap", "approach_speed")

Quantity = Callable[[System, Kinematics], Scalar]


class BallContact(eqx.Module):
    """A ball fixed on ``body``, its centre at ``point`` [m, body axes], against a flank on ``carrier`` (or the ground).

    ``pair``: its shape (one segment), law and friction.
    """

    body: int = eqx.field(static=True)
    carrier: int = eqx.field(static=True)
    pair: BallOnSegments
    point: tuple[Scalar, Scalar] = (0.0, 0.0)

    def approach(self, kin: Kinematics) -> tuple[Approach, Vector]:
        """Geometry and relative motion, and the ball's arm from its body's centre of mass."""
        body, carrier = kin.frame(self.body), kin.frame(self.carrier)
        arm = body.turn(Vector(*self.point))
        centre, velocity = body.origin + arm, body.velocity_at(arm)
        ball = Ball(centre.x, centre.y, velocity.x, velocity.y, body.spin)
        origin, motion = carrier.origin, carrier.velocity
        return self.pair.approach(
            ball, Carrier(origin.x, origin.y, carrier.cos, carrier.sin, motion.x, motion.y, carrier.spin)
        ), arm

    def loads(self, kin: Kinematics, memory: Scalar, active: Scalar) -> tuple[tuple[Load, ...], Scalar]:
        """Loads on both bodies at the foot, and F_n [N]."""
        a, arm = self.approach(kin)
        normal = active * self.pair.normal_force(a, jnp.asarray(memory))
        friction = self.pair.friction_force(a, normal)
        push = Vector(normal * a.normal_x + friction * a.tangent_x, normal * a.normal_y + friction * a.tangent_y)
        to_foot = Vector(arm.x - a.distance * a.normal_x, arm.y - a.distance * a.normal_y)
        on_ball = load_at(self.body, push, to_foot)
        return (on_ball, load_at(self.carrier, -push, Vector(a.foot_x, a.foot_y))), normal


class Assembled(HybridSystem):
    """A mechanism ready to be stepped through time from a consistent start.

    **Arguments:** ``system``; ``q``, ``v``: positions and velocities at t = 0, on the constraints; ``contacts``;
    ``closed``: which of them are closed at t = 0 (default: none); ``integrals``: quantities whose integrals over time
    are wanted, zero at t = 0; ``ends``: quantities whose crossing of zero upwards ends the run; ``size``: magnitudes
    that matter of a coordinate and of a velocity. Observables are the contacts' normal forces [N].
    """

    system: System
    q: Float[Array, " coordinates"]
    v: Float[Array, " coordinates"]
    contacts: tuple[BallContact, ...] = ()
    closed: tuple[bool, ...] = eqx.field(static=True, default=())
    integrals: tuple[Quantity, ...] = eqx.field(static=True, default=())
    ends: tuple[Quantity, ...] = eqx.field(static=True, default=())
    size: tuple[Scalar, Scalar] = (1.0, 1.0)

    @property
    def coordinates(self) -> int:
        return self.system.coordinates

    @property
    def jumps(self) -> bool:
        return any(contact.pair.law.jumps for contact in self.contacts)

    def kinematics(self, state: Float[Array, " state"]) -> Kinematics:
        """Frames of the bodies."""
        n = self.system.coordinates
        return Kinematics(state[:n], state[n : 2 * n])

    def memory(self, state: Float[Array, " state"]) -> Float[Array, " contacts"]:
        """δ̇⁻ of each contact [m/s]."""
        n = 2 * self.system.coordinates
        return state[n : n + len(self.contacts)]

    def integral(self, state: Float[Array, " state"]) -> Float[Array, " integrals"]:
        """The integrals so far."""
        return state[2 * self.system.coordinates + len(self.contacts) :]

    def start(self) -> tuple[Float[Array, " state"], Float[Array, " contacts"]]:
        kin = Kinematics(self.q, self.v)
        speeds = [jnp.sum(contact.approach(kin)[0].approach_speed) for contact in self.contacts]
        memory = [jnp.maximum(speed, SLOWEST_TOUCHDOWN) for speed in speeds]
        state = jnp.concatenate([self.q, self.v, _row(memory), jnp.zeros(len(self.integrals))])
        closed = self.closed or (False,) * len(self.contacts)
        return state, jnp.asarray(closed, float)

    def forces(
        self, state: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> tuple[tuple[Load, ...], list[Scalar]]:
        """All contacts' loads, and their F_n [N]."""
        kin, memory = self.kinematics(state), self.memory(state)
        found = [contact.loads(kin, memory[k], active[k]) for k, contact in enumerate(self.contacts)]
        return tuple(load for loads, _ in found for load in loads), [normal for _, normal in found]

    def derivative(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Float[Array, " state"]:
        kin = self.kinematics(state)
        acceleration = self.system.motion(kin, self.forces(state, active)[0]).acceleration
        rates = [quantity(self.system, kin) for quantity in self.integrals]
        return jnp.concatenate([kin.v, acceleration, jnp.zeros(len(self.contacts)), _row(rates)])

    def gaps(self, state: Float[Array, " state"]) -> Float[Array, " contacts"]:
        kin = self.kinematics(state)
        return _row([contact.approach(kin)[0].gap for contact in self.contacts])

    def touchdown(
        self, state: Float[Array, " state"], quickening: Float[Array, ""], contact: Int[Array, ""]
    ) -> Float[Array, " state"]:
        """The memory takes the approach speed at the crossing itself, a first-order step from the located state."""
        chosen = jnp.arange(len(self.contacts)) == contact
        late, speed = self._until_contact(state, chosen)
        memory = jnp.where(chosen, jnp.maximum(speed + quickening * late, SLOWEST_TOUCHDOWN), self.memory(state))
        n = 2 * self.system.coordinates
        closed = jnp.concatenate([state[:n], memory, self.integral(state)])
        if not self.jumps:
            return closed
        zero, alone = jnp.zeros(()), jnp.where(chosen, 1.0, 0.0)
        onset = self.derivative(zero, closed, alone) - self.derivative(zero, closed, jnp.zeros_like(alone))
        return closed - onset * late

    def _until_contact(self, state: Float[Array, " state"], chosen: Array) -> tuple[Array, Array]:
        """Of the chosen contact: gap / δ̇ [s], and δ̇ [m/s]."""
        kin = self.kinematics(state)
        found = [contact.approach(kin)[0] for contact in self.contacts]
        gap, speed = (jnp.sum(jnp.where(chosen, _row([getattr(a, name) for a in found]), 0.0)) for name in GAP)
        return gap / jnp.where(speed == 0.0, 1.0, speed), speed

    def terminals(self, state: Float[Array, " state"]) -> Float[Array, " terminals"]:
        kin = self.kinematics(state)
        return _row([quantity(self.system, kin) for quantity in self.ends] or [-jnp.ones(())])

    def observables(
        self, state: Float[Array, " state"], rate: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Float[Array, " observables"]:
        return _row(self.forces(state, active)[1])

    def rate_observables(self) -> tuple[bool, ...]:
        return (False,) * len(self.contacts)

    def scales(self) -> Float[Array, " state"]:
        n = self.system.coordinates
        place, motion = self.size
        return stacked([place] * n + [motion] * (n + len(self.contacts)) + [1.0] * len(self.integrals))

    def impact_step(self, state: Float[Array, " state"]) -> Float[Array, ""]:
        """A fifteenth of the shortest impact of a contact's ball and its body; 1e-6 s without contacts [s]."""
        memory, steps = self.memory(state), [jnp.asarray(1e-6)]
        for k, contact in enumerate(self.contacts):
            mass = self.system.bodies[contact.body].mass
            steps.append(0.2 * jnp.asarray(contact.pair.law.time_scale(mass, memory[k])))
        return jnp.min(jnp.stack(steps[1:] or steps))

    def linearisation(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Linearisation:
        """Nothing is known to be stiff: explicit steps are held by their error alone."""
        return Linearisation.none(self.coordinates, self.coordinates)


def _row(values: list) -> Float[Array, " n"]:
    return stacked(values) if values else jnp.zeros(0)
