"""The probe-cone capture mechanism as a hybrid system, ready to be stepped through time."""

import dataclasses
from collections.abc import Iterator

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..._types import Scalar, stacked
from ...hybrid import Linearisation
from ...multibody import Kinematics
from ..energy import Energy
from ..linearisation import inverse_masses
from ..snapshot import Snapshot
from ..system import SLOWEST_TOUCHDOWN as SLOWEST_TOUCHDOWN
from ..system import ContactSystem, SmoothMemory
from .assembly import FLANKS, LOWER, B, P, S, T, start_motion
from .bending import modal_scales
from .buffer_force import BufferForce
from .design import Design, Scenario
from .linearisation import flank_directions, linearisation
from .posture import Posture, ProbeInCone
from .state_layout import LATCH, THRUST_OVER

CONTACTS = ("lower", "upper")  # flanks
ROUNDED_ACCELERATION = 1e-12  # m/s²: what rounding of positions of a metre makes of it by the constraints' correction
ROUNDED_LENGTH = 1e-13  # m, rad
PIECES = 0.2  # see `CaptureMechanism.tolerance_share`
LONG_RUN = 0.012  # see `CaptureMechanism.invariant_change`
DEEPEST = 0.99  # of the tip's radius: near 1, where the tip's centre meets the flank, the contact's normal turns over


class CaptureMechanism(ProbeInCone, ContactSystem):
    """A design in a scenario, ready to be stepped through time; ``stabilisation``: Baumgarte's gain [1/s]."""

    def __init__(self, design: Design, scenario: Scenario, stabilisation: Scalar = 20.0):
        super().__init__(design, scenario, stabilisation)

    @property
    def typical_speed(self) -> Scalar:
        return self.scenario.approach_speed

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
        none = jnp.zeros(self.spins + len(self.loss_names) + len(self.extra_names))
        swinging = [] if self.oscillators is None else [self.oscillators.start(self.system.kinematics(q, v))]
        if self.scenario.start == "free":  # nothing touches, and the memory is at its floor (M170)
            rest = none.at[0].set(self.scenario.active_rate) if self.spins else none
            state = jnp.concatenate([q, v, rest, *swinging, jnp.full(FLANKS, self.slowest_touchdown)])
            active = jnp.zeros(self.contact_count)
            return self._with_first_energy(self.posture(state), state, active), active
        state = jnp.concatenate([q, v, none, *swinging, jnp.ones(2)])
        at = self.posture(state)
        approach = at.approach.approach_speed
        state = jnp.concatenate([state[:-2], jnp.maximum(approach, self.slowest_touchdown)])
        touching = jnp.where((jnp.arange(FLANKS) == LOWER) & (approach > 0.0), 1.0, 0.0)
        active = jnp.pad(touching, (0, self.contact_count - FLANKS))
        return self._with_first_energy(at, state, active), active

    def _with_first_energy(self, at: Posture, state: Array, active: Array) -> Posture:
        """The posture at the start, its state with the energy of relative motion there where latches need that
        (M177)."""
        if self.latch is None:
            return at._replace(state=state)
        return at._replace(state=self.with_extra(state, "first_energy", self.relative_energy(at, active)))

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
            others.append(self.hinge.loss(at.pin, self.closed(active, "pin")))
        if self.probe.bending is not None:
            others.append(self.system.dissipation(at.kin) - axial - torsional)
        if self.design.buffer.friction is not None and isinstance(self.axial, BufferForce):
            others.append(self.axial.friction_loss(at.kin))
            axial = axial - others[-1]
        if self.rebound is not None:
            others.append(self.rebound_loss(at, active))
        others += self._latch_rates(at, active)
        if self.thrust is not None:
            others += [1.0, *self.thrust.rates(at.kin, 1.0 - self.closed(active, THRUST_OVER))]
        rest = stacked([*spin, axial, torsional, hysteresis, friction, *others])
        swinging = [] if self.oscillators is None else [self.oscillators.derivative(at.kin, self.swinging(at.state))]
        memory = jnp.zeros(FLANKS) if (smooth := self.smooth_memory(at)) is None else smooth.rate
        return jnp.concatenate([at.kin.v, motion.acceleration, rest, *swinging, memory])

    def _latch_rates(self, at: Posture, active: Float[Array, " contacts"]) -> list[Scalar]:
        """Of the energy lost in latches, the time since they began to close, the energy that closing put in, and the
        energy of relative motion at the start; none without latches."""
        if self.latch is None or at.latch is None:
            return []
        latch = self.acting_latch(at, active)
        return [self.latch.loss(latch), self.closed(active, LATCH), self.latch.closing_power(latch), 0.0]

    def gaps_at(self, at: Posture) -> tuple[Float[Array, " contacts"], Float[Array, " contacts"]]:
        """Distance of each contact [m], and how fast it closes [m/s]; of what is over after some time the time left
        [s], and how fast that passes."""
        gap, closing = at.approach.gap, at.approach.approach_speed
        for distance, speed in self._other_gaps(at):
            gap, closing = jnp.append(gap, distance), jnp.append(closing, speed)
        return gap, closing

    def _other_gaps(self, at: Posture) -> Iterator[tuple[Scalar | Array, Scalar | Array]]:
        """Those of all contacts but the flanks."""
        buffer = self.design.buffer
        if self.stop is not None:
            yield buffer.end - at.stroke, at.stroke_rate
        if self.rebound is not None:
            yield at.stroke + buffer.rebound_gap, -at.stroke_rate
        if at.pin is not None:
            yield at.pin.approach.gap, at.pin.approach.approach_speed
        if self.latch is not None:
            before, receding = self.throat(at.kin, at.tip)
            since = self.extra(at.state, "since_crossing")
            yield before, -receding
            yield self.design.latch.closing_time - since, jnp.where(since > 0.0, 1.0, 0.0)
        if self.thrust is not None:
            yield self.thrust.time - self.extra(at.state, "time"), 1.0

    def off_rim(self, at: Posture) -> Scalar:
        """How much farther than the cone's rim the tip's centre is from the axis [m]; below zero within."""
        cone = self.design.cone
        return jnp.abs(self.tip_in_cone(at).y) - (cone.throat_radius + cone.length * jnp.sin(cone.half_angle))

    @property
    def jumps(self) -> bool:
        more = (self.stop, self.rebound, self.latch, self.thrust)
        return self.pair.law.jumps or any(part is not None for part in more)

    @property
    def contact_observables(self) -> int:
        return FLANKS + (self.stop is not None)

    def touchdown(
        self, state: Array, acceleration: Float[Array, ""], contact: Int[Array, ""]
    ) -> Float[Array, " state"]:
        """As of every mechanism; latches that close in no time store their energy at once."""
        after = super().touchdown(state, acceleration, contact)
        at = self.posture(state)
        if self.latch is None or at.latch is None:
            return after
        at_once = (contact == self.contact_names.index(LATCH)) & (self.design.latch.closing_time == 0.0)
        work = self.extra(after, "closing_work") + jnp.where(at_once, self.latch.stored(at.latch), 0.0)
        return self.with_extra(after, "closing_work", work)

    def terminals_at(self, at: Posture) -> Float[Array, " terminals"]:
        """Captured, escaped, bottomed, as deep in a flank as the tip's radius and, with latches, torn and held."""
        design, free = self.design, self.scenario.start == "free"
        before = self.throat(at.kin, at.tip)[0]
        retreat = 2.0 * design.cone.length - design.probe.tip_radius * jnp.sin(design.cone.half_angle)
        captured, escaped = -before, before - (retreat + self.scenario.standoff if free else retreat)
        if free:  # past the mouth outside the rim the tip has missed the cone; behind a flank the contact means nothing
            mouth = -design.cone.offset - design.cone.length * jnp.cos(design.cone.half_angle)
            past = self.tip_in_cone(at).x - mouth
            escaped = jnp.where(jnp.asarray(self.off_rim(at)) > 0.0, jnp.maximum(escaped, past), escaped)
        bottomed = at.stroke - design.buffer.longest_stroke
        deep = (1.0 - DEEPEST) * design.probe.tip_radius - jnp.min(at.approach.distance)
        if self.latch is None or at.latch is None:
            return stacked([captured, escaped, bottomed, deep])
        strength = design.latch.strength
        torn = -1.0 if strength is None else self.latch.size(at.latch) - strength
        return stacked([-1.0, escaped, bottomed, deep, torn, self._at_rest(at)])

    @property
    def end_outcomes(self) -> tuple[str, ...]:
        return (
            "captured",
            "escaped",
            "bottomed",
            "failed_penetration",
            *(() if self.latch is None else ("torn", "held")),
        )

    def _at_rest(self, at: Posture) -> Scalar:
        """Above zero where the latches are closed, the thrust is over and the energy of relative motion is below its
        quiet share (M177)."""
        latch, since = self.design.latch, self.extra(at.state, "since_crossing")
        over = (since > 0.0) & (since >= latch.closing_time)
        if self.thrust is not None:
            over = over & (self.extra(at.state, "time") >= self.thrust.time)
        # Which contacts are closed shows in their gaps, but for the latches: the tip may come back out a little.
        active = jnp.where(self.gaps_at(at)[0] <= 0.0, 1.0, 0.0)
        active = active.at[self.contact_names.index(LATCH)].set(jnp.where(since > 0.0, 1.0, 0.0))
        left = self.relative_energy(at, active) / self.extra(at.state, "first_energy")
        return jnp.where(over, latch.quiet - left, -1.0)

    @property
    def observed(self) -> tuple[str, ...]:
        """What `observables` are: F_n of both flanks, F_s of the end stop, if there is one, hinge and buffer force [N],
        stroke [m], hinge angle [rad], the bending of a probe that bends [m], the force of latches [N]; with latches or
        from a free start the force on the passive vehicle [N]; the accelerations of oscillators [m/s²]."""
        return self.observed_of(self.design, self.scenario)

    @staticmethod
    def observed_of(design: Design, scenario: Scenario) -> tuple[str, ...]:
        """Return `observed`, for which nothing need be assembled."""
        there = {
            "stop_force": design.buffer.stop_stiffness is not None,
            **dict.fromkeys(("hinge_force", "buffer_force", "stroke", "hinge_angle"), True),
            "bending": design.probe.bending_stiffness is not None,
            "latch_force": design.latch.stiffness is not None,
            "passive_force": design.latch.stiffness is not None or scenario.start == "free",
        }
        return (*CONTACTS, *(name for name, is_there in there.items() if is_there), *design.shock.frequencies)

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
        if self.latch is not None:
            others.append(self.latch.size(self.acting_latch(at, active)))
        if "passive_force" in self.observed:
            on_passive = rate[n + 3 * T : n + 3 * T + 2] * self.design.passive.mass
            others.append(jnp.sqrt(on_passive[0] ** 2 + on_passive[1] ** 2 + 1e-24))
        if self.oscillators is not None:
            others += self.oscillators.sizes(kin, self.swinging(at.state))
        return jnp.concatenate([self.contact(at, active).normal, stacked(others)])

    def rate_observables(self) -> tuple[bool, ...]:
        return tuple(name in ("hinge_force", "passive_force") for name in self.observed)

    @property
    def sudden(self) -> bool:
        """Where the probe rings or the hinge's pin bounces."""
        return self.hinge is not None or self.probe.bending is not None

    def negligible(self) -> Float[Array, " observables"]:
        spring = ROUNDED_LENGTH * self.axial_stiffness
        sizes: dict[str, Scalar] = {name: ROUNDED_LENGTH for name in ("stroke", "hinge_angle", "bending")}
        sizes |= {"buffer_force": spring, "hinge_force": spring + ROUNDED_ACCELERATION * self.design.active.mass}
        sizes["passive_force"] = spring + ROUNDED_ACCELERATION * self.design.passive.mass
        if self.latch is not None:
            sizes["latch_force"] = ROUNDED_LENGTH * self.latch.latch.stiffness
        if self.oscillators is not None:
            rates = self.oscillators.rates[::2]
            sizes |= dict(zip(self.design.shock.frequencies, ROUNDED_LENGTH * rates**2, strict=True))
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
        sizes: dict[str, Scalar] = {"since_crossing": 1.0, "time": 1.0}  # s
        sizes |= dict.fromkeys(("impulse_x", "impulse_y", "impulse_turn"), self.momentum_scale)
        extras = [sizes.get(name, energy) for name in self.extra_names]
        swinging = [] if self.oscillators is None else list(self.oscillators.scales(speed))
        return stacked(position + velocity + spin + [energy] * len(self.loss_names) + extras + swinging + [speed] * 2)

    def inverse_masses_at(self, at: Posture) -> Float[Array, "flanks flanks"]:
        return inverse_masses(self.system, at.kin, flank_directions(self, at)[0][: self.coordinates])

    def normal_force_at(self, at: Posture, active: Float[Array, " contacts"]) -> Float[Array, " flanks"]:
        return self.contact(at, active).normal

    def snapshot_at(self, at: Posture, active: Float[Array, " contacts"]) -> Snapshot:
        motion, forces, _ = self.dynamics(at, active)
        rate = jnp.concatenate([at.kin.v, motion.acceleration])
        values = dict(zip(self.observed, self.observables_at(at, rate, active), strict=True))
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
                "hinge_force": values["hinge_force"],
                "buffer_force": jnp.copysign(values["buffer_force"], self.axial.tension(at.kin)),
                "stop_force": jnp.asarray(self.stop_force(at, active)),
                "stroke": values["stroke"],
                "hinge_angle": jnp.copysign(values["hinge_angle"], at.kin.q[5] - at.kin.q[2]),
                "throat_distance": self.throat(at.kin, at.tip)[0],
                **({} if at.pin is None else {"hinge_gap": at.pin.approach.gap[0]}),
                "bending": self.bending(at.kin),
                "relative_energy": self.relative_energy(at, active),
                **{name: values[name] for name in ("latch_force", "passive_force") if name in values},
                **{name: values[name] for name in self.design.shock.frequencies},
                **({} if at.latch is None else {"latch_closed": self.acting_latch(at, active).share}),
            },
        )

    def energy_at(self, at: Posture, active: Float[Array, " contacts"]) -> Energy:
        none = {name: jnp.zeros(()) for name in ("stop_damper", "hinge_play", "bending")}
        lost = none | dict(zip(self.loss_names, self.losses(at.state), strict=True))
        stored = {**self.stored(at, active), **self.put_in(at.state)}
        return Energy({name: jnp.asarray(energy) for name, energy in stored.items()}, lost)

    def momentum(self, state: Float[Array, " state"]) -> tuple[Float[Array, " 2"], Float[Array, ""]]:
        kin = self.kinematics(state)
        angular = self.system.angular_momentum(kin)
        if self.spins:
            angular = angular + self.probe.tip_inertia * state[2 * self.coordinates]
        linear = self.system.linear_momentum(kin)
        if self.thrust is not None:  # what it put in is no error
            linear = linear - stacked([self.extra(state, "impulse_x"), self.extra(state, "impulse_y")])
            angular = angular - self.extra(state, "impulse_turn")
        return linear, angular

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
        forces = jnp.abs(self.axial.tension(at.kin)) + self.stop_force(at, active) + self.rebound_force(at, active)
        if self.hinge is not None and at.pin is not None:
            forces = forces + self.hinge.force(at.pin, self.closed(active, "pin"))[0]
        if self.latch is not None:
            forces = forces + self.latch.size(self.acting_latch(at, active))
        return forces

    def impact_step(self, state: Float[Array, " state"]) -> Float[Array, ""]:
        """A fifteenth of the duration of an impact of the probe's mass at the memorised speed [s]."""
        speed = jnp.max(self.memory(state))
        if self.scenario.start == "free":  # before the first touchdown the memory is at its floor
            speed = jnp.where(speed > self.slowest_touchdown, speed, self.scenario.approach_speed)
        return 0.2 * jnp.asarray(self.pair.law.time_scale(self.probe.mass, speed))

    @property
    def tolerance_share(self) -> float:
        """Less with measured curves: between two of their pieces the force's second derivative jumps."""
        buffer = self.design.buffer
        return 1.0 if buffer.spring_curve is None and buffer.damper_curve is None else PIECES

    @property
    def invariant_change(self) -> float:
        """Less with latches: until the vehicles are at rest there are hundreds of long steps, whose errors add up."""
        return super().invariant_change if self.latch is None else LONG_RUN

    def linearisation(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Linearisation:
        at = self.posture(state)
        smooth = self.smooth_memory(at)
        decay = None if smooth is None else smooth.all_decay(state, 2 * self.coordinates + self.spins)
        stiff = linearisation(self, at, active, decay)
        if self.oscillators is None:
            return stiff
        first = len(self.loss_names) + len(self.extra_names)
        return dataclasses.replace(stiff, followers=self.oscillators.followers(first))

    def smooth_memory(self, at: Posture) -> SmoothMemory | None:
        """How the memory follows δ̇ while out of contact; None with events, which set it."""
        if not self.smooth:
            return None
        contact, approach = self.design.contact, at.approach
        memory = self.memory(at.state)
        return SmoothMemory.of(
            memory,
            approach.gap,
            approach.approach_speed,
            contact.memory_time,
            contact.onset_length,
            self.slowest_touchdown,
        )
