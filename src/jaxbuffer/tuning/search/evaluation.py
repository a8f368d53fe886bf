"""All load cases of a design problem at one design: values and first derivatives, on all cores.

Each run is a `Measurement`; the quantities that a user has made of the mechanism's are in `own_quantities`.
"""

import functools
from collections.abc import Iterable, Sequence
from concurrent.futures import Executor
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from ...cluster.pool import Pool
from ...errors import InputError
from ...fields import Part, get, value_at
from ...hybrid import Diffrax, Solver, name_of, solver_named
from ...mechanisms.quantity import END_TIME
from ...run.request import check_pair
from ...run.stepper import stepper_of
from ..problem.cases import Case
from ..problem.own_quantities import check_start, compose
from ..problem.problem import Problem
from .measurement import Measurement, measure

LOST = -10.0  # margin of a run that could not be solved [-]
# rtol of the last check by diffrax: below it the smooth law's bias is larger, and derivatives take too many steps.
FINEST_OF_DIFFRAX = 1e-8


class Evaluation(NamedTuple):
    """A design in all load cases. Derivatives are by the scaled variables (see `Variable`).

    ``scaled`` [-]: the variables, 0 at the low bound and 1 at the high one; ``code`` of each outcome, ``solved``: which
    cases have numbers, ``succeeded``: which ended as the problem asks (all solved ones where it says nothing of that);
    ``impacts``: touchdowns; ``peaks`` [N]: each case's highest impacts, falling, and ``slots``: which impacts they are,
    none of them where no quantity of the problem is the peak force; ``rest``: the problem's other quantities in their
    units; ``margin`` [-]: positive where the run ends as the problem
    asks (see `measurement.margin_of_end`); ``first`` [N]: the first impact's peak; ``rest_slope``: at a fixed largest
    peak, ``by_peak`` [unit/N]: by that peak, zero for all but own quantities.
    """

    scaled: Float[np.ndarray, " variables"]
    code: Int[np.ndarray, " cases"]
    solved: Bool[np.ndarray, " cases"]
    succeeded: Bool[np.ndarray, " cases"]
    impacts: Int[np.ndarray, " cases"]
    peaks: Float[np.ndarray, "cases peaks"]
    slots: Int[np.ndarray, "cases peaks"]
    rest: Float[np.ndarray, "cases rest"]
    margin: Float[np.ndarray, " cases"]
    first: Float[np.ndarray, " cases"]
    peaks_slope: Float[np.ndarray, "cases peaks variables"]
    rest_slope: Float[np.ndarray, "cases rest variables"]
    margin_slope: Float[np.ndarray, "cases variables"]
    by_peak: Float[np.ndarray, "cases rest"]

    @property
    def peak_force(self) -> Float[np.ndarray, " cases"]:
        """Return the largest contact force of each load case [N], 0 where nothing touches or no quantity is of it."""
        return np.max(self.peaks, axis=1, initial=0.0)

    @property
    def quantities(self) -> Float[np.ndarray, "cases quantities"]:
        """Return the quantities of each load case, in the order of `Problem.names`: the peak force, if it is
        one of them, then the ``rest``."""
        return np.column_stack([self.peaks[:, :1], self.rest])  # peaks fall, so the first is the largest

    @property
    def quantities_slope(self) -> Float[np.ndarray, "cases quantities variables"]:
        """Return the slopes of `quantities`; the peak force has that of the largest impact."""
        top = self.peaks_slope[:, :1]
        through = np.einsum("cr,cpv->crv", self.by_peak, top)  # the sum is over one peak or none
        return np.concatenate([top, self.rest_slope + through], axis=1)


class Evaluator:
    """An evaluator runs designs of one problem and counts the runs.

    Each run has its derivatives unless ``slopes`` is False: they are zero then, for methods that use none.
    ``executor``, ``solver``: as in `tune`. ``tight``: relative error of runs in which a tuned design is checked [-].
    """

    def __init__(
        self,
        problem: Problem,
        workers: int | None = None,
        slopes: bool = True,
        executor: Executor | None = None,
        solver: Solver | str | None = None,
    ) -> None:
        self.problem, self.captures, self.slopes = problem, 0, slopes
        named = solver_named(solver)
        # A solver goes to other processes by its name, because one of diffrax's would not equal itself there.
        self._solver = named if executor is None else name_of(named)
        usual = stepper_of(problem.mechanism).tight
        self.tight = max(usual, FINEST_OF_DIFFRAX) if isinstance(named, Diffrax) else usual
        self._pool = Pool(executor, workers)

    def __enter__(self) -> "Evaluator":
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.close()

    def __call__(
        self,
        points: Iterable[np.ndarray],
        rtol: float | None = None,
        slopes: bool | None = None,
        cases: Sequence[Case] | None = None,
    ) -> list[Evaluation]:
        """Evaluate designs, each given by its scaled variables, in one batch.

        ``rtol`` [-] and ``cases`` default to the problem's, ``slopes`` to the evaluator's.
        """
        points = [np.asarray(point, float) for point in points]
        cases = self.problem.cases if cases is None else cases
        runs = self._measure(points, cases, rtol, self.slopes if slopes is None else slopes, self.problem.paths)
        count, problem = len(cases), self.problem
        return [gather(problem, point, cases, runs[k * count : (k + 1) * count]) for k, point in enumerate(points)]

    def by_tolerances(
        self, scaled: Float[np.ndarray, " variables"], cases: Sequence[Case], rtol: float | None = None
    ) -> Evaluation:
        """Evaluate a design in some load cases, with derivatives by the tolerances in place of the variables.

        A tolerance counts from -1 at its low end to 1 at its high one.
        """
        problem, point, addresses = self.problem, np.asarray(scaled, float), tuple(self.problem.tolerances)
        # The search's own program serves where it differentiates by all of these numbers: another one takes long to
        # compile.
        known = set(addresses) <= set(problem.paths)
        runs = self._measure([point], cases, rtol, True, problem.paths if known else addresses)
        if known:
            columns = [problem.paths.index(address) for address in addresses]
            runs = [run.of_columns(columns) for run in runs]
        # d built number / d share of its tolerance is half the tolerance's width.
        design = problem.built(point)
        shares = [
            [
                it.half_width(float(dict(case.values).get(address, value_at(design, case.scenario, address))))
                for address, it in problem.tolerances.items()
            ]
            for case in cases
        ]
        return gather(problem, point, cases, runs, np.array(shares))

    def by_numbers(
        self,
        scaled: Float[np.ndarray, " variables"],
        cases: Sequence[Case],
        paths: Sequence[str],
        rtol: float | None = None,
    ) -> Evaluation:
        """Evaluate a design in some load cases, with derivatives by the logarithms of its numbers at some ``paths`` in
        place of the variables.

        A number counts as drawn: the factor and the shift of a load case stay as they are.
        """
        point, design = np.asarray(scaled, float), self.problem.built(scaled)
        runs = [run.of_known_slopes() for run in self._measure([point], cases, rtol, True, paths)]
        stretch = [[float(get(case.of(design), it)) - dict(case.shifts).get(it, 0.0) for it in paths] for case in cases]
        return gather(self.problem, point, cases, runs, np.array(stretch))

    def _measure(
        self,
        points: Sequence[np.ndarray],
        cases: Sequence[Case],
        rtol: float | None,
        slopes: bool,
        paths: Sequence[str],
    ) -> list[Measurement]:
        """Run designs in load cases, all cases of the first design first, with derivatives by ``paths``."""
        problem = self.problem
        jobs = [(built_design(problem, point, case), case.scenario) for point in points for case in cases]
        fitting = [(design, scenario) for design, scenario in jobs if design is not None]
        one = functools.partial(
            measure,
            mechanism=problem.mechanism,
            measured=problem.measured_rest,
            peak=problem.peak_quantity,
            paths=paths,
            duration=problem.duration,
            rtol=rtol or problem.rtol,
            end=problem.end,
            solver=self._solver,
            slopes=slopes,
        )
        results = iter(self._pool.map(one, fitting))
        self.captures += len(jobs)
        # Designs whose parts do not fit are not run, and count: a resumed tuning must count the same.
        return [Measurement.lost(problem, len(paths)) if design is None else next(results) for design, _ in jobs]


def built_design(problem: Problem, scaled: Float[np.ndarray, " variables"], case: Case) -> Part | None:
    """Return the design as a load case has it built, or None where its parts or its scenario do not fit."""
    try:
        design = case.of(problem.built(scaled))
        check_pair(problem.mechanism, design, case.scenario)
    except InputError:
        return None
    return design


def gather(
    problem: Problem,
    scaled: np.ndarray,
    cases: Sequence[Case],
    runs: Sequence[Measurement],
    stretch: Float[np.ndarray, "cases parameters"] | None = None,
) -> Evaluation:
    """Gather the runs' numbers in arrays and add the own quantities.

    ``stretch``: by which the chain rule makes slopes by built numbers those that the evaluation has, by default those
    by the scaled variables. A load case where an own quantity is not finite counts as failed, and is an error at the
    problem's start.
    """
    if stretch is None:
        # d built number / d scaled variable: the load case's factor times the variable's scale.
        values = problem.values(scaled)
        slopes = {v.path: v.slope(x) for v, x in zip(problem.variables, values, strict=True)}
        factors = [dict(case.factors) for case in cases]
        stretch = np.array([[slope * it.get(path, 1.0) for path, slope in slopes.items()] for it in factors])
    stacked = {name: np.stack([getattr(m, name) for m in runs]) for name in Measurement._fields}
    for name in ("peaks_slope", "rest_slope"):
        stacked[name] = stacked[name] * stretch[:, None, :]
    stacked["margin_slope"] = stacked["margin_slope"] * stretch
    lost = (stacked["code"] >= problem.mechanism.outcomes["failed_steps"]) | ~np.isfinite(stacked["margin"])
    for name in ("peaks_slope", "rest_slope", "margin_slope"):
        # A search cannot go on from a design without slopes, so its run counts as one without numbers.
        lost |= ~np.all(np.isfinite(stacked[name]), axis=tuple(range(1, stacked[name].ndim)))
    run = _by_field(problem, stacked, lost)
    peak, rest = run["peaks"][:, :1], run["rest"]  # peaks fall, so the first is the largest
    own = compose(problem, peak, rest, run["rest_slope"])
    known = np.isfinite(own.values) & np.isfinite(own.by_peak) & np.all(np.isfinite(own.slopes), axis=2)
    if np.any(without := ~np.all(known, axis=1) & ~lost):
        if cases is problem.cases and np.array_equal(scaled, problem.start()):
            check_start(problem, np.column_stack([peak, rest]), int(np.argmax(without)))
        run = _by_field(problem, stacked, lost | without)
    # Quantities that only the own ones are made of stand behind the mechanism's tuned ones and are left out here.
    solved, others = run["solved"][:, None], len(problem.rest) - len(problem.quantities)
    return Evaluation(
        scaled=scaled,
        **run
        | {
            "rest": np.column_stack([run["rest"][:, :others], np.where(solved, own.values, 0.0)]),
            "rest_slope": np.concatenate(
                [run["rest_slope"][:, :others], np.where(solved[:, :, None], own.slopes, 0.0)], axis=1
            ),
            "by_peak": np.column_stack([np.zeros((len(runs), others)), np.where(solved, own.by_peak, 0.0)]),
        },
    )


def _by_field(problem: Problem, stacked: dict[str, np.ndarray], lost: np.ndarray) -> dict[str, np.ndarray]:
    """Return the runs' numbers by the fields of `Evaluation`, zero for the ``lost`` runs."""
    outcomes, code = problem.mechanism.outcomes, stacked["code"]
    code = np.where(lost & (code < outcomes["failed_steps"]), outcomes["failed_not_finite"], code)
    numbers = ("peaks", "rest", "margin", "first", "peaks_slope", "rest_slope", "margin_slope")
    run = {name: stacked[name].copy() for name in numbers}
    for array in run.values():
        # NaN times a weight of zero would still be NaN in a sum; `solved` says which numbers there are.
        array[lost] = 0.0
    run["margin"][lost] = LOST
    ended_otherwise = (lost | ~problem.mechanism.succeeded(code)) & (
        code != outcomes[problem.mechanism.outcomes.time_is_up()]
    )
    # A run that breaks off early, by bouncing out say, must not pass for a quick one: its end time is the duration.
    if (end_time := problem.mechanism.name_of(END_TIME)) in problem.measured_rest:
        time = problem.measured_rest.index(end_time)
        run["rest"][ended_otherwise, time] = problem.duration
        run["rest_slope"][ended_otherwise, time] = 0.0
    states = {"code": code, "solved": ~lost, "succeeded": ~lost & problem.succeeded(code)}
    return run | states | {name: stacked[name] for name in ("impacts", "slots")}


def main_values(problem: Problem, evaluation: Evaluation) -> Float[np.ndarray, " cases"]:
    """Return the problem's main quantity in each load case."""
    return np.asarray(evaluation.quantities[:, problem.names.index(problem.main_quantity)])


def validity_lines(problem: Problem, design: Part, evaluation: Evaluation) -> list[str]:
    """Return a line for each validity limit that a design exceeds, with the number of load cases and the worst one."""
    passed: dict[str, list[tuple[float, int]]] = {}
    for place, case in enumerate(problem.cases):
        if not evaluation.solved[place]:
            continue
        values = dict(zip(problem.names, evaluation.quantities[place], strict=True))
        for limit in problem.mechanism.view.validity(case.of(design), values):
            if np.any(limit.passed):
                passed.setdefault(limit.beyond, []).append((float(np.max(limit.share)), place))
    count, lines = len(problem.cases), []
    for beyond, those in passed.items():
        share, k = max(those, key=lambda it: it[0])
        worst = (
            f", by a factor of {share:.3g} at {problem.in_sentence(k)}"
            if count > 1
            else f", by a factor of {share:.3g}"
        )
        lines.append(f"{beyond} in {len(those)} of {count} scenarios{worst}")
    return lines
