"""A mechanism: its physics, requests for runs of it, and who steps them. What is told of it is its `View`."""

import dataclasses
import itertools
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool

from .._types import Scalar
from ..errors import InputError, check_known, inside
from ..fields import NON_NEGATIVE, POSITIVE, Part, all_of, get, paths
from ..hybrid import LEAST_TOLERANCE, Options
from .outcome import RunOutcome, Simulated
from .quantity import Catalogue, Quantity, of_impact
from .reading import Reader
from .sizing import Sizer, Sizing
from .system import ContactSystem
from .view import Names, View

T = TypeVar("T")
TOLERANCES = {"low": LEAST_TOLERANCE, "high": 1e-2}
LIMITS: dict[str, dict[str, Any]] = {
    "duration": POSITIVE,
    "rtol": TOLERANCES,
    "atol": TOLERANCES,
    "stabilisation": NON_NEGATIVE,
}
DERIVED, MAPPED = 2, 4  # how many quantities are differentiated, and drawn of a sweep, where nothing is said
PARAMETERS = 6  # how many numbers they are differentiated by then
Parameters = tuple[Any, Any, Scalar]  # design, scenario, Baumgarte's gain [1/s]
Tolerances = tuple[Scalar, Scalar]  # rtol and atol [-]


@dataclasses.dataclass(frozen=True)
class Defaults:
    """What is used where a call or a study does not say.

    ``duration`` [s]; ``parameters`` to differentiate by and ``differentiated`` quantities, () for the first ones;
    ``grid`` of a sweep, as TOML writes it, and ``mapped``: the quantities drawn of one, the main one first, () for the
    first ones that sweeps have; ``variables`` of a tuning with their bounds, as TOML writes them, and ``limits`` it
    keeps to; ``success``: how runs should end, in a word, None for the first of the mechanism's successes;
    ``pushed``: the bodies that a caller of `stepper` pushes, () for all; ``with_part``: those that are others for a
    design that has a number at a path; ``example``: values that an example study has beside the design's defaults, with
    ``example_limits`` of its own and ``example_variables``, with their bounds, that it suggests.
    """

    duration: float = 1.0
    parameters: tuple[str, ...] = ()
    differentiated: tuple[str, ...] = ()
    grid: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    mapped: tuple[str, ...] = ()
    variables: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    limits: Mapping[str, float] = dataclasses.field(default_factory=dict)
    success: str | None = None
    pushed: tuple[str, ...] = ()
    with_part: Mapping[str, Mapping[str, Any]] = dataclasses.field(default_factory=dict)
    example: Mapping[str, float] = dataclasses.field(default_factory=dict)
    example_limits: Mapping[str, float] = dataclasses.field(default_factory=dict)
    example_variables: Mapping[str, Any] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True)
class LowerBound:
    """What limits a tuned peak force from below: the first impact, which the tuned parts do not soften.

    ``first_impact``: its closed form from design and scenario, with ``elastic_peak`` [N], ``effective_energy`` [J] and
    ``duration`` [s]; ``compliant_parts``: paths of the parts that are taken away to find it; ``elasticities``: of the
    elastic peak by the design's numbers, by path, from design and scenario; ``quantities``: further largest values
    that the first impact alone reaches, however soft the compliant parts are.
    """

    first_impact: Callable[[Any, Any], Any]
    compliant_parts: tuple[str, ...]
    elasticities: Callable[[Any, Any], Mapping[str, float]] = lambda design, scenario: {}
    quantities: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class RequiredEnd:
    """An end of a run that a study may ask for, stricter than that the run succeeds: ``name = true`` in its limits.

    ``outcomes``: those that have it; ``part``: path of the design's number without which no run ends so; ``quantity``:
    what is above the design's number at the path ``threshold`` in a run that has the end before this one alone, so that
    its slopes lead on; "" where the margin of success alone leads there.
    """

    name: str
    outcomes: tuple[str, ...]
    part: str
    quantity: str = ""
    threshold: str = ""


class EndCount(NamedTuple):
    """In how many of some ``runs`` the end called ``name`` was ``reached``."""

    name: str
    reached: int
    runs: int

    @property
    def complete(self) -> bool:
        """Return whether this was the end of all runs."""
        return self.reached == self.runs

    def __str__(self) -> str:
        return f"{self.name} in {self.reached} of {self.runs}"


@dataclasses.dataclass(frozen=True)
class TuningRules:
    """What tuning needs to know of a mechanism.

    ``always``: limits that hold unless a problem sets lower ones; ``check_problem``: raises `InputError` where a
    problem makes no sense; ``margin``: the quantity that is positive exactly for successful runs; ``ends``: those that
    a study may ask for besides, each stricter than the one before it; ``lower_bound``: what is known of the first
    impact without simulating it; ``unfinished``: from a problem and the evaluation of its tuned design, a line for what
    its runs leave open; ``left_open``: the quantities that say what the runs of a design leave open, from its numbers
    by their paths.
    """

    always: Mapping[str, float] = dataclasses.field(default_factory=dict)
    check_problem: Callable[[Any], None] = lambda problem: None
    margin: str | None = None
    ends: tuple[RequiredEnd, ...] = ()
    lower_bound: LowerBound | None = None
    unfinished: Callable[[Any, Any], list[str]] | None = None
    left_open: Callable[[Callable[[str], Any]], tuple[str, ...]] = lambda number: ()


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
        """Return the equations of motion, ready to be stepped."""
        return self.mechanism.system(*self.parameters)

    @property
    def allowed(self) -> Bool[Array, ""]:
        """Return whether all numbers are in range."""
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

    def step(self, request: Request, unchecked: bool, enabled: Bool[Array, ""] | bool) -> Any:
        """Step a run. ``unchecked``: whether its numbers may be out of range, or the run not ``enabled``; it then fails
        without a step, and need have derivatives backwards only."""

    def run(self, request: Request) -> Any:
        """Return the `Run` of unchecked numbers, with derivatives by all of its parameters."""
        return self.read(request, self.step(request, unchecked=True, enabled=True))

    def step_with_tangents(self, make: Callable[[list[Array], Any], Request], values: list[Array], others: Any) -> Any:
        """Step the run ``make(values, others)`` with a tangent for each value; None where `with_derivatives` steps."""
        return None

    def with_derivatives(
        self,
        read: Callable[[list[Array], Any], T],
        make: Callable[[list[Array]], Request],
        values: list[Array],
        result: Any,
    ) -> tuple[T, T]:
        """Return ``read(values, stepped)`` with its derivatives by each value along a leading axis, None for what has
        none. ``stepped``: as `step` returns it, of ``make(values)``; ``result``: that of `step_with_tangents`."""

        def step_and_read(values: list[Array]) -> T:
            return read(values, self.step(make(values), unchecked=False, enabled=True))

        def push(direction: list[Array]) -> tuple[T, T]:
            return eqx.filter_jvp(step_and_read, (values,), (direction,))

        return eqx.filter_vmap(push, out_axes=(None, 0))(list(jnp.eye(len(values))))

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
    """Return whether every number is in its declared range, for numbers known only inside compiled code."""
    return all_of([*design.in_range(), *scenario.in_range()])


def no_smooth_law(design: Part, scenario: Part) -> Part:
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

    - ``outcomes``: how runs end; ``successes``: the outcomes of which a tuned design must have one, () for any;
    - ``check_fit``: raises `InputError` where design and scenario do not fit; ``valid``: the same of traced numbers;
    - ``run``: makes the `Run` of what was `Solved`, None for a plain one;
    - ``reader``: what that reads off single instants of a run, None for nothing;
    - ``smooth``: from design and scenario to a design that needs no events, for `diffrax.diffeqsolve`;
    - ``defaults`` of calls and studies; ``tuning``: what tuning needs besides; ``view``: what is told and drawn;
      ``sizing``: what a study to begin with is made from, None for no such study; ``sizer``: what sizes its parts, or
      None.
    """

    name: str
    design: type[Part]
    scenario: type[Part]
    quantities: Catalogue
    system: Callable[..., ContactSystem] = no_equations
    stepper: Stepper | None = None
    outcomes: type[RunOutcome] = Simulated
    successes: tuple[str, ...] = ()
    check_fit: Callable[[Any, Any], None] = lambda design, scenario: None
    valid: Callable[[Any, Any], Bool[Array, ""]] = plain_valid
    run: Callable[[Any, Any], Any] | None = None
    reader: Reader | None = None
    smooth: Callable[[Any, Any], Any] = no_smooth_law
    # No compiled program depends on these: see `programs.identity.Description`.
    defaults: Defaults = dataclasses.field(default=Defaults(), compare=False)
    tuning: TuningRules = dataclasses.field(default=TuningRules(), compare=False)
    view: View = dataclasses.field(default=View(), compare=False)
    sizing: Sizing | None = dataclasses.field(default=None, compare=False)
    sizer: Sizer | None = dataclasses.field(default=None, compare=False)

    def __post_init__(self) -> None:
        """Complete the defaults by the first of the mechanism's own quantities. **Raises:** `InputError` for defaults
        that name others."""
        smooth = tuple(name for name, quantity in self.quantities.items() if quantity.differentiable)
        differentiated = self.defaults.differentiated or smooth[:DERIVED]
        mapped = self.defaults.mapped or self.swept[:MAPPED]
        where = f"mechanism {self.name}, Defaults"
        check_known((it for it in differentiated if of_impact(it) is None), self.quantities, f"{where}.differentiated")
        check_known(mapped, self.swept, f"{where}.mapped")
        defaults = dataclasses.replace(self.defaults, differentiated=differentiated, mapped=mapped)
        object.__setattr__(self, "defaults", defaults)

    @property
    def success(self) -> str | None:
        """Return how a run should end, in a word: the first of ``successes``; None where any end will do."""
        return self.successes[0] if self.successes else None

    def success_of(self, design: Part) -> str | None:
        """Return how a run of a design should end, in a word: a part of it may ask for an end of its own."""
        return self.defaults_for(design).success or self.success

    def possible_successes(self, design: Part) -> tuple[str, ...]:
        """Return the successes that a run of a design can end in: a part without which some ends do not come about
        takes the place of the ends that need none."""
        having = [end.outcomes for end in self.tuning.ends if get(design, end.part) is not None]
        needing = {name for end in self.tuning.ends for name in end.outcomes}
        possible = {name for outcomes in having for name in outcomes} or set(self.successes) - needing
        return tuple(name for name in self.successes if name in possible)

    def required_end(self, names: Collection[str], quantities: Iterable[str] = ()) -> RequiredEnd | None:
        """Return the strictest of the ends that are named, or that some quantities wait for; None for no such end."""
        wanted = {*names, *(self.quantities[it].awaits for it in quantities if it in self.quantities)}
        # Each of the ends is stricter than the one before it.
        return next((end for end in reversed(self.tuning.ends) if end.name in wanted), None)

    def strictest_end(self, value_at: Callable[[str], Any]) -> RequiredEnd | None:
        """Return the strictest end that a run of a design can have, given as its value at a path; None for no such."""
        return next((end for end in reversed(self.tuning.ends) if value_at(end.part) is not None), None)

    def end_count(self, value_at: Callable[[str], Any], counts: Mapping[str, int]) -> EndCount | None:
        """Return in how many runs of a design its strictest end was reached; None where it can have no such end.

        **Arguments:** ``value_at``: as of `strictest_end`; ``counts``: how many runs had each outcome.
        """
        end = self.strictest_end(value_at)
        if end is None:
            return None
        return EndCount(end.name, sum(counts.get(name, 0) for name in end.outcomes), sum(counts.values()))

    def succeeded(self, code: Any) -> Any:
        """Return which outcomes, given as codes, are successes; all that did not fail, where any end will do."""
        if not self.successes:
            # Codes of failed runs follow those of all others (`RunOutcome`).
            return np.asarray(code) < self.outcomes["failed_steps"]
        return np.isin(code, [int(self.outcomes[name]) for name in self.successes])

    def defaults_for(self, design: Part | None, varied: Collection[str] = ()) -> Defaults:
        """Return the defaults for a design: some depend on what it has, or gets where numbers at the ``varied`` paths
        are put into it; without one the general ones."""
        others = dict[str, Any]()
        if design is not None:
            # A study that varies a part's number gives the design that part, though it is not set yet.
            for path, changes in self.defaults.with_part.items():
                others |= changes if path in varied or get(design, path) is not None else {}
        return dataclasses.replace(self.defaults, **others)

    def duration(self, design: Part, varied: Collection[str] = ()) -> float:
        """Return how long a run of a design lasts where nothing is said [s]; ``varied``: as of `defaults_for`."""
        return self.defaults_for(design, varied).duration

    def parameters(self, design: Part) -> tuple[str, ...]:
        """Return the paths to differentiate by where nothing is said: those at which a design has a number; of a
        mechanism that names none the first ones of the design."""
        if self.defaults.parameters:
            return tuple(path for path in self.defaults.parameters if get(design, path) is not None)
        numbers = (path for path in paths(design) if isinstance(get(design, path), float))
        return tuple(itertools.islice(numbers, PARAMETERS))

    def variables(self, design: Part) -> dict[str, Any]:
        """Return the variables of a tuning where nothing is said, with their bounds: those that a design has."""
        return {path: bounds for path, bounds in self.defaults.variables.items() if get(design, path) is not None}

    def always(self, design: Part) -> dict[str, float]:
        """Return the limits that every tuned design keeps: those on parts that this one has."""
        return {name: limit for name, limit in self.tuning.always.items() if self.has(name, design)}

    def names(self, design: Part) -> Names:
        """Return what the parts of a design are called; where nothing is said of what else a history has, those of the
        mechanism's quantities that it has under their names."""
        names = self.view.names(design)
        own = {name: quantity.unit for name, quantity in self.quantities.items()}
        return names if names.others else dataclasses.replace(names, others=own)

    def main_quantity(self, names: Sequence[str], design: Part | None = None) -> str:
        """Return which of some ``names`` stands for a run where nothing is said: the first that is drawn of a sweep, or
        else the first of them; "" of no names."""
        return next((name for name in (*self.defaults_for(design).mapped, *names) if name in names), "")

    def name_of(self, common: Quantity) -> str | None:
        """Return the name under which the mechanism has a quantity that many have, such as `PEAK_FORCE`; None where it
        has not."""
        # Its description and its uses may be the mechanism's own: what it reads off a run makes it what it is.
        return next((name for name, it in self.quantities.items() if it.of is common.of), None)

    @property
    def swept(self) -> tuple[str, ...]:
        """Return the quantities that sweeps, records and summaries have."""
        return tuple(name for name, quantity in self.quantities.items() if quantity.swept)

    def meant(self, value_at: Callable[[str], Any]) -> tuple[str, ...]:
        """Return those of the `swept` quantities that mean something for a design, given as its value at a path: not
        the bending of what does not bend."""
        return tuple(name for name in self.swept if not (part := self.quantities[name].part) or value_at(part))

    def has(self, name: str, design: Part) -> bool:
        """Return whether a quantity means something for a design: it has the part that the quantity is of."""
        part = self.quantities[name].part
        return not part or bool(get(design, part))

    @property
    def tuned(self) -> tuple[str, ...]:
        """Return the quantities that objectives and limits may use."""
        return tuple(name for name, quantity in self.quantities.items() if quantity.tuned)
