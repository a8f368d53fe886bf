"""The objective of a tuning, its constraints, and what decides among designs that are as good."""

import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from ...errors import InputError, check_flag, check_known, check_single, check_type
from ...fields import POSITIVE, Part, check_declared, choice, declared, flag, get, in_unit, number, whole
from ...mechanisms import all_mechanisms
from ...mechanisms.limit import IMPACTS, Limit, both_sides
from ...mechanisms.mechanism import Mechanism
from ...mechanisms.quantity import Catalogue
from ...mechanisms.run import Run
from ...value_text import with_unit
from .custom_quantity import CustomQuantity

AGGREGATES = ("worst", "mean", "cvar")
ONE_LIMIT = "it holds for all cases"


class MainQuantity(dict[str, float]):
    """Weights that name no quantity: a `Problem` has those of its mechanism's main quantity alone in their place."""


@dataclasses.dataclass(frozen=True)
class Objective:
    """The objective: a weighted sum of quantities in each load case, put together over the load cases, to be lowered.

    **Arguments:**

    - ``weights``: by quantity, in N per unit of it: ``{"peak_force": 1, "stroke": 1e4}`` trades a millimetre of stroke
      for 10 N (default: the mechanism's main quantity alone, in a `Problem`). The value of a single quantity with a
      weight of 1 is in that quantity's unit.
    - ``over``: the "worst" case, the "mean", or the mean of the worst share ("cvar", conditional value at risk).
    - ``level``: that share is 1 - ``level`` [-].

    **Raises:** `InputError` for numbers out of range; `Problem`, which knows the names, for unknown quantities.

    **Example:**

    >>> scenarios, variables = [jb.Scenario(approach_speed=0.2)], [jb.Variable("buffer.k_A", 100.0, 2000.0)]
    >>> both = jb.Objective({"peak_force": 1.0, "stroke": 1e4}, over="mean")
    >>> problem = jb.Problem(jb.table2(), scenarios, variables, both)
    >>> print(problem.objective)
    peak_force + 10000 stroke, mean over the cases
    """

    weights: Mapping[str, float] = dataclasses.field(default_factory=MainQuantity)
    over: str = choice("worst", *AGGREGATES, doc="of the load cases; cvar is the mean of the worst share")
    level: float = number(0.9, "-", low=0.0, high=1.0, high_open=True, doc="of cvar, whose share is 1 - level")

    def __post_init__(self) -> None:
        check_type("objective's weights", self.weights, Mapping, "Objective({'stroke': 1.0})")
        if not self.weights and not isinstance(self.weights, MainQuantity):
            raise InputError("objective: no quantity is given; name one of " + ", ".join(_units()))
        for name, weight in self.weights.items():
            unit = f"N/{_units().get(name, 'unit')}"
            check_single(f"objective.{name}", weight, unit, ONE_LIMIT, low=0.0, low_open=True)
        check_declared(self, "objective.")

    def of(self, main: str) -> "Objective":
        """Return this objective with the ``main`` quantity alone where it has no weights."""
        return self if self.weights else dataclasses.replace(self, weights={main: 1.0})

    def unit(self, catalogue: Catalogue) -> str:
        """Return the unit of its value: that of a single quantity with a weight of 1, else N."""
        (name, weight), *more = self.weights.items()
        return "N" if more or weight != 1.0 else catalogue[name].unit

    def in_figures(self, catalogue: Catalogue) -> tuple[str, float]:
        """Return the unit in which people are shown its value, and how many of those its own unit is."""
        unit = self.unit(catalogue)
        (name, *_) = self.weights
        return catalogue[name].in_figures if unit == catalogue[name].unit else (unit, 1.0)

    def shown(self, value: float, catalogue: Catalogue) -> tuple[float, str]:
        """Return its value in the unit that people are shown, and that unit."""
        unit, factor = self.in_figures(catalogue)
        return factor * value, unit

    def cap(self, cases: int) -> float:
        """Return the largest weight of a load case.

        Each aggregate is max w·f over weights that sum to 1 and are at most this one.
        """
        if self.over == "mean":
            return 1.0 / cases
        # A case's weight in the mean over the worst share; all of it where the share is less than one case.
        return 1.0 if self.over == "worst" else min(1.0, 1.0 / ((1.0 - self.level) * cases))

    def vector(self, names: Iterable[str]) -> Float[np.ndarray, " quantities"]:
        """Return the weights of the named quantities, in their order."""
        return np.array([float(self.weights.get(name, 0.0)) for name in names])

    def aggregate(self, values: Float[np.ndarray, " cases"]) -> float:
        """Put the load cases' values together."""
        return float(self.case_weights(values) @ values)

    def case_weights(self, values: Float[np.ndarray, " cases"]) -> Float[np.ndarray, " cases"]:
        """Return how much each load case counts; the weights sum to 1."""
        # The largest values get the cap each until nothing is left of 1: all of it at once for the worst case.
        cap = self.cap(len(values))
        left = 1.0 - cap * np.arange(len(values))
        weights = np.empty(len(values))
        weights[np.argsort(-values, kind="stable")] = np.clip(left, 0.0, cap)
        return weights

    def __str__(self) -> str:
        return self.format()

    def format(self, samples: str = "") -> str:
        """Return it in words. ``samples``: "24 samples", where the load cases are such: their largest is no bound."""
        names = [f"{w:g} {name}" if w != 1.0 else name for name, w in self.weights.items()]
        over = f"mean of the worst {1.0 - self.level:.3g}" if self.over == "cvar" else self.over
        # The largest of a random sample is no worst case.
        over, no_bound = ("largest", ", no bound") if samples and over == "worst" else (over, "")
        return f"{' + '.join(names) or 'the main quantity'}, {over} " + (
            f"of {samples}{no_bound}" if samples else "over the cases"
        )


@dataclasses.dataclass(frozen=True, init=False)
class Limits:
    """The constraints that hold in every load case.

    **Arguments:**

    - ``require_success``: whether it must end as the mechanism's runs should, within the duration.
    - ``at_most``: upper limits by quantity, in its unit or with one ("25 mm"), beside those that the mechanism always
      has.
    - ``at_least``: lower limits by quantity, likewise.
    - ``impacts``: at most so many touchdowns (a whole number, so without a gradient: a design that breaks it is
      rejected, none is led back by it); None: any number.
    - ``ends``: stricter ends that a mechanism knows, by name, each also a keyword of its own: ``held=True`` asks of a
      docking that both vehicles are at rest together within the duration.

    **Raises:** `InputError` for numbers out of range, and a lower limit that is not below the upper one; `Problem`,
    which knows the names, for unknown quantities.

    **Example:** at most 25 mm of stroke, and a capture that takes half a second or more.

    >>> scenarios, variables = [jb.Scenario(approach_speed=0.2)], [jb.Variable("buffer.k_A", 100.0, 2000.0)]
    >>> limits = jb.Limits(at_most={"stroke": 0.025}, at_least={"end_time": 0.5})
    >>> problem = jb.Problem(jb.table2(), scenarios, variables, limits=limits)
    >>> problem.limits
    Limits(require_success=True, at_most={'stroke': 0.025}, impacts=None, at_least={'end_time': 0.5})
    >>> jb.Limits(held=True).held
    True
    """

    require_success: bool = flag(True, doc="each run must end as the mechanism's should, within the duration")
    at_most: Mapping[str, float] = dataclasses.field(default_factory=dict)
    impacts: int | None = whole(None, 1, doc="at most so many touchdowns")
    at_least: Mapping[str, float] = dataclasses.field(default_factory=dict)
    ends: tuple[str, ...] = ()

    def __init__(
        self,
        require_success: bool = True,
        at_most: Mapping[str, float] | None = None,
        impacts: int | None = None,
        at_least: Mapping[str, float] | None = None,
        ends: Iterable[str] = (),
        **also: Any,
    ) -> None:
        known, ends = end_names(), tuple(ends)
        others = {name: also.pop(name) for name in declared(type(self)) if name in also}
        check_known(ends, known, "constraints")
        check_known(also, known, "constraints")
        for name, asked in also.items():
            check_flag(f"constraints.{name}", asked)
        given: dict[str, Any] = {"require_success": require_success, "impacts": impacts, **others}
        given |= {"at_most": {} if at_most is None else at_most, "at_least": {} if at_least is None else at_least}
        given["ends"] = tuple(name for name in known if also.get(name, name in ends))
        for name, value in given.items():
            # The class is frozen, and has an __init__ of its own because the ends' keywords depend on the mechanisms.
            object.__setattr__(self, name, value)
        self.__post_init__()

    def __post_init__(self) -> None:
        check_type("constraints' at_most", self.at_most, Mapping, "Limits(at_most={'stroke': 0.025})")
        check_type("constraints' at_least", self.at_least, Mapping, "Limits(at_least={'end_time': 0.5})")
        units = _units()
        for side in ("at_most", "at_least"):
            object.__setattr__(self, side, in_units(getattr(self, side), units))
        for name, limit in (*self.at_most.items(), *self.at_least.items()):
            if isinstance(limit, str) and name not in units:
                continue  # of a quantity of the user's own, whose unit a `Problem` knows
            unit = units.get(name, "-")
            check_single(f"constraints.{name}", limit, unit, ONE_LIMIT, low=0.0, low_open=True)
        for name in self.at_least:
            ends = self.at_least[name], self.at_most.get(name, math.inf)
            if not any(isinstance(end, str) for end in ends) and not ends[0] < ends[1]:
                low, high = (with_unit(end, _units().get(name, "")) for end in ends)
                raise InputError(f"constraints.{name}: at least {low} and at most {high} contradict")
        check_declared(self, "constraints.")
        if self.ends and not self.require_success:
            raise InputError(f"constraints: require_success = false and {self.ends[-1]} = true contradict; keep one")

    def __getattr__(self, name: str) -> bool:
        """Return whether an end is asked for: ``limits.held``."""
        if not name.startswith("_") and name in end_names():
            return name in self.ends
        raise AttributeError(f"{type(self).__name__} has no {name!r}")

    def __repr__(self) -> str:
        plain = dict.fromkeys(("require_success", "at_most", "impacts", "at_least", *declared(type(self))))
        fields = [f"{name}={getattr(self, name)!r}" for name in plain]
        return f"Limits({', '.join([*fields, *(f'{name}=True' for name in self.ends)])})"

    @property
    def names(self) -> tuple[str, ...]:
        """Return the limited quantities, those with an upper limit first."""
        return (*self.at_most, *self.at_least)

    @property
    def each(self) -> tuple[Limit, ...]:
        """Return the limits on quantities, upper ones first."""
        return both_sides(self.at_most, self.at_least)

    @property
    def of_impacts(self) -> tuple[Limit, ...]:
        """Return the limit on the number of impacts, if there is one."""
        return () if self.impacts is None else (Limit(IMPACTS, float(self.impacts)),)

    def with_always(self, always: Mapping[str, float]) -> "Limits":
        """Return these limits with those that a mechanism always has, where it has no lower ones."""
        # A limit of the user's own replaces the mechanism's: `Problem` accepts none above what always holds.
        return dataclasses.replace(self, at_most={**always, **self.at_most})

    def check(self, mechanism: Mechanism, value_at: Callable[[str], Any], own: Iterable[str] = ()) -> None:
        """Raise `InputError` for a limit on what a design does not have, and for unknown names.

        **Arguments:** ``value_at``: the design, as its value at a path; ``own``: quantities beside the mechanism's.
        """
        parts = {end.name: end.part for end in mechanism.tuning.ends}
        check_known(self.ends, (*declared(type(self)), *parts), "constraints")
        check_known(self.names, (*mechanism.quantities, *own), "constraints", quantity_in_words)
        parts |= {it: mechanism.quantities[it].part for it in self.names if it in mechanism.quantities}
        for name in (*self.ends, *self.names):
            if (part := parts.get(name)) and not value_at(part):
                raise InputError(f"constraints.{name} needs {part}, which the design has not; give it, or leave it out")

    def success(self, mechanism: Mechanism, design: Part) -> str | None:
        """Return how runs of a design must end, in a word: the strictest end that is asked for."""
        end = mechanism.required_end(self.ends, self.names)
        return mechanism.success_of(design) if end is None else end.name

    def ended(self, mechanism: Mechanism, code: Any) -> Bool[np.ndarray, "..."]:
        """Return which outcomes, given as codes, are ends that these limits ask for."""
        end, code = mechanism.required_end(self.ends, self.names), np.asarray(code)
        if end is not None:
            return np.isin(code, [int(mechanism.outcomes[name]) for name in end.outcomes])
        solved = (code >= 0) & (code < mechanism.outcomes["failed_steps"])
        return solved & mechanism.succeeded(code) if self.require_success else solved

    def broken(self, values: Mapping[str, float], impacts: int, catalogue: Catalogue) -> list[str]:
        """Return a line for each limit that a run with these quantities and this number of impacts breaks."""
        lines = [it.sentence(values[it.name], catalogue[it.name]) for it in self.each if not it.keeps(values[it.name])]
        lines += [f"{impacts} impacts, above {self.impacts}" for it in self.of_impacts if not it.keeps(impacts)]
        return lines

    def broken_by(self, run: Run, own: Catalogue | None = None) -> list[str]:
        """Return a line for each limit that one run breaks; ``own``: quantities beside the mechanism's.

        A run that failed keeps none of them.

        **Raises:** `InputError` for limited quantities that are unknown, or of a part that the design does not have.
        """
        mechanism, outcome = run.mechanism, run.outcome
        catalogue = {**mechanism.quantities, **(own or {})}
        self.check(mechanism, lambda path: get(run.design, path), catalogue)
        if outcome.failed:
            return [outcome.reason]
        lines = []
        if not self.ended(mechanism, int(outcome)):
            lines.append(f"not {self.success(mechanism, run.design) or 'solved'} ({outcome.reason})")
        named = {name: float(catalogue[name].of(run)) for name in self.names}
        return lines + self.broken(named, int(run.impact_count), catalogue)

    def lines(self, catalogue: Catalogue) -> list[str]:
        """Return each limit on a quantity: "stroke ≤ 0.025 m"."""
        return [it.line(catalogue[it.name]) for it in self.each]


@dataclasses.dataclass(frozen=True)
class SecondObjective:
    """A second objective, which decides among designs that are about as good as the best.

    **Arguments:**

    - ``objective``: the second one.
    - ``tolerance``: how far the first objective may be above its best, relative [-].

    **Raises:** `InputError` for a tolerance outside (0, 1].

    **Example:** the least hinge force of all designs within 2 % of the least contact force.

    >>> scenarios, variables = [jb.Scenario(approach_speed=0.2)], [jb.Variable("buffer.k_A", 100.0, 2000.0)]
    >>> then = jb.SecondObjective(jb.Objective({"peak_hinge_force": 1.0}), tolerance=0.02)
    >>> problem = jb.Problem(jb.table2(), scenarios, variables, then=then)
    >>> print(problem.then.objective)
    peak_hinge_force, worst over the cases
    """

    objective: Objective
    tolerance: float = number(
        0.01, "-", low=0.0, high=1.0, low_open=True, doc="how far the objective may be above its best, relative"
    )

    def __post_init__(self) -> None:
        check_type("then's objective", self.objective, Objective, "SecondObjective(Objective({'stroke': 1.0}))")
        check_declared(self, "then.")

    def ceiling(self, least: float) -> float:
        """Return how high the first objective may be, whose ``least`` value is this."""
        # The tolerance makes room above the least value, also where that is negative.
        return (1.0 + (self.tolerance if least >= 0.0 else -self.tolerance)) * least


def end_names() -> tuple[str, ...]:
    """Return the ends that limits of some mechanism may ask for, by name."""
    return tuple(dict.fromkeys(end.name for m in all_mechanisms() for end in m.tuning.ends))


def _units() -> dict[str, str]:
    """Return the units of all quantities that objectives and limits of some mechanism may use, by name."""
    return {name: m.quantities[name].unit for m in all_mechanisms() for name in m.tuned}


def quantity_in_words(name: str) -> str:
    """Return what a quantity of some mechanism means; "" for one that none has."""
    known = (m.quantities[name] for m in all_mechanisms() if name in m.quantities)
    return next((f"{it.title} {it.description}" for it in known), "")


def in_units(limits: Mapping[str, Any], units: Mapping[str, str]) -> dict[str, Any]:
    """Return limits, those given with a unit as numbers in the quantities' ``units``."""
    read = lambda name, limit: in_unit(f"constraints.{name}", limit, units[name], **POSITIVE)  # noqa: E731
    return {name: read(name, limit) if name in units else limit for name, limit in limits.items()}


class Constraints(NamedTuple):
    """A study's constraints on a single run: limits, and the ``own`` quantities, by name, that they may be on."""

    limits: Limits
    own: Mapping[str, CustomQuantity]

    def broken_by(self, run: Run) -> list[str]:
        """Return a line for each limit that the run breaks."""
        return self.limits.broken_by(run, self.catalogue(run.mechanism))

    def values(self, run: Run) -> dict[str, float]:
        """Return each limited quantity of the run, in its unit."""
        catalogue = self.catalogue(run.mechanism)
        return {name: float(catalogue[name].of(run)) for name in self.limits.names}

    def catalogue(self, mechanism: Mechanism) -> Catalogue:
        """Return the mechanism's quantities and the own ones."""
        return {**mechanism.quantities, **{name: derived.as_quantity(name) for name, derived in self.own.items()}}
