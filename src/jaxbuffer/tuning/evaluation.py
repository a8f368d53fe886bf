"""All load cases of a design problem at one design: values and first derivatives, on all cores.

The own quantities follow by the chain rule from those of the mechanism. The largest contact force is a maximum over
impacts, max p_i, and another impact may take over within a step d. So the slope at a fixed largest force and the
derivative by that force are separate numbers, and h(max p_i, x) becomes h + ∂h/∂p (max (p_i + ∇p_i d) - max p_i) +
∂h/∂x ∇x d, with the linear model of every impact inside (a composite function; Fletcher, *Practical Methods of
Optimization*, chapter 14).
"""

import functools
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from ..cluster.extra import pool_of
from ..errors import InputError
from ..fields import Part, get
from ..hybrid import Diffrax, Solver, name_of, solver_named
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.run import Run
from ..run.request import check_pair
from ..run.simulate import simulate
from ..run.stepper import stepper_of
from ..sensitivities.gradients import gradients
from .cases import Case
from .problem import PEAK_FORCE, Problem

# How many of each run's highest impacts are listed: none below them has yet mattered within the length of a step.
PEAKS = 24
LOST = -10.0  # margin of a run that could not be solved [-]
# rtol of the last check by diffrax: below it the smooth law's bias is larger, and derivatives take too many steps.
FINEST_OF_DIFFRAX = 1e-8


class Evaluation(NamedTuple):
    """A design in all load cases. Derivatives are by the scaled variables (see `Variable`).

    ``scaled`` [-]: the variables, 0 at the low bound and 1 at the high one; ``code`` of each outcome, ``solved``: which
    cases have numbers, ``succeeded``: which ended as the mechanism's runs should (all solved ones where it says nothing
    of that); ``impacts``: touchdowns; ``peaks`` [N]: each case's highest impacts, falling, and ``slots``: which impacts
    they are; ``rest``: the problem's other quantities in their units; ``margin`` [-]: the mechanism's, positive where
    the run succeeds; ``first`` [N]: the first impact's peak; ``rest_slope``: at a fixed largest peak,
    ``by_peak`` [unit/N]: by that peak, zero for all but own quantities.
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
        """The largest contact force of each load case [N]."""
        return np.asarray(self.peaks[:, 0])  # they fall

    @property
    def quantities(self) -> Float[np.ndarray, "cases quantities"]:
        """The quantities of each load case, in the order of `Problem.names`: the peak force, then the ``rest``."""
        return np.column_stack([self.peak_force, self.rest])

    @property
    def quantities_slope(self) -> Float[np.ndarray, "cases quantities variables"]:
        """The slopes of `quantities`; the peak force has that of the largest impact."""
        top = self.peaks_slope[:, :1]
        return np.concatenate([top, self.rest_slope + self.by_peak[:, :, None] * top], axis=1)


class Evaluator:
    """An evaluator runs designs of one problem and counts the runs.

    Each run has its derivatives unless ``slopes`` is False: they are zero then, for methods that use none. ``client``,
    ``solver``: as in `tune`. ``tight``: relative error of the runs in which a tuned design is checked [-].
    """

    def __init__(
        self,
        problem: Problem,
        workers: int | None = None,
        slopes: bool = True,
        client: Any = None,
        solver: Solver | str | None = None,
    ) -> None:
        self.problem, self.captures, self.slopes = problem, 0, slopes
        named = None if solver is None else solver_named(solver)
        self._solver = named if client is None else name_of(named)
        usual = stepper_of(problem.mechanism).tight
        self.tight = max(usual, FINEST_OF_DIFFRAX) if isinstance(named, Diffrax) else usual
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
        """Evaluate designs, each given by its scaled variables, in one batch.

        ``rtol`` [-] and ``cases`` default to the problem's, ``slopes`` to the evaluator's.
        """
        problem, with_slopes = self.problem, self.slopes if slopes is None else slopes
        cases = problem.cases if cases is None else cases
        points = [np.asarray(point, float) for point in points]
        jobs = [(built_design(problem, point, case), case.scenario) for point in points for case in cases]
        fitting = [(design, scenario) for design, scenario in jobs if design is not None]
        one = functools.partial(
            measure,
            mechanism=problem.mechanism,
            measured=problem.measured,
            paths=problem.paths,
            duration=problem.duration,
            rtol=rtol or problem.rtol,
            solver=self._solver,
            slopes=with_slopes,
        )
        results = iter(self._pool.map(one, fitting))
        # Designs whose parts do not fit are not run, and count: a resumed tuning must count the same.
        runs = [Measurement.lost(problem) if design is None else next(results) for design, _ in jobs]
        self.captures += len(jobs)
        count = len(cases)
        return [_gather(problem, point, cases, runs[k * count : (k + 1) * count]) for k, point in enumerate(points)]


def built_design(problem: Problem, scaled: Float[np.ndarray, " variables"], case: Case) -> Part | None:
    """Return the design as a load case has it built, or None where its parts or its scenario do not fit."""
    try:
        design = case.of(problem.built(scaled))
        check_pair(problem.mechanism, design, case.scenario)
    except InputError:
        return None
    return design


class Measurement(NamedTuple):
    """The numbers of one run (see `Evaluation`), with slopes by the variables' own values.

    ``rest`` has the problem's measured quantities, without the own ones that are made of them.
    """

    code: int
    impacts: int
    peaks: Float[np.ndarray, " peaks"]
    slots: Int[np.ndarray, " peaks"]
    rest: Float[np.ndarray, " rest"]
    margin: float
    first: float
    peaks_slope: Float[np.ndarray, "peaks paths"]
    rest_slope: Float[np.ndarray, "rest paths"]
    margin_slope: Float[np.ndarray, " paths"]

    @staticmethod
    def lost(problem: Problem) -> "Measurement":
        """Return that of a load case whose design and scenario do not fit each other."""
        rest, paths = len(problem.measured) - 1, len(problem.paths)
        slopes = {"peaks_slope": (PEAKS, paths), "rest_slope": (rest, paths), "margin_slope": (paths,)}
        shapes = {"peaks": (PEAKS,), "rest": (rest,), "margin": (), "first": ()} | slopes
        numbers: dict[str, Any] = {name: np.full(shape, np.nan) for name, shape in shapes.items()}
        code = int(problem.mechanism.outcomes["failed_input"])
        return Measurement(code=code, impacts=0, slots=np.arange(PEAKS), **numbers)


def measure(
    built: tuple[Part, Part],
    *,
    mechanism: Mechanism,
    measured: Sequence[str],
    paths: Sequence[str],
    duration: Any,
    rtol: float,
    solver: Solver | str | None = None,
    slopes: bool = True,
) -> Measurement:
    """Run once and read off the numbers, with their derivatives if ``slopes``; else those are zero.

    **Arguments:** ``built``: design and scenario; ``mechanism``: whose design it is; ``measured``: names of the
    quantities to read off; ``paths``: by which they are differentiated; ``solver``: as for `simulate`.
    """
    (design, scenario), solver = built, None if solver is None else solver_named(solver)
    rest = [name for name in measured if name != PEAK_FORCE]
    catalogue = mechanism.quantities
    margin = [] if mechanism.tuning.margin is None else [mechanism.tuning.margin]
    if slopes:
        at = [float(get(design, p)) for p in paths]
        result = gradients(mechanism, design, scenario, paths, at, duration, rtol=rtol, solver=solver)
        run = result.run
        of_peaks = np.asarray(result.by_impact[PEAK_FORCE])
        top_slope, *others = (result.of(name) for name in (PEAK_FORCE, *rest, *margin))
    else:
        run = simulate(design, scenario, duration, rtol=rtol, solver=solver)
        none = np.zeros(len(paths))
        of_peaks = np.zeros((len(run.impacts.peak_force), len(paths)))
        top_slope, others = none, [none] * (len(rest) + len(margin))
    values = np.array([float(catalogue[name].of(run)) for name in rest + margin])
    peaks, of_peaks = _all_peaks(run, of_peaks, top_slope)
    slots = np.argsort(-peaks, kind="stable")[:PEAKS]
    of_rest = np.array(others[: len(rest)]).reshape(len(rest), len(paths))
    return Measurement(
        code=int(run.code),
        impacts=int(run.impact_count),
        peaks=peaks[slots],
        slots=slots,
        rest=values[: len(rest)],
        margin=float(values[-1]) if margin else 1.0,
        first=float(peaks[0]),
        peaks_slope=of_peaks[slots],
        rest_slope=of_rest,
        margin_slope=others[-1] if margin else np.zeros(len(paths)),
    )


def _all_peaks(run: Run, slopes: np.ndarray, top_slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return every impact's peak [N] and its slopes, at least `PEAKS` of them, the rest zero.

    The last slot is free: of a run with more impacts than are listed it takes the largest, if that is not listed.
    """
    more = max(PEAKS - len(slopes), 0)
    peaks, slopes = np.pad(run.impacts.peak_force, (0, more)), np.pad(slopes, ((0, more), (0, 0)))
    unlisted = int(run.peak_impact) < 0
    peaks[-1], slopes[-1] = (float(run.peak_force), top_slope) if unlisted else (0.0, 0.0)
    return peaks, slopes


def _gather(problem: Problem, scaled: np.ndarray, cases: Sequence[Case], runs: list[Measurement]) -> Evaluation:
    """Gather the runs' numbers in arrays and add the own quantities.

    A load case where one of these is not finite counts as failed, and is an error at the problem's start.
    """
    factors = [dict(case.factors) for case in cases]
    values = problem.values(scaled)
    stretch = np.array(
        [[v.slope(x) * f.get(v.path, 1.0) for v, x in zip(problem.variables, values, strict=True)] for f in factors]
    )
    stacked = {name: np.stack([getattr(m, name) for m in runs]) for name in Measurement._fields}
    for name in ("peaks_slope", "rest_slope"):
        stacked[name] = stacked[name] * stretch[:, None, :]
    stacked["margin_slope"] = stacked["margin_slope"] * stretch
    lost = (stacked["code"] >= problem.mechanism.outcomes["failed_steps"]) | ~np.isfinite(stacked["margin"])
    for name in ("peaks_slope", "rest_slope", "margin_slope"):
        lost |= ~np.all(np.isfinite(stacked[name]), axis=tuple(range(1, stacked[name].ndim)))
    run = _by_field(problem, stacked, lost)
    peak, rest = run["peaks"][:, 0], run["rest"]  # peaks fall, so the first is the largest
    own = compose(problem, peak, rest, run["rest_slope"])
    known = np.isfinite(own.values) & np.isfinite(own.by_peak) & np.all(np.isfinite(own.slopes), axis=2)
    if np.any(without := ~np.all(known, axis=1) & ~lost):
        if cases is problem.cases and np.array_equal(scaled, problem.start()):
            check_start(problem, peak, rest, int(np.argmax(without)))
        run = _by_field(problem, stacked, lost | without)
    # Quantities that only the own ones are made of stand behind the mechanism's tuned ones and are left out here.
    solved, others = run["solved"][:, None], len(problem.names) - len(problem.quantities) - 1
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
        array[lost] = 0.0
    run["margin"][lost] = LOST
    succeeded = ~lost & problem.mechanism.succeeded(code)
    ended_otherwise = ~succeeded & (code != outcomes[problem.mechanism.outcomes.time_is_up()])
    # A run that breaks off early, by bouncing out say, must not pass for a quick one: its end time is the duration.
    time = problem.measured.index("end_time") - 1  # in the rest, which is without the peak force
    run["rest"][ended_otherwise, time] = problem.duration
    run["rest_slope"][ended_otherwise, time] = 0.0
    states = {"code": code, "solved": ~lost, "succeeded": succeeded}
    return run | states | {name: stacked[name] for name in ("impacts", "slots")}


class OwnQuantities(NamedTuple):
    """The own quantities of every load case.

    ``values`` in their units; ``slopes`` by the scaled variables at a fixed largest contact force; ``by_peak``: their
    derivatives by that force [unit/N].
    """

    values: Float[np.ndarray, "cases own"]
    slopes: Float[np.ndarray, "cases own variables"]
    by_peak: Float[np.ndarray, "cases own"]


def compose(
    problem: Problem,
    peak: Float[np.ndarray, " cases"],
    rest: Float[np.ndarray, "cases measured-1"],
    rest_slope: Float[np.ndarray, "cases measured-1 variables"],
) -> OwnQuantities:
    """Compute the own quantities from the measured ones by the chain rule.

    **Arguments:** ``peak``: the largest contact force [N]; ``rest``: the others of ``problem.measured``, with their
    slopes by the scaled variables.
    """
    count, variables = len(peak), rest_slope.shape[2]
    own = len(problem.quantities)
    result = OwnQuantities(np.zeros((count, own)), np.zeros((count, own, variables)), np.zeros((count, own)))
    known = np.column_stack([peak, rest])
    for k, derived in enumerate(problem.quantities.values()):
        columns = [problem.measured.index(name) for name in derived.parameters]
        values, partials = map(np.asarray, derived.linearised(jnp.asarray(known[:, columns])))
        result.values[:, k] = values
        for name, column, partial in zip(derived.parameters, columns, partials.T, strict=True):
            if name == PEAK_FORCE:
                result.by_peak[:, k] = partial
            else:
                result.slopes[:, k] += partial[:, None] * rest_slope[:, column - 1]
    return result


def check_start(
    problem: Problem, peak: Float[np.ndarray, " cases"], rest: Float[np.ndarray, "cases measured-1"], case: int
) -> None:
    """Raise `InputError` with the own quantity that has no number, or no derivative, in a load case of the start."""
    known = dict(zip(problem.measured, [float(peak[case]), *map(float, rest[case])], strict=True))
    for name, derived in problem.quantities.items():
        values = [known[parameter] for parameter in derived.parameters]
        value, partials = (np.asarray(array)[0] for array in derived.linearised(jnp.array([values])))
        units = (problem.catalogue[parameter].unit for parameter in derived.parameters)
        at = ", ".join(
            f"{p} = {x:.4g} {u}".rstrip(" -") for p, x, u in zip(derived.parameters, values, units, strict=True)
        )
        where = f"at the start, {problem.cases[case].label(problem.cases)}, where {at}"
        if not np.isfinite(value):
            raise InputError(f"quantities.{name}: {derived.label} is {float(value):g} {where}")
        for parameter, partial in zip(derived.parameters, partials, strict=True):
            if not np.isfinite(partial):
                what = f"its derivative by {parameter} is {float(partial):g}"
                raise InputError(f"quantities.{name}: {derived.label}: {what} {where}")
