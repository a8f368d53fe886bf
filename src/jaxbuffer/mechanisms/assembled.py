"""Any mechanism with contacts, of the plane or of space: bodies, joints, and elements between them."""

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._types import Scalar, stacked
from ..basis import PositionRate
from ..elements import BallContact as BallContact
from ..elements import ContactForces, Element, Magnitudes, Oscillators
from ..elements.stiff_terms import inverse_masses
from ..errors import InputError
from ..hybrid import Linearisation
from ..multibody import Kinematics, System
from ..multibody.scalars import with_scalars
from .assembly_checks import check_constraints, check_magnitudes, check_names, known
from .energies import added, momentum, stored_energies, supplied_energies
from .energy import Energy
from .equations import Forces, forces_of, rate_of_state
from .layout import Closed, EvaluatedState, Layout, State, row
from .observables import Observable as Observable
from .observables import element_observables, element_records
from .relative_energy import rigid_energy
from .scales import scale_limits, scales
from .snapshot import Snapshot
from .stiff_part import stiff_part
from .system import ContactSystem

NO_END = ("failed_penetration",)  # time stepping needs an end: where no part has one, it is this, which never comes

Quantity = Callable[[System, Kinematics], Scalar]
E = TypeVar("E", bound=Element)


class Assembled(ContactSystem):
    """A mechanism ready to be stepped through time from a consistent start.

    **Arguments:** ``system``: bodies, joints and force elements; the elements' driving joints are added to its own; its
    basis is that of the elements; ``q``, ``v``: positions and velocities at t = 0, on the constraints; ``elements``:
    parts between the bodies, see `jaxbuffer.elements`; ``closed``: which contacts that have impacts, and then which of
    the elements' other switches, are closed at t = 0 (default: what each element says, see `Element.closed_at_start`);
    ``ends``: quantities whose crossing of zero upwards ends the run (so do elements); ``end_names``: of each, the name
    of the outcome that it stands for, among the mechanism's outcomes ("ended" unless given); ``rest_threshold``: if
    given, the run ends as "held" where all that closes once has closed and the energy of relative motion is below this
    share of that at t = 0 (M177); ``size``: magnitudes that matter of the coordinates and of the velocities, one or one
    each; ``speed`` [m/s]: that velocities are of the order of (default: the second of ``size``); ``shown``: further
    observables; ``recorded``: what a history shows besides; ``parts``: whatever these need to know; ``energy_size``
    [J]: magnitude of the energy; if given, steps must also keep the energy balance; ``momentum_size`` [kg m/s]: that of
    the momentum, where the ground takes no part; ``stored_in``, ``lost_in``: names of the energies that the system
    itself stores and loses (None: it loses none); ``listed``: names of energies, stored and lost, that are listed also
    where no part has them; ``impulsive_reactions``: whether reactions may rise suddenly, as where a body bends.

    Observables are the contacts' normal forces [N], the forces of elements that open and close [N], those shown, and
    what else the elements observe.
    """

    system: System
    q: Float[Array, " coordinates"]
    v: Float[Array, " velocities"]
    elements: tuple[Element, ...] = ()
    closed: Any = ()
    ends: tuple[Quantity, ...] = eqx.field(static=True, default=())
    size: tuple[Any, Any] = (1.0, 1.0)
    shown: tuple[Observable, ...] = eqx.field(static=True, default=())
    recorded: tuple[Observable, ...] = eqx.field(static=True, default=())
    parts: Any = None
    energy_size: Scalar | None = None
    end_names: tuple[str, ...] = eqx.field(static=True, default=())
    rest_threshold: Scalar | None = None
    speed: Scalar | None = None
    momentum_size: Scalar | None = None
    stored_in: str = eqx.field(static=True, default="potential")
    lost_in: str | None = eqx.field(static=True, default="dampers")
    listed: tuple[tuple[str, ...], tuple[str, ...]] = eqx.field(static=True, default=((), ()))
    impulsive_reactions: bool = eqx.field(static=True, default=True)

    def __post_init__(self) -> None:
        """Make numbers of the elements' arrays of one entry, tell them the speed of the mechanism, and add their
        driving joints to those of the system."""
        elements = with_scalars(self.elements)
        self.elements = tuple(element.in_mechanism(self.typical_speed, self.system.basis) for element in elements)
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
        check_names("elements", [element.name for element in self.elements])
        check_names("contacts", self.contact_names)
        check_names("observables", self.observed)
        if self.rest_threshold is not None and self.momentum_size is None:
            raise InputError(
                "rest_threshold is of bodies that nothing holds to the ground: give momentum_size [kg m/s] too"
            )
        if sum(isinstance(element, Oscillators) for element in self.elements) > 1:
            raise InputError("there are several Oscillators: put all of them into one, which implicit steps then know")
        if known((self.system, self.q, self.v, self.elements, self.size, self.parts), dimensions=np.ndim(self.q)):
            check_constraints(self.system, self.q, self.v)
            check_magnitudes(self, {"rest_threshold": self.rest_threshold})

    # --- the state's layout -------------------------------------------------------------------------------------------

    @property
    def layout(self) -> Layout:
        """Return where in the state each part's numbers stand."""
        return Layout(
            coordinates=self.coordinates,
            velocities=self.velocities,
            elements=self.elements,
            losses=len(self.loss_names),
            held=self.rest_threshold is not None,
            basis=self.system.basis,
        )

    @property
    def places(self) -> dict[str, slice]:
        return self.layout.places

    def part(self, state: State, name: str) -> Array:
        """Return a part of the state, by its name in `Layout.places`."""
        return state[self.places[name]]

    def acceleration(self, rate: State, body: int) -> Any:
        """Return the acceleration vector of a body's origin [m/s²], from the state's rate."""
        return self.system.translation(self.part(rate, "v"), body)

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
    def velocities(self) -> int:
        return self.system.velocities

    def position_rate(self, q: Float[Array, " coordinates"]) -> PositionRate:
        return self.system.position_rate(q)

    @property
    def spins(self) -> int:
        """Return how many velocities of parts that turn by themselves stand behind the bodies'."""
        return len(self.layout.spin_inertias)

    @property
    def loss_names(self) -> tuple[str, ...]:
        """Return where energy is lost: in the system and in elements."""
        own = () if self.lost_in is None else (self.lost_in,)
        names = [*own, *(name for element in self.elements for name in element.loss_names)]
        return tuple(dict.fromkeys(names))

    @property
    def contact_names(self) -> tuple[str, ...]:
        """Return the names of the contacts that have impacts, and then of the elements' other switches."""
        return self.layout.switch_names

    @property
    def impact_contacts(self) -> int:
        return self.layout.impacts

    @property
    def contact_count(self) -> int:
        return len(self.contact_names)

    @property
    def contact_observables(self) -> int:
        return len(self.layout.switch_forces)

    @property
    def one_way(self) -> tuple[bool, ...]:
        return self.layout.one_way

    def gap_depths(self) -> Float[Array, "..."]:
        return self.layout.of_switches([element.gap_depths() for element in self.elements])

    # --- what the mechanism says of itself ----------------------------------------------------------------------------

    @property
    def jumps(self) -> bool:
        return any(element.jumps for element in self.elements)

    @property
    def observed(self) -> tuple[str, ...]:
        forces = self.layout.switch_forces
        names = (name for element in self.elements for name in (*element.observed, *element.observed_of_rate))
        others = (name for name in names if name not in forces)
        return (*forces, *(shown.name for shown in self.shown), *others)

    @property
    def lower_bounds(self) -> Mapping[str, float]:
        least = {shown.name: shown.least for shown in self.shown}
        for element in self.elements:
            least |= element.lower_bounds
        return {name: value for name, value in least.items() if value > -math.inf}

    def roundoff(self) -> Float[Array, " observables"]:
        sizes: dict[str, Scalar] = {
            shown.name: -jnp.inf if shown.roundoff is None else shown.roundoff(self) for shown in self.shown
        }
        for element in self.elements:
            sizes |= element.roundoff()
        return stacked([sizes.get(name, 0.0) for name in self.observed]) if self.observed else jnp.zeros(0)

    def rate_observables(self) -> tuple[bool, ...]:
        rated = {shown.name for shown in self.shown if shown.of_rate}
        rated.update(name for element in self.elements for name in element.observed_of_rate)
        return tuple(name in rated for name in self.observed)

    @property
    def has_impulsive_reactions(self) -> bool:
        return self.impulsive_reactions or any(element.has_impulsive_reactions for element in self.elements)

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
        return self.energy_size is not None and all(element.balanced for element in self.elements)

    @property
    def reversals_shape(self) -> tuple[int, int]:
        return sum(element.reversing for element in self.elements), self.system.basis.dimensions

    @property
    def tolerance_share(self) -> float:
        return min((element.tolerance_share for element in self.elements), default=1.0)

    # --- one instant --------------------------------------------------------------------------------------------------

    def kinematics(self, state: State) -> Kinematics:
        """Return the frames of the bodies."""
        places = self.layout.places
        # Time enters by the driving joints alone.
        time = state[places["time"]][0] if self.layout.driven else 0.0
        return self.system.kinematics(state[places["q"]], state[places["v"]], time)

    def evaluate(self, state: State) -> EvaluatedState:
        return self._evaluated(state, self.kinematics(state))

    def evaluate_contacts(self, state: State) -> EvaluatedState:
        # An element without switches opens and closes nothing.
        return self._evaluated(state, self.kinematics(state), switching=True)

    def _evaluated(self, state: State, kin: Kinematics, switching: bool = False) -> EvaluatedState:
        """Return an evaluated state; ``switching``: whether elements without switches are left out."""
        layout = self.layout
        elements = (
            None if switching and not element.switches else element.evaluate(kin, layout.own(state, k))
            for k, element in enumerate(self.elements)
        )
        return EvaluatedState(state, kin, tuple(elements))

    def start(self) -> tuple[State, Closed]:
        at, closed = self.first_evaluation()
        return at.state, closed

    def first_evaluation(self) -> tuple[EvaluatedState, Closed]:
        kin = self.system.kinematics(self.q, self.v)
        own = [element.start(kin) for element in self.elements]
        at = self._evaluated(self._start_state(own), kin)
        # Which contacts and switches are closed is given, or else, of switches, what their elements say.
        closed = jnp.asarray(self.closed, float)
        if (given := closed.shape[0]) < self.contact_count:
            each = zip(self.elements, at.elements, strict=True)
            default = self.layout.of_switches([element.closed_at_start(it) for element, it in each])
            closed = jnp.concatenate([closed, default[given:]])
        parts = zip(self.elements, at.elements, own, self.layout.of_elements(closed), strict=True)
        # A state is evaluated once: an element that changes its numbers says what that changes of it.
        after = [element.after_start(it, mine, active) for element, it, mine, active in parts]
        state = self._start_state([mine for _, mine in after])
        at = at._replace(state=state, elements=tuple(it for it, _ in after))
        if self.rest_threshold is not None:
            # A run ends as held below a share of the first energy (M177), which therefore stands in the state.
            energy = self.relative_energy(at, closed)
            at = at._replace(state=at.state.at[self.places["first energy"]].set(energy))
        return at, closed

    def _start_state(self, own: list[Array]) -> State:
        nothing = jnp.zeros(len(self.loss_names))
        return self.layout.state(q=self.q, v=self.v, lost=nothing, first_energy=0.0, own=own, time=0.0)

    def contact_forces(self, at: EvaluatedState, active: Closed) -> tuple[ContactForces, ...]:
        """Return F_n and F_t of the contacts that have impacts, of each element that has some [N]."""
        closed = self.layout.of_elements(active)
        return tuple(self.elements[k].contact_forces(at.elements[k], closed[k]) for k in self.layout.impacting)

    def forces(self, at: EvaluatedState, active: Closed, directions: Array | None = None) -> Forces:
        """Return what acts at an instant. ``directions``: of the masses, a column each."""
        return forces_of(self.system, self.layout, at, active, directions)

    def rate_at(self, at: EvaluatedState, active: Closed) -> State:
        return self._rate(at, active, self.forces(at, active))

    def rate_and_masses(self, at: EvaluatedState, active: Closed, directions: Array) -> tuple[State, Array]:
        acting = self.forces(at, active, directions)
        assert acting.masses is not None
        return self._rate(at, active, acting), acting.masses

    def _rate(self, at: EvaluatedState, active: Closed, acting: Forces) -> State:
        """Return the rate of the state."""
        return rate_of_state(self.system, self.layout, at.kin, active, acting, (self.loss_names, self.lost_in))

    def gaps_at(self, at: EvaluatedState) -> tuple[Closed, Closed]:
        """Return the gap of each contact and each switch [m], and how fast it closes [m/s]; of what is over after some
        time the time left [s], and how fast that passes."""
        parts = zip(self.elements, at.elements, strict=True)
        of = [element.gaps(it) if element.switches else [] for element, it in parts]
        gaps = self.layout.of_switches([[gap for gap, _ in pairs] for pairs in of])
        return gaps, self.layout.of_switches([[speed for _, speed in pairs] for pairs in of])

    def touchdown(self, state: State, acceleration: Float[Array, ""], contact: Int[Array, ""]) -> State:
        changed = [k for k, element in enumerate(self.elements) if element.switches and element.resets]
        if changed:
            at, before = self.evaluate_contacts(state), state
            # At the crossing itself, a first-order step away from the located state.
            late, speed = self.until_contact_at(at, contact)
            speed = speed + acceleration * late
            closing = self.layout.of_elements(jnp.where(jnp.arange(self.contact_count) == contact, 1.0, 0.0))
            for k in changed:
                own = self.layout.own(before, k)
                own = self.elements[k].after_closing(at.elements[k], own, closing[k], speed)
                state = self.layout.with_own(state, k, own)
        return super().touchdown(state, acceleration, contact)

    # --- ends of a run ------------------------------------------------------------------------------------------------

    @property
    def _ending(self) -> list[int]:
        """Return the elements in the order of their ends: contacts, which end a run that failed, are the last."""
        return sorted(range(len(self.elements)), key=lambda k: k in self.layout.impacting)

    @property
    def end_outcomes(self) -> tuple[str, ...]:
        elements = (name for k in self._ending for name in self.elements[k].outcomes)
        held = () if self.rest_threshold is None else ("held",)
        return (*(self.end_names or ("ended",) * len(self.ends)), *elements, *held) or NO_END

    def terminals_at(self, at: EvaluatedState) -> Float[Array, " terminals"]:
        """Return those of ``ends`` and of elements, and whether all is held."""
        ends = [quantity(self.system, at.kin) for quantity in self.ends]
        for k in self._ending:
            ends += self.elements[k].guards(at.elements[k])
        ends += [] if self.rest_threshold is None else [self._at_rest(at)]
        return stacked(ends or [-1.0])

    def _at_rest(self, at: EvaluatedState) -> Scalar:
        """Return a number above zero where all that closes once has closed and the energy of relative motion is below
        its threshold (M177)."""
        assert self.rest_threshold is not None
        parts = list(zip(self.elements, at.elements, strict=True))
        settled = jnp.asarray(True)
        for element, it in parts:
            settled = settled & element.settled(it)
        # No event tells here which contacts are closed: it shows in their gaps, and in what elements know.
        active = self.layout.of_switches([element.closed_by_state(it) for element, it in parts])
        left = self.relative_energy(at, active) / self.part(at.state, "first energy")[0]
        return jnp.where(settled, self.rest_threshold - left, -1.0)

    # --- what is watched, and the balance -----------------------------------------------------------------------------

    def normal_force_at(self, at: EvaluatedState, active: Closed) -> Float[Array, " contacts"]:
        return row([forces.normal for forces in self.contact_forces(at, active)])

    def memory(self, state: State) -> Float[Array, " contacts"]:
        layout = self.layout
        return row([self.elements[k].touchdown_speeds(layout.own(state, k)) for k in layout.impacting])

    def observables_at(self, at: EvaluatedState, rate: State, active: Closed) -> Float[Array, " observables"]:
        values = element_observables(self.layout, at, rate, active)
        values |= {shown.name: shown.of(self, at, rate) for shown in self.shown}
        others = [values[name] for name in self.observed[self.impact_contacts :]]
        return row([self.normal_force_at(at, active), *([stacked(others)] if others else [])])

    def snapshot_at(self, at: EvaluatedState, active: Closed) -> Snapshot:
        acting = self.forces(at, active)
        rate = self._rate(at, active, acting)
        others = element_observables(self.layout, at, rate, active) | element_records(self.layout, at, active)
        # Those recorded come last: where a size is watched, the history has the value with its sign.
        others |= {shown.name: shown.of(self, at, rate) for shown in (*self.shown, *self.recorded)}
        if self.momentum_size is not None:
            others["relative_energy"] = self.relative_energy(at, active)
        gap, closing = self.gaps_at(at)
        forces = self.contact_forces(at._replace(elements=acting.elements), active)
        return Snapshot(
            gap=gap[: self.impact_contacts],
            approach_speed=closing[: self.impact_contacts],
            slip=row([self.elements[k].slips(at.elements[k]) for k in self.layout.impacting]),
            normal=row([it.normal for it in forces]),
            friction=row([it.friction for it in forces]),
            multipliers=acting.motion.multipliers,
            others={name: jnp.asarray(value) for name, value in others.items()},
            acceleration=acting.motion.acceleration,
        )

    def stored(self, at: EvaluatedState, active: Closed) -> dict[str, Scalar]:
        """Return the energy in motion, in the system's springs and in elements, by name [J] (M76)."""
        return stored_energies(self.system, self.layout, at, active, self.stored_in)

    def relative_energy(self, at: EvaluatedState, active: Closed) -> Float[Array, ""]:
        """Return the energy of relative motion [J]: what is stored and in motion beyond the motion of the whole as one
        rigid body (M177)."""
        whole = rigid_energy(self.system, at.kin, self.layout.spinning(at.state))
        return jnp.asarray(sum(self.stored(at, active).values()) - whole)

    def energy_at(self, at: EvaluatedState, active: Closed) -> Energy:
        always_stored, always_lost = (dict.fromkeys(names, jnp.zeros(())) for names in self.listed)
        # What came from outside is counted negative, so that the total stays constant (M76).
        put_in = {name: -energy for name, energy in supplied_energies(self.layout, at.state).items()}
        stored = added(always_stored | self.stored(at, active), put_in)
        lost = always_lost | dict(zip(self.loss_names, self.part(at.state, "lost"), strict=True))
        return Energy({name: jnp.asarray(energy) for name, energy in stored.items()}, lost)

    def stiff_forces_at(self, at: EvaluatedState, active: Closed) -> Scalar:
        parts = zip(self.elements, at.elements, self.layout.of_elements(active), strict=True)
        return sum((element.stiff_force(*part) for element, *part in parts), start=jnp.zeros(()))

    def reversals_at(self, at: EvaluatedState, active: Closed) -> Float[Array, "reversing axes"]:
        parts = zip(self.elements, at.elements, self.layout.of_elements(active), strict=True)
        each = [element.reversals(*part) for element, *part in parts if element.reversing]
        return jnp.concatenate([jnp.zeros((0, self.reversals_shape[1])), *each])

    def momentum_at(self, at: EvaluatedState) -> tuple[Float[Array, " dimensions"], Float[Array, "..."]]:
        return momentum(self.system, self.layout, at)

    def constraint_errors(self, kin: Kinematics) -> Float[Array, " rows"]:
        return self.system.errors(kin)

    def penetration(self, force: Float[Array, ""]) -> Float[Array, ""]:
        depths = [self.elements[k].penetration(force) for k in self.layout.impacting]
        return jnp.max(jnp.stack(depths)) if depths else jnp.zeros(())

    # --- time stepping ------------------------------------------------------------------------------------------------

    def scales(self) -> State:
        momentum = 1.0 if self.momentum_size is None else self.momentum_size
        return scales(self.layout, self.size, Magnitudes(self.typical_speed, self.energy_scale, momentum))

    def scale_limits(self) -> State | None:
        return scale_limits(self.layout)

    def impact_step(self, state: State) -> Float[Array, ""]:
        """Return a fifteenth of the shortest impact; 1e-6 s without contacts [s]."""
        steps = [element.impact_step(self.system, self.layout.own(state, k)) for k, element in enumerate(self.elements)]
        of_impacts = [jnp.asarray(step) for step in steps if step is not None]
        return jnp.min(jnp.stack(of_impacts)) if of_impacts else jnp.asarray(1e-6)

    def inverse_masses_at(self, at: EvaluatedState) -> Float[Array, "contacts contacts"]:
        closing = [self.elements[k].closing_directions(self.system, at.elements[k]) for k in self.layout.impacting]
        return inverse_masses(self.system, at.kin, jnp.concatenate(closing, axis=1))

    def linearisation(self, time: Scalar, state: State, active: Closed) -> Linearisation:
        return stiff_part(self.system, self.layout, self.evaluate(state), active)
