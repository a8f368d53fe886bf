"""Any planar mechanism with contacts: bodies and joints, force elements, balls on flanks and in holes, and elements."""

import math
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._types import Scalar, stacked
from ..elements import BallContact as BallContact
from ..elements import ContactForces, Element, Magnitudes, Oscillators
from ..elements.element import ROUNDED_LENGTH
from ..elements.stiff_terms import inverse_masses
from ..errors import InputError, concrete
from ..hybrid import Linearisation
from ..multibody import Kinematics, Motion, System
from ..plane import Vector
from .energy import Energy
from .layout import Closed, EvaluatedState, Layout, State, row
from .relative_energy import rigid_energy
from .snapshot import Snapshot
from .stiff_part import stiff_part
from .system import ONSET, ContactSystem, SmoothMemory

DEEPEST = 0.99  # of a ball's radius
HYSTERESIS, FRICTION = "hysteresis", "friction"  # where contacts lose energy

Quantity = Callable[[System, Kinematics], Scalar]
E = TypeVar("E", bound=Element)


class Shown(NamedTuple):
    """An observable: its ``name``; ``of``: its value from the mechanism, an evaluated state and the state's rate;
    ``of_rate``: whether it depends on the rate; ``least``: what its largest value is at least, as a depth is 0 where
    nothing touches; ``negligible``: from the mechanism, what of it is rounding where nothing acts."""

    name: str
    of: Callable[["Assembled", EvaluatedState, State], Scalar]
    of_rate: bool = False
    least: float = -math.inf
    negligible: Callable[["Assembled"], Scalar] | None = None


class Exerted(NamedTuple):
    """What acts at one instant: the contacts' forces, and accelerations and multipliers of the bodies."""

    contacts: tuple[ContactForces, ...]
    motion: Motion


class Assembled(ContactSystem):
    """A mechanism ready to be stepped through time from a consistent start.

    **Arguments:** ``system``: bodies, joints and force elements; the elements' driving joints are added to its own;
    ``q``, ``v``: positions and velocities at t = 0, on the constraints; ``contacts``: balls that have impacts;
    ``elements``: further parts, see `jaxbuffer.elements`; ``closed``: which contacts, and then which of the elements'
    switches, are closed at t = 0 (default: none); ``ends``: quantities whose crossing of zero upwards ends the run (so
    do elements, and a ball's centre that comes to its flank: "failed_penetration"); ``end_names``: of each, the name of
    the outcome that it stands for, among the mechanism's outcomes ("ended" unless given); ``quiet``: if given, the run
    ends as "held" where all that closes once has closed and the energy of relative motion is below this share of that
    at t = 0 (M177); ``size``: magnitudes that matter of the coordinates and of the velocities, one for all or one for
    each; ``speed`` [m/s]: that velocities are of the order of (default: the second of ``size``); ``shown``: further
    observables; ``recorded``: what a history shows besides; ``parts``: whatever these need to know; ``energy_size``
    [J]: magnitude of the energy; if given, steps must also keep the energy balance; ``momentum_size`` [kg m/s]: that of
    the momentum, where the ground takes no part; ``memory_time`` [s]: if given, no event sets the contacts' memory: it
    follows the approach speed while the contact is open (M61); ``first_memory`` [m/s]: the contacts' memory at t = 0;
    ``stored_in``, ``lost_in``: names of the energies that the system itself stores and loses (None: it loses none);
    ``listed``: names of energies, stored and lost, that are listed also where no part has them; ``rings``: whether
    reactions may rise suddenly, as where a body bends or a pin bounces.

    Observables are the contacts' normal forces [N], the forces of elements that open and close [N], those shown, and
    what else the elements observe.
    """

    system: System
    q: Float[Array, " coordinates"]
    v: Float[Array, " coordinates"]
    contacts: tuple[BallContact, ...] = ()
    closed: Any = ()
    ends: tuple[Quantity, ...] = eqx.field(static=True, default=())
    size: tuple[Any, Any] = (1.0, 1.0)
    shown: tuple[Shown, ...] = eqx.field(static=True, default=())
    recorded: tuple[Shown, ...] = eqx.field(static=True, default=())
    parts: Any = None
    energy_size: Scalar | None = None
    memory_time: Scalar | None = None
    end_names: tuple[str, ...] = eqx.field(static=True, default=())
    elements: tuple[Element, ...] = ()
    quiet: Scalar | None = None
    speed: Scalar | None = None
    momentum_size: Scalar | None = None
    first_memory: Float[Array, " contacts"] | None = None
    stored_in: str = eqx.field(static=True, default="potential")
    lost_in: str | None = eqx.field(static=True, default="dampers")
    listed: tuple[tuple[str, ...], tuple[str, ...]] = eqx.field(static=True, default=((), ()))
    rings: bool = eqx.field(static=True, default=True)

    def __post_init__(self) -> None:
        """Add the elements' driving joints to those of the system."""
        mine = tuple(joint for element in self.elements if (joint := element.driving_joint) is not None)
        there = sum(joint.driven for joint in self.system.joints)
        if mine and not there:
            self.system = self.system.with_joints(mine)
        elif there != len(mine):  # else the system is that of a mechanism, which has the elements' joints already
            raise InputError(
                "a joint among the system's prescribes a motion: give it as Drive(joint) among the elements, which"
                " keeps what it puts in"
            )

    def __check_init__(self) -> None:
        """Raise `InputError` for parts that do not fit each other.

        Of two with one name, what one of them shows would hide what the other does. The energy of relative motion means
        nothing where the ground takes part: all of the motion would count as that of the whole.
        """
        named = {
            "elements are called": [element.name for element in self.elements],
            "contacts are called": self.contact_names,
            "observables are called": self.observed,
        }
        for what, names in named.items():
            for name, count in Counter(names).items():
                if count > 1:
                    raise InputError(f"{count} {what} {name!r}: give each a name of its own")
        if self.quiet is not None and self.momentum_size is None:
            raise InputError("quiet is of bodies that nothing holds to the ground: give momentum_size [kg m/s] too")
        if sum(isinstance(element, Oscillators) for element in self.elements) > 1:
            raise InputError("there are several Oscillators: put all of them into one, which implicit steps then know")
        self._check_magnitudes()

    def _check_magnitudes(self) -> None:
        """Raise `InputError` for a threshold, scale or tolerance that is no number: NaN is below and above nothing, so
        that what is compared with it is decided without a word. Traced numbers have no values to look at."""
        leaves = jax.tree.leaves((self.system, self.q, self.v, self.contacts, self.elements, self.size, self.parts))
        if any(isinstance(leaf, jax.core.Tracer) or np.ndim(leaf) > np.ndim(self.q) for leaf in leaves):
            return
        # A threshold may be -∞, a limit ∞ and a number that nothing stands for None; NaN is wrong everywhere.
        magnitudes: dict[str, tuple[Any, bool]] = {
            **{f"negligible of {name}": (x, True) for name, x in zip(self.observed, self.negligible(), strict=True)},
            "scales": (self.scales(), False),
            "scale_limits": (self.scale_limits(), True),
            "typical_speed": (self.typical_speed, False),
            "energy_scale": (self.energy_scale, False),
            "momentum_scale": (self.momentum_scale, False),
            "tolerance_share": (self.tolerance_share, False),
            "invariant_change": (self.invariant_change, False),
            "quiet": (self.quiet, False),
            "memory_time": (self.memory_time, False),
        }
        for name, (value, unbounded) in magnitudes.items():
            array = None if value is None else concrete(value)
            if array is not None and not np.all(~np.isnan(array) if unbounded else np.isfinite(array)):
                raise InputError(f"{name} of the assembled mechanism is {array}: give the elements finite numbers")

    # --- the state's layout -------------------------------------------------------------------------------------------

    @property
    def layout(self) -> Layout:
        """Return where in the state each part's numbers stand."""
        return Layout(self.coordinates, self.contacts, self.elements, len(self.loss_names), self.quiet is not None)

    @property
    def places(self) -> dict[str, slice]:
        return self.layout.places

    def part(self, state: State, name: str) -> Array:
        """Return a part of the state, by its name in `Layout.places`."""
        return state[self.places[name]]

    def acceleration(self, rate: State, body: int) -> Vector:
        """Return the acceleration of a body's origin [m/s²], from the state's rate."""
        return self.system.order.translation(self.part(rate, "v"), body)

    def element(self, name: str) -> Any:
        """Return the element of a name, None where there is none."""
        return next((element for element in self.elements if element.name == name), None)

    def all_of(self, kind: type[E]) -> list[E]:
        """Return the elements of a class."""
        return [element for element in self.elements if isinstance(element, kind)]

    def evaluated(self, at: EvaluatedState, name: str) -> Any:
        """Return the element of a name as it is in an evaluated state, None where there is none."""
        pairs = zip(self.elements, at.elements, strict=True)
        return next((it for element, it in pairs if element.name == name), None)

    def closed_switches(self, active: Closed, name: str) -> Array:
        """Return which switches of the element of a name are closed, 1 or 0 each."""
        names = [element.name for element in self.elements]
        return self.layout.of_elements(active)[names.index(name)]

    @property
    def coordinates(self) -> int:
        return self.system.coordinates

    @property
    def spins(self) -> int:
        """Return how many balls spin freely, each with a velocity of its own behind the coordinates'."""
        return len(self.layout.spin_inertias)

    @property
    def loss_names(self) -> tuple[str, ...]:
        """Return where energy is lost: in the system, in contacts, and in elements."""
        own = () if self.lost_in is None else (self.lost_in,)
        names = [*own, HYSTERESIS, FRICTION, *(name for element in self.elements for name in element.loss_names)]
        return tuple(dict.fromkeys(names))

    @property
    def contact_names(self) -> tuple[str, ...]:
        """Return the names of the contacts' segments, and then of the elements' switches."""
        return self.layout.contact_names

    @property
    def impact_contacts(self) -> int:
        return self.layout.segments

    @property
    def contact_count(self) -> int:
        return len(self.contact_names)

    @property
    def contact_observables(self) -> int:
        return self.impact_contacts + len(self.layout.switch_forces)

    @property
    def one_way(self) -> tuple[bool, ...]:
        return self.layout.one_way

    # --- what the mechanism says of itself ----------------------------------------------------------------------------

    @property
    def remembers(self) -> bool:
        return self.memory_time is None

    @property
    def jumps(self) -> bool:
        laws = (contact.pair.law.jumps for contact in self.contacts)
        return any(laws) or any(element.jumps for element in self.elements)

    @property
    def observed(self) -> tuple[str, ...]:
        forces = (*self.layout.segment_names, *self.layout.switch_forces)
        names = (name for element in self.elements for name in (*element.observed, *element.observed_of_rate))
        others = (name for name in names if name not in forces)
        return (*forces, *(shown.name for shown in self.shown), *others)

    @property
    def least_maxima(self) -> Mapping[str, float]:
        least = {shown.name: shown.least for shown in self.shown}
        for element in self.elements:
            least |= element.least_maxima
        return {name: value for name, value in least.items() if value > -math.inf}

    def negligible(self) -> Float[Array, " observables"]:
        sizes: dict[str, Scalar] = {
            shown.name: -jnp.inf if shown.negligible is None else shown.negligible(self) for shown in self.shown
        }
        for contact, names in zip(self.contacts, self.layout.of_contacts(self.layout.segment_names), strict=True):
            if contact.onset_length is not None:  # even a flank far away exerts something, which is rounding
                sizes |= dict.fromkeys(names, contact.pair.law.elastic(jnp.asarray(ROUNDED_LENGTH)))
        for element in self.elements:
            sizes |= element.negligible()
        return stacked([sizes.get(name, 0.0) for name in self.observed]) if self.observed else jnp.zeros(0)

    def rate_observables(self) -> tuple[bool, ...]:
        rated = {shown.name for shown in self.shown if shown.of_rate}
        rated.update(name for element in self.elements for name in element.observed_of_rate)
        return tuple(name in rated for name in self.observed)

    @property
    def sudden(self) -> bool:
        return self.rings or any(element.sudden for element in self.elements)

    @property
    def typical_speed(self) -> Scalar:
        return self.size[1] if self.speed is None else self.speed

    @property
    def energy_scale(self) -> Scalar:
        masses = sum((body.mass for body in self.system.bodies), start=jnp.zeros(()))
        return 0.5 * masses * self.typical_speed**2 if self.energy_size is None else self.energy_size

    @property
    def momentum_scale(self) -> Scalar | None:
        return self.momentum_size

    @property
    def balance_complete(self) -> bool:
        balanced = (*(it.balanced for it in self.contacts), *(it.balanced for it in self.elements))
        return self.energy_size is not None and all(balanced)

    @property
    def tolerance_share(self) -> float:
        return min((element.tolerance_share for element in self.elements), default=1.0)

    @property
    def invariant_change(self) -> float:
        return super().invariant_change * min((element.invariant_share for element in self.elements), default=1.0)

    # --- one instant --------------------------------------------------------------------------------------------------

    def kinematics(self, state: State) -> Kinematics:
        """Return the frames of the bodies."""
        places = self.layout.places
        # Time enters by the driving joints alone.
        time = state[places["time"]][0] if self.layout.driven else 0.0
        return self.system.kinematics(state[places["q"]], state[places["v"]], time)

    def evaluate(self, state: State) -> EvaluatedState:
        kin, places, inertias = self.kinematics(state), self.layout.places, self.layout.spin_inertias
        spins = dict(zip(inertias, state[places["spins"]], strict=True)) if inertias else {}
        contacts = tuple(contact.evaluate(kin, spins.get(k)) for k, contact in enumerate(self.contacts))
        elements = tuple(
            element.evaluate(kin, state[places[f"element {k}"]]) for k, element in enumerate(self.elements)
        )
        return EvaluatedState(state, kin, contacts, elements)

    def start(self) -> tuple[State, Closed]:
        at, closed = self.first_evaluation()
        return at.state, closed

    def first_evaluation(self) -> tuple[EvaluatedState, Closed]:
        kin = self.system.kinematics(self.q, self.v)
        own = [element.start(kin) for element in self.elements]
        spins = [kin.point(self.contacts[k].body, self.contacts[k].point).spin for k in self.layout.spin_inertias]
        parts: dict[str, Any] = {
            "q": self.q,
            "v": self.v,
            "spins": spins,
            "lost": jnp.zeros(len(self.loss_names)),
            "first energy": [0.0] * (self.quiet is not None),
            **{f"element {k}": mine for k, mine in enumerate(own)},
            "time": [0.0] * self.layout.driven,
            "memory": jnp.ones(self.impact_contacts),
        }
        closed = self._start_closed(self.evaluate(self.layout.joined(parts)))
        at = self.evaluate(self.layout.joined(parts | {"memory": self._start_memory(kin, closed)}))
        if self.quiet is not None:
            # A run ends as held below a share of the first energy (M177), which therefore stands in the state.
            energy = self.relative_energy(at, closed)
            at = at._replace(state=at.state.at[self.layout.places["first energy"]].set(energy))
        return at, closed

    def _start_closed(self, at: EvaluatedState) -> Closed:
        """Return which contacts and switches are closed at t = 0: those that are said to be. Of the others the contacts
        are open, and a switch is closed where the start is beyond its place: no event would close it."""
        given = jnp.asarray(self.closed, float)
        if given.shape[0] == self.contact_count:
            return given
        beyond = jnp.where(self.gaps_at(at)[0][self.impact_contacts :] < 0.0, 1.0, 0.0)
        default = jnp.concatenate([jnp.zeros(self.impact_contacts), beyond])
        return jnp.concatenate([given, default[given.shape[0] :]])

    def _start_memory(self, kin: Kinematics, closed: Closed) -> Float[Array, " contacts"]:
        """Return the memory at t = 0: an open contact's only says how fast the first impact may be."""
        if self.first_memory is not None:
            return self.first_memory
        speeds = row([contact.evaluate(kin).approach.approach_speed for contact in self.contacts])
        return jnp.maximum(
            speeds, jnp.where(closed[: self.impact_contacts] > 0.5, self.slowest_touchdown, self.typical_speed)
        )

    def smooth_memory(self, at: EvaluatedState) -> SmoothMemory | None:
        """Return how the memory follows the approach speed; None with events, which set it."""
        if self.memory_time is None:
            return None
        # Each contact is let go over the length over which its own force sets in, if it has one.
        onsets = [
            jnp.full(contact.segments, ONSET if contact.onset_length is None else contact.onset_length)
            for contact in self.contacts
        ]
        approaches = [it.approach for it in at.contacts]
        return SmoothMemory.of(
            self.memory(at.state),
            row([a.gap for a in approaches]),
            row([a.approach_speed for a in approaches]),
            self.memory_time,
            row(onsets),
            self.slowest_touchdown,
        )

    def contact_forces(self, at: EvaluatedState, active: Closed) -> tuple[ContactForces, ...]:
        """Return F_n and F_t of each contact [N]."""
        memory = self.layout.of_contacts(self.memory(at.state))
        parts = zip(self.contacts, at.contacts, memory, self.layout.of_contacts(active), strict=True)
        return tuple(contact.forces(ball, speeds, closed) for contact, ball, speeds, closed in parts)

    def exerted(self, at: EvaluatedState, active: Closed) -> Exerted:
        """Return what acts at an instant."""
        forces = self.contact_forces(at, active)
        balls = zip(self.contacts, at.contacts, forces, strict=True)
        loads = [load for contact, ball, force in balls for load in contact.loads(ball, force)]
        elements = zip(self.elements, at.elements, self.layout.of_elements(active), strict=True)
        loads += [load for element, *part in elements for load in element.loads(*part)]
        return Exerted(forces, self.system.motion(at.kin, tuple(loads)))

    def derivative(self, time: Scalar, state: State, active: Closed) -> State:
        at = self.evaluate(state)
        return self._rate(at, active, self.exerted(at, active))

    def _rate(self, at: EvaluatedState, active: Closed, exerted: Exerted) -> State:
        """Return the rate of the state."""
        spins = [
            self.contacts[k].spin_moment(at.contacts[k], exerted.contacts[k]) / inertia
            for k, inertia in self.layout.spin_inertias.items()
        ]
        lost = self._losses(at, active, exerted)
        parts: dict[str, Any] = {
            "q": at.kin.v,
            "v": exerted.motion.acceleration,
            "spins": spins,
            "lost": [lost[name] for name in self.loss_names],
            "first energy": [0.0] * (self.quiet is not None),
            **{f"element {k}": rates for k, rates in enumerate(self._element_rates(at, active, exerted))},
            "time": [1.0] * self.layout.driven,
            "memory": jnp.zeros(self.impact_contacts) if (smooth := self.smooth_memory(at)) is None else smooth.rate,
        }
        return self.layout.joined(parts)

    def _element_rates(self, at: EvaluatedState, active: Closed, exerted: Exerted) -> list[list[Scalar]]:
        """Return the rates of each element's numbers."""
        rates: list[list[Scalar]] = []
        # The driving joints stand behind all others, and so do their multipliers.
        others = [joint for joint in self.system.joints if not joint.driven] if self.layout.driven else []
        first = sum(len(joint.rows(at.kin)) for joint in others)
        for element, it, closed in zip(self.elements, at.elements, self.layout.of_elements(active), strict=True):
            rates.append(element.rates(it, closed))
            if element.driving_joint is not None:
                last = first + len(element.driving_joint.rows(at.kin))
                rates[-1] = rates[-1] + element.reaction_rates(it, exerted.motion.multipliers[first:last])
                first = last
        return rates

    def _losses(self, at: EvaluatedState, active: Closed, exerted: Exerted) -> dict[str, Scalar]:
        """Return the power that is lost, by where it is [W]."""
        lost: dict[str, Scalar] = {HYSTERESIS: jnp.zeros(()), FRICTION: jnp.zeros(())}
        balls = zip(self.contacts, at.contacts, exerted.contacts, self.layout.of_contacts(active), strict=True)
        for contact, ball, forces, closed in balls:
            hysteresis, friction = contact.losses(ball, forces, closed)
            lost[HYSTERESIS], lost[FRICTION] = lost[HYSTERESIS] + hysteresis, lost[FRICTION] + friction
        parts = [
            element.losses(*part)
            for element, *part in zip(self.elements, at.elements, self.layout.of_elements(active), strict=True)
        ]
        own = {} if self.lost_in is None else {self.lost_in: self.system.dissipation(at.kin)}
        for powers in (own, *parts):
            lost = _added(lost, powers)
        return lost

    def gaps_at(self, at: EvaluatedState) -> tuple[Closed, Closed]:
        """Return the gap of each contact and each switch [m], and how fast it closes [m/s]; of what is over after some
        time the time left [s], and how fast that passes."""
        of = [element.gaps(it) for element, it in zip(self.elements, at.elements, strict=True)]
        gaps = self.layout.of_switches(
            [it.approach.gap for it in at.contacts], [[gap for gap, _ in pairs] for pairs in of]
        )
        speeds = [[speed for _, speed in pairs] for pairs in of]
        return gaps, self.layout.of_switches([it.approach.approach_speed for it in at.contacts], speeds)

    def touchdown(self, state: State, acceleration: Float[Array, ""], contact: Int[Array, ""]) -> State:
        after = super().touchdown(state, acceleration, contact)
        # Hardly an element changes its numbers as it closes: without one, the state need not be evaluated once more.
        if all(type(element).after_closing is Element.after_closing for element in self.elements):
            return after
        at, places = self.evaluate(state), self.layout.places
        closing = self.layout.of_elements(jnp.where(jnp.arange(self.contact_count) == contact, 1.0, 0.0))
        for k, element in enumerate(self.elements):
            mine = places[f"element {k}"]
            after = after.at[mine].set(element.after_closing(at.elements[k], after[mine], closing[k]))
        return after

    # --- ends of a run ------------------------------------------------------------------------------------------------

    @property
    def end_outcomes(self) -> tuple[str, ...]:
        elements = (name for element in self.elements for name in element.outcomes)
        held = () if self.quiet is None else ("held",)
        return (*(self.end_names or ("ended",) * len(self.ends)), *elements, "failed_penetration", *held)

    def terminals_at(self, at: EvaluatedState) -> Float[Array, " terminals"]:
        """Return those of ``ends`` and of elements, whether a ball's centre comes to its flank, where the contact's
        normal turns over, and whether all is held."""
        ends = [quantity(self.system, at.kin) for quantity in self.ends]
        for element, it in zip(self.elements, at.elements, strict=True):
            ends += element.guards(it)
        pairs = zip(at.contacts, self.contacts, strict=True)
        deep = [jnp.max(-it.approach.gap) - DEEPEST * jnp.asarray(contact.pair.radius) for it, contact in pairs]
        # Without a contact the guard never rises.
        ends.append(jnp.max(jnp.stack(deep)) if deep else -jnp.ones(()))
        return stacked([*ends, *([] if self.quiet is None else [self._at_rest(at)])])

    def _at_rest(self, at: EvaluatedState) -> Scalar:
        """Return a number above zero where all that closes once has closed and the energy of relative motion is below
        its quiet share (M177)."""
        assert self.quiet is not None
        parts = list(zip(self.elements, at.elements, strict=True))
        settled = jnp.asarray(True)
        for element, it in parts:
            settled = settled & element.settled(it)
        # No event tells here which contacts are closed: it shows in their gaps, and in what elements know.
        balls = [jnp.where(it.approach.gap <= 0.0, 1.0, 0.0) for it in at.contacts]
        active = self.layout.of_switches(balls, [element.closed_by_state(it) for element, it in parts])
        left = self.relative_energy(at, active) / self.part(at.state, "first energy")[0]
        return jnp.where(settled, self.quiet - left, -1.0)

    # --- what is watched, and the balance -----------------------------------------------------------------------------

    def normal_force_at(self, at: EvaluatedState, active: Closed) -> Float[Array, " contacts"]:
        return row([forces.normal for forces in self.contact_forces(at, active)])

    def observables_at(self, at: EvaluatedState, rate: State, active: Closed) -> Float[Array, " observables"]:
        values = self._element_observables(at, rate, active)
        values |= {shown.name: shown.of(self, at, rate) for shown in self.shown}
        others = [values[name] for name in self.observed[self.impact_contacts :]]
        return row([self.normal_force_at(at, active), *([stacked(others)] if others else [])])

    def _element_observables(self, at: EvaluatedState, rate: State, active: Closed) -> dict[str, Scalar]:
        values: dict[str, Scalar] = {}
        acceleration, closed = self.part(rate, "v"), self.layout.of_elements(active)
        for k, (element, it) in enumerate(zip(self.elements, at.elements, strict=True)):
            values |= element.observables(it, closed[k])
            if element.observed_of_rate:
                values |= element.observables_of_rate(it, acceleration, self.part(rate, f"element {k}"))
        return values

    def snapshot_at(self, at: EvaluatedState, active: Closed) -> Snapshot:
        exerted = self.exerted(at, active)
        rate = self._rate(at, active, exerted)
        approaches = [it.approach for it in at.contacts]
        others = self._element_observables(at, rate, active)
        sources = dict[str, str]()
        for element, *part in zip(self.elements, at.elements, self.layout.of_elements(active), strict=True):
            recorded = element.recorded(*part)
            # An element may record with its sign what it observes without; of two elements one would hide the other.
            for name in {*element.observed, *element.observed_of_rate, *recorded}:
                if sources.setdefault(name, element.name) != element.name:
                    both = f"{sources[name]!r} and {element.name!r}"
                    raise InputError(f"the elements {both} both show {name!r}: give one of them another name")
            others |= recorded
        # Those recorded come last: where a size is watched, the history has the value with its sign.
        others |= {shown.name: shown.of(self, at, rate) for shown in (*self.shown, *self.recorded)}
        if self.momentum_size is not None:
            others["relative_energy"] = self.relative_energy(at, active)
        gap, closing = self.gaps_at(at)
        return Snapshot(
            gap=gap[: self.impact_contacts],
            approach_speed=closing[: self.impact_contacts],
            slip=row([a.slip for a in approaches]),
            normal=row([forces.normal for forces in exerted.contacts]),
            friction=row([forces.friction for forces in exerted.contacts]),
            multipliers=exerted.motion.multipliers,
            others={name: jnp.asarray(value) for name, value in others.items()},
            acceleration=exerted.motion.acceleration,
        )

    def stored(self, at: EvaluatedState, active: Closed) -> dict[str, Scalar]:
        """Return the energy in motion, in the system's springs, in contacts and in elements, by name [J] (M76)."""
        kinetic = self.system.kinetic_energy(at.kin)
        for k, inertia in self.layout.spin_inertias.items():
            kinetic = kinetic + 0.5 * inertia * at.contacts[k].spin ** 2
        balls = zip(self.contacts, at.contacts, self.layout.of_contacts(active), strict=True)
        elastic = sum((contact.stored(ball, closed) for contact, ball, closed in balls), start=jnp.zeros(()))
        potential = jnp.asarray(self.system.stored_energy(at.kin))
        stored = {"kinetic": kinetic, self.stored_in: potential, "contact": elastic}
        for element, *part in zip(self.elements, at.elements, self.layout.of_elements(active), strict=True):
            stored = _added(stored, element.stored(*part))
        return stored

    def supplied(self, state: State) -> dict[str, Scalar]:
        """Return the energy that elements have put in from outside so far, by name [J]."""
        supplied: dict[str, Scalar] = {}
        for k, element in enumerate(self.elements):
            supplied = _added(supplied, element.supplied(self.part(state, f"element {k}")))
        return supplied

    def relative_energy(self, at: EvaluatedState, active: Closed) -> Float[Array, ""]:
        """Return the energy of relative motion [J]: what is stored and in motion beyond the motion of the whole as one
        rigid body (M177)."""
        spins = [(inertia, at.contacts[k].spin) for k, inertia in self.layout.spin_inertias.items()]
        return jnp.asarray(sum(self.stored(at, active).values()) - rigid_energy(self.system, at.kin, spins))

    def energy_at(self, at: EvaluatedState, active: Closed) -> Energy:
        always_stored, always_lost = (dict.fromkeys(names, jnp.zeros(())) for names in self.listed)
        # What came from outside is counted negative, so that the total stays constant (M76).
        put_in = {name: -energy for name, energy in self.supplied(at.state).items()}
        stored = _added(always_stored | self.stored(at, active), put_in)
        lost = always_lost | dict(zip(self.loss_names, self.part(at.state, "lost"), strict=True))
        return Energy({name: jnp.asarray(energy) for name, energy in stored.items()}, lost)

    def other_forces_at(self, at: EvaluatedState, active: Closed) -> Scalar:
        parts = zip(self.elements, at.elements, self.layout.of_elements(active), strict=True)
        return sum((element.stiff_force(*part) for element, *part in parts), start=jnp.zeros(()))

    def momentum(self, state: State) -> tuple[Float[Array, " 2"], Float[Array, ""]]:
        kin = self.kinematics(state)
        linear, angular = self.system.linear_momentum(kin), self.system.angular_momentum(kin)
        for inertia, spin in zip(self.layout.spin_inertias.values(), self.part(state, "spins"), strict=True):
            angular = angular + inertia * spin
        for k, element in enumerate(self.elements):
            impulse = element.impulse(self.part(state, f"element {k}"))
            if impulse is not None:  # what came from outside is no error
                linear, angular = linear - stacked([impulse[0].x, impulse[0].y]), angular - impulse[1]
        return linear, angular

    def constraint_errors(self, kin: Kinematics) -> Float[Array, " rows"]:
        return self.system.errors(kin)

    def penetration(self, force: Float[Array, ""]) -> Float[Array, ""]:
        depths = [jnp.asarray(contact.pair.law.depth(force)) for contact in self.contacts]
        return jnp.max(jnp.stack(depths)) if depths else jnp.zeros(())

    # --- time stepping ------------------------------------------------------------------------------------------------

    def scales(self) -> State:
        n, speed, energy = self.coordinates, self.typical_speed, self.energy_scale
        place, motion = (jnp.broadcast_to(jnp.asarray(size, float), (n,)) for size in self.size)
        momentum = 1.0 if self.momentum_size is None else self.momentum_size
        magnitudes = Magnitudes(speed, energy, momentum)
        parts: dict[str, Any] = {
            "q": place,
            "v": motion,
            # A ball that rolls at the typical speed spins at that over its radius.
            "spins": [speed / self.contacts[k].pair.radius for k in self.layout.spin_inertias],
            "lost": [energy] * len(self.loss_names),
            "first energy": [energy] * (self.quiet is not None),
            **{f"element {k}": element.scales(magnitudes) for k, element in enumerate(self.elements)},
            "time": [1.0] * self.layout.driven,
            "memory": [speed] * self.impact_contacts,
        }
        return self.layout.joined(parts)

    def scale_limits(self) -> State | None:
        places, spinning = self.layout.places, self.layout.spin_inertias
        if not spinning:
            return None
        spins = stacked([self.contacts[k].spin_scale_limit for k in spinning])
        behind = places["memory"].stop - places["spins"].stop
        return jnp.pad(spins, (places["spins"].start, behind), constant_values=jnp.inf)

    def impact_step(self, state: State) -> Float[Array, ""]:
        """Return a fifteenth of the shortest impact of a contact's ball and its body; 1e-6 s without contacts [s]."""
        # A lossless Hertz impact lasts 3.2 of its law's time scales (M58, M80): a fifth of one is about a fifteenth of
        # it.
        memory, steps = self.layout.of_contacts(self.memory(state)), []
        for contact, speeds in zip(self.contacts, memory, strict=True):
            speed = jnp.max(speeds)
            # At its floor, as before the first touchdown of a free start, the memory says nothing of the impact.
            speed = jnp.where(speed > self.slowest_touchdown, speed, self.typical_speed)
            steps.append(0.2 * jnp.asarray(contact.pair.law.time_scale(self.system.bodies[contact.body].mass, speed)))
        return jnp.min(jnp.stack(steps)) if steps else jnp.asarray(1e-6)

    def inverse_masses_at(self, at: EvaluatedState) -> Float[Array, "contacts contacts"]:
        normals = [
            # A ball's own spin does not change how fast its contact closes: its rows are zero, and left out.
            contact.directions(self.system, it)[0][: self.coordinates]
            for contact, it in zip(self.contacts, at.contacts, strict=True)
        ]
        return inverse_masses(self.system, at.kin, jnp.concatenate(normals, axis=1))

    def linearisation(self, time: Scalar, state: State, active: Closed) -> Linearisation:
        at = self.evaluate(state)
        return stiff_part(self.system, self.layout, at, active, self.smooth_memory(at))


def _added(energies: Mapping[str, Scalar], more: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """Add energies, or powers, of one name."""
    sums = dict(energies)
    for name, value in more.items():
        sums[name] = sums[name] + value if name in sums else value
    return sums
