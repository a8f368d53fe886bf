"""The probe-cone capture mechanism as a hybrid system, ready to be stepped through time."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .._types import Scalar, stacked
from ..contact import Approach
from ..multibody import Vector
from .assembly import FLANKS, LOWER, B, N, S, T, start_motion
from .design import Design, Scenario
from .hybrid import HybridSystem, Linearisation, Watched
from .probe_in_cone import Posture, ProbeInCone
from .stiffness import linearisation

ROUNDED = 1e-14  # m, and relative: rounding of positions of the order of a metre, with some to spare
DEEPEST = 0.99  # of the tip's radius: near 1, where the tip's centre meets the flank, the contact's normal turns over
SLOWEST_TOUCHDOWN = 1e-5  # m/s, the least δ̇⁻ of the model's section 5


class CaptureMechanism(ProbeInCone, HybridSystem):
    """A design in a scenario, ready to be stepped through time; ``stabilisation``: Baumgarte's gain [1/s]."""

    def __init__(self, design: Design, scenario: Scenario, stabilisation: Scalar = 20.0):
        super().__init__(design, scenario, stabilisation)

    @property
    def coordinates(self) -> int:
        return N

    def start(self) -> tuple[Float[Array, " state"], Float[Array, " contacts"]]:
        at, touching = self.first_posture()
        return at.state, touching

    def first_posture(self) -> tuple[Posture, Float[Array, " contacts"]]:
        """`start`, looked at."""
        q, v = start_motion(self.design, self.scenario, self.probe)
        none = jnp.zeros(self.spins + self._losses)
        state = jnp.concatenate([q, v, none, jnp.ones(2)])
        at = self.posture(state)
        approach = at.approach.approach_speed
        state = jnp.concatenate([state[:-2], jnp.maximum(approach, SLOWEST_TOUCHDOWN)])
        touching = jnp.where((jnp.arange(FLANKS) == LOWER) & (approach > 0.0), 1.0, 0.0)
        return at._replace(state=state), jnp.pad(touching, (0, self.contacts - FLANKS))

    @property
    def _losses(self) -> int:
        """In how many places energy is lost."""
        return 4 + (self.stop is not None)

    def derivative(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Float[Array, " state"]:
        at, pair = self.posture(state), self.pair
        motion, forces, tip_moment = self.dynamics(at, active)
        axial, torsional = (element.dissipation(at.kin) for element in self.system.forces)
        hysteresis = jnp.sum(self.exerting(active) * pair.hysteresis_power(self.rounded(at.approach), forces.normal))
        friction = -jnp.sum(forces.friction * at.approach.slip)
        spin = [tip_moment / self.probe.tip_inertia] if self.spins else []
        stop = [] if self.stop is None else [self.stop_loss(at, active)]
        rest = stacked([*spin, axial, torsional, hysteresis, friction, *stop])
        return jnp.concatenate([at.kin.v, motion.acceleration, rest, self._memory_rate(at.approach, state)])

    def _memory_rate(self, approach: Approach, state: Float[Array, " state"]) -> Float[Array, " flanks"]:
        """Zero with events; the smooth law follows δ̇ while out of contact and holds while in it."""
        if not self.smooth:
            return jnp.zeros(2)
        contact = self.design.contact
        out = 0.5 * (1.0 + jnp.tanh(approach.gap / contact.onset_length))
        target = jnp.maximum(approach.approach_speed, SLOWEST_TOUCHDOWN)
        return out * (target - self.memory(state)) / contact.memory_time

    def gaps(self, state: Float[Array, " state"]) -> Float[Array, " contacts"]:
        return self.gaps_at(self.posture(state))[0]

    def gaps_at(self, at: Posture) -> tuple[Float[Array, " contacts"], Float[Array, " contacts"]]:
        """Distance of each contact [m], and how fast it closes [m/s]."""
        gap, closing = at.approach.gap, at.approach.approach_speed
        if self.stop is None:
            return gap, closing
        return jnp.append(gap, self.design.buffer.end - at.stroke), jnp.append(closing, at.stroke_rate)

    def touching(self, active: Float[Array, " contacts"]) -> Bool[Array, ""]:
        return jnp.any(active[:FLANKS] > 0.5)

    def touchdown(
        self, state: Float[Array, " state"], quickening: Float[Array, ""], contact: Int[Array, ""]
    ) -> Float[Array, " state"]:
        """δ̇⁻ takes the approach speed at the crossing itself, a first-order step away from the located state."""
        if not self.smooth:
            late, speed = self._until_contact(state, contact)
            mine = jnp.arange(FLANKS) == contact
            memory = jnp.where(mine, jnp.maximum(speed + quickening * late, SLOWEST_TOUCHDOWN), self.memory(state))
            state = jnp.concatenate([state[:-2], memory])
        return state + self.saltation(state, contact) if self.jumps else state

    @property
    def jumps(self) -> bool:
        return self.pair.law.jumps or self.stop is not None

    def saltation(self, closed: Float[Array, " state"], contact: Int[Array, ""]) -> Float[Array, " state"]:
        """What a force that jumps does to sensitivities at fixed time: (f⁻ - f⁺) dt_c, with no value worth mention."""
        zero, alone = jnp.zeros(()), jnp.where(jnp.arange(self.contacts) == contact, 1.0, 0.0)
        onset = self.derivative(zero, closed, alone) - self.derivative(zero, closed, jnp.zeros_like(alone))
        return -onset * self.time_to_contact(closed, contact)

    def time_to_contact(self, state: Float[Array, " state"], contact: Int[Array, ""]) -> Float[Array, ""]:
        """gap / δ̇ of one contact [s]."""
        return self._until_contact(state, contact)[0]

    def _until_contact(self, state: Float[Array, " state"], contact: Int[Array, ""]) -> tuple[Array, Array]:
        """Of one contact: gap / δ̇ [s], and δ̇ [m/s]."""
        mine = jnp.arange(self.contacts) == contact
        gap, speed = (jnp.sum(jnp.where(mine, x, 0.0)) for x in self.gaps_at(self.posture(state)))
        return gap / jnp.where(speed == 0.0, 1.0, speed), speed

    def terminals(self, state: Float[Array, " state"]) -> Float[Array, " 4"]:
        """Captured, escaped, bottomed, and as deep in a flank as the tip's radius: see `outcome`."""
        return self._terminals(self.posture(state))

    def _terminals(self, at: Posture) -> Float[Array, " 4"]:
        design = self.design
        before = self.throat(at.kin, at.tip)[0]
        retreat = 2.0 * design.cone.length - design.probe.tip_radius * jnp.sin(design.cone.half_angle)
        bottomed = at.stroke - design.buffer.longest_stroke
        deep = jnp.max(self._behind_flank(at)) + (1.0 - DEEPEST) * design.probe.tip_radius
        return stacked([-before, before - retreat, bottomed, deep])

    def _behind_flank(self, at: Posture) -> Float[Array, " flanks"]:
        """How far the tip's centre is behind each flank [m], negative before it. Beside a flank, where a rim is the
        nearest point, it is not behind it."""
        flanks, cone = self.pair.segments, at.kin.frame(T)
        local = cone.unturn(Vector(at.tip.x, at.tip.y) - cone.origin)
        off_x, off_y = local.x - flanks.start_x, local.y - flanks.start_y
        behind = self.pair.side * (flanks.direction_x * off_y - flanks.direction_y * off_x)
        beside = (at.approach.slant <= 0.0) | (at.approach.slant >= flanks.length)
        return jnp.where(beside, -at.approach.distance, behind)

    def observables(
        self, state: Float[Array, " state"], rate: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Float[Array, " observables"]:
        """As `observed` names them."""
        return self._observables(self.posture(state), rate, active)

    @property
    def observed(self) -> tuple[str, ...]:
        """What `observables` are: F_n of both flanks and F_s of the end stop, if there is one [N], hinge force [N],
        buffer force [N], stroke [m], hinge angle [rad]."""
        stop = () if self.stop is None else ("stop_force",)
        return ("lower", "upper", *stop, "hinge_force", "buffer_force", "stroke", "hinge_angle")

    def _observables(
        self, at: Posture, rate: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Float[Array, " observables"]:
        kin = at.kin
        reaction = rate[N : N + 2] * self.design.active.mass
        hinge_force = jnp.sqrt(reaction[0] ** 2 + reaction[1] ** 2 + 1e-24)
        angle = kin.frame(B).angle - kin.frame(S).angle
        stop = [] if self.stop is None else [self.stop_force(at, active)]
        others = [*stop, hinge_force, jnp.abs(self.axial.tension(kin)), at.stroke, jnp.abs(angle)]
        return jnp.concatenate([self.contact(at, active).normal, stacked(others)])

    def watched(
        self, state: Float[Array, " state"], rate: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Watched:
        at = self.posture(state)
        gap, closing = self.gaps_at(at)
        return Watched(
            gap=gap,
            gap_rate=-closing,
            terminal=self._terminals(at),
            value=self._observables(at, rate, active),
            invariant=self._invariant(jax.lax.stop_gradient(at), active),
        )

    def rate_observables(self) -> tuple[bool, ...]:
        return tuple(name == "hinge_force" for name in self.observed)

    def scales(self) -> Float[Array, " state"]:
        """Positions by the penetration of a typical impact, velocities by the approach speed, energies by ½ m v²."""
        speed = self.scenario.approach_speed
        length = 1e-3
        energy = 0.5 * self.design.active.mass * speed**2
        position = [length, length, length / 0.1]
        velocity = [speed, speed, speed / 0.1]
        spin = [speed / self.design.probe.tip_radius] * self.spins
        return stacked(position * 4 + velocity * 4 + spin + [energy] * self._losses + [speed] * 2)

    def invariant(
        self, state: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """Energy, losses included, over that of the approach; its rounding is mostly the positions'. The smooth law's
        and the published arms' forces do work that no ledger holds."""
        return self._invariant(self.posture(state), active)

    def _invariant(self, at: Posture, active: Float[Array, " contacts"]) -> tuple[Float[Array, ""], Float[Array, ""]]:
        if self.smooth or self.design.contact.arms == "published":
            return super().invariant(at.state, active)
        approach = 0.5 * self.design.active.mass * self.scenario.approach_speed**2
        total = sum(self.stored(at, active)) + jnp.sum(self.losses(at.state))
        forces = jnp.sum(self.contact(at, active).normal) + jnp.abs(self.axial.tension(at.kin))
        forces = forces + self.stop_force(at, active)
        return total / approach, ROUNDED * (1.0 + forces / approach)

    def impact_step(self, state: Float[Array, " state"]) -> Float[Array, ""]:
        """A fifteenth of the duration of an impact of the probe's mass at the memorised speed [s]."""
        return 0.2 * jnp.asarray(self.pair.law.time_scale(self.probe.mass, jnp.max(self.memory(state))))

    def linearisation(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Linearisation:
        return linearisation(self, state, active)
