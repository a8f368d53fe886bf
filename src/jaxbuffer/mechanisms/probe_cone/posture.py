"""A design in a scenario at one instant: where everything is, and what acts on it.

The state is ``[q, v, tip spin (if free), energy lost, extras, oscillators, contact memory (2)]``: 12 coordinates and
those of a probe that bends; losses and extras by name as `ProbeInCone.loss_names` and `extra_names` say. Contacts are
the lower and the upper flank and, where there are these, the buffer's stops, the pin of a hinge with play, and what
closes once and for all: the latches where the tip crosses the capture plane, their closing as it ends, and the end of a
thrust.
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
    S,
    T,
    assemble_contact,
    assemble_system,
    end_stop,
    probe_masses,
    rebound_stop,
)
from .design import Design, Scenario
from .hinge_play import HingePlay, PinPosture
from .latch_force import LatchForce, LatchPosture
from .oscillators import Oscillators
from .relative_energy import rigid_energy
from .thrust import Thrust

# With latches there are long implicit steps, and Newton's method does not know of Baumgarte's terms: with the full gain
# it fails at steps that accuracy would allow.
GAIN_WITH_LATCH = 0.5
LATCH, LATCHED, THRUST_OVER = "latch", "latched", "thrust over"
ONE_WAY = (LATCH, LATCHED, THRUST_OVER)  # contacts that never open again


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


class ProbeInCone(eqx.Module):
    """The probe-cone mechanism at one instant.

    - ``design``, ``scenario``: as given.
    - ``probe``: masses and lengths of the probe with its tip (M6).
    - ``system``: bodies, joints and buffer, with Baumgarte's gain ``stabilisation`` [1/s] (M16), half of it
      with latches.
    - ``pair``: tip against flanks.
    - ``stop``: the law of the buffer's end stop, or None.
    - ``rebound``: the law of the buffer's rebound stop, or None.
    - ``hinge``: its play, or None.
    - ``latch``, ``thrust``, ``oscillators``: None where there are none.
    """

    design: Design
    scenario: Scenario
    probe: Masses
    system: System
    pair: BallPair
    stop: KelvinVoigt | None
    rebound: KelvinVoigt | None
    hinge: HingePlay | None
    latch: LatchForce | None
    thrust: Thrust | None
    oscillators: Oscillators | None

    def __init__(self, design: Design, scenario: Scenario, stabilisation: Scalar = 20.0):
        self.design, self.scenario = design, scenario
        self.probe = probe_masses(design)
        gain = stabilisation if design.latch.stiffness is None else GAIN_WITH_LATCH * stabilisation
        self.system = assemble_system(design, self.probe, gain)
        self.pair = assemble_contact(design)
        self.stop = end_stop(design)
        self.rebound = rebound_stop(design)
        self.hinge = None if design.hinge.play is None else HingePlay(design)
        self.latch = None if design.latch.stiffness is None else LatchForce(design)
        self.thrust = None if scenario.thrust is None else Thrust(scenario.thrust, scenario.thrust_time)
        self.oscillators = Oscillators(design.shock, {"active": S, "passive": T}) if design.shock.frequencies else None

    @property
    def axial(self) -> AxialSpringDamper:
        """The buffer's axial spring-damper."""
        element = self.system.forces[0]
        assert isinstance(element, AxialSpringDamper)
        return element

    @property
    def axial_stiffness(self) -> Scalar:
        """Stiffness of the buffer's axial spring at its free length [N/m]."""
        curve = self.design.buffer.spring_curve
        return self.design.buffer.k_A if curve is None else curve.values[0] / curve.places[0]

    @property
    def smooth(self) -> bool:
        """Whether the contact's memory is a state that follows, rather than set by events."""
        return self.design.contact.memory == "smooth"

    @property
    def contact_names(self) -> tuple[str, ...]:
        """Both flanks, and then what there is beside them."""
        there = {
            "stop": self.stop is not None,
            "rebound": self.rebound is not None,
            "pin": self.hinge is not None,
            LATCH: self.latch is not None,
            LATCHED: self.latch is not None,
            THRUST_OVER: self.thrust is not None,
        }
        return ("lower", "upper", *(name for name, is_there in there.items() if is_there))

    @property
    def contact_count(self) -> int:
        """How many contacts there are."""
        return len(self.contact_names)

    @property
    def one_way(self) -> tuple[bool, ...]:
        """Which contacts never open again."""
        return tuple(name in ONE_WAY for name in self.contact_names)

    def closed(self, active: Float[Array, " contacts"], name: str) -> Float[Array, ""]:
        """Whether the contact of a name is closed, 1, or open, 0."""
        return active[self.contact_names.index(name)]

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

    @property
    def loss_names(self) -> tuple[str, ...]:
        """Where energy is lost (M76)."""
        there = {
            "stop_damper": self.stop is not None,
            "hinge_play": self.hinge is not None,
            "bending": self.probe.bending is not None,
            "buffer_friction": self.design.buffer.friction is not None,
            "rebound_damper": self.rebound is not None,
            "latch_damper": self.latch is not None,
        }
        always = ("axial_damper", "torsional_damper", "hysteresis", "friction")
        return (*always, *(name for name, is_there in there.items() if is_there))

    @property
    def extra_names(self) -> tuple[str, ...]:
        """What else the state has: of latches the time since the tip crossed the capture plane [s], the energy that
        closing them put in and the energy of relative motion at the start [J]; of a thrust the time [s], the energy
        [J], the impulses [N s] and the angular impulse [N m s] that it put in."""
        latch = ("since_crossing", "closing_work", "first_energy") if self.latch is not None else ()
        thrust = ("time", "thrust_work", "impulse_x", "impulse_y", "impulse_turn") if self.thrust is not None else ()
        return (*latch, *thrust)

    def losses(self, state: Float[Array, " state"]) -> Float[Array, " losses"]:
        """Energy lost so far, as in `loss_names` [J]. ``state``: (state,)."""
        first = 2 * self.coordinates + self.spins
        return state[first : first + len(self.loss_names)]

    def extra(self, state: Float[Array, " state"], name: str) -> Float[Array, ""]:
        """One of the `extra_names`. ``state``: (state,)."""
        first = 2 * self.coordinates + self.spins + len(self.loss_names)
        return state[first + self.extra_names.index(name)]

    def with_extra(self, state: Float[Array, " state"], name: str, value: Scalar) -> Float[Array, " state"]:
        """The state with another value of one of the `extra_names`."""
        first = 2 * self.coordinates + self.spins + len(self.loss_names)
        return state.at[first + self.extra_names.index(name)].set(value)

    def swinging(self, state: Float[Array, " state"]) -> Float[Array, " oscillators"]:
        """States of the oscillators, which end where the memory begins. ``state``: (state,)."""
        assert self.oscillators is not None
        end = len(state) - FLANKS
        return state[end - 2 * self.oscillators.axes : end]

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
