"""What a design would do with other numbers: models of its quantities around it, with the error that runs kept apart
from their fit measure."""

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import scipy
from jaxtyping import Bool, Float

from ..errors import check_type, check_whole
from ..fields import as_displayed, get, unit_at
from ..mechanisms.quantity import END_TIME
from ..tuning.problem.cases import Case, Distribution, in_sentence, numbered
from ..tuning.problem.problem import Problem
from ..tuning.problem.tolerances import moved
from ..tuning.search.evaluation import Evaluation, Evaluator
from ..value_text import percent_text
from .what_if_model import Endings, Model, endings, fit

RUNS = 128  # of each scenario that models are fitted to
LEAST, MOST = 32, 4096
WIDTHS = (0.2, 0.1, 0.05)  # of each variable's range to either side of the design; the next where one is not good
GOOD = 0.02  # the largest relative miss with which a model's numbers are shown
MOST_CASES = 12
ROWS = 8  # between two reports of progress


class MovableNumber(NamedTuple):
    """A number that may be moved: its ``name``, ``unit``, ``low`` and ``high`` end and the design's ``value`` in that
    unit, and the ``scale`` on which its range is divided, "log" or "linear"."""

    name: str
    unit: str
    low: float
    high: float
    value: float
    scale: str


@dataclasses.dataclass(frozen=True)
class WhatIf:
    """Models of a design's quantities around it. Print it for how good they are.

    - ``problem``: whose design it is.
    - ``sliders``: the d numbers that the models depend on: the problem's variables, then factors of what is built on
      what is drawn, then by how much a number that has a tolerance differs from the drawn one.
    - ``cases``: load cases; ``left_out``: how many others decide no quantity at the design.
    - ``quantities``: names; ``omitted``: those without models, since they are times at which a run ends.
    - ``shares`` (n, d) [-]: where in the sliders' ranges the runs lie that models are fitted to; ``nominal`` (d,):
      where the design lies.
    - ``models``: of each case and quantity, (cases, quantities); None where too few runs ended as they should.
    - ``succeeded`` (n, cases): which of those runs did; ``endings`` (cases,): where others do, as runs kept apart
      confirm.
    - ``apart``: how many runs of each case were kept apart; ``runs`` in all.

    **Example:**

    >>> problem = jb.Problem(jb.BarDrop(), [jb.BarDropScenario()], [jb.Variable("impact.stiffness", 1e10, 1e12)])
    >>> found = jb.what_if(problem, runs=32)
    >>> found.models[0][0].at(found.nominal, found.shares) > 0.0
    True
    """

    problem: Problem
    sliders: tuple[MovableNumber, ...]
    cases: tuple[Case, ...]
    left_out: int
    quantities: tuple[str, ...]
    omitted: tuple[str, ...]
    shares: Float[np.ndarray, "n d"]
    nominal: Float[np.ndarray, " d"]
    models: tuple[tuple[Model | None, ...], ...]
    succeeded: Bool[np.ndarray, "n cases"]
    endings: tuple[Endings, ...]
    apart: int
    runs: int

    def good(self, case: int, quantity: int) -> bool:
        """Return whether a model misses no run kept apart by more than 2 %."""
        model = self.models[case][quantity]
        return model is not None and model.error <= GOOD

    def __repr__(self) -> str:
        lines = [f"What if: {len(self.sliders)} numbers, {len(self.cases)} cases, {self.runs} runs"]
        lines += [f"  {it.name} {it.low:.4g} … {it.high:.4g} {it.unit}" for it in self.sliders]
        for q, name in enumerate(self.quantities):
            good = sum(self.good(c, q) for c in range(len(self.cases)))
            lines.append(f"  {name}: good to {percent_text(GOOD)} in {good} of {len(self.cases)} cases")
        return "\n".join(lines)

    @property
    def count_good(self) -> int:
        """Return how many of the models are good to 2 %."""
        pairs = ((c, q) for c in range(len(self.cases)) for q in range(len(self.quantities)))
        return sum(self.good(*pair) for pair in pairs)

    def _names(self, case: Case) -> dict[str, str]:
        """Return a case in words, for a table and a sentence, with its scenario's number where it is of one alone."""
        problem, label = self.problem, case.label(self.cases)
        places = [k for k, drawn in enumerate(problem.drawn, 1) if _without_slider(problem, drawn) == case]
        # Samples that differ in numbers with a slider alone are one case here, which has none of their numbers.
        number = str(places[0]) if len(places) == 1 < len(problem.drawn) else ""
        return {"label": numbered(label, number), "in_sentence": in_sentence(label, number)}

    def record(self) -> dict[str, Any]:
        """Return what a page evaluates, as JSON: numbers of sliders in their units, of models in SI units."""
        every = zip(self.models, self.succeeded.T, self.endings, self.cases, strict=True)
        return {
            "kind": self.problem.mechanism.name,
            "sliders": [slider._asdict() for slider in self.sliders],
            "nominal": self.nominal.tolist(),
            "shares": self.shares.tolist(),
            "quantities": list(self.quantities),
            "omitted": list(self.omitted),
            "cases": [
                {
                    **self._names(case),
                    "succeeded": np.asarray(succeeded).tolist(),
                    **ending._asdict(),
                    "models": [None if model is None else model.record() for model in models],
                }
                for models, succeeded, ending, case in every
            ],
            "left_out": self.left_out,
            "apart": self.apart,
            "runs": self.runs,
            "good": GOOD,
            "at_most": {**self.problem.mechanism.always(self.problem.design), **self.problem.limits.at_most},
            "at_least": dict(self.problem.limits.at_least),
            "success": self.problem.success,
            "variables": {path: float(get(self.problem.design, path)) for path in self.problem.paths},
        }


def what_if(problem: Problem, runs: int = RUNS, *, progress: Callable[[int, int], None] | None = None) -> WhatIf:
    """Fit models of a design's quantities to runs around it, and measure what they miss at runs kept apart.

    The ranges are a fifth of each variable's to either side; where a model is not good to 2 % there, they are halved,
    at most twice.

    **Arguments:**

    - ``problem``: whose ``design`` it is, a tuned one say, with the numbers that may be moved as its variables.
    - ``runs``: of each scenario that models are fitted to; half as many are kept apart.
    - ``progress``: called with the runs done and those that there are at most.

    **Returns:** a `WhatIf`.

    **Raises:** `InputError` for ``problem`` and ``runs`` that are no such things.

    **Example:** a bar's drop, by its contact's stiffness.

    >>> problem = jb.Problem(jb.BarDrop(), [jb.BarDropScenario()], [jb.Variable("impact.stiffness", 1e10, 1e12)])
    >>> found = jb.what_if(problem, runs=32)
    >>> found.sliders[0].name, found.good(0, found.quantities.index("penetration"))
    ('impact.stiffness', True)
    """
    check_type("problem", problem, Problem, "load('design.toml').problem()")
    check_whole("runs", runs, LEAST, MOST)
    with Evaluator(problem, slopes=False) as evaluator:
        return _Search(problem, evaluator, runs, progress or (lambda done, most: None)).widest()


def most_runs(problem: Problem, runs: int) -> int:
    """Return how many runs `what_if` makes at most."""
    cases = len(_without_factors(problem))
    return len(WIDTHS) * min(cases, MOST_CASES) * (runs + runs // 2) + (cases if cases > MOST_CASES else 0)


class _Search:
    """The search for the widest ranges in which all models are good."""

    def __init__(self, problem: Problem, evaluator: Evaluator, runs: int, report: Callable[[int, int], None]) -> None:
        self.problem, self.evaluator, self.runs, self.report = problem, evaluator, runs, report
        self.factors, self.tolerances, self.most = _factors(problem), problem.tolerances, most_runs(problem, runs)
        self.quantities, self.omitted = _quantities(problem)
        self.every = _without_factors(problem)
        self.apart = runs // 2
        self.cases = self.every
        self.cases = self._deciding()

    def widest(self) -> WhatIf:
        found: list[WhatIf] = []
        for width in WIDTHS:
            found.append(self._around(width))
            if found[-1].count_good == len(self.cases) * len(self.quantities):
                break
        # Of equally many good models those of the widest ranges.
        return max(found, key=lambda it: it.count_good)

    def _deciding(self) -> tuple[Case, ...]:
        """Return the cases that have the largest and least values at the design, at most `MOST_CASES`."""
        if len(self.every) <= MOST_CASES:
            return self.every
        (found,) = self.evaluator([self.problem.start()], cases=self.every)
        values, chosen = self._values(found), dict[int, None]()
        # Rank by rank over all quantities, so that each of them has its own worst cases among the few.
        for rank in range(len(self.every)):
            for column in range(values.shape[1]):
                chosen[int(np.argsort(-values[:, column], kind="stable")[rank])] = None
        return tuple(self.every[k] for k in sorted(list(chosen)[:MOST_CASES]))

    def _around(self, width: float) -> WhatIf:
        low, high = self._ends(width)
        start = np.array([*self.problem.start(), *np.ones(len(self.factors)), *np.zeros(len(self.tolerances))])
        spread = np.maximum(high - low, 1e-300)
        nominal = np.clip((start - low) / spread, 0.0, 1.0)
        with np.errstate(all="ignore"):
            # A Sobol' sequence is balanced at powers of two: one is drawn, and cut to the runs that are asked for.
            sequence = scipy.stats.qmc.Sobol(len(low), rng=0).random(1 << (self.runs - 1).bit_length())
        # The design itself is among the runs, so that the page is exact where it begins.
        shares = np.vstack([nominal, sequence[: self.runs - 1]])
        apart = np.random.default_rng(1).random((self.apart, len(low)))
        known, kept = (self._evaluate(low + spread * places) for places in (shares, apart))
        models = tuple(
            tuple(self._fit(shares, known, apart, kept, c, q) for q in range(len(self.quantities)))
            for c in range(len(self.cases))
        )
        return WhatIf(
            problem=self.problem,
            sliders=self._sliders(low, high),
            cases=self.cases,
            left_out=len(self.every) - len(self.cases),
            quantities=self.quantities,
            omitted=self.omitted,
            shares=shares,
            nominal=nominal,
            models=models,
            succeeded=known.succeeded,
            endings=tuple(
                endings(shares, of, apart, ended) for of, ended in zip(known.succeeded.T, kept.succeeded.T, strict=True)
            ),
            apart=self.apart,
            runs=self.evaluator.captures,
        )

    def _fit(
        self, shares: np.ndarray, known: "_Runs", apart: np.ndarray, kept: "_Runs", case: int, quantity: int
    ) -> Model | None:
        of, tested = known.usable[:, case, quantity], kept.usable[:, case, quantity]
        truth = kept.values[tested, case, quantity]
        return fit(shares[of], known.values[of, case, quantity], apart[tested], truth, np.flatnonzero(of), self.runs)

    def _ends(self, width: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the ends of the ranges: scaled variables, then factors, then changes within tolerances."""
        start = self.problem.start()
        ends = [given.range for given in self.factors.values()] + [(it.low, it.high) for it in self.tolerances.values()]
        ranges = np.array(ends).reshape(-1, 2)
        low = np.concatenate([np.clip(start - width, 0.0, 1.0), ranges[:, 0]])
        return low, np.concatenate([np.clip(start + width, 0.0, 1.0), ranges[:, 1]])

    def _sliders(self, low: np.ndarray, high: np.ndarray) -> tuple[MovableNumber, ...]:
        problem, count = self.problem, len(self.problem.variables)
        sliders = []
        for v, first, last in zip(problem.variables, low, high, strict=False):
            own = float(get(problem.design, v.path))
            (least, symbol), (most, _), (value, _) = (
                problem.shown(v.path, it) for it in (v.value(first), v.value(last), own)
            )
            sliders.append(MovableNumber(v.path, symbol, least, most, value, v.scale))
        for path, first, last in zip(self.factors, low[count:], high[count:], strict=False):
            sliders.append(MovableNumber(f"{path}, as built over as drawn", "-", first, last, 1.0, "linear"))
        for address, it in self.tolerances.items():
            own_unit = unit_at(problem.design, problem.drawn[0].scenario, address)
            ends = [(100.0 * end, "%") if it.relative else as_displayed(end, own_unit) for end in (it.low, it.high)]
            (least, symbol), (most, _) = ends
            sliders.append(MovableNumber(f"{address}, as built less as drawn", symbol, least, most, 0.0, "linear"))
        return tuple(sliders)

    def _evaluate(self, rows: np.ndarray) -> "_Runs":
        """Run the cases at rows of scaled variables, factors and changes."""
        count, found = len(self.problem.variables), list[Evaluation]()
        for first in range(0, len(rows), ROWS):
            block = rows[first : first + ROWS]
            if self.factors or self.tolerances:
                # Factors and changes are the case's own, so that each row has other cases and is a call of its own.
                for row in block:
                    found += self.evaluator([row[:count]], cases=[self._built(it, row[count:]) for it in self.cases])
            else:
                found += self.evaluator([*block], cases=self.cases)
            self.report(self.evaluator.captures, self.most)
        succeeded = np.array([it.succeeded for it in found])
        names = [self.problem.names.index(name) for name in self.quantities]
        # A time that a run waited for in vain has the duration in its place, which no model is to be fitted to.
        waited = np.array([self.problem.known(it.code)[:, names] for it in found])
        values = np.array([self._values(it) for it in found])
        return _Runs(values, succeeded, succeeded[:, :, None] & waited & np.isfinite(values))

    def _built(self, case: Case, row: Float[np.ndarray, " numbers"]) -> Case:
        """Return the case with factors and with changes of the numbers that have tolerances."""
        split = len(self.factors)
        ends = zip(self.tolerances.values(), row[split:].tolist(), strict=True)
        # Without a change there is no side to take, and that side may have no width to divide by.
        signs = [change / (it.high if change > 0.0 else -it.low) if change else 0.0 for it, change in ends]
        factors = dict(zip(self.factors, row[:split].tolist(), strict=True))
        return moved(_with_factors(case, factors), self.tolerances, signs)

    def _values(self, found: Evaluation) -> Float[np.ndarray, "cases quantities"]:
        return found.quantities[:, [self.problem.names.index(name) for name in self.quantities]]


class _Runs(NamedTuple):
    values: Float[np.ndarray, "n cases quantities"]
    succeeded: Bool[np.ndarray, "n cases"]
    usable: Bool[np.ndarray, "n cases quantities"]


def _quantities(problem: Problem) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return what a designer looks at: what is lowered and limited, what derivatives are usually of, and the own
    quantities; then which of these have no models."""
    usual = problem.mechanism.defaults_for(problem.design).differentiated
    asked = (*problem.objective.weights, *problem.limits.names, *usual, *problem.quantities)
    names = tuple(dict.fromkeys(name for name in asked if name in problem.names))
    omitted = tuple(name for name in names if _ends_runs(problem, name))
    return tuple(name for name in names if name not in omitted), omitted


def _ends_runs(problem: Problem, name: str) -> bool:
    """Return whether a quantity depends on the time at which a run ends: it jumps where one swing more is waited for,
    and none is longer than the duration."""
    own = problem.quantities.get(name)
    if own is not None:
        return any(_ends_runs(problem, parameter) for parameter in own.parameters)
    return name == problem.mechanism.name_of(END_TIME) or bool(problem.mechanism.quantities[name].awaits)


def _factors(problem: Problem) -> Mapping[str, Distribution]:
    """Return the factors of what is built on what is drawn that have a slider of their own."""
    return {} if problem.scatter is None else problem.scatter.factors


def _without_factors(problem: Problem) -> tuple[Case, ...]:
    """Return the cases, each once, without what has a slider of its own: factors, and corners of tolerances."""
    return tuple(dict.fromkeys(_without_slider(problem, case) for case in problem.drawn))


def _without_slider(problem: Problem, case: Case) -> Case:
    """Return a case without the factors that have a slider of their own."""
    return _with_factors(case, dict.fromkeys(_factors(problem)))


def _with_factors(case: Case, factors: Mapping[str, float | None]) -> Case:
    """Return the case with these factors; without those that are None."""
    merged = {**dict(case.factors), **factors}
    return dataclasses.replace(case, factors=tuple((path, it) for path, it in merged.items() if it is not None))
