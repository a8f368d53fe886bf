"""The probe-cone capture mechanism as a hybrid system, ready to be stepped through time."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar, stacked
from ...contact import Approach
from ...hybrid import Linearisation
from ...multibody import Kinematics
from ..energy import Energy
from ..snapshot import Snapshot
from ..system import SLOWEST_TOUCHDOWN, ContactSystem
from .assembly import FLANKS, LOWER, B, P, S, start_motion
from .bending import modal_scales
from .design import Design, Scenario
from .linearisation import linearisation
from .posture import Posture, ProbeInCone

CONTACTS = ("lower", "upper")  # flanks
ROUNDED_ACCELERATION = 1e-12  # m/s²: what rounding of positions of a metre makes of it by the constraints' correction
ROUNDED_LENGTH = 1e-13  # m, rad
DEEPEST = 0.99  # of the tip's radius: near 1, where the tip's centre meets the flank, the contact's normal turns over


class CaptureMechanism(ProbeInCone, ContactSystem):
    """A design in a scenario, ready to be stepped through time; ``stabilisation``: Baumgarte's gain [1/s]."""

    def __init__(self, design: Design, scenario: Scenario, stabilisation: Scalar = 20.0):
        super().__init__(design, scenario, stabilisation)

    @property
    def impact_contacts(self) -> int:
        return FLANKS

    @property
    def remembers(self) -> bool:
        return not self.smooth

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
        return at._replace(state=state), jnp.pad(touching, (0, self.contact_count - FLANKS))

    @property
    def _losses(self) -> int:
        """In how many places energy is lost."""
        return 4 + (self.stop is not None) + (self.hinge is not None) + (self.probe.bending is not None)

    def derivative(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Float[Array, " state"]:
        at, pair = self.posture(state), self.pair
        motion, forces, tip_moment = self.dynamics(at, active)
        axial, torsional = (element.dissipation(at.kin) for element in self.system.forces)
        hysteresis = jnp.sum(self.exerting(active) * pair.hysteresis_power(self.rounded(at.approach), forces.normal))
        friction = -jnp.sum(forces.friction * at.approach.slip)
        spin = [tip_moment / self.probe.tip_inertia] if self.spins else []
        others = [] if self.stop is None else [self.stop_loss(at, active)]
        if self.hinge is not None and at.pin is not None:
            others.append(self.hinge.loss(at.pin, active[-1]))
        if self.probe.bending is not None:
            others.append(self.system.dissipation(at.kin) - axial - torsional)
        rest = stacked([*spin, axial, torsional, hysteresis, friction, *others])
        return jnp.concatenate([at.kin.v, motion.acceleration, rest, self._memory_rate(at.approach, state)])

    def _memory_rate(self, approach: Approach, state: Float[Array, " state"]) -> Float[Array, " flanks"]:
        """Zero with events; the smooth law follows δ̇ while out of contact and holds while in it."""
        if not self.smooth:
            return jnp.zeros(2)
        contact = self.design.contact
        out = 0.5 * (1.0 + jnp.tanh(approach.gap / contact.onset_length))
        target = jnp.maximum(approach.approach_speed, SLOWEST_TOUCHDOWN)
        return out * (target - self.memory(state)) / contact.memory_time

    def gaps_at(self, at: Posture) -> tuple[Float[Array, " contacts"], Float[Array, " contacts"]]:
        """Distance of each contact [m], and how fast it closes [m/s]."""
        gap, closing = at.approach.gap, at.approach.approach_speed
        if self.stop is not None:
            gap, closing = jnp.append(gap, self.design.buffer.end - at.stroke), jnp.append(closing, at.stroke_rate)
        if at.pin is not None:
            gap = jnp.append(gap, at.pin.approach.gap)
            closing = jnp.append(closing, at.pin.approach.approach_speed)
        return gap, closing

    @property
    def jumps(self) -> bool:
        return self.pair.law.jumps or self.stop is not None

    def terminals_at(self, at: Posture) -> Float[Array, " 4"]:
        """Captured, escaped, bottomed, and as deep in a flank as the tip's radius: see `Outcome.ends`."""
        design = self.design
        before = self.throat(at.kin, at.tip)[0]
        retreat = 2.0 * design.cone.length - design.probe.tip_radius * jnp.sin(design.cone.half_angle)
        bottomed = at.stroke - design.buffer.longest_stroke
        deep = (1.0 - DEEPEST) * design.probe.tip_radius - jnp.min(at.approach.distance)
        return stacked([-before, before - retreat, bottomed, deep])

    @property
    def observed(self) -> tuple[str, ...]:
        """What `observables` are: F_n of both flanks and F_s of the end stop, if there is one [N], hinge force [N],
        buffer force [N], stroke [m], hinge angle [rad], and the bending of a probe that bends [m]."""
        stop = () if self.stop is None else ("stop_force",)
        bending = () if self.probe.bending is None else ("bending",)
        return (*CONTACTS, *stop, "hinge_force", "buffer_force", "stroke", "hinge_angle", *bending)

    def observables_at(
        self, at: Posture, rate: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Float[Array, " observables"]:
        kin = at.kin
        n = self.coordinates
        reaction = rate[n : n + 2] * self.design.active.mass
        hinge_force = jnp.sqrt(reaction[0] ** 2 + reaction[1] ** 2 + 1e-24)
        angle = kin.frame(B).angle - kin.frame(S).angle
        stop = [] if self.stop is None else [self.stop_force(at, active)]
        others = [*stop, hinge_force, jnp.abs(self.axial.tension(kin)), at.stroke, jnp.abs(angle)]
        if self.probe.bending is not None:
            others.append(jnp.abs(self.bending(kin)))
        return jnp.concatenate([self.contact(at, active).normal, stacked(others)])

    def rate_observables(self) -> tuple[bool, ...]:
        return tuple(name == "hinge_force" for name in self.observed)

    @property
    def sudden(self) -> bool:
        """Where the probe rings or the hinge's pin bounces."""
        return self.hinge is not None or self.probe.bending is not None

    def negligible(self) -> Float[Array, " observables"]:
        spring = ROUNDED_LENGTH * self.design.buffer.k_A
        sizes: dict[str, Scalar] = {name: ROUNDED_LENGTH for name in ("stroke", "hinge_angle", "bending")}
        sizes |= {"buffer_force": spring, "hinge_force": spring + ROUNDED_ACCELERATION * self.design.active.mass}
        if self.smooth:  # what a flank far away exerts is rounding; an open contact with events exerts exactly nothing
            sizes |= dict.fromkeys(CONTACTS, self.pair.law.elastic(jnp.asarray(ROUNDED_LENGTH)))
        return stacked([sizes.get(name, 0.0) for name in self.observed])

    def scales(self) -> Float[Array, " state"]:
        """Positions by the penetration of a typical impact, velocities by the approach speed, energies by ½ m v²."""
        speed, energy = self.scenario.approach_speed, self.energy_scale
        length, bending = 1e-3, self.probe.bending
        bent, bending_rate = ([], []) if bending is None else modal_scales(bending, speed)
        position = [length, length, length / 0.1] * 4 + bent
        velocity = [speed, speed, speed / 0.1] * 4 + bending_rate
        spin = [speed / self.design.probe.tip_radius] * self.spins
        return stacked(position + velocity + spin + [energy] * self._losses + [speed] * 2)

    def normal_force_at(self, at: Posture, active: Float[Array, " contacts"]) -> Float[Array, " flanks"]:
        return self.contact(at, active).normal

    def snapshot_at(self, at: Posture, active: Float[Array, " contacts"]) -> Snapshot:
        motion, forces, _ = self.dynamics(at, active)
        rate = jnp.concatenate([at.kin.v, motion.acceleration])
        seen = dict(zip(self.observed, self.observables_at(at, rate, active), strict=True))
        approach = at.approach
        return Snapshot(
            gap=approach.gap,
            approach_speed=approach.approach_speed,
            slip=approach.slip,
            normal=forces.normal,
            friction=forces.friction,
            multipliers=motion.multipliers,
            others={
                "tip_spin": at.tip.spin,
                "hinge_force": seen["hinge_force"],
                "buffer_force": jnp.copysign(seen["buffer_force"], self.axial.tension(at.kin)),
                "stop_force": jnp.asarray(self.stop_force(at, active)),
                "stroke": seen["stroke"],
                "hinge_angle": jnp.copysign(seen["hinge_angle"], at.kin.q[5] - at.kin.q[2]),
                "throat_distance": self.throat(at.kin, at.tip)[0],
                **({} if at.pin is None else {"hinge_gap": at.pin.approach.gap[0]}),
                "bending": self.bending(at.kin),
            },
        )

    def energy_at(self, at: Posture, active: Float[Array, " contacts"]) -> Energy:
        names = ["axial_damper", "torsional_damper", "hysteresis", "friction"]
        there = {
            "stop_damper": self.stop is not None,
            "hinge_play": self.hinge is not None,
            "bending": self.probe.bending is not None,
        }
        names += [name for name, is_there in there.items() if is_there]
        none = {name: jnp.zeros(()) for name in there}
        lost = none | dict(zip(names, self.losses(at.state), strict=True))
        return Energy({name: jnp.asarray(energy) for name, energy in self.stored(at, active).items()}, lost)

    def momentum(self, state: Float[Array, " state"]) -> tuple[Float[Array, " 2"], Float[Array, ""]]:
        kin = self.kinematics(state)
        angular = self.system.angular_momentum(kin)
        if self.spins:
            angular = angular + self.probe.tip_inertia * state[2 * self.coordinates]
        return self.system.linear_momentum(kin), angular

    def constraint_errors(self, kin: Kinematics) -> Float[Array, " rows"]:
        return self.system.errors(kin)

    def penetration(self, force: Float[Array, ""]) -> Float[Array, ""]:
        return jnp.asarray(self.pair.law.depth(force))

    def bending(self, kin: Kinematics) -> Scalar:
        """How far the tip is bent off the probe's axis [m], 0 if it does not bend."""
        if self.probe.bending is None:
            return jnp.zeros(())
        return self.probe.bending.end.displacement(kin.modal(P)[0]).y

    @property
    def energy_scale(self) -> Scalar:
        """That of the approach."""
        return 0.5 * self.design.active.mass * self.scenario.approach_speed**2

    @property
    def momentum_scale(self) -> Scalar:
        return self.design.active.mass * self.scenario.approach_speed

    @property
    def balance_complete(self) -> bool:
        """The smooth law's and the published arms' forces do work that `energy_at` does not hold."""
        return not (self.smooth or self.design.contact.arms == "published")

    def other_forces_at(self, at: Posture, active: Float[Array, " contacts"]) -> Scalar:
        forces = jnp.abs(self.axial.tension(at.kin)) + self.stop_force(at, active)
        if self.hinge is not None and at.pin is not None:
            forces = forces + self.hinge.force(at.pin, active[-1])[0]
        return forces

    def impact_step(self, state: Float[Array, " state"]) -> Float[Array, ""]:
        """A fifteenth of the duration of an impact of the probe's mass at the memorised speed [s]."""
        return 0.2 * jnp.asarray(self.pair.law.time_scale(self.probe.mass, jnp.max(self.memory(state))))

    def linearisation(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Linearisation:
        return linearisation(self, state, active)
