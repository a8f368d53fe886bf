"""A design in a scenario at one instant: where everything is, and what acts on it."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar, Values
from ...contact import Approach, Ball, Carrier, Segment
from ...multibody import AxialState, Kinematics, Load, MaterialPoint, Motion, load_at
from ...plane import Vector
from .assembly import FLANKS, P, T
from .design import Design, Scenario
from .hinge_play import PinPosture
from .latch_force import LatchPosture
from .relative_energy import rigid_energy
from .state_layout import LATCH, THRUST_OVER, StateLayout


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
    - ``latch``: of a design with latches.
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
    latch: LatchPosture | None


class Forces(NamedTuple):
    """Contact at one instant, an entry a flank.

    - ``approach``: geometry and speeds.
    - ``normal``: (flanks,) F_n [N].
    - ``friction``: (flanks,) F_t along the tangent [N].
    """

    approach: Approach
    normal: Float[Array, " flanks"]
    friction: Float[Array, " flanks"]


class ProbeInCone(StateLayout):
    """The probe-cone mechanism at one instant: where everything is, and what acts on it."""

    def __init__(self, design: Design, scenario: Scenario, stabilisation: Scalar = 20.0):
        super().__init__(design, scenario, stabilisation)

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
        latch = None
        if self.latch is not None:
            latch = self.latch.posture(kin, centre, self.extra(state, "since_crossing"))
        approach = self.pair.approach(tip, carrier)
        return Posture(state, kin, tip, centre, approach, axial, stroke, -axial.rate, pin, latch)

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
        closed = self.closed(active, "stop")
        return closed * self.stop.force(self._stop_depth(at), jnp.asarray(at.stroke_rate), jnp.ones(()))

    def _stop_depth(self, at: Posture) -> Float[Array, ""]:
        """By how much the stroke exceeds s_m [m] (M28)."""
        return jnp.asarray(at.stroke - self.design.buffer.end)

    def rebound_force(self, at: Posture, active: Float[Array, " contacts"]) -> Scalar:
        """The force with which the rebound stop pulls the probe in [N], 0 while it is open or where there is none
        (M174)."""
        if self.rebound is None:
            return 0.0
        closed = self.closed(active, "rebound")
        return closed * self.rebound.force(self._rebound_depth(at), jnp.asarray(-at.stroke_rate), jnp.ones(()))

    def _rebound_depth(self, at: Posture) -> Float[Array, ""]:
        """How far the probe is beyond the beginning of the rebound stop [m] (M174)."""
        return jnp.asarray(-at.stroke - self.design.buffer.rebound_gap)

    def _stop_loads(self, at: Posture, active: Float[Array, " contacts"]) -> tuple[Load, ...]:
        """The end stop pushes the spring's ends apart along the cylinder (M28), the rebound stop together (M174)."""
        if self.stop is None and self.rebound is None:
            return ()
        push = at.axial.along * (self.stop_force(at, active) - self.rebound_force(at, active))
        return load_at(at.axial.first, -push), load_at(at.axial.second, push)

    def rounded(self, approach: Approach) -> Approach:
        """With the smooth contact, the approach with its penetration rounded over the onset length (M60)."""
        if not self.smooth:
            return approach
        gap, onset = approach.gap, self.design.contact.onset_length
        return approach._replace(gap=0.5 * (gap - jnp.sqrt(gap * gap + onset * onset)))

    def acting_latch(self, at: Posture, active: Float[Array, " contacts"]) -> LatchPosture:
        """The latches as they act: not at all before the tip has crossed the capture plane."""
        assert at.latch is not None
        return at.latch._replace(share=at.latch.share * self.closed(active, LATCH))

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
            loads += self.hinge.loads(at.pin, self.closed(active, "pin"))
        if self.latch is not None:
            loads += self.latch.loads(self.acting_latch(at, active))
        if self.thrust is not None:
            loads.append(self.thrust.load(at.kin, 1.0 - self.closed(active, THRUST_OVER)))
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

    def tip_in_cone(self, at: Posture) -> Vector:
        """The tip's centre in the axes of T [m]."""
        cone = at.kin.frame(T)
        return cone.unturn(Vector(at.tip.x, at.tip.y) - cone.origin)

    def throat_of(self, state: Float[Array, " state"]) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """`throat` of a ``state``, (state,)."""
        kin = self.kinematics(state)
        return self.throat(kin, self.tip(kin, state)[0])

    def stored(self, at: Posture, active: Float[Array, " contacts"]) -> dict[str, Scalar]:
        """Energy in motion, in the springs and a probe that bends, in the contacts, in the stops and, where there are
        these, in the hinge's pin and the latches [J] (M76)."""
        kinetic = self.system.kinetic_energy(at.kin)
        if self.spins:
            kinetic = kinetic + 0.5 * self.probe.tip_inertia * at.state[2 * self.coordinates] ** 2
        elastic = jnp.sum(self.exerting(active) * self.pair.stored_energy(self.rounded(at.approach)))
        stop: Scalar = 0.0
        if self.stop is not None:
            stop = self.closed(active, "stop") * self.stop.energy(self._stop_depth(at))
        stored = {"kinetic": kinetic, "spring": self.system.stored_energy(at.kin), "contact": elastic, "stop": stop}
        if self.hinge is not None and at.pin is not None:
            stored["hinge"] = self.hinge.stored(at.pin, self.closed(active, "pin"))
        if self.rebound is not None:
            stored["rebound"] = self.closed(active, "rebound") * self.rebound.energy(self._rebound_depth(at))
        if self.latch is not None:
            stored["latch"] = self.latch.stored(self.acting_latch(at, active))
        return stored

    def put_in(self, state: Float[Array, " state"]) -> dict[str, Scalar]:
        """Energy that was put in from outside, negative, beside what is `stored` [J]: by the closing of latches and by
        a thrust."""
        closing = {"latch_closing": -self.extra(state, "closing_work")} if self.latch is not None else {}
        thrust = {"thrust": -self.extra(state, "thrust_work")} if self.thrust is not None else {}
        return {**closing, **thrust}

    def relative_energy(self, at: Posture, active: Float[Array, " contacts"]) -> Float[Array, ""]:
        """The energy of relative motion [J]: what is stored and in motion beyond the motion of the whole as one rigid
        body (M177)."""
        spin = (self.probe.tip_inertia, at.state[2 * self.coordinates]) if self.spins else (0.0, 0.0)
        rigid = rigid_energy(self.system, at.kin, *spin)
        return jnp.asarray(sum(self.stored(at, active).values()) - rigid)

    def stop_loss(self, at: Posture, active: Float[Array, " contacts"]) -> Scalar:
        """Power lost in the end stop [W]: what the stop takes less what the spring in it takes (M28)."""
        assert self.stop is not None
        elastic = self.closed(active, "stop") * self.stop.elastic(self._stop_depth(at))
        return (self.stop_force(at, active) - elastic) * at.stroke_rate

    def rebound_loss(self, at: Posture, active: Float[Array, " contacts"]) -> Scalar:
        """Power lost in the rebound stop [W], as in the end stop (M174)."""
        assert self.rebound is not None
        elastic = self.closed(active, "rebound") * self.rebound.elastic(self._rebound_depth(at))
        return (self.rebound_force(at, active) - elastic) * -at.stroke_rate
