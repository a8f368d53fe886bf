"""All cases of a design problem at one design: values and first derivatives, on all cores."""

import functools
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from ..cluster.pool import pool_of
from ..errors import InputError
from ..fields import Part, get
from ..mechanisms.registry import mechanism_of
from ..mechanisms.run import Run, rising
from ..run.request import check_pair
from ..run.simulate import simulate
from ..sensitivities.gradients import gradients
from .cases import Case
from .composed import check_start, composed
from .problem import Problem

PEAKS = (
    24  # highest impacts of each run that are listed: at a step's length from the top none below them has yet mattered
)
LOST = -10.0  # margin of a run that could not be solved [-]


class Evaluation(NamedTuple):
    """A design in all cases. Derivatives are by the scaled variables (see `Variable`).

    ``scaled`` [-]: the variables, 0 at the low bound and 1 at the high one; ``code`` of each outcome, ``solved``: which
    cases have numbers, ``succeeded``: which ended as the mechanism's runs should (all solved ones where it says nothing
    of that); ``impacts``: touchdowns; ``peaks`` [N]: each case's highest impacts, falling, and ``slots``: which impacts
    they are; ``rest``: the problem's other quantities in their units; ``margin`` [-]: the mechanism's, positive where
    the run succeeds; ``first`` [N]: the first impact's peak; ``rising``: which of the mechanism's tuned quantities are
    largest at the end of a run that succeeded, and still rising there; ``rest_slope``: at a fixed largest peak,
    ``by_peak`` [unit/N]: by that peak, zero for all but own quantities (see `composed`).
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
    rising: Bool[np.ndarray, "cases tuned"]
    peaks_slope: Float[np.ndarray, "cases peaks variables"]
    rest_slope: Float[np.ndarray, "cases rest variables"]
    margin_slope: Float[np.ndarray, "cases variables"]
    by_peak: Float[np.ndarray, "cases rest"]

    @property
    def quantities(self) -> Float[np.ndarray, "cases quantities"]:
        """The problem's quantities of each case."""
        return np.column_stack([self.peaks[:, 0], self.rest])

    @property
    def quantities_slope(self) -> Float[np.ndarray, "cases quantities variables"]:
        """Their slopes, with that of the largest impact."""
        top = self.peaks_slope[:, :1]
        return np.concatenate([top, self.rest_slope + self.by_peak[:, :, None] * top], axis=1)


class Evaluator:
    """Evaluates designs of one problem and counts the runs it took, each with its derivatives unless ``slopes`` is
    False: they are zero then, for methods that use none. ``client``: as in `tune`."""

    def __init__(self, problem: Problem, workers: int | None = None, slopes: bool = True, client: Any = None) -> None:
        self.problem, self.captures, self.slopes = problem, 0, slopes
        self._pool = pool_of(client, workers)

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
        """Evaluate designs, each given by its scaled variables, together; ``rtol`` [-] and ``cases`` default to the
        problem's, ``slopes`` to the evaluator's."""
        problem, with_slopes = self.problem, self.slopes if slopes is None else slopes
        cases = problem.cases if cases is None else cases
        points = [np.asarray(point, float) for point in points]
        jobs = [(fitted(problem, point, case), case.scenario) for point in points for case in cases]
        fitting = [(design, scenario) for design, scenario in jobs if design is not None]
        one = functools.partial(_measured, Wanted.of(problem), problem.duration, rtol or problem.rtol, with_slopes)
        measured = iter(self._pool.map(one, fitting))
        found = [Measured.lost(problem) if design is None else next(measured) for design, _ in jobs]
        self.captures += len(jobs)
        count = len(cases)
        return [_gathered(problem, point, cases, found[k * count : (k + 1) * count]) for k, point in enumerate(points)]


def fitted(problem: Problem, scaled: Float[np.ndarray, " variables"], case: Case) -> Part | None:
    """The mechanism of a case as built with those scaled variables, or None where its parts or its scenario do not
    fit."""
    try:
        design = case.of(problem.built(scaled))
        check_pair(problem.mechanism, design, case.scenario)
    except InputError:
        return None
    return design


class Measured(NamedTuple):
    """What one run tells the tuner (see `Evaluation`); slopes by the variables' own values. ``rest`` has the problem's
    measured quantities, without the own ones that are made of them."""

    code: int
    impacts: int
    peaks: Float[np.ndarray, " peaks"]
    slots: Int[np.ndarray, " peaks"]
    rest: Float[np.ndarray, " rest"]
    margin: float
    first: float
    rising: Bool[np.ndarray, " tuned"]
    peaks_slope: Float[np.ndarray, "peaks paths"]
    rest_slope: Float[np.ndarray, "rest paths"]
    margin_slope: Float[np.ndarray, " paths"]

    @staticmethod
    def lost(problem: Problem) -> "Measured":
        """Of a case whose design and scenario do not fit each other."""
        rest, paths = len(problem.measured) - 1, len(problem.paths)
        code, peaks, unknown = int(problem.mechanism.outcomes["failed_input"]), np.full(PEAKS, np.nan), np.nan
        slopes = [np.full((*shape, paths), np.nan) for shape in ((PEAKS,), (rest,), ())]
        return Measured(
            code,
            0,
            peaks,
            np.arange(PEAKS),
            np.full(rest, np.nan),
            unknown,
            unknown,
            np.zeros(len(problem.mechanism.tuned), bool),
            *slopes,
        )


class Wanted(NamedTuple):
    """What is read off each run: quantities and the paths they are differentiated by, all by name."""

    measured: tuple[str, ...]
    paths: tuple[str, ...]

    @staticmethod
    def of(problem: Problem) -> "Wanted":
        """A problem's."""
        return Wanted(tuple(problem.measured), tuple(problem.paths))


def measure(wanted: Wanted, design: Part, scenario: Part, duration: Any, rtol: float, slopes: bool = True) -> Measured:
    """One run and, with ``slopes``, its derivatives by the paths wanted; else those are zero."""
    mechanism, rest, paths = mechanism_of(design), list(wanted.measured[1:]), wanted.paths
    catalogue = mechanism.quantities
    margin = [] if mechanism.margin is None else [mechanism.margin]
    if slopes:
        found = gradients(design, scenario, paths, [float(get(design, p)) for p in paths], duration, rtol=rtol)
        run = found.run
        of_peaks = np.asarray(found.by_impact["peak_force"])
        top_slope, *others = (found.of(name) for name in ("peak_force", *rest, *margin))
    else:
        run = simulate(design, scenario, duration, rtol=rtol)
        none = np.zeros(len(paths))
        of_peaks = np.zeros((len(run.impacts.peak_force), len(paths)))
        top_slope, others = none, [none] * (len(rest) + len(margin))
    values = np.array([float(catalogue[name].of(run)) for name in rest + margin])
    peaks, of_peaks = _peaks(run, of_peaks, top_slope)
    slots = np.argsort(-peaks, kind="stable")[:PEAKS]
    of_rest = np.array(others[: len(rest)]).reshape(len(rest), len(paths))
    return Measured(
        code=int(run.code),
        impacts=int(run.impact_count),
        peaks=peaks[slots],
        slots=slots,
        rest=values[: len(rest)],
        margin=float(values[-1]) if margin else 1.0,
        first=float(peaks[0]),
        rising=np.isin(mechanism.tuned, rising(run)),
        peaks_slope=of_peaks[slots],
        rest_slope=of_rest,
        margin_slope=others[-1] if margin else np.zeros(len(paths)),
    )


def _measured(wanted: Wanted, duration: Any, rtol: float, slopes: bool, job: tuple[Part, Part]) -> Measured:
    return measure(wanted, *job, duration, rtol, slopes)


def _peaks(run: Run, slopes: np.ndarray, top_slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every impact's peak [N] and its slopes, at least `PEAKS` of them, the rest zero. The last slot is free: of a run
    with more impacts than are listed it takes the largest, if that is not listed."""
    more = max(PEAKS - len(slopes), 0)
    peaks, slopes = np.pad(run.impacts.peak_force, (0, more)), np.pad(slopes, ((0, more), (0, 0)))
    unlisted = int(run.peak_impact) < 0
    peaks[-1], slopes[-1] = (float(run.peak_force), top_slope) if unlisted else (0.0, 0.0)
    return peaks, slopes


def _gathered(problem: Problem, scaled: np.ndarray, cases: Sequence[Case], found: list[Measured]) -> Evaluation:
    """The cases' numbers as arrays, the own quantities among them. A case where one of these is not finite counts as
    failed, and is an error at the problem's start."""
    factors = [dict(case.factors) for case in cases]
    values = problem.values(scaled)
    stretch = np.array(
        [[v.slope(x) * f.get(v.path, 1.0) for v, x in zip(problem.variables, values, strict=True)] for f in factors]
    )
    stacked = {name: np.stack([getattr(m, name) for m in found]) for name in Measured._fields}
    for name in ("peaks_slope", "rest_slope"):
        stacked[name] = stacked[name] * stretch[:, None, :]
    stacked["margin_slope"] = stacked["margin_slope"] * stretch
    lost = (stacked["code"] >= problem.mechanism.outcomes["failed_steps"]) | ~np.isfinite(stacked["margin"])
    for name in ("peaks_slope", "rest_slope", "margin_slope"):
        lost |= ~np.all(np.isfinite(stacked[name]), axis=tuple(range(1, stacked[name].ndim)))
    run = _settled(problem, stacked, lost)
    peak, rest = run["peaks"][:, 0], run["rest"]
    own = composed(problem, peak, rest, run["rest_slope"])
    if np.any(without := ~own.finite & ~lost):
        if cases is problem.cases and np.array_equal(scaled, problem.start()):
            check_start(problem, peak, rest, int(np.argmax(without)))
        run = _settled(problem, stacked, lost | without)
    kept, others = run["solved"][:, None], len(problem.mechanism.tuned) - 1
    return Evaluation(
        scaled=scaled,
        **run
        | {
            "rising": run["rising"] & run["succeeded"][:, None],
            "rest": np.column_stack([run["rest"][:, :others], np.where(kept, own.values, 0.0)]),
            "rest_slope": np.concatenate(
                [run["rest_slope"][:, :others], np.where(kept[:, :, None], own.slopes, 0.0)], axis=1
            ),
            "by_peak": np.column_stack([np.zeros((len(found), others)), np.where(kept, own.by_peak, 0.0)]),
        },
    )


def _settled(problem: Problem, stacked: dict[str, np.ndarray], lost: np.ndarray) -> dict[str, np.ndarray]:
    """The runs' numbers by the fields of `Evaluation`: ``lost`` ones without numbers and slopes, end times of those
    that ended otherwise than they should at the duration."""
    outcomes, success = problem.mechanism.outcomes, problem.mechanism.success
    code = stacked["code"]
    code = np.where(lost & (code < outcomes["failed_steps"]), outcomes["failed_not_finite"], code)
    numbers = ("peaks", "rest", "margin", "first", "peaks_slope", "rest_slope", "margin_slope")
    run = {name: stacked[name].copy() for name in numbers}
    for array in run.values():
        array[lost] = 0.0
    run["margin"][lost] = LOST
    succeeded = ~lost if success is None else code == outcomes[success]
    ended_otherwise = ~succeeded & (code != outcomes[problem.mechanism.time_is_up])
    time = problem.measured.index("end_time") - 1
    run["rest"][ended_otherwise, time] = problem.duration
    run["rest_slope"][ended_otherwise, time] = 0.0
    states = {"code": code, "solved": ~lost, "succeeded": succeeded}
    return run | states | {name: stacked[name] for name in ("impacts", "slots", "rising")}
