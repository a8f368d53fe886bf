"""The interface of an element: a physical part between bodies that says all of itself in one class."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from ..basis import AnyBasis
from ..multibody import Joint, Kinematics, Load, System
from ..space.either import Turn, Vector
from .report import Report
from .stepping import Closed as Closed
from .stepping import Own as Own
from .stepping import SteppingHints

ROUNDED_LENGTH = 1e-13  # m, rad: what rounding makes of positions of the order of a metre


class Switch(NamedTuple):
    """Something of an element that closes where a gap falls through zero and opens where it rises again.

    - ``name``: of the switch.
    - ``one_way``: whether it never opens again, as a latch.
    - ``force``: the observable that is its force, which starts to act where it closes; None if there is none.
    - ``impact``: whether it closes by an impact, which a run lists; `Element.contact_forces` then has its ``force``.
    """

    name: str
    one_way: bool = False
    force: str | None = None
    impact: bool = False


class ContactForces(NamedTuple):
    """``normal``: F_n, and ``friction``: F_t along the tangent, an entry a contact [N]."""

    normal: Float[Array, " contacts"]
    friction: Float[Array, " contacts"]


class Magnitudes(NamedTuple):
    """What changes of a mechanism's state are compared with: ``speed`` [m/s], ``energy`` [J] and ``momentum`` [N s]."""

    speed: Scalar
    energy: Scalar
    momentum: Scalar


class Impacts(eqx.Module):
    """What an element says of those of its switches that close by an impact; nothing of one that has none."""

    def contact_forces(self, at: Any, closed: Closed) -> ContactForces:
        """Return the forces of these contacts."""
        return ContactForces(jnp.zeros(0), jnp.zeros(0))

    def slips(self, at: Any) -> Float[Array, " contacts"]:
        """Return how fast the surfaces of these contacts slip [m/s]."""
        return jnp.zeros(0)

    def touchdown_speeds(self, own: Own) -> Float[Array, " contacts"]:
        """Return the approach speed of each at its last touchdown [m/s]."""
        return jnp.zeros(0)

    def closing_directions(self, system: System, at: Any) -> Float[Array, "velocities contacts"]:
        """Return columns b with δ̇ = b·q̇, how fast each contact closes."""
        return jnp.zeros((system.velocities, 0))

    def penetration(self, force: Scalar) -> Scalar:
        """Return the depth [m] at which the contact's spring alone exerts a force [N]."""
        return jnp.zeros(())


class Element(Impacts, SteppingHints):
    """A physical part between bodies, such as a buffer, a latch or a drive, or a sensor of their motion.

    `jaxbuffer.mechanisms.assembled.Assembled` joins elements to a mechanism. It keeps each element's numbers in the
    state, its switches among the contacts, and the energy that it loses, and hands them back: ``own`` are the numbers,
    in the order of `variables`, and ``closed`` the switches, 1 where closed and 0 where open. An element looks at its
    own geometry once, by `evaluate`; ``at`` is what that returns.

    Every method has a default that says "nothing", so that an element defines what it has and no more. Elements have a
    field ``name``: that of their energies and switches, which in one mechanism tells two of a kind apart.
    """

    @property
    def name(self) -> str:
        """Return the element's name; each class has a field for it."""
        raise NotImplementedError

    @property
    def report(self) -> Report[Any]:
        """Return what a summary, a figure and a page say of the element."""
        return Report(self)

    # --- what it adds to the mechanism's state ------------------------------------------------------------------------

    @property
    def variables(self) -> tuple[str, ...]:
        """Return the names of the element's numbers in the state."""
        return ()

    def start(self, kin: Kinematics) -> Own:
        """Return the values of `variables` at t = 0."""
        return jnp.zeros(len(self.variables))

    def closed_at_start(self, at: Any) -> list[Scalar]:
        """Return which switches are closed at t = 0 unless the mechanism says it, 1 or 0 each, or a row of all: those
        beyond their place, which no event would close."""
        return [jnp.where(jnp.asarray(gap) < 0.0, 1.0, 0.0) for gap, _ in self.gaps(at)]

    def after_start(self, at: Any, own: Own, closed: Closed) -> tuple[Any, Own]:
        """Return ``at`` and `variables` at t = 0, where it is known which switches are closed then."""
        return at, own

    def scales(self, size: Magnitudes) -> list[Scalar]:
        """Return the magnitude below which an error does not matter, for each of `variables`."""
        return []

    @property
    def switches(self) -> tuple[Switch, ...]:
        """Return what of the element opens and closes."""
        return ()

    def gap_depths(self) -> list[Any]:
        """Return how far below zero each switch's gap still tells that it should have closed [m]."""
        return [jnp.inf] * len(self.switches)

    @property
    def jumps(self) -> bool:
        """Return whether the state's rate jumps where a switch closes."""
        return bool(self.switches)

    @property
    def spin_inertias(self) -> tuple[Scalar, ...]:
        """Return the moments of inertia of what of the element turns by itself [kg m²], one for each spin: the first of
        `variables` are the spins [rad/s], of a ball in space three, which count as velocities of the mechanism."""
        return ()

    def in_mechanism(self, speed: Scalar, basis: AnyBasis) -> "Element":
        """Return the element as a part of a mechanism of the plane or of space, as its ``basis`` says, whose velocities
        are of the order of ``speed`` [m/s]."""
        return self

    @property
    def driving_joint(self) -> Joint | None:
        """Return the joint by which the element prescribes a motion over time; None if it prescribes none."""
        return None

    # --- one instant --------------------------------------------------------------------------------------------------

    def evaluate(self, kin: Kinematics, own: Own) -> Any:
        """Return the element's geometry and motion at one instant, from which all that follows is computed."""
        return kin

    def gaps(self, at: Any) -> list[tuple[Scalar, Scalar]]:
        """Return the gap of each switch [m], and how fast it closes [m/s]; of what is over after some time, the time
        left [s] and how fast that passes. One pair of rows may be of all switches together."""
        return []

    def with_forces(self, at: Any, closed: Closed) -> Any:
        """Return ``at`` with forces that `loads`, `rates` and `losses` would compute each on its own."""
        return at

    def loads(self, at: Any, closed: Closed) -> tuple[Load, ...]:
        """Return the loads on the bodies."""
        return ()

    def rates(self, at: Any, closed: Closed) -> list[Scalar]:
        """Return the rates of `variables`."""
        return []

    def reaction_rates(self, at: Any, multipliers: Float[Array, " rows"]) -> list[Scalar]:
        """Return the rates of those `variables`, the last ones, that go with the reaction of the `driving_joint`.
        ``multipliers``: that joint's, an entry a row (M16)."""
        return []

    @property
    def resets(self) -> bool:
        """Return whether `variables` may jump where a switch closes."""
        return type(self).after_closing is not Element.after_closing

    def after_closing(self, at: Any, own: Own, closing: Closed, speed: Scalar) -> Own:
        """Return `variables` just after a switch has closed. ``closing``: 1 for that switch, 0 for all others;
        ``speed``: how fast its gap closed [m/s]."""
        return own

    # --- energy -------------------------------------------------------------------------------------------------------

    def stored(self, at: Any, closed: Closed) -> Mapping[str, Scalar]:
        """Return the energy that the element stores, by name [J]."""
        return {}

    @property
    def loss_names(self) -> tuple[str, ...]:
        """Return the names of the energies that the element loses."""
        return ()

    def losses(self, at: Any, closed: Closed) -> Mapping[str, Scalar]:
        """Return the power that the element loses, by the names of `loss_names` [W]."""
        return {}

    def supplied(self, own: Own) -> Mapping[str, Scalar]:
        """Return the energy that the element has put in from outside so far, by name [J]."""
        return {}

    def impulse(self, own: Own) -> tuple[Vector, Turn] | None:
        """Return the impulse [N s] and the angular impulse about the origin [N m s], in space vectors both, that the
        element has put in from outside; None where it puts in none."""
        return None

    @property
    def balanced(self) -> bool:
        """Return whether the energies above hold the work of all forces of the element."""
        return True

    # --- ends of a run, and what is watched ---------------------------------------------------------------------------

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Return the outcomes with which the element may end a run."""
        return ()

    def guards(self, at: Any) -> list[Scalar]:
        """Return the guard of each of `outcomes`: the run ends where it rises through zero."""
        return []

    def settled(self, at: Any) -> Any:
        """Return whether the element has done what it does only once: closed a latch, ended a thrust."""
        return True

    def closed_by_state(self, at: Any) -> list[Scalar]:
        """Return which switches are closed as far as a state alone can tell, 1 or 0 each."""
        return [jnp.where(jnp.asarray(gap) <= 0.0, 1.0, 0.0) for gap, _ in self.gaps(at)]

    @property
    def observed(self) -> tuple[str, ...]:
        """Return the names of what is watched for its largest value."""
        return ()

    def observables(self, at: Any, closed: Closed) -> Mapping[str, Scalar]:
        """Return the values of `observed`, by name."""
        return {}

    @property
    def observed_of_rate(self) -> tuple[str, ...]:
        """Return the names of what is watched besides `observed` and depends on accelerations or rates."""
        return ()

    def observables_of_rate(self, at: Any, acceleration: Array, own_rate: Own) -> Mapping[str, Scalar]:
        """Return the values of `observed_of_rate`, by name. ``acceleration``: q̈; ``own_rate``: rates of `variables`."""
        return {}

    @property
    def lower_bounds(self) -> Mapping[str, float]:
        """Return what the largest values of some of what is watched are at least, by name."""
        return {}

    def roundoff(self) -> Mapping[str, Scalar]:
        """Return the value that is rounding where nothing acts, of some of what is watched; of all others it is
        zero."""
        return {}

    def recorded(self, at: Any, closed: Closed) -> Mapping[str, Scalar]:
        """Return what a history shows besides, by name; it replaces an observable of the same name, for a sign, say."""
        return {}
