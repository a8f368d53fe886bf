"""All cases of a design problem at one design: values and first derivatives, on all cores, by one compiled program."""

import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..capture import Capture, simulate
from ..errors import InputError
from ..mechanisms import CaptureMechanism, Design, Scenario, check_fit, get, replace
from ..outcome import Outcome
from ..programs import Static, kept
from ..quantities import QUANTITIES as CATALOGUE
from .problem import QUANTITIES, Case, Problem

PEAKS = 24  # highest impacts kept of each capture: at a step's length from the top none below them has yet mattered
LOST = -10.0  # margin of a capture that could not be solved [-]
MISFIT = Outcome.failed_not_finite  # of a case whose design and scenario do not fit each other


class Evaluation(NamedTuple):
    """A design in all cases. Derivatives are by the variables' places between their bounds (see `Variable`).

    ``places`` [-]; ``code``: an `Outcome` each; ``impacts``: touchdowns; ``peaks`` [N]: each case's highest impacts,
    falling, and ``slots``: which impacts they are; ``rest``: the other `QUANTITIES` in their units; ``margin`` [-]: how
    clearly a case is captured, see `margin`; ``first`` [N]: the first impact's peak.
    """

    places: Float[np.ndarray, " variables"]
    code: Int[np.ndarray, " cases"]
    impacts: Int[np.ndarray, " cases"]
    peaks: Float[np.ndarray, "cases peaks"]
    slots: Int[np.ndarray, "cases peaks"]
    rest: Float[np.ndarray, "cases rest"]
    margin: Float[np.ndarray, " cases"]
    first: Float[np.ndarray, " cases"]
    peaks_slope: Float[np.ndarray, "cases peaks variables"]
    rest_slope: Float[np.ndarray, "cases rest variables"]
    margin_slope: Float[np.ndarray, "cases variables"]

    @property
    def quantities(self) -> Float[np.ndarray, "cases quantities"]:
        """`QUANTITIES` of each case."""
        return np.column_stack([self.peaks[:, 0], self.rest])

    @property
    def captured(self) -> Bool[np.ndarray, " cases"]:
        """Which cases are captured."""
        return self.code == Outcome.captured

    @property
    def solved(self) -> Bool[np.ndarray, " cases"]:
        """Which cases have numbers at all."""
        return self.code < Outcome.failed_steps


class Evaluator:
    """Evaluates designs of one problem and counts the captures it took, each with its derivatives unless ``slopes`` is
    False: they are zero then, for methods that use none."""

    def __init__(self, problem: Problem, workers: int | None = None, slopes: bool = True) -> None:
        self.problem, self.captures, self.slopes = problem, 0, slopes
        self._pool = ThreadPoolExecutor(workers or len(os.sched_getaffinity(0)))

    def __enter__(self) -> "Evaluator":
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(wait=True, cancel_futures=True)

    def __call__(
        self, points: Iterable[np.ndarray], rtol: float | None = None, slopes: bool | None = None
    ) -> list[Evaluation]:
        """Evaluate designs at their places, together; ``rtol`` [-] defaults to the problem's, ``slopes`` to the
        evaluator's."""
        problem, measured = self.problem, measure if (self.slopes if slopes is None else slopes) else measure_values
        points = [np.asarray(point, float) for point in points]
        jobs = [(point, case) for point in points for case in problem.cases]

        def solved(job: tuple[np.ndarray, Case]) -> Measured:
            fitting = fitted(problem, *job)
            if fitting is None:
                return Measured.lost(len(problem.paths))
            return measured(fitting, job[1].scenario, problem.paths, problem.duration, rtol or problem.rtol)

        found = list(self._pool.map(solved, jobs))
        self.captures += len(jobs)
        count = len(problem.cases)
        return [_gathered(problem, point, found[k * count : (k + 1) * count]) for k, point in enumerate(points)]


def fitted(problem: Problem, places: Float[np.ndarray, " variables"], case: Case) -> Design | None:
    """The mechanism of a case as built at those places, or None where its parts or its scenario do not fit."""
    try:
        design = case.of(problem.built(places))
        check_fit(design, case.scenario)
    except InputError:
        return None
    return design


class Measured(eqx.Module):
    """What one capture tells the tuner; slopes by the paths' own values."""

    code: Int[Array, ""]
    impacts: Int[Array, ""]
    peaks: Float[Array, " peaks"]
    slots: Int[Array, " peaks"]
    rest: Float[Array, " rest"]
    margin: Float[Array, ""]
    first: Float[Array, ""]
    peaks_slope: Float[Array, "peaks paths"]
    rest_slope: Float[Array, "rest paths"]
    margin_slope: Float[Array, " paths"]

    @staticmethod
    def lost(paths: int) -> "Measured":
        """Of a case that can not be simulated."""
        rest, peaks = len(QUANTITIES) - 1, np.arange(PEAKS)
        shapes: list[tuple[int, ...]] = [(rest,), (), (), (PEAKS, paths), (rest, paths), (paths,)]
        numbers: list[Any] = [np.full(shape, np.nan) for shape in shapes]
        code: list[Any] = [np.array(int(MISFIT)), np.array(0), np.full(PEAKS, np.nan), peaks]
        return Measured(*code, *numbers)


def measure(design: Design, scenario: Scenario, paths: Sequence[str], duration: float, rtol: float) -> Measured:
    """One capture and its derivatives by ``paths``; one compiled program for all numbers, durations and tolerances."""
    values = [float(get(design, path)) for path in paths]
    inputs = jax.tree.map(lambda x: np.asarray(x, float), (design, scenario, duration, rtol, values))
    return jax.tree.map(np.asarray, _measure(inputs, Static(tuple(paths))))


def measure_values(design: Design, scenario: Scenario, paths: Sequence[str], duration: float, rtol: float) -> Measured:
    """One capture without derivatives, those of `measure` being zero; a program of its own."""
    inputs = jax.tree.map(lambda x: np.asarray(x, float), (design, scenario, duration, rtol))
    peaks, rest, clear, code, count = map(np.asarray, _measure_values(inputs))
    slots = np.argsort(-peaks, kind="stable")[:PEAKS]
    none = [np.zeros((*shape, len(paths))) for shape in (slots.shape, rest.shape, ())]
    found: list[Any] = [code, count, peaks[slots], slots, rest, clear, peaks[0], *none]
    return Measured(*found)


@kept
def _measure(inputs: tuple[Design, Scenario, Array, Array, list[Array]], asked: Static) -> Measured:
    design, scenario, duration, rtol, values = inputs
    paths = asked.value

    def outputs(values: list[Array]) -> tuple[tuple[Array, Array, Array], tuple[Array, ...]]:
        moved = replace(design, dict(zip(paths, values, strict=True)))
        seen = _seen(moved, scenario, duration, rtol)
        return seen[:3], seen

    slopes, (peaks, rest, clear, code, count) = jax.jacfwd(outputs, has_aux=True)(values)
    peaks_slope, rest_slope, clear_slope = (jnp.stack(slope, axis=-1) for slope in slopes)
    top, slots = jax.lax.top_k(peaks, PEAKS)
    return Measured(code, count, top, slots, rest, clear, peaks[0], peaks_slope[slots], rest_slope, clear_slope)


@kept
def _measure_values(inputs: tuple[Design, Scenario, Array, Array]) -> tuple[Array, Array, Array, Array, Array]:
    return _seen(*inputs)


def _seen(design: Design, scenario: Scenario, duration: Array, rtol: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Every impact's peak, the other quantities, the margin; outcome and count of impacts."""
    capture = simulate(design, scenario, duration, rtol=rtol)
    clear = margin(CaptureMechanism(capture.design, scenario), capture, duration)
    rest = jnp.stack([CATALOGUE[name].of(capture) for name in list(QUANTITIES)[1:]])
    peaks = capture.impacts.peak_force
    # the last slot is free: of a run with more impacts than are listed it takes the largest, if that is not
    peaks = peaks.at[-1].set(jnp.where(capture.peak_impact < 0, capture.peak_force, 0.0))
    return peaks, rest, clear, capture.code, capture.impact_count


def margin(mechanism: CaptureMechanism, capture: Capture, duration: Float[Array, ""]) -> Float[Array, ""]:
    """How clearly a capture succeeds [-]: the tip's mean speed towards the capture plane over the whole run, relative
    to the speed that arrives just in time, minus 1.

    One formula, smooth where one outcome turns into another: captured after t of at most D, D/t - 1; still on its way
    at D, minus the share of the distance that is left; escaped, below -1, the lower the sooner. Of a bottomed run it
    says what it would have come to, going on like that; what is wrong with it is its `stroke_share`.
    """
    before, after = mechanism.throat_of(mechanism.start()[0])[0], capture.throat_distance
    # where an event ended the run, the distance there is always the same and the time moves
    anywhere = (capture.code == Outcome.timeout) | (capture.code == Outcome.bottomed)
    after = jnp.where(anywhere, after, jax.lax.stop_gradient(after))
    return (before - after) / before * duration / capture.end_time - 1.0


def _gathered(problem: Problem, places: np.ndarray, found: list[Measured]) -> Evaluation:
    """The cases' numbers as arrays: unsolved ones without slopes, end times of the uncaptured at the duration."""
    factors = [dict(case.factors) for case in problem.cases]
    values = problem.values(places)
    stretch = np.array(
        [[v.slope(x) * f.get(v.path, 1.0) for v, x in zip(problem.variables, values, strict=True)] for f in factors]
    )
    stacked = {name: np.stack([getattr(m, name) for m in found]) for name in Measured.__dataclass_fields__}
    code = stacked["code"]
    slopes = {
        "peaks_slope": stacked["peaks_slope"] * stretch[:, None, :],
        "rest_slope": stacked["rest_slope"] * stretch[:, None, :],
        "margin_slope": stacked["margin_slope"] * stretch,
    }
    lost = (code >= Outcome.failed_steps) | ~np.isfinite(stacked["margin"])
    for slope in slopes.values():
        lost |= ~np.all(np.isfinite(slope), axis=tuple(range(1, slope.ndim)))
    code = np.where(lost & (code < Outcome.failed_steps), Outcome.failed_not_finite, code)
    values_of = {name: stacked[name].copy() for name in ("peaks", "rest", "margin", "first")} | slopes
    for array in values_of.values():
        array[lost] = 0.0
    values_of["margin"][lost] = LOST
    escaped = (code == Outcome.escaped) | (code == Outcome.bottomed)
    time = list(QUANTITIES).index("end_time") - 1
    values_of["rest"][escaped | lost, time] = problem.duration
    values_of["rest_slope"][escaped | lost, time] = 0.0
    return Evaluation(places=places, code=code, impacts=stacked["impacts"], slots=stacked["slots"], **values_of)
