"""A mechanism: its physics, requests for runs of it, and who steps them. What is told of it is its `View`."""

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

import jax
from jaxtyping import Array, Bool

from .._types import Scalar
from ..errors import InputError, inside
from ..fields import NON_NEGATIVE, POSITIVE, Part, all_of
from ..hybrid import Options
from .outcome import RunOutcome, Simulated
from .quantity import Catalogue
from .system import ContactSystem
from .view import View

TOLERANCES = {"low": 1e-13, "high": 1e-2}
LIMITS: dict[str, dict[str, Any]] = {
    "duration": POSITIVE,
    "rtol": TOLERANCES,
    "atol": TOLERANCES,
    "stabilisation": NON_NEGATIVE,
}
Parameters = tuple[Any, Any, Scalar]  # design, scenario, Baumgarte's gain [1/s]
Tolerances = tuple[Scalar, Scalar]  # rtol and atol [-]


@dataclasses.dataclass(frozen=True)
class Defaults:
    """What is used where a call or a study does not say.

    ``duration`` [s]; ``parameters`` to differentiate by and ``differentiated`` quantities; ``grid`` of a sweep, as TOML
    writes it, and ``mapped``: the quantities drawn of one; ``variables`` of a tuning with their bounds, as TOML writes
    them, and ``limits`` it keeps to.
    """

    duration: float = 1.0
    parameters: tuple[str, ...] = ()
    differentiated: tuple[str, ...] = ("peak_force", "end_time")
    grid: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    mapped: tuple[str, ...] = ("peak_force", "penetration", "end_time", "contact_time")
    variables: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    limits: Mapping[str, float] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True)
class Floor:
    """What limits a tuned peak force from below: the first impact, which the tuned parts do not soften.

    ``first_impact``: its closed form from design and scenario, with ``elastic_peak`` [N], ``effective_energy`` [J] and
    ``duration`` [s]; ``softeners``: paths of the parts that are taken away to find it.
    """

    first_impact: Callable[[Any, Any], Any]
    softeners: tuple[str, ...]


@dataclasses.dataclass(frozen=True)
class TuningRules:
    """What tuning needs to know of a mechanism.

    ``always``: limits that hold unless a problem sets lower ones; ``check_problem``: raises `InputError` where a
    problem makes no sense; ``margin``: the quantity that is positive exactly for successful runs; ``floor``: what is
    known of the first impact without simulating it.
    """

    always: Mapping[str, float] = dataclasses.field(default_factory=dict)
    check_problem: Callable[[Any], None] = lambda problem: None
    margin: str | None = None
    floor: Floor | None = None


class Request(NamedTuple):
    """A request for one run: a tree of numbers, for one mechanism.

    ``mechanism``; ``parameters``: design, scenario and Baumgarte's gain [1/s]; ``duration`` [s]; ``tolerances``: rtol
    and atol [-]; ``options``: how it is stepped, without its tolerances.
    """

    mechanism: "Mechanism"
    parameters: Parameters
    duration: Scalar
    tolerances: Tolerances
    options: Options

    @property
    def system(self) -> ContactSystem:
        """The equations of motion, ready to be stepped."""
        return self.mechanism.system(*self.parameters)

    @property
    def allowed(self) -> Bool[Array, ""]:
        """Whether all numbers are in range."""
        design, scenario, stabilisation = self.parameters
        numbers = (self.duration, *self.tolerances, stabilisation)
        within = (inside(x, **limits) for x, limits in zip(numbers, LIMITS.values(), strict=True))
        return self.mechanism.valid(design, scenario) & all_of(within)


class Stepper(Protocol):
    """How runs are stepped through time: from event to event (`run.stepper.Events`), or in steps of its own.

    ``difference_tolerance``: rtol of the runs that differences are taken of; ``tight``: rtol at which a tuned design is
    evaluated.
    """

    difference_tolerance: float
    tight: float

    def step(self, request: Request, unchecked: bool, wanted: Bool[Array, ""] | bool) -> Any:
        """Step a run. ``unchecked``: whether its numbers may be out of range, or the run not ``wanted``; it then fails
        without a step, and need have derivatives backwards only."""

    def step_with_tangents(self, make: Callable[[list[Array], Any], Request], values: list[Array], others: Any) -> Any:
        """Step the run ``make(values, others)`` with a tangent for each value; None where `differentiable` does it."""
        return None

    def differentiable(self, request: Request, result: Any, values: list[Array]) -> Any:
        """Return the result of `step_with_tangents`, with derivatives by the values; without one, step the run."""
        return self.step(request, unchecked=False, wanted=True)

    def many(self, one: Callable[..., Any]) -> Callable[..., Any]:
        """Return the function ``one`` of a run's numbers as a function of arrays of them."""

    def read(self, request: Request, result: Any) -> Any:
        """Return the `Run` that was stepped."""

    def rows(self, run: Any) -> int:
        """Return how many rows of its history a run has filled."""


def no_equations(design: Part, scenario: Part, stabilisation: Any = 0.0) -> ContactSystem:
    """Raise `InputError`: the mechanism is stepped otherwise."""
    raise InputError(f"{type(design).__name__} is not a system of equations of motion between events")


def plain_valid(design: Part, scenario: Part) -> Bool[Array, ""]:
    """Whether every number is in its declared range, for numbers known only inside compiled code."""
    return all_of([*design.in_range(), *scenario.in_range()])


def no_smooth_law(design: Part) -> Part:
    """Raise `InputError`: most mechanisms have none."""
    raise InputError(f"{type(design).__name__} has no contact law without events, which diffrax.diffeqsolve needs")


@jax.tree_util.register_static  # a compiled program is made for it, and takes no numbers from it
@dataclasses.dataclass(frozen=True, eq=False)
class Mechanism:
    """A mechanism: what can be simulated, swept, differentiated and tuned. It is equal to itself alone.

    What every mechanism has:

    - ``name``: as ``kind`` in TOML;
    - ``design``, ``scenario``: classes of declared fields, whose defaults are used where nothing is said;
    - ``quantities``: its one catalogue;
    - ``system``: from a design, a scenario and Baumgarte's gain [1/s] to the hybrid system; or else ``stepper``: how it
      is stepped through time.

    What has a plain default:

    - ``outcomes``: how runs end; ``success``: the outcome that a tuned design must have, None for any;
    - ``check_fit``: raises `InputError` where design and scenario do not fit; ``valid``: the same of traced numbers;
    - ``run``: makes the `Run` of what was `Solved`, None for a plain one;
    - ``smooth``: a design with a contact law that needs no events, for `diffrax.diffeqsolve`;
    - ``defaults`` of calls and studies; ``tuning``: what tuning needs besides; ``view``: what is told and drawn.
    """

    name: str
    design: type[Part]
    scenario: type[Part]
    quantities: Catalogue
    system: Callable[..., ContactSystem] = no_equations
    stepper: Stepper | None = None
    outcomes: type[RunOutcome] = Simulated
    success: str | None = None
    check_fit: Callable[[Any, Any], None] = lambda design, scenario: None
    valid: Callable[[Any, Any], Bool[Array, ""]] = plain_valid
    run: Callable[[Any, Any], Any] | None = None
    smooth: Callable[[Any], Any] = no_smooth_law
    # No compiled program depends on these: see `programs.identity.label`.
    defaults: Defaults = dataclasses.field(default=Defaults(), compare=False)
    tuning: TuningRules = dataclasses.field(default=TuningRules(), compare=False)
    view: View = dataclasses.field(default=View(), compare=False)

    @property
    def swept(self) -> tuple[str, ...]:
        """Quantities that sweeps, records and summaries have."""
        return tuple(name for name, quantity in self.quantities.items() if quantity.swept)

    def meant(self, value_at: Callable[[str], Any]) -> tuple[str, ...]:
        """Of the `swept` quantities those that mean something for a design, given as its value at a path: not the
        bending of what does not bend."""
        return tuple(name for name in self.swept if not (part := self.quantities[name].part) or value_at(part))

    @property
    def tuned(self) -> tuple[str, ...]:
        """Quantities that objectives and limits may use."""
        return tuple(name for name, quantity in self.quantities.items() if quantity.tuned)
