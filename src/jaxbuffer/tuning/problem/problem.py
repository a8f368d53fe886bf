"""The design problem as data: design variables, load cases, objective and constraints."""

import contextlib
import dataclasses
import functools
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from ...errors import InputError, check_known, check_single, check_type, shown
from ...fields import Part, as_typed, check_path, get, paths, replace, typed_unit, unit, unit_at
from ...mechanisms.mechanism import Mechanism, RequiredEnd
from ...mechanisms.quantity import PEAK_FORCE, Catalogue
from ...mechanisms.registry import mechanism_of
from ...run.request import DEFAULT_TOLERANCE, TOLERANCES, check_pair
from .cases import WHOLE_CORNERS, Case, Scatter, corner_signs, in_sentence, numbered
from .custom_quantity import CustomQuantity, check_custom_quantities
from .objective import ONE_LIMIT, Limits, Objective, SecondObjective, in_units, quantity_in_words
from .tolerances import check_ends, corner_cases, read_tolerances
from .variable import Variable, check_variables


@dataclasses.dataclass(frozen=True)
class Problem:
    """A design problem: design variables, load cases, an objective and constraints.

    **Arguments:**

    - ``design``: to start from.
    - ``scenarios``: the mechanism's scenarios, or `Case`s, to serve; ``cases`` has them all as `Case`s.
    - ``variables``: what may change; () where `choose` alone is to set numbers.
    - ``objective``: what to lower (default: the worst of the mechanism's main quantity, the peak force mostly).
    - ``limits``: the constraints (default: captured in every load case).
    - ``then``: what decides beyond the objective, or None.
    - ``duration`` [s], ``rtol`` [-]: as for `simulate`.
    - ``quantities``: your own by name, a `CustomQuantity` each; objective, limits and ``then`` use them as any other.
    - ``units``: in which people are shown the numbers at some dotted paths; default: each in its own.
    - ``scatter``: how each of the ``scenarios`` and the design scatter, a `jaxbuffer.tuning.Scatter`; ``cases`` are
      then samples of that, each at every scenario, and a tuning runs its result in the corners of the ranges too.
    - ``tolerances``: how far built numbers may be from the drawn ones, by dotted path, "scenario." before a field of
      the scenario: "10 %" of the number, "0.5 mm", ["-1 mm", "2 mm"], or a `Tolerance`. ``cases`` then has each
      scenario as drawn and in every ``corners`` of up to six tolerances; of more, in those that ``signs`` names.
    - ``signs``: corners as rows of -1 and 1, a number a tolerance; default: all of up to six tolerances, else none.
      `tune` searches for those that matter.

    **Raises:** `InputError` for names that are unknown, empty lists, bounds that are crossed or do not hold the start,
    and tolerances that lead out of the allowed range.

    **Example:**

    >>> problem = jb.Problem(
    ...     jb.table2(),
    ...     [jb.Scenario(approach_speed=speed) for speed in (0.1, 0.2)],
    ...     [jb.Variable("buffer.k_A", 100.0, 2000.0), jb.Variable("buffer.c_A", 1.0, 60.0)],
    ... )
    >>> print(f"{problem.objective}: {len(problem.cases)} cases by {', '.join(problem.paths)}")
    peak_force, worst over the cases: 2 cases by buffer.k_A, buffer.c_A
    """

    design: Part
    scenarios: Sequence[Part | Case]
    variables: Sequence[Variable]
    objective: Objective = dataclasses.field(default_factory=Objective)
    limits: Limits = dataclasses.field(default_factory=Limits)
    then: SecondObjective | None = None
    duration: float | None = None
    rtol: float = DEFAULT_TOLERANCE
    quantities: Mapping[str, CustomQuantity] = dataclasses.field(default_factory=dict)
    scatter: Scatter | None = None
    units: Mapping[str, str] = dataclasses.field(default_factory=dict)
    tolerances: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    signs: tuple[tuple[float, ...], ...] = ()
    cases: tuple[Case, ...] = dataclasses.field(init=False, default=())
    drawn: tuple[Case, ...] = dataclasses.field(init=False, default=())  # the load cases without tolerances

    def __post_init__(self) -> None:
        mechanism = self.mechanism
        # The class is frozen, so that fields which are completed here are set past its own assignment.
        object.__setattr__(self, "quantities", check_custom_quantities(self.quantities, mechanism.quantities))
        if self.duration is None:
            object.__setattr__(self, "duration", mechanism.duration(self.design))
        self._check_parts()
        self._complete_objectives()
        self._check_quantities(mechanism)
        cases = tuple(s if isinstance(s, Case) else Case(s) for s in self.scenarios)
        if self.scatter is not None and cases:
            check_type("scatter", self.scatter, Scatter, "Scatter(24, {'approach_speed': Distribution(...)})")
            cases = self.scatter.cases(cases, self.design)
        if not cases:
            raise InputError("scenarios is empty; tuning needs at least one")
        self._read_units()
        check_variables(self.design, self.variables, self.units)
        self._check_values(cases)
        cases = self._with_corners(cases)
        object.__setattr__(self, "cases", cases)
        for k, case in enumerate(cases):
            try:
                check_pair(mechanism, case.of(self.design), case.scenario)
            except InputError as error:
                # A factor or a sampled field may lead out of the range that the design or the scenario allows.
                raise error.between(f"{in_sentence(case.label(cases), self.number_text(k))}: ") from None
        mechanism.tuning.check_problem(self)

    def _check_values(self, cases: Sequence[Case]) -> None:
        """Raise `InputError` where a load case sets a number that is tuned."""
        for path in dict.fromkeys(path for case in cases for path, _ in case.values):
            check_path(self.design, path)
            if path in self.paths:
                raise InputError(
                    f"{path} is tuned, and the scenarios list values of it; keep one, or give it a tolerance instead"
                )

    def _with_corners(self, cases: tuple[Case, ...]) -> tuple[Case, ...]:
        """Return the load cases, each followed by its corners; the tolerances are read on the way."""
        tolerances = read_tolerances(self.tolerances, self.design, cases[0].scenario)
        object.__setattr__(self, "tolerances", tolerances)
        object.__setattr__(self, "drawn", cases)
        if not tolerances:
            return cases
        bounds = {variable.path: (variable.low, variable.high) for variable in self.variables}
        check_ends(tolerances, self.design, cases, bounds)
        if any(len(row) != len(tolerances) for row in self.signs):
            raise InputError(f"signs: a corner has {len(tolerances)} numbers, one a tolerance")
        # A case and its corners stand together: `corner_places` tells by that which cases are corners.
        return tuple(it for case in cases for it in (case, *corner_cases([case], tolerances, self.corner_rows)))

    def _read_units(self) -> None:
        """Read bounds and limits that were given with a unit; people are shown the numbers in those units."""
        given, own = tuple(self.variables), {name: derived.unit for name, derived in self.quantities.items()}
        for variable in given:
            check_type("variable", variable, Variable, "Variable('buffer.k_A', 100.0, 2000.0)")
            check_path(self.design, variable.path)
        # Units are read before the bounds become numbers, which no longer tell.
        typed = {v.path: symbol for v in given if (symbol := typed_unit((v.low, v.high)))}
        object.__setattr__(self, "variables", tuple(v.read(self.design) for v in given))
        object.__setattr__(self, "units", {**typed, **self.units})
        at_most, at_least = in_units(self.limits.at_most, own), in_units(self.limits.at_least, own)
        object.__setattr__(self, "limits", dataclasses.replace(self.limits, at_most=at_most, at_least=at_least))

    def _check_parts(self) -> None:
        for name, values, example in (
            ("scenarios", self.scenarios, "[Scenario(approach_speed=0.2)]"),
            ("variables", self.variables, "[Variable('buffer.k_A', 100.0, 2000.0)]"),
        ):
            if not isinstance(values, Iterable) or isinstance(values, (str, bytes, Mapping)):
                raise InputError(f"{name} = {shown(values)} is not a list; write {example}")
        check_type("objective", self.objective, Objective, "Objective({'peak_force': 1.0})")
        check_type("limits", self.limits, Limits, "Limits(at_most={'stroke': 0.025})")
        if self.then is not None:
            check_type("then", self.then, SecondObjective, "SecondObjective(Objective({'stroke': 1.0}))")
        check_single("duration", self.duration, "s", ONE_LIMIT, low=0.0, low_open=True)
        check_single("rtol", self.rtol, "-", ONE_LIMIT, **TOLERANCES)

    def _complete_objectives(self) -> None:
        """Let an objective without weights be the main quantity alone."""
        if not self.names:
            raise InputError(
                f"{self.mechanism.name} has no quantity that an objective may use: declare one with tuned=True, or give"
                " quantities of your own"
            )
        completed = self.objective.of(self.main_quantity)
        object.__setattr__(self, "objective", completed)
        if self.then is not None:
            then = dataclasses.replace(self.then, objective=self.then.objective.of(self.main_quantity))
            object.__setattr__(self, "then", then)

    def _check_quantities(self, mechanism: Mechanism) -> None:
        """Raise `InputError` where a quantity is another mechanism's, or a limit above what always holds."""
        self.limits.check(mechanism, lambda path: get(self.design, path), self.quantities)
        uses: dict[str, Iterable[str]] = {"objective": self.objective.weights, "constraints": self.limits.names}
        uses |= {} if self.then is None else {"then": self.then.objective.weights}
        for where, names in uses.items():
            for name in names:
                if name in mechanism.tuned and not mechanism.has(name, self.design):
                    part = mechanism.quantities[name].part
                    raise InputError(f"{where}.{name} needs {part}, which the design has not; give it, or leave it out")
            check_known(names, self.names, where, quantity_in_words)
        for name, high in mechanism.always(self.design).items():
            limit, unit = self.limits.at_most.get(name, high), self.catalogue[name].unit
            check_single(f"constraints.{name}", limit, unit, ONE_LIMIT, low=0.0, low_open=True, high=high)

    def number(self, k: int) -> int:
        """Return the number of the scenario of a load case, by its place: scenarios are counted from 1 in the order of
        the study, a corner of tolerances has that of its scenario, and `--scenario-number` takes it."""
        return k // (1 + len(self.corner_rows)) + 1

    def number_text(self, k: int) -> str:
        """Return the number of a load case: its scenario's, and behind a point that of its corner: "2.5"."""
        corner = k % (1 + len(self.corner_rows))
        return f"{self.number(k)}.{corner}" if corner else str(self.number(k))

    def label(self, k: int) -> str:
        """Return what people call a load case, its number first where there are several: "2: 0.2 m/s"."""
        return numbered(self.cases[k].label(self.cases), self._number_among_several(k))

    def in_sentence(self, k: int) -> str:
        """Return a load case as a sentence names it, with its number among several: "scenario 2 (0.2 m/s)"."""
        return in_sentence(self.cases[k].label(self.cases), self._number_among_several(k))

    def at_case(self, k: int) -> str:
        """Return where a load case is met: " at scenario 2 (0.2 m/s)", "" of a single one."""
        return f" at {self.in_sentence(k)}" if len(self.cases) > 1 else ""

    def _number_among_several(self, k: int) -> str:
        """Return the number of a load case; "" of a single one, which needs none."""
        return self.number_text(k) if len(self.cases) > 1 else ""

    @property
    def corner_runs(self) -> list[tuple[str, Part, Part]]:
        """Return number, design as built from the start and scenario of each corner that can be built."""
        runs = list[tuple[str, Part, Part]]()
        for k in self.corner_places:
            # A corner whose numbers do not fit is the tuning's to report.
            with contextlib.suppress(InputError):
                runs.append((self.number_text(k), self.cases[k].of(self.design), self.cases[k].scenario))
        return runs

    @property
    def corners(self) -> tuple[Case, ...]:
        """Return those of the cases that are corners of the tolerances; none where there are no tolerances."""
        return tuple(self.cases[k] for k in self.corner_places)

    @property
    def over(self) -> str:
        """Return how many load cases there are, in words: "4 scenarios and 16 corners of their tolerances"."""
        cases, corners = len(self.drawn), len(self.corner_places)
        text = f"{cases} scenario{'s' if cases > 1 else ''}"
        return f"{text} and {corners} corners of their tolerances" if corners else text

    @property
    def corner_places(self) -> tuple[int, ...]:
        """Return the places of the corners among the cases: all behind a load case as drawn are its own."""
        return tuple(k for k in range(len(self.cases)) if k % (1 + len(self.corner_rows)))

    @property
    def corner_rows(self) -> Float[np.ndarray, "corners tolerances"]:
        """Return the corners among the cases as rows of -1 and 1: ``signs``, or all where these may be all."""
        count = len(self.tolerances)
        if not self.signs and 0 < count <= WHOLE_CORNERS:
            return corner_signs(count)
        return np.array(self.signs, float).reshape(len(self.signs), count)

    @property
    def needs_search(self) -> bool:
        """Return whether there are more corners than `tune` has among its cases, so that it searches for the worst."""
        return len(self.tolerances) > WHOLE_CORNERS

    def check_tunable(self) -> None:
        """Raise `InputError` where there is nothing to tune."""
        if not self.variables:
            raise InputError("variables is empty; tuning needs at least one")

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism whose designs are tuned."""
        return mechanism_of(self.design)

    @property
    def end(self) -> RequiredEnd | None:
        """Return the strictest end that the limits ask for, or that a limited or lowered quantity waits for; None for
        none."""
        objectives = (self.objective, *(() if self.then is None else (self.then.objective,)))
        used = (name for objective in objectives for name in objective.weights)
        return self.mechanism.required_end(self.limits.ends, (*self.limits.names, *used))

    @property
    def success(self) -> str | None:
        """Return how each run must end, in a word; None where any end will do."""
        return self.mechanism.success_of(self.design) if self.end is None else self.end.name

    def succeeded(self, code: Any) -> Bool[np.ndarray, "..."]:
        """Return which outcomes, given as codes, are those that each run must have."""
        if self.end is None:
            return np.asarray(self.mechanism.succeeded(code))
        return np.isin(code, [int(self.mechanism.outcomes[name]) for name in self.end.outcomes])

    def known(self, code: Int[np.ndarray, " cases"]) -> Bool[np.ndarray, "cases quantities"]:
        """Return which of the `names` are known of runs with these outcomes.

        A time that a run waited for in vain is not known.
        """
        ends = [self.mechanism.required_end((), (name,)) for name in self.names]
        outcomes = self.mechanism.outcomes
        columns = [
            np.ones(len(code), bool) if end is None else np.isin(code, [int(outcomes[it]) for it in end.outcomes])
            for end in ends
        ]
        return np.column_stack(columns)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the quantities that objectives and constraints may use: the `peak_quantity` first, the own ones
        last."""
        return (*self._tuned, *self.quantities)

    @functools.cached_property  # asked for hundreds of times in a search
    def _tuned(self) -> tuple[str, ...]:
        names = [name for name in self.mechanism.tuned if self.mechanism.has(name, self.design)]
        # First, because an `Evaluation` has the peak force apart from the rest.
        return tuple(sorted(names, key=lambda name: name != self.mechanism.name_of(PEAK_FORCE)))

    @functools.cached_property
    def peak_quantity(self) -> str | None:
        """Return the one of the `names` that is known of every impact; None where there is none."""
        name = self.mechanism.name_of(PEAK_FORCE)
        return name if name in self.names else None

    @functools.cached_property
    def main_quantity(self) -> str:
        """Return the one of the `names` that stands for a run where nothing is said."""
        return self.mechanism.main_quantity(self.names, self.design)

    @property
    def measured(self) -> tuple[str, ...]:
        """Return the mechanism's quantities among `names`, then those that only the own ones are made of."""
        parameters = (name for derived in self.quantities.values() for name in derived.parameters)
        return tuple(dict.fromkeys((*self._tuned, *parameters)))

    @property
    def rest(self) -> tuple[str, ...]:
        """Return the `names` without the `peak_quantity`."""
        return tuple(name for name in self.names if name != self.peak_quantity)

    @property
    def measured_rest(self) -> tuple[str, ...]:
        """Return the `measured` quantities without the `peak_quantity`."""
        return tuple(name for name in self.measured if name != self.peak_quantity)

    @property
    def catalogue(self) -> Catalogue:
        """Return the mechanism's quantities and the own ones."""
        own = {name: derived.as_quantity(name) for name, derived in self.quantities.items()}
        return {**self.mechanism.quantities, **own}

    @property
    def scenarios_met(self) -> tuple[Part, ...]:
        """Return the cases' scenarios, as often as they occur."""
        return tuple(case.scenario for case in self.cases)

    @property
    def paths(self) -> tuple[str, ...]:
        """Return the variables' dotted paths."""
        return tuple(v.path for v in self.variables)

    @property
    def samples(self) -> str:
        """Return the samples that the cases are, in words: "24 samples at each of 3 scenarios"; "" where nothing
        scatters."""
        if self.scatter is None:
            return ""
        scenarios = len(self.drawn) // self.scatter.count
        return f"{self.scatter.count} samples" + (f" at each of {scenarios} scenarios" if scenarios > 1 else "")

    def format(self, objective: Objective) -> str:
        """Return an objective of this problem in words."""
        return objective.format(self.samples)

    def shown(self, path: str, value: float) -> tuple[float, str]:
        """Return a number of the design in the unit that people are shown, and that unit."""
        return as_typed(float(value), unit(self.design, path), self.units.get(path, ""))

    def tolerance_text(self, address: str) -> str:
        """Return a tolerance in words: "±10 %", "-1 to +2 mm"."""
        symbol = unit_at(self.design, self.drawn[0].scenario, address)
        return str(self.tolerances[address].in_words(symbol, self.units.get(f"tolerances.{address}", "")))

    def start(self) -> Float[np.ndarray, " variables"]:
        """Return the design's scaled variables [-]."""
        return np.array([v.scaled(float(get(self.design, v.path))) for v in self.variables])

    def values(self, scaled: Iterable[float]) -> Float[np.ndarray, " variables"]:
        """Return the variables' numbers, each in its unit, from their scaled values (0 low, 1 high)."""
        return np.array([v.value(float(z)) for v, z in zip(self.variables, scaled, strict=True)])

    def built(self, scaled: Iterable[float]) -> Part:
        """Return the design with those scaled variables."""
        return replace(self.design, dict(zip(self.paths, map(float, self.values(scaled)), strict=True)))

    def fingerprint(self) -> str:
        """Return a text that is the same for the same problem, so that a run goes on with none but its own."""
        listed = [f"{path}={get(self.design, path)!r}" for path in paths(self.design)]
        for case in self.cases:
            listed.append(repr([getattr(case.scenario, name) for name in paths(case.scenario)]) + repr(case.factors))
            if case.shifts or case.values:
                listed.append(repr(case.shifts) + repr(case.values))
        listed += [f"{address} {it!r}" for address, it in self.tolerances.items()]
        # The units in which people are shown numbers are left out: they change none.
        rest: tuple[Any, ...] = (self.variables, self.objective, self.limits, self.then, self.duration, self.rtol)
        listed += map(repr, rest)
        listed += [f"{name} [{own.unit}] {own.parameters} {own.identity}" for name, own in self.quantities.items()]
        return hashlib.sha256("\n".join(listed).encode()).hexdigest()[:16]
