"""The probe-cone capture mechanism as a hybrid system, ready to be stepped through time."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from .._types import Scalar, stacked
from ..contact import Approach
from .assembly import LOWER, B, N, S, start_motion
from .design import Design, Scenario
from .hybrid import HybridSystem, Linearisation, Watched
from .probe_in_cone import Posture, ProbeInCone
from .stiffness import linearisation

ROUNDED = 1e-14  # m, and relative: rounding of positions of the order of a metre, with some to spare
SLOWEST_TOUCHDOWN = 1e-5  # m/s, the least δ̇⁻ of the model's section 5


class CaptureMechanism(ProbeInCone, HybridSystem):
    """A design in a scenario, ready to be stepped through time; ``stabilisation``: Baumgarte's gain [1/s]."""

    def __init__(self, design: Design, scenario: Scenario, stabilisation: Scalar = 20.0):
        super().__init__(design, scenario, stabilisation)

    @property
    def coordinates(self) -> int:
        return N

    def start(self) -> tuple[Float[Array, " state"], Float[Array, " flanks"]]:
        at, touching = self.first_posture()
        return at.state, touching

    def first_posture(self) -> tuple[Posture, Float[Array, " flanks"]]:
        """`start`, looked at."""
        q, v = start_motion(self.design, self.scenario, self.probe)
        none = jnp.zeros(self.spins + 4)
        state = jnp.concatenate([q, v, none, jnp.ones(2)])
        at = self.posture(state)
        approach = at.approach.approach_speed
        state = jnp.concatenate([state[:-2], jnp.maximum(approach, SLOWEST_TOUCHDOWN)])
        touching = jnp.where((jnp.arange(2) == LOWER) & (approach > 0.0), 1.0, 0.0)
        return at._replace(state=state), touching

    def derivative(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> Float[Array, " state"]:
        at, pair = self.posture(state), self.pair
        motion, forces, tip_moment = self.dynamics(at, active)
        axial, torsional = (element.dissipation(at.kin) for element in self.system.forces)
        hysteresis = jnp.sum(self.exerting(active) * pair.hysteresis_power(self.rounded(at.approach), forces.normal))
        friction = -jnp.sum(forces.friction * at.approach.slip)
        spin = [tip_moment / self.probe.tip_inertia] if self.spins else []
        rest = stacked([*spin, axial, torsional, hysteresis, friction])
        return jnp.concatenate([at.kin.v, motion.acceleration, rest, self._memory_rate(at.approach, state)])

    def _memory_rate(self, approach: Approach, state: Float[Array, " state"]) -> Float[Array, " flanks"]:
        """Zero with events; the smooth law follows δ̇ while out of contact and holds while in it."""
        if not self.smooth:
            return jnp.zeros(2)
        contact = self.design.contact
        out = 0.5 * (1.0 + jnp.tanh(approach.gap / contact.onset_length))
        target = jnp.maximum(approach.approach_speed, SLOWEST_TOUCHDOWN)
        return out * (target - self.memory(state)) / contact.memory_time

    def gaps(self, state: Float[Array, " state"]) -> Float[Array, " flanks"]:
        return self.posture(state).approach.gap

    def touchdown(
        self, state: Float[Array, " state"], quickening: Float[Array, ""], contact: Int[Array, ""]
    ) -> Float[Array, " state"]:
        """δ̇⁻ takes the approach speed at the crossing itself, a first-order step away from the located state."""
        if self.smooth:
            return state
        late, speed = self._until_contact(state, contact)
        mine = jnp.arange(2) == contact
        memory = jnp.where(mine, jnp.maximum(speed + quickening * late, SLOWEST_TOUCHDOWN), self.memory(state))
        closed = jnp.concatenate([state[:-2], memory])
        return closed + self.saltation(closed, contact) if self.jumps else closed

    @property
    def jumps(self) -> bool:
        return self.pair.law.jumps

    def saltation(self, closed: Float[Array, " state"], contact: Int[Array, ""]) -> Float[Array, " state"]:
        """What a force that jumps does to sensitivities at fixed time: (f⁻ - f⁺) dt_c, with no value worth mention."""
        zero, alone = jnp.zeros(()), jnp.where(jnp.arange(2) == contact, 1.0, 0.0)
        onset = self.derivative(zero, closed, alone) - self.derivative(zero, closed, jnp.zeros(2))
        return -onset * self.time_to_contact(closed, contact)

    def time_to_contact(self, state: Float[Array, " state"], contact: Int[Array, ""]) -> Float[Array, ""]:
        """gap / δ̇ of one flank [s]."""
        return self._until_contact(state, contact)[0]

    def _until_contact(self, state: Float[Array, " state"], contact: Int[Array, ""]) -> tuple[Array, Array]:
        """Of one flank: gap / δ̇ [s], and δ̇ [m/s]."""
        approach, mine = self.posture(state).approach, jnp.arange(2) == contact
        gap, speed = (jnp.sum(jnp.where(mine, x, 0.0)) for x in (approach.gap, approach.approach_speed))
        return gap / jnp.where(speed == 0.0, 1.0, speed), speed

    def terminals(self, state: Float[Array, " state"]) -> Float[Array, " 2"]:
        """Captured, escaped."""
        return self._terminals(self.throat_of(state)[0])

    def _terminals(self, before: Float[Array, ""]) -> Float[Array, " 2"]:
        retreat = 2.0 * self.design.cone.length - self.design.probe.tip_radius * jnp.sin(self.design.cone.half_angle)
        return jnp.stack([-before, before - retreat])

    def observables(
        self, state: Float[Array, " state"], rate: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> Float[Array, " 6"]:
        """F_n of the lower and upper flank [N], hinge force [N], buffer force [N], stroke [m], hinge angle [rad]."""
        return self._observables(self.posture(state), rate, active)

    def _observables(
        self, at: Posture, rate: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> Float[Array, " 6"]:
        kin, axial = at.kin, self.axial
        reaction = rate[N : N + 2] * self.design.active.mass
        hinge_force = jnp.sqrt(reaction[0] ** 2 + reaction[1] ** 2 + 1e-24)
        stroke = axial.free_length - axial.state(kin).length
        angle = kin.frame(B).angle - kin.frame(S).angle
        others = [hinge_force, jnp.abs(axial.tension(kin)), stroke, jnp.abs(angle)]
        return jnp.concatenate([self.contact(at, active).normal, jnp.stack(others)])

    def watched(
        self, state: Float[Array, " state"], rate: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> Watched:
        at = self.posture(state)
        return Watched(
            gap=at.approach.gap,
            gap_rate=-at.approach.approach_speed,
            terminal=self._terminals(self.throat(at.kin, at.tip)[0]),
            value=self._observables(at, rate, active),
            invariant=self._invariant(jax.lax.stop_gradient(at), active),
        )

    def rate_observables(self) -> tuple[bool, ...]:
        return (False, False, True, False, False, False)

    def scales(self) -> Float[Array, " state"]:
        """Positions by the penetration of a typical impact, velocities by the approach speed, energies by ½ m v²."""
        speed = self.scenario.approach_speed
        length = 1e-3
        energy = 0.5 * self.design.active.mass * speed**2
        position = [length, length, length / 0.1]
        velocity = [speed, speed, speed / 0.1]
        spin = [speed / self.design.probe.tip_radius] * self.spins
        return stacked(position * 4 + velocity * 4 + spin + [energy] * 4 + [speed] * 2)

    def invariant(
        self, state: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """Energy, losses included, over that of the approach; its rounding is mostly the positions'. The smooth law's
        and the published arms' forces do work that no ledger holds."""
        return self._invariant(self.posture(state), active)

    def _invariant(self, at: Posture, active: Float[Array, " flanks"]) -> tuple[Float[Array, ""], Float[Array, ""]]:
        if self.smooth or self.design.contact.arms == "published":
            return super().invariant(at.state, active)
        approach = 0.5 * self.design.active.mass * self.scenario.approach_speed**2
        total = sum(self.stored(at, active)) + jnp.sum(self.losses(at.state))
        forces = jnp.sum(self.contact(at, active).normal) + jnp.abs(self.axial.tension(at.kin))
        return total / approach, ROUNDED * (1.0 + forces / approach)

    def impact_step(self, state: Float[Array, " state"]) -> Float[Array, ""]:
        """A fifteenth of the duration of an impact of the probe's mass at the memorised speed [s]."""
        return 0.2 * jnp.asarray(self.pair.law.time_scale(self.probe.mass, jnp.max(self.memory(state))))

    def linearisation(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> Linearisation:
        return linearisation(self, state, active)
