"""A design in a scenario at one instant: where everything is, and what acts on it.

The state is ``[q (12), v (12), tip spin (if free), energy lost (4, with an end stop 5), contact memory (2)]``. Contacts
are the lower and the upper flank and, if there is one, the buffer's end stop.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar, Values
from ...contact import Approach, Ball, BallOnSegments, Carrier, KelvinVoigt
from ...multibody import AxialSpringDamper, AxialState, Kinematics, Load, Motion, System, load_at
from ...plane import Vector
from .assembly import FLANKS, B, Masses, N, P, T, assemble_contact, assemble_system, end_stop, probe_masses
from .design import Design, Scenario


class Posture(NamedTuple):
    """A state looked at once.

    - ``state``: (state,).
    - ``kin``: the bodies' frames.
    - ``tip``: the tip ball (M29).
    - ``arm``: from the probe's centre of mass to the tip's centre, in inertial axes [m].
    - ``approach``: geometry and relative motion of the tip against both flanks (M31, M32).
    - ``axial``: the buffer's axial element (M22).
    - ``stroke``: s = l_0 - L [m] (M28).
    - ``stroke_rate``: ṡ [m/s].
    """

    state: Float[Array, " state"]
    kin: Kinematics
    tip: Ball
    arm: Vector
    approach: Approach
    axial: AxialState
    stroke: Scalar
    stroke_rate: Scalar


class Forces(NamedTuple):
    """Contact at one instant, an entry a flank.

    - ``approach``: geometry and speeds.
    - ``normal``: (flanks,) F_n [N].
    - ``friction``: (flanks,) F_t along the tangent [N].
    """

    approach: Approach
    normal: Float[Array, " flanks"]
    friction: Float[Array, " flanks"]


class ProbeInCone(eqx.Module):
    """The probe-cone mechanism at one instant.

    - ``design``, ``scenario``: as given.
    - ``probe``: masses and lengths of the probe with its tip (M6).
    - ``system``: bodies, joints and buffer, with Baumgarte's gain ``stabilisation`` [1/s] (M16).
    - ``pair``: tip against flanks.
    - ``stop``: the law of the buffer's end stop, or None.
    """

    design: Design
    scenario: Scenario
    probe: Masses
    system: System
    pair: BallOnSegments
    stop: KelvinVoigt | None

    def __init__(self, design: Design, scenario: Scenario, stabilisation: Scalar = 20.0):
        self.design, self.scenario = design, scenario
        self.probe = probe_masses(design)
        self.system = assemble_system(design, self.probe, stabilisation)
        self.pair = assemble_contact(design)
        self.stop = end_stop(design)

    @property
    def axial(self) -> AxialSpringDamper:
        """The buffer's axial spring-damper."""
        element = self.system.forces[0]
        assert isinstance(element, AxialSpringDamper)
        return element

    @property
    def smooth(self) -> bool:
        """Whether the contact's memory is a state that follows, rather than set by events."""
        return self.design.contact.memory == "smooth"

    @property
    def contact_count(self) -> int:
        """Both flanks, and the end stop if there is one."""
        return FLANKS + (self.stop is not None)

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
        """Frames of the bodies. ``state``: (state,)."""
        return Kinematics(state[:N], state[N : 2 * N])

    def losses(self, state: Float[Array, " state"]) -> Float[Array, " losses"]:
        """Energy lost so far in axial damper, torsional damper, contact, friction and end stop, if there is one [J]
        (M76).

        **Arguments:** ``state``: (state,).
        """
        return state[2 * N + self.spins : -2]

    def memory(self, state: Float[Array, " state"]) -> Float[Array, " flanks"]:
        """(flanks,) δ̇⁻ [m/s] (M36). ``state``: (state,)."""
        return state[-2:]

    # --- what acts ----------------------------------------------------------------------------------------------------

    def tip(self, kin: Kinematics, state: Float[Array, " state"]) -> tuple[Ball, Vector]:
        """The tip ball, and its arm from the probe's centre of mass in inertial axes [m] (M29)."""
        probe = kin.frame(P)
        arm = probe.turn(Vector(self.probe.front, 0.0))
        centre, velocity = probe.origin + arm, probe.velocity_at(arm)
        spin = state[2 * N] if self.spins else probe.spin
        return Ball(centre.x, centre.y, velocity.x, velocity.y, spin), arm

    def posture(self, state: Float[Array, " state"]) -> Posture:
        """Where everything is; tip against both flanks, and the buffer. ``state``: (state,)."""
        kin = self.kinematics(state)
        (tip, arm), cone = self.tip(kin, state), kin.frame(T)
        carrier = Carrier(cone.origin.x, cone.origin.y, cone.cos, cone.sin, cone.velocity.x, cone.velocity.y, cone.spin)
        axial = self.axial.state(kin)
        stroke = self.axial.free_length - axial.length
        return Posture(state, kin, tip, arm, self.pair.approach(tip, carrier), axial, stroke, -axial.rate)

    def contact(self, at: Posture, active: Float[Array, " contacts"]) -> Forces:
        """Contact forces of both flanks; an open one exerts none (the smooth contact knows no open and closed).

        **Arguments:** ``at``; ``active``: (contacts,) 1 for closed ones, 0 for open ones.
        """
        pair, approach = self.pair, at.approach
        normal = self.exerting(active) * pair.normal_force(self.rounded(approach), self.memory(at.state))
        return Forces(approach, normal, pair.friction_force(approach, normal))

    def exerting(self, active: Float[Array, " contacts"]) -> Float[Array, " flanks"]:
        """(flanks,) 1 for those whose force follows the gap, 0 for open ones."""
        return jnp.ones(FLANKS) if self.smooth else active[:FLANKS]

    def stop_force(self, at: Posture, active: Float[Array, " contacts"]) -> Scalar:
        """F_s of the end stop [N], 0 while it is open or where there is none (M28)."""
        if self.stop is None:
            return 0.0
        return active[FLANKS] * self.stop.force(self._stop_depth(at), jnp.asarray(at.stroke_rate), jnp.ones(()))

    def _stop_depth(self, at: Posture) -> Float[Array, ""]:
        """By how much the stroke exceeds s_m [m] (M28)."""
        return jnp.asarray(at.stroke - self.design.buffer.end)

    def _stop_loads(self, at: Posture, active: Float[Array, " contacts"]) -> tuple[Load, ...]:
        """The end stop pushes the spring's ends apart along the cylinder (M28)."""
        if self.stop is None:
            return ()
        push = at.axial.along * self.stop_force(at, active)
        return load_at(B, -push, at.axial.first_arm), load_at(P, push, at.axial.second_arm)

    def rounded(self, approach: Approach) -> Approach:
        """With the smooth contact, the approach with its penetration rounded over the onset length (M60)."""
        if not self.smooth:
            return approach
        gap, onset = approach.gap, self.design.contact.onset_length
        return approach._replace(gap=0.5 * (gap - jnp.sqrt(gap * gap + onset * onset)))

    def _contact_loads(self, at: Posture, forces: Forces) -> tuple[Load, Load, Scalar]:
        """Loads on probe and passive vehicle, and the moment that spins a free tip [N m] (M33, M34)."""
        a = at.approach
        force_x = forces.normal * a.normal_x + forces.friction * a.tangent_x
        force_y = forces.normal * a.normal_y + forces.friction * a.tangent_y
        total = Vector(jnp.sum(force_x), jnp.sum(force_y))
        # About the tip's centre the foot's arm is -distance · normal, so only friction turns the tip.
        tip_moment: Scalar = -jnp.sum(a.distance * (a.normal_x * force_y - a.normal_y * force_x))
        foot_x: Values | Scalar = a.foot_x
        foot_y: Values | Scalar = a.foot_y
        if self.design.contact.arms == "published":
            flanks, cone = self.pair.segments, at.kin.frame(T)
            frozen_x = flanks.start_x + self.scenario.contact_distance * flanks.direction_x
            frozen_y = flanks.start_y + self.scenario.contact_distance * flanks.direction_y
            foot_x, foot_y = cone.cos * frozen_x - cone.sin * frozen_y, cone.sin * frozen_x + cone.cos * frozen_y
            tip_moment = jnp.zeros(())
        cone_moment = -jnp.sum(foot_x * force_y - foot_y * force_x)
        on_probe = load_at(P, total, at.arm)
        if not self.spins:
            on_probe = on_probe._replace(moment=on_probe.moment + tip_moment)
        return on_probe, Load(T, -total, cone_moment), tip_moment

    def dynamics(self, at: Posture, active: Float[Array, " contacts"]) -> tuple[Motion, Forces, Scalar]:
        """Accelerations and multipliers (M16), contact forces, and the moment on the tip about its centre [N m]."""
        forces = self.contact(at, active)
        on_probe, on_cone, tip_moment = self._contact_loads(at, forces)
        return self.system.motion(at.kin, (on_probe, on_cone, *self._stop_loads(at, active))), forces, tip_moment

    def throat(self, kin: Kinematics, tip: Ball) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """How far the tip centre is before the capture plane [m] (M65), and how that changes [m/s].

        **Arguments:** ``kin``: the bodies' frames; ``tip``: the tip ball.
        """
        cone = kin.frame(T)
        local = cone.unturn(Vector(tip.x, tip.y) - cone.origin)
        moves = cone.unturn(Vector(tip.velocity_x, tip.velocity_y) - cone.velocity)
        plane = -self.design.cone.offset - self.design.probe.tip_radius * jnp.sin(self.design.cone.half_angle)
        return plane - local.x, -jnp.asarray(moves.x + cone.spin * local.y)

    def throat_of(self, state: Float[Array, " state"]) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """`throat` of a ``state``, (state,)."""
        kin = self.kinematics(state)
        return self.throat(kin, self.tip(kin, state)[0])

    def stored(self, at: Posture, active: Float[Array, " contacts"]) -> tuple[Scalar, Scalar, Scalar, Scalar]:
        """Energy in motion, in the springs, in the contacts and in the end stop [J] (M76)."""
        kinetic = self.system.kinetic_energy(at.kin.v)
        if self.spins:
            kinetic = kinetic + 0.5 * self.probe.tip_inertia * at.state[2 * N] ** 2
        elastic = jnp.sum(self.exerting(active) * self.pair.stored_energy(self.rounded(at.approach)))
        stop: Scalar = 0.0
        if self.stop is not None:
            stop = active[FLANKS] * self.stop.energy(self._stop_depth(at))
        return kinetic, self.system.stored_energy(at.kin), elastic, stop

    def stop_loss(self, at: Posture, active: Float[Array, " contacts"]) -> Scalar:
        """Power lost in the end stop [W]: what the stop takes less what the spring in it takes (M28)."""
        assert self.stop is not None
        elastic = active[FLANKS] * self.stop.elastic(self._stop_depth(at))
        return (self.stop_force(at, active) - elastic) * at.stroke_rate
