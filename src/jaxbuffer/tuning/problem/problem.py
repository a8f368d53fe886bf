"""The design problem as data: design variables, load cases, objective and constraints."""

import contextlib
import dataclasses
import functools
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from ...errors import InputError
from ...fields import Part, as_typed, get, paths, replace, unit, unit_at
from ...mechanisms.mechanism import RequiredEnd
from ...mechanisms.registry import mechanism_of
from ...run.request import DEFAULT_TOLERANCE, check_pair
from .cases import WHOLE_CORNERS, Case, Scatter, corner_signs, in_sentence, numbered
from .completion import completed
from .custom_quantity import CustomQuantity
from .objective import Limits, Objective, SecondObjective
from .problem_data import ProblemData
from .tolerances import corner_cases
from .variable import Variable

NONE: Mapping[str, Any] = MappingProxyType({})


class Problem(ProblemData):
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

    def __init__(
        self,
        design: Part,
        scenarios: Sequence[Part | Case],
        variables: Sequence[Variable],
        objective: Objective | None = None,
        limits: Limits | None = None,
        then: SecondObjective | None = None,
        duration: float | None = None,
        rtol: float = DEFAULT_TOLERANCE,
        quantities: Mapping[str, CustomQuantity] = NONE,
        scatter: Scatter | None = None,
        units: Mapping[str, str] = NONE,
        tolerances: Mapping[str, Any] = NONE,
        signs: tuple[tuple[float, ...], ...] = (),
    ) -> None:
        given = ProblemData(
            design=design,
            scenarios=scenarios,
            variables=variables,
            objective=Objective() if objective is None else objective,
            limits=Limits() if limits is None else limits,
            then=then,
            duration=mechanism_of(design).duration(design) if duration is None else duration,
            rtol=rtol,
            quantities=quantities,
            scatter=scatter,
            units=units,
            tolerances=tolerances,
            signs=signs,
        )
        data = completed(given)
        super().__init__(**{field.name: getattr(data, field.name) for field in dataclasses.fields(data)})
        for k, case in enumerate(self.cases):
            try:
                check_pair(self.mechanism, case.of(self.design), case.scenario)
            except InputError as error:
                # A factor or a sampled field may lead out of the range that the design or the scenario allows.
                label = in_sentence(case.label(self.cases), self.number_text(k))
                raise error.between(f"{label}: ") from None
        self.mechanism.tuning.check_problem(self)

    @functools.cached_property
    def cases(self) -> tuple[Case, ...]:
        """Return the load cases, each followed by its corners."""
        if not self.tolerances:
            return self.drawn
        # A case and its corners stand together: `corner_places` tells by that which cases are corners.
        return tuple(
            it for case in self.drawn for it in (case, *corner_cases([case], self.tolerances, self.corner_rows))
        )

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
    def scenarios_met(self) -> tuple[Part, ...]:
        """Return the cases' scenarios, as often as they occur."""
        return tuple(case.scenario for case in self.cases)

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
