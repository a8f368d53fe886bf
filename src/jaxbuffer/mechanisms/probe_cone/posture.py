"""A design in a scenario at one instant: where everything is, and what acts on it.

The state is ``[q, v, tip spin (if free), energy lost, contact memory (2)]``: 12 coordinates and those of a probe that
bends; losses as `ProbeInCone.losses` says. Contacts are the lower and the upper flank and, where there are these, the
buffer's end stop and the pin of a hinge with play.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar, Values
from ...contact import Approach, Ball, BallPair, Carrier, KelvinVoigt, Segment
from ...multibody import AxialSpringDamper, AxialState, Kinematics, Load, MaterialPoint, Motion, System, load_at
from ...plane import Vector
from .assembly import (
    FLANKS,
    Masses,
    P,
    T,
    assemble_contact,
    assemble_system,
    end_stop,
    probe_masses,
)
from .design import Design, Scenario
from .hinge_play import HingePlay, PinPosture


class Posture(NamedTuple):
    """A state looked at once.

    - ``state``: (state,).
    - ``kin``: the bodies' frames.
    - ``tip``: the tip ball (M29).
    - ``centre``: the tip's centre on the probe.
    - ``approach``: geometry and relative motion of the tip against both flanks (M31, M32).
    - ``axial``: the buffer's axial element (M22).
    - ``stroke``: s = l_0 - L [m] (M28).
    - ``stroke_rate``: ṡ [m/s].
    - ``pin``: of a hinge with play.
    """

    state: Float[Array, " state"]
    kin: Kinematics
    tip: Ball
    centre: MaterialPoint
    approach: Approach
    axial: AxialState
    stroke: Scalar
    stroke_rate: Scalar
    pin: PinPosture | None


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
    - ``hinge``: its play, or None.
    """

    design: Design
    scenario: Scenario
    probe: Masses
    system: System
    pair: BallPair
    stop: KelvinVoigt | None
    hinge: HingePlay | None

    def __init__(self, design: Design, scenario: Scenario, stabilisation: Scalar = 20.0):
        self.design, self.scenario = design, scenario
        self.probe = probe_masses(design)
        self.system = assemble_system(design, self.probe, stabilisation)
        self.pair = assemble_contact(design)
        self.stop = end_stop(design)
        self.hinge = None if design.hinge.play is None else HingePlay(design)

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
        """Both flanks, the end stop if there is one, and a hinge with play."""
        return FLANKS + (self.stop is not None) + (self.hinge is not None)

    # --- the state's layout -------------------------------------------------------------------------------------------

    @property
    def spins(self) -> int:
        """Number of tip spins in the state."""
        return int(self.design.probe.free_tip)

    @property
    def coordinates(self) -> int:
        """Number of coordinates: three for each body, and the probe's modes."""
        return self.system.coordinates

    @property
    def velocities(self) -> int:
        """Number of velocities: the coordinates' and the tip's spin."""
        return self.coordinates + self.spins

    def kinematics(self, state: Float[Array, " state"]) -> Kinematics:
        """Frames of the bodies. ``state``: (state,)."""
        n = self.coordinates
        return self.system.kinematics(state[:n], state[n : 2 * n])

    def losses(self, state: Float[Array, " state"]) -> Float[Array, " losses"]:
        """Energy lost so far in axial damper, torsional damper, contact, friction and, where there are these, end stop,
        hinge's play and bending probe [J] (M76).

        **Arguments:** ``state``: (state,).
        """
        return state[2 * self.coordinates + self.spins : -2]

    def memory(self, state: Float[Array, " state"]) -> Float[Array, " flanks"]:
        """(flanks,) δ̇⁻ [m/s] (M36). ``state``: (state,)."""
        return state[-2:]

    # --- what acts ----------------------------------------------------------------------------------------------------

    def tip(self, kin: Kinematics, state: Float[Array, " state"]) -> tuple[Ball, MaterialPoint]:
        """The tip ball, and its centre on the probe (M29)."""
        centre = kin.point(P, self.probe.tip_centre)
        spin = state[2 * self.coordinates] if self.spins else centre.spin
        return Ball(*centre.place, *centre.velocity, spin), centre

    def posture(self, state: Float[Array, " state"]) -> Posture:
        """Where everything is; tip against both flanks, and the buffer. ``state``: (state,)."""
        kin = self.kinematics(state)
        (tip, centre), cone = self.tip(kin, state), kin.frame(T)
        carrier = Carrier(cone.origin.x, cone.origin.y, cone.cos, cone.sin, cone.velocity.x, cone.velocity.y, cone.spin)
        axial = self.axial.state(kin)
        stroke = self.axial.free_length - axial.length
        pin = None if self.hinge is None else self.hinge.posture(kin)
        return Posture(state, kin, tip, centre, self.pair.approach(tip, carrier), axial, stroke, -axial.rate, pin)

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
        return load_at(at.axial.first, -push), load_at(at.axial.second, push)

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
            flanks, cone = self.pair.shape, at.kin.frame(T)
            assert isinstance(flanks, Segment)
            frozen_x = flanks.start_x + self.scenario.contact_distance * flanks.direction_x
            frozen_y = flanks.start_y + self.scenario.contact_distance * flanks.direction_y
            foot_x, foot_y = cone.cos * frozen_x - cone.sin * frozen_y, cone.sin * frozen_x + cone.cos * frozen_y
            tip_moment = jnp.zeros(())
        cone_moment = -jnp.sum(foot_x * force_y - foot_y * force_x)
        on_probe = load_at(at.centre, total, 0.0 if self.spins else tip_moment)
        return on_probe, Load(T, -total, cone_moment), tip_moment

    def dynamics(self, at: Posture, active: Float[Array, " contacts"]) -> tuple[Motion, Forces, Scalar]:
        """Accelerations and multipliers (M16), contact forces, and the moment on the tip about its centre [N m]."""
        forces = self.contact(at, active)
        on_probe, on_cone, tip_moment = self._contact_loads(at, forces)
        loads = [on_probe, on_cone, *self._stop_loads(at, active)]
        if self.hinge is not None and at.pin is not None:
            loads += self.hinge.loads(at.pin, active[-1])
        return self.system.motion(at.kin, tuple(loads)), forces, tip_moment

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

    def stored(self, at: Posture, active: Float[Array, " contacts"]) -> dict[str, Scalar]:
        """Energy in motion, in the springs and a probe that bends, in the contacts, in the end stop and, if the hinge
        has play, in its pin [J] (M76)."""
        kinetic = self.system.kinetic_energy(at.kin)
        if self.spins:
            kinetic = kinetic + 0.5 * self.probe.tip_inertia * at.state[2 * self.coordinates] ** 2
        elastic = jnp.sum(self.exerting(active) * self.pair.stored_energy(self.rounded(at.approach)))
        stop: Scalar = 0.0
        if self.stop is not None:
            stop = active[FLANKS] * self.stop.energy(self._stop_depth(at))
        stored = {"kinetic": kinetic, "spring": self.system.stored_energy(at.kin), "contact": elastic, "stop": stop}
        if self.hinge is not None and at.pin is not None:
            stored["hinge"] = self.hinge.stored(at.pin, active[-1])
        return stored

    def stop_loss(self, at: Posture, active: Float[Array, " contacts"]) -> Scalar:
        """Power lost in the end stop [W]: what the stop takes less what the spring in it takes (M28)."""
        assert self.stop is not None
        elastic = active[FLANKS] * self.stop.elastic(self._stop_depth(at))
        return (self.stop_force(at, active) - elastic) * at.stroke_rate
