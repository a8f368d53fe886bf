"""The probe-cone capture mechanism as a hybrid system, ready to be stepped through time.

The state is ``[q (12), v (12), tip spin (if free), energy lost (4), contact memory (2)]``.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from .._types import Scalar, Values, stacked
from ..contact import Approach, Ball, BallOnSegments, Carrier
from ..multibody import AxialSpringDamper, Kinematics, Load, Motion, System, Vector, load_at
from .assembly import (
    LOWER,
    B,
    Masses,
    N,
    P,
    S,
    T,
    assemble_contact,
    assemble_system,
    probe_masses,
    start_motion,
)
from .design import Design, Scenario
from .hybrid import HybridSystem, Linearisation
from .stiffness import linearisation

ROUNDED = 1e-14  # m, and relative: rounding of positions of the order of a metre, with some to spare
SLOWEST_TOUCHDOWN = 1e-5  # m/s, the least δ̇⁻ of the model's section 5
LOSSES = ("axial damper", "torsional damper", "contact", "friction")


class Forces(NamedTuple):
    """Contact at one instant, an entry a flank: geometry and speeds, F_n and F_t [N]."""

    approach: Approach
    normal: Float[Array, " flanks"]
    friction: Float[Array, " flanks"]


class CaptureMechanism(HybridSystem):
    """A design in a scenario, ready to be stepped through time.

    **Arguments:** ``design``; ``scenario``; ``stabilisation``: Baumgarte's gain [1/s]. Assembled once: ``probe``,
    masses and lengths of the probe with its tip; ``system``, bodies, joints and buffer; ``pair``, tip against flanks.
    """

    design: Design
    scenario: Scenario
    probe: Masses
    system: System
    pair: BallOnSegments

    def __init__(self, design: Design, scenario: Scenario, stabilisation: Scalar = 20.0):
        self.design, self.scenario = design, scenario
        self.probe = probe_masses(design)
        self.system = assemble_system(design, stabilisation)
        self.pair = assemble_contact(design)

    @property
    def axial(self) -> AxialSpringDamper:
        """The buffer's axial spring-damper."""
        element = self.system.forces[0]
        assert isinstance(element, AxialSpringDamper)
        return element

    # --- the state's layout -------------------------------------------------------------------------------------------

    @property
    def coordinates(self) -> int:
        return N

    @property
    def spins(self) -> int:
        """Number of tip spins in the state."""
        return int(self.design.probe.free_tip)

    @property
    def velocities(self) -> int:
        """Number of velocities: the coordinates' and the tip's spin."""
        return N + self.spins

    def kinematics(self, state: Float[Array, " state"]) -> Kinematics:
        """Frames of the bodies."""
        return Kinematics(state[:N], state[N : 2 * N])

    def losses(self, state: Float[Array, " state"]) -> Float[Array, " 4"]:
        """Energy lost so far in the order of `LOSSES` [J]."""
        return state[2 * N + self.spins : 2 * N + self.spins + 4]

    def memory(self, state: Float[Array, " state"]) -> Float[Array, " flanks"]:
        """δ̇⁻ of each flank [m/s]."""
        return state[-2:]

    # --- contact ------------------------------------------------------------------------------------------------------

    @property
    def smooth(self) -> bool:
        return self.design.contact.memory == "smooth"

    def tip(self, kin: Kinematics, state: Float[Array, " state"]) -> tuple[Ball, Vector]:
        """The tip ball and its arm from the probe's centre of mass."""
        probe = kin.frame(P)
        arm = probe.turn(Vector(self.probe.front, 0.0))
        centre, velocity = probe.origin + arm, probe.velocity_at(arm)
        spin = state[2 * N] if self.spins else probe.spin
        return Ball(centre.x, centre.y, velocity.x, velocity.y, spin), arm

    def approach(self, kin: Kinematics, state: Float[Array, " state"]) -> Approach:
        """Geometry and relative motion of the tip against both flanks."""
        cone = kin.frame(T)
        carrier = Carrier(cone.origin.x, cone.origin.y, cone.cos, cone.sin, cone.velocity.x, cone.velocity.y, cone.spin)
        return self.pair.approach(self.tip(kin, state)[0], carrier)

    def contact(self, kin: Kinematics, state: Float[Array, " state"], active: Float[Array, " flanks"]) -> Forces:
        """Contact forces of both flanks; an open one exerts none (the smooth law knows no open and closed)."""
        pair = self.pair
        approach = self.approach(kin, state)
        normal = self.exerting(active) * pair.normal_force(self.rounded(approach), self.memory(state))
        return Forces(approach, normal, pair.friction_force(approach, normal))

    def exerting(self, active: Float[Array, " flanks"]) -> Float[Array, " flanks"]:
        """1 for flanks whose force follows the gap, 0 for open ones."""
        return jnp.ones(2) if self.smooth else active

    def rounded(self, approach: Approach) -> Approach:
        """With the smooth law, the penetration is rounded over the onset length: δ → (δ + √(δ² + ε²))/2."""
        if not self.smooth:
            return approach
        gap, onset = approach.gap, self.design.contact.onset_length
        return approach._replace(gap=0.5 * (gap - jnp.sqrt(gap * gap + onset * onset)))

    def _contact_loads(
        self, kin: Kinematics, state: Float[Array, " state"], forces: Forces
    ) -> tuple[Load, Load, Scalar]:
        """Loads on probe and passive vehicle, and the moment that spins a free tip."""
        a = forces.approach
        force_x = forces.normal * a.normal_x + forces.friction * a.tangent_x
        force_y = forces.normal * a.normal_y + forces.friction * a.tangent_y
        total = Vector(jnp.sum(force_x), jnp.sum(force_y))
        # About the tip's centre the foot's arm is -distance · normal, so only friction turns the tip.
        tip_moment: Scalar = -jnp.sum(a.distance * (a.normal_x * force_y - a.normal_y * force_x))
        foot_x: Values | Scalar = a.foot_x
        foot_y: Values | Scalar = a.foot_y
        if self.design.contact.arms == "published":
            flanks, cone = self.pair.segments, kin.frame(T)
            frozen_x = flanks.start_x + self.scenario.contact_distance * flanks.direction_x
            frozen_y = flanks.start_y + self.scenario.contact_distance * flanks.direction_y
            foot_x, foot_y = cone.cos * frozen_x - cone.sin * frozen_y, cone.sin * frozen_x + cone.cos * frozen_y
            tip_moment = jnp.zeros(())
        cone_moment = -jnp.sum(foot_x * force_y - foot_y * force_x)
        on_probe = load_at(P, total, self.tip(kin, state)[1])
        if not self.spins:
            on_probe = on_probe._replace(moment=on_probe.moment + tip_moment)
        return on_probe, Load(T, -total, cone_moment), tip_moment

    # --- time stepping (see integrate.HybridSystem) -------------------------------------------------------------------

    def start(self) -> tuple[Float[Array, " state"], Float[Array, " flanks"]]:
        q, v = start_motion(self.design, self.scenario)
        none = jnp.zeros(self.spins + 4)
        state = jnp.concatenate([q, v, none, jnp.ones(2)])
        approach = self.approach(self.kinematics(state), state).approach_speed
        state = jnp.concatenate([state[:-2], jnp.maximum(approach, SLOWEST_TOUCHDOWN)])
        touching = jnp.where((jnp.arange(2) == LOWER) & (approach > 0.0), 1.0, 0.0)
        return state, touching

    def dynamics(self, state: Float[Array, " state"], active: Float[Array, " flanks"]) -> tuple[Motion, Forces, Scalar]:
        """Accelerations and multipliers, contact forces, and the moment on the tip about its centre [N m]."""
        kin = self.kinematics(state)
        forces = self.contact(kin, state, active)
        on_probe, on_cone, tip_moment = self._contact_loads(kin, state, forces)
        return self.system.motion(kin, (on_probe, on_cone)), forces, tip_moment

    def derivative(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> Float[Array, " state"]:
        kin = self.kinematics(state)
        motion, forces, tip_moment = self.dynamics(state, active)
        system, pair = self.system, self.pair
        axial, torsional = (element.dissipation(kin) for element in system.forces)
        hysteresis = jnp.sum(
            self.exerting(active) * pair.hysteresis_power(self.rounded(forces.approach), forces.normal)
        )
        friction = -jnp.sum(forces.friction * forces.approach.slip)
        spin = [tip_moment / self.probe.tip_inertia] if self.spins else []
        rest = stacked([*spin, axial, torsional, hysteresis, friction])
        return jnp.concatenate([kin.v, motion.acceleration, rest, self._memory_rate(forces.approach, state)])

    def _memory_rate(self, approach: Approach, state: Float[Array, " state"]) -> Float[Array, " flanks"]:
        """Zero with events; the smooth law follows δ̇ while out of contact and holds while in it."""
        if not self.smooth:
            return jnp.zeros(2)
        contact = self.design.contact
        out = 0.5 * (1.0 + jnp.tanh(approach.gap / contact.onset_length))
        target = jnp.maximum(approach.approach_speed, SLOWEST_TOUCHDOWN)
        return out * (target - self.memory(state)) / contact.memory_time

    def gaps(self, state: Float[Array, " state"]) -> Float[Array, " flanks"]:
        return self.approach(self.kinematics(state), state).gap

    def touchdown(
        self, state: Float[Array, " state"], rate: Float[Array, " state"], contact: Int[Array, ""]
    ) -> Float[Array, " state"]:
        """δ̇⁻ takes the approach speed at the crossing itself, a first-order step away from the located state."""
        if self.smooth:
            return state
        crossing = state + rate * self.time_to_contact(state, contact)
        speed = self.approach(self.kinematics(crossing), crossing).approach_speed
        memory = jnp.where(jnp.arange(2) == contact, jnp.maximum(speed, SLOWEST_TOUCHDOWN), self.memory(state))
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
        approach = self.approach(self.kinematics(state), state)
        chosen = jnp.arange(2) == contact
        gap, speed = (
            jnp.sum(jnp.where(chosen, approach.gap, 0.0)),
            jnp.sum(jnp.where(chosen, approach.approach_speed, 0.0)),
        )
        return gap / jnp.where(speed == 0.0, 1.0, speed)

    def throat_distance(self, state: Float[Array, " state"]) -> Float[Array, ""]:
        """How far the tip centre is before the capture plane x = -L_T - R sin β in the cone's axes [m]."""
        kin = self.kinematics(state)
        cone, (tip, _) = kin.frame(T), self.tip(kin, state)
        local = cone.unturn(Vector(tip.x, tip.y) - cone.origin)
        plane = -self.design.cone.offset - self.design.probe.tip_radius * jnp.sin(self.design.cone.half_angle)
        return plane - local.x

    def terminals(self, state: Float[Array, " state"]) -> Float[Array, " 2"]:
        """Captured, escaped."""
        before = self.throat_distance(state)
        retreat = 2.0 * self.design.cone.length - self.design.probe.tip_radius * jnp.sin(self.design.cone.half_angle)
        return jnp.stack([-before, before - retreat])

    def observables(
        self, state: Float[Array, " state"], rate: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> Float[Array, " 6"]:
        """F_n of the lower and upper flank [N], hinge force [N], buffer force [N], stroke [m], hinge angle [rad]."""
        kin = self.kinematics(state)
        axial = self.axial
        forces = self.contact(kin, state, active)
        reaction = rate[N : N + 2] * self.design.active.mass
        hinge_force = jnp.sqrt(reaction[0] ** 2 + reaction[1] ** 2 + 1e-24)
        stroke = axial.free_length - axial.state(kin).length
        angle = kin.frame(B).angle - kin.frame(S).angle
        others = [hinge_force, jnp.abs(axial.tension(kin)), stroke, jnp.abs(angle)]
        return jnp.concatenate([forces.normal, jnp.stack(others)])

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

    def stored(
        self, state: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> tuple[Scalar, Scalar, Float[Array, ""]]:
        """Energy in motion, in the springs and in the contacts [J]."""
        kin = self.kinematics(state)
        kinetic = self.system.kinetic_energy(kin.v)
        if self.spins:
            kinetic = kinetic + 0.5 * self.probe.tip_inertia * state[2 * N] ** 2
        elastic = self.pair.stored_energy(self.rounded(self.approach(kin, state)))
        return kinetic, self.system.stored_energy(kin), jnp.sum(self.exerting(active) * elastic)

    def invariant(
        self, state: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """Energy, losses included, over that of the approach; its rounding is mostly the positions'. The smooth law's
        and the published arms' forces do work that no ledger holds."""
        if self.smooth or self.design.contact.arms == "published":
            return super().invariant(state, active)
        kin = self.kinematics(state)
        approach = 0.5 * self.design.active.mass * self.scenario.approach_speed**2
        total = sum(self.stored(state, active)) + jnp.sum(self.losses(state))
        forces = jnp.sum(self.contact(kin, state, active).normal) + jnp.abs(self.axial.tension(kin))
        return total / approach, ROUNDED * (1.0 + forces / approach)

    def impact_step(self, state: Float[Array, " state"]) -> Float[Array, ""]:
        """A fifteenth of the duration of an impact of the probe's mass at the memorised speed [s]."""
        return 0.2 * jnp.asarray(self.pair.law.time_scale(self.probe.mass, jnp.max(self.memory(state))))

    def linearisation(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> Linearisation:
        return linearisation(self, state, active)
