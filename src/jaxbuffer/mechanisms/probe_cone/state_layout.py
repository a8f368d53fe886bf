"""What a design in a scenario consists of, and where in the state each number stands.

The state is ``[q, v, tip spin (if free), energy lost, extras, oscillators, contact memory (2)]``: 12 coordinates and
those of a probe that bends; losses and extras by name as `StateLayout.loss_names` and `extra_names` say. Contacts are
the lower and the upper flank and, where there are these, the buffer's stops, the pin of a hinge with play, and what
closes once and for all: the latches where the tip crosses the capture plane, their closing as it ends, and the end of a
thrust.
"""

import equinox as eqx
from jaxtyping import Array, Float

from ..._types import Scalar
from ...contact import BallPair, KelvinVoigt
from ...multibody import AxialSpringDamper, Kinematics, System
from .assembly import (
    FLANKS,
    Masses,
    S,
    T,
    assemble_contact,
    assemble_system,
    end_stop,
    probe_masses,
    rebound_stop,
)
from .design import Design, Scenario
from .hinge_play import HingePlay
from .latch_force import LatchForce
from .oscillators import Oscillators
from .thrust import Thrust

# With latches there are long implicit steps, and Newton's method does not know of Baumgarte's terms: with the full gain
# it fails at steps that accuracy would allow.
GAIN_WITH_LATCH = 0.5
LATCH, LATCHED, THRUST_OVER = "latch", "latched", "thrust over"
ONE_WAY = (LATCH, LATCHED, THRUST_OVER)  # contacts that never open again


class StateLayout(eqx.Module):
    """The parts of a design in a scenario, and where in the state each number stands.

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
