"""The probe-cone capture mechanism assembled from bodies, joints, spring-dampers and a ball-on-flanks contact.

Four bodies in the paper's order: active vehicle S, cylinder B, probe P (with the tip on its end), passive vehicle T.
The state is ``[q (12), v (12), tip spin (if free), energy lost (4), contact memory (2)]``.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._types import Scalar
from ..contact import Approach, Ball, BallOnSegments, Carrier, LankaraniNikravesh, RegularisedCoulomb, Segment
from ..multibody import (
    AxialSpringDamper,
    Body,
    Kinematics,
    Load,
    Motion,
    Prismatic,
    Revolute,
    System,
    TorsionalSpringDamper,
    Vector,
    load_at,
)
from .design import Design, Scenario
from .hybrid import HybridSystem, Linearisation

S, B, P, T = range(4)  # bodies, in the order of the coordinates
N = 12  # coordinates
LOWER, UPPER = 0, 1  # flanks
SIDE = np.array([1.0, -1.0])  # σ: +1 lower, -1 upper flank
SLOWEST_TOUCHDOWN = 1e-5  # m/s, the least δ̇⁻ of the model's section 5
LOSSES = ("axial damper", "torsional damper", "contact", "friction")


class Masses(NamedTuple):
    """Probe with its tip: mass [kg], inertia about the centre of mass [kg m²], distances from it to rear end and tip
    centre [m], and the tip's own inertia [kg m²] (0 when it is part of the probe's)."""

    mass: Scalar
    inertia: Scalar
    rear: Scalar
    front: Scalar
    tip_inertia: Scalar


def probe_masses(design: Design) -> Masses:
    """Rod and tip as one body (the model's section 1); a free tip's spin inertia is left out of it."""
    probe = design.probe
    mass = probe.rod_mass + probe.tip_mass
    shift = probe.tip_mass * (probe.length / 2) / mass
    rear, front = probe.length / 2 + shift, probe.length / 2 - shift
    tip = 0.4 * probe.tip_mass * probe.tip_radius**2
    inertia = probe.rod_mass * (probe.length**2 / 12 + shift**2) + probe.tip_mass * front**2
    return Masses(mass, inertia if probe.free_tip else inertia + tip, rear, front, tip)


def assemble_system(design: Design, stabilisation: Scalar) -> System:
    """Bodies, joints and buffer of the capture mechanism."""
    probe = probe_masses(design)
    half = design.buffer.cylinder_length / 2
    cylinder = Body(design.buffer.cylinder_mass, design.buffer.cylinder_mass * design.buffer.cylinder_length**2 / 12)
    return System(
        bodies=(
            Body(design.active.mass, design.active.inertia),
            cylinder,
            Body(probe.mass, probe.inertia),
            Body(design.passive.mass, design.passive.inertia),
        ),
        joints=(
            Revolute(S, B, first_point=(design.active.hinge_offset, 0.0), second_point=(half, 0.0)),
            Prismatic(B, P),
        ),
        forces=(
            AxialSpringDamper(
                B,
                P,
                first_point=(-half, 0.0),
                second_point=(-probe.rear, 0.0),
                stiffness=design.buffer.k_A,
                damping=design.buffer.c_A,
                free_length=design.buffer.free_length,
                published_damping=design.buffer.damping == "published",
            ),
            TorsionalSpringDamper(S, B, stiffness=design.buffer.k_T, damping=design.buffer.c_T),
        ),
        stabilisation=stabilisation,
    )


def assemble_contact(design: Design) -> BallOnSegments:
    """The tip against both flanks, in the passive vehicle's axes."""
    angle = design.cone.half_angle
    flanks = Segment(
        start_x=-design.cone.offset,
        start_y=-SIDE * design.cone.throat_radius,
        direction_x=-jnp.cos(angle),
        direction_y=-SIDE * jnp.sin(angle),
        length=design.cone.length,
    )
    return BallOnSegments(
        radius=design.probe.tip_radius,
        segments=flanks,
        side=SIDE,
        law=LankaraniNikravesh(design.contact_stiffness, design.contact.restitution),
        friction=RegularisedCoulomb(design.contact.friction, design.contact.slip_speed),
    )


class Forces(NamedTuple):
    """Contact at one instant, an entry a flank: geometry and speeds, F_n and F_t [N]."""

    approach: Approach
    normal: Float[Array, " flanks"]
    friction: Float[Array, " flanks"]


class CaptureMechanism(HybridSystem):
    """A design in a scenario, ready to be stepped through time."""

    design: Design
    scenario: Scenario
    stabilisation: Scalar = 20.0

    # --- the parts ----------------------------------------------------------------------------------------------------

    @property
    def probe(self) -> Masses:
        """Masses and lengths of the probe with its tip."""
        return probe_masses(self.design)

    @property
    def system(self) -> System:
        """Bodies, joints and buffer."""
        return assemble_system(self.design, self.stabilisation)

    @property
    def pair(self) -> BallOnSegments:
        """Tip against flanks."""
        return assemble_contact(self.design)

    # --- the state's layout -------------------------------------------------------------------------------------------

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
        """Contact forces of both flanks; an open one exerts none."""
        pair = self.pair
        approach = self.approach(kin, state)
        normal = active * pair.normal_force(self._onset(approach), self.memory(state))
        return Forces(approach, normal, pair.friction_force(approach, normal))

    def _onset(self, approach: Approach) -> Approach:
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
        tip_moment = -jnp.sum(a.distance * (a.normal_x * force_y - a.normal_y * force_x))
        foot_x, foot_y = a.foot_x, a.foot_y
        if self.design.contact.arms == "published":
            flanks, cone = self.pair.segments, kin.frame(T)
            frozen_x = flanks.start_x + self.scenario.contact_distance * flanks.direction_x
            frozen_y = flanks.start_y + self.scenario.contact_distance * flanks.direction_y
            foot_x, foot_y = cone.cos * frozen_x - cone.sin * frozen_y, cone.sin * frozen_x + cone.cos * frozen_y
            tip_moment = 0.0 * tip_moment
        cone_moment = -jnp.sum(foot_x * force_y - foot_y * force_x)
        on_probe = load_at(P, total, self.tip(kin, state)[1])
        if not self.spins:
            on_probe = on_probe._replace(moment=on_probe.moment + tip_moment)
        return on_probe, Load(T, -total, cone_moment), tip_moment

    # --- time stepping (see integrate.HybridSystem) -------------------------------------------------------------------

    def start(self) -> tuple[Float[Array, " state"], Float[Array, " flanks"]]:
        """The tip just touches the lower flank at the slant distance b (the model's section 6)."""
        design, scenario = self.design, self.scenario
        angle, zero = design.cone.half_angle, jnp.zeros(())
        cos, sin = jnp.cos(angle), jnp.sin(angle)
        local = Vector(
            -design.cone.offset - scenario.contact_distance * cos - design.probe.tip_radius * sin,
            -design.cone.throat_radius - scenario.contact_distance * sin + design.probe.tip_radius * cos,
        )
        turn_cos, turn_sin = jnp.cos(scenario.misalignment), jnp.sin(scenario.misalignment)
        tip = Vector(turn_cos * local.x - turn_sin * local.y, turn_sin * local.x + turn_cos * local.y)
        probe = self.probe
        rear = tip.x - probe.front - probe.rear
        cylinder = rear - design.buffer.free_length + design.buffer.cylinder_length / 2
        active = cylinder + design.buffer.cylinder_length / 2 - design.active.hinge_offset
        q = [
            active,
            tip.y,
            zero,
            cylinder,
            tip.y,
            zero,
            tip.x - probe.front,
            tip.y,
            zero,
            zero,
            zero,
            scenario.misalignment,
        ]
        speed = scenario.approach_speed
        v = [speed, zero, zero] * 3 + [zero, zero, scenario.passive_rate]
        state = _vector(q + v + [zero] * (self.spins + 4) + [1.0, 1.0])
        approach = self.approach(self.kinematics(state), state).approach_speed
        memory = jnp.maximum(approach, SLOWEST_TOUCHDOWN)
        closed = jnp.where(approach[LOWER] > 0.0, 1.0, 0.0)
        state = jnp.concatenate([state[:-2], memory])
        return state, (jnp.ones(2) if self.smooth else jnp.stack([closed, jnp.zeros(())]))

    def dynamics(self, state: Float[Array, " state"], active: Float[Array, " flanks"]) -> tuple[Motion, Forces, Scalar]:
        """Accelerations and multipliers, contact forces, and the moment on the tip about its centre [N m]."""
        kin = self.kinematics(state)
        forces = self.contact(kin, state, active)
        on_probe, on_cone, tip_moment = self._contact_loads(kin, state, forces)
        return self.system.motion(kin, (on_probe, on_cone)), forces, tip_moment

    def derivative(
        self, time: Float[Array, ""], state: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> Float[Array, " state"]:
        kin = self.kinematics(state)
        motion, forces, tip_moment = self.dynamics(state, active)
        system, pair = self.system, self.pair
        axial, torsional = (element.dissipation(kin) for element in system.forces)
        hysteresis = jnp.sum(active * pair.hysteresis_power(self._onset(forces.approach), forces.normal))
        friction = -jnp.sum(forces.friction * forces.approach.slip)
        spin = [tip_moment / self.probe.tip_inertia] if self.spins else []
        rest = _vector([*spin, axial, torsional, hysteresis, friction])
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

    def closed_by_events(self) -> bool:
        return not self.smooth

    def touchdown(
        self, state: Float[Array, " state"], rate: Float[Array, " state"], contact: Int[Array, ""]
    ) -> Float[Array, " state"]:
        """δ̇⁻ takes the approach speed at the crossing itself, a first-order step away from the located state."""
        if self.smooth:
            return state
        crossing = state + rate * self.time_to_contact(state, contact)
        speed = self.approach(self.kinematics(crossing), crossing).approach_speed
        memory = jnp.where(jnp.arange(2) == contact, jnp.maximum(speed, SLOWEST_TOUCHDOWN), self.memory(state))
        return jnp.concatenate([state[:-2], memory])

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
        axial, _ = self.system.forces
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
        return _vector(position * 4 + velocity * 4 + spin + [energy] * 4 + [speed] * 2)

    def impact_step(self, state: Float[Array, " state"]) -> Float[Array, ""]:
        """A hundredth of the duration of a Hertz impact of the probe's mass at the memorised speed [s]."""
        mass, speed = self.probe.mass, jnp.max(self.memory(state))
        return 0.03 * (mass**2 / (self.design.contact_stiffness**2 * speed)) ** 0.2


    def linearisation(
        self, time: Float[Array, ""], state: Float[Array, " state"], active: Float[Array, " flanks"]
    ) -> Linearisation:
        """Axial and torsional spring-damper, and each flank's normal force and friction, with frozen directions."""
        kin = self.kinematics(state)
        approach, memory = self._onset(self.approach(kin, state)), self.memory(state)
        pair, buffer = self.pair, self.design.buffer
        axial = self.system.forces[0].state(kin)

        def contact_forces(depth: Array, speed: Array, slip: Array) -> tuple[Array, Array]:
            normal = active * pair.law.force(depth, speed, memory)
            return normal, -pair.friction.force(normal, slip)

        def slopes(along: tuple[float, float, float]) -> tuple[Array, Array]:
            point = (-approach.gap, approach.approach_speed, approach.slip)
            return jax.jvp(contact_forces, point, tuple(jnp.full(2, a) for a in along))[1]

        none = jnp.zeros(2)
        per_depth, per_speed, per_slip = slopes((1.0, 0.0, 0.0)), slopes((0.0, 1.0, 0.0)), slopes((0.0, 0.0, 1.0))

        def coupled(axial: Scalar, torsional: Scalar, normal: tuple[Array, Array], tangential: Array) -> Array:
            """Rows: axial, torsional, normal (2), friction (2); columns: what each depends on, in the same order."""
            buffer_rows = _vector([axial, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, torsional, 0.0, 0.0, 0.0, 0.0]).reshape(2, 6)
            left, eye = jnp.zeros((2, 2)), jnp.eye(2)
            normal_rows = jnp.concatenate([left, normal[0] * eye, left], axis=1)
            friction_rows = jnp.concatenate([left, normal[1] * eye, tangential * eye], axis=1)
            return jnp.concatenate([buffer_rows, normal_rows, friction_rows])

        directions = self._contact_directions(kin, state, approach)
        u, a, b = axial.along, axial.first_arm, axial.second_arm
        along = _vector([0.0] * 3 + [-u.x, -u.y, -a.cross(u), u.x, u.y, b.cross(u)] + [0.0] * (3 + self.spins))
        twist = _vector([0.0, 0.0, -1.0, 0.0, 0.0, 1.0] + [0.0] * (6 + self.spins))
        directions = jnp.concatenate([along[:, None], twist[:, None], directions], axis=1)
        response = self.system.response(kin, directions[:N])
        if self.spins:
            response = jnp.concatenate([response, directions[N:] / self.probe.tip_inertia])
        return Linearisation(
            directions=directions,
            response=response,
            stiffness=coupled(buffer.k_A, buffer.k_T, per_depth, none),
            damping=coupled(buffer.c_A, buffer.c_T, per_speed, per_slip[1]),
            coordinates=N,
        )

    def _contact_directions(self, kin: Kinematics, state: Array, approach: Approach) -> Float[Array, "velocities 4"]:
        """Columns b with δ̇ = b·w (both flanks), then v_t = b·w (both flanks)."""
        _, arm = self.tip(kin, state)
        normal_x, normal_y = -approach.normal_x, -approach.normal_y
        x = jnp.concatenate([normal_x, approach.tangent_x])
        y = jnp.concatenate([normal_y, approach.tangent_y])
        foot_x, foot_y = jnp.tile(approach.foot_x, 2), jnp.tile(approach.foot_y, 2)
        # The foot seen from the tip's centre: only the tangential speed feels the tip's spin.
        spin = jnp.concatenate([jnp.zeros(2), SIDE * approach.distance])
        turn = arm.x * y - arm.y * x + (0.0 if self.spins else spin)
        zero = jnp.zeros(4)
        rows = [zero] * 6 + [x, y, turn, -x, -y, -(foot_x * y - foot_y * x)] + [spin] * self.spins
        return jnp.stack(rows)


def _vector(values: list[Scalar]) -> Float[Array, " n"]:
    return jnp.stack([jnp.asarray(value, float) for value in values])
