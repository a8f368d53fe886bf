"""One run of a tuning: its numbers and their first derivatives."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from jaxtyping import Float, Int

from ...fields import Part, get, value_at
from ...hybrid import Solver, solver_named
from ...mechanisms.mechanism import Mechanism, RequiredEnd
from ...mechanisms.outcome import RunOutcome
from ...mechanisms.quantity import END_TIME, IMPACT_PEAK
from ...mechanisms.run import Run
from ...run.simulate import simulate
from ...sensitivities.gradients import gradients
from ..problem.problem import Problem

# How many of each run's highest impacts are listed: none below them has yet mattered within the length of a step.
PEAKS = 24
SLOPES = ("peaks_slope", "rest_slope", "margin_slope")
LEAST_LACK = 1e-6  # of the margin of a run that has not reached an end [-]


class RunEnd(Protocol):
    """How a run of a design has ended: a `Run`, or these three alone."""

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism."""

    @property
    def outcome(self) -> RunOutcome:
        """Return the outcome."""

    @property
    def design(self) -> Part:
        """Return the design that was run."""


class Measurement(NamedTuple):
    """The numbers of one run (see `Evaluation`), with slopes by the variables' own values.

    ``rest`` has the problem's measured quantities, without the own ones that are made of them; ``peaks``: of no impact
    where none of those is the peak force.
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
    def lost(problem: Problem, paths: int | None = None) -> "Measurement":
        """Return that of a load case whose design and scenario do not fit each other.

        ``paths``: how many slopes it has, by default one a variable.
        """
        rest, paths = len(problem.measured_rest), len(problem.paths) if paths is None else paths
        peaks = 0 if problem.peak_quantity is None else PEAKS
        slopes = {"peaks_slope": (peaks, paths), "rest_slope": (rest, paths), "margin_slope": (paths,)}
        shapes = {"peaks": (peaks,), "rest": (rest,), "margin": (), "first": ()} | slopes
        numbers: dict[str, Any] = {name: np.full(shape, np.nan) for name, shape in shapes.items()}
        code = int(problem.mechanism.outcomes["failed_input"])
        return Measurement(code=code, impacts=0, slots=np.arange(peaks), **numbers)

    def of_columns(self, columns: Sequence[int]) -> "Measurement":
        """Return the same run with the slopes by some of its paths only."""
        return self._replace(**{name: getattr(self, name)[..., columns] for name in SLOPES})

    def of_known_slopes(self) -> "Measurement":
        """Return the same run with a slope of zero in place of each that is not finite."""
        return self._replace(**{name: np.nan_to_num(getattr(self, name), posinf=0.0, neginf=0.0) for name in SLOPES})

    @staticmethod
    def of_numbers(problem: Problem, run: RunEnd, impacts: int, numbers: Mapping[str, float]) -> "Measurement":
        """Return that of a run of which these quantities are known by name, and no derivative.

        Of its peaks the largest alone is known, which the first impact's is taken for.
        """
        rest, no_slopes = problem.measured_rest, np.zeros(len(problem.paths))
        values, slopes = np.array([numbers[name] for name in rest]), np.zeros((len(rest), len(problem.paths)))
        duration, margin, end = float(problem.duration or 0.0), problem.mechanism.tuning.margin, problem.end
        own = Margin(1.0 if margin is None else numbers[margin], no_slopes)
        if not run.outcome.failed:
            _fill_awaited(run.mechanism, run, rest, values, slopes, duration)
            if end is not None and end.quantity:
                known = {name: Margin(float(values[k]), slopes[k]) for k, name in enumerate(rest)}
                own = margin_of_end(end, run, own, known, duration)
        peaks = np.zeros(0 if problem.peak_quantity is None else PEAKS)
        if problem.peak_quantity is not None:
            peaks[0] = numbers[problem.peak_quantity]
        return Measurement(
            code=int(run.outcome),
            impacts=impacts,
            peaks=peaks,
            slots=np.arange(len(peaks)),
            rest=values,
            margin=own.value,
            first=float(np.max(peaks, initial=0.0)),
            peaks_slope=np.zeros((len(peaks), len(problem.paths))),
            rest_slope=slopes,
            margin_slope=own.slope,
        )


def measure(
    built: tuple[Part, Part],
    *,
    mechanism: Mechanism,
    measured: Sequence[str],
    peak: str | None,
    paths: Sequence[str],
    duration: Any,
    rtol: float,
    end: RequiredEnd | None = None,
    solver: Solver | str | None = None,
    slopes: bool = True,
) -> Measurement:
    """Run once and read off the numbers, with their derivatives if ``slopes``; else those are zero.

    **Arguments:** ``built``: design and scenario; ``mechanism``: whose design it is; ``measured``: names of the
    quantities to read off; ``peak``: the one that is the largest contact force, of which every impact's is read off,
    None for none; ``paths``: addresses by which they are differentiated; ``end``: what the run must reach
    besides, None for nothing; ``solver``: as for `simulate`.
    """
    solver = solver_named(solver)
    margin = [] if mechanism.tuning.margin is None else [mechanism.tuning.margin]
    names, settings = [*measured, *margin], {"duration": duration, "rtol": rtol, "solver": solver}
    run, (peaks, of_peaks), slope_rows = _solved(built, mechanism, names, peak, paths, slopes, settings)
    values = np.array([float(mechanism.quantities[name].of(run)) for name in names])
    # All numbers of a run that failed are NaN, and stay so.
    if not run.outcome.failed:
        _fill_awaited(mechanism, run, measured, values, slope_rows, float(duration))
    # Stable: slots without an impact, all of them zero, keep their order.
    slots = np.argsort(-peaks, kind="stable")[:PEAKS]
    # A mechanism without a margin has no end to miss, so that its margin always holds.
    own = Margin(float(values[-1]), slope_rows[-1]) if margin else Margin(1.0, np.zeros(len(paths)))
    if end is not None and end.quantity and not run.outcome.failed:
        numbers = {name: Margin(float(values[k]), slope_rows[k]) for k, name in enumerate(measured)}
        own = margin_of_end(end, run, own, numbers, float(duration))
    return Measurement(
        code=int(run.code),
        impacts=int(run.impact_count),
        peaks=peaks[slots],
        slots=slots,
        rest=values[: len(measured)],
        margin=own.value,
        # Not yet in order of height: the first slot is the first impact.
        first=float(peaks[0]) if len(peaks) else 0.0,
        peaks_slope=of_peaks[slots],
        rest_slope=slope_rows[: len(measured)],
        margin_slope=own.slope,
    )


def _solved(
    built: tuple[Part, Part],
    mechanism: Mechanism,
    names: Sequence[str],
    peak: str | None,
    paths: Sequence[str],
    slopes: bool,
    settings: Mapping[str, Any],
) -> tuple[Run, tuple[np.ndarray, np.ndarray], np.ndarray]:
    """Return the run, the peaks of its impacts with their slopes, none where no quantity is the ``peak``, and the
    slopes of the quantities of some names; all slopes are zero unless ``slopes``."""
    count = len(paths)
    if slopes:
        at = [float(value_at(*built, path)) for path in paths]
        result = gradients(mechanism, *built, paths, at, **settings)
        run, rows = result.run, np.array([result.of(name) for name in names]).reshape(len(names), count)
    else:
        run, rows = simulate(*built, **settings), np.zeros((len(names), count))
    if peak is None:
        return run, (np.zeros(0), np.zeros((0, count))), rows
    if not slopes:
        return run, _all_peaks(run, np.zeros((len(run.impacts.peak_force), count)), np.zeros(count)), rows
    return run, _all_peaks(run, np.asarray(result.by_impact[IMPACT_PEAK]), result.of(peak)), rows


class Margin(NamedTuple):
    """A number of a run and its slope by the variables' own values."""

    value: float
    slope: Float[np.ndarray, " paths"]


def _fill_awaited(
    mechanism: Mechanism, run: RunEnd, names: Sequence[str], values: np.ndarray, slopes: np.ndarray, duration: float
) -> None:
    """Give the times that the run waited for in vain the duration [s], which they exceed, and no slope."""
    for k, name in enumerate(names):
        end = mechanism.required_end((), (name,))
        if end is not None and run.outcome.name not in end.outcomes:
            values[k], slopes[k] = duration, 0.0


def margin_of_end(end: RequiredEnd, run: RunEnd, own: Margin, numbers: Mapping[str, Margin], duration: float) -> Margin:
    """Return a number that is positive exactly where a run has an end that waits for a share to fall, with its slope.

    It is continuous where a run reaches the end just at its ``duration`` [s]: the logarithm of the share that is left
    over the one to be reached, negative, for a share falls as an exponential; of a run that has the end the logarithm
    of the duration over the time that it took. Of a run that does not even succeed all is left, and the slope is that
    of the mechanism's ``own`` margin.

    **Arguments:** ``numbers``: of the run, by quantity.
    """
    mechanism, outcome = run.mechanism, run.outcome
    if outcome.name in end.outcomes:
        time = numbers[str(mechanism.name_of(END_TIME))]
        return Margin(max(math.log(duration / time.value), 0.0), -time.slope / time.value)
    threshold = float(get(run.design, end.threshold))
    if mechanism.succeeded(int(outcome)):
        left = numbers[end.quantity]
        # Little may be left in a run that ends before all has closed that is to: it has not reached the end either.
        above = max(math.log(max(left.value, 1e-300) / threshold), LEAST_LACK)
        return Margin(-above, -left.slope / max(left.value, 1e-300))
    nothing = np.zeros_like(own.slope)
    # The slope of min(own, 0): a margin that is positive adds nothing.
    failing = own.value < 0.0
    return Margin(math.log(threshold) + min(own.value, 0.0), own.slope if failing else nothing)


def _all_peaks(run: Run, slopes: np.ndarray, top_slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return every impact's peak [N] and its slopes, at least `PEAKS` of them, the rest zero.

    The last slot is free: of a run with more impacts than are listed it takes the largest, if that is not listed.
    """
    more = max(PEAKS - len(slopes), 0)
    peaks, slopes = np.pad(run.impacts.peak_force, (0, more)), np.pad(slopes, ((0, more), (0, 0)))
    unlisted = int(run.peak_impact) < 0
    peaks[-1], slopes[-1] = (float(run.peak_force), top_slope) if unlisted else (0.0, 0.0)
    return peaks, slopes
