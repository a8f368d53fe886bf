"""The lower bound of the peak force, a check of a tuned design beside its search.

The lower bound of the peak contact force is the first impact, which no buffer softens: it is over before a spring or
damper has moved, and sets the peak of a buffer gone soft. Friction and hysteresis lower its closed form
(`first_impact`) by some per cent; so the bound itself is the first impact *simulated* with the buffer taken away, and
the closed form stands beside it and says what it is made of.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy
from jaxtyping import Float

from ..fields import Curve, Part, get, replace
from ..run.simulate import simulate
from .cases import Case
from .evaluation import built_design
from .measurement import Measurement, measure
from .problem import Problem

GONE = 1e-6  # what is left of the buffer's springs and dampers
DURATIONS = 4.0  # of an undamped Hertz impact, 2.943 δ/v each
SHARPER = 0.1  # of the problem's tolerance
LATE = 1e-3  # of a flight: by how much the touchdown may move without the buffer
SPARE = 0.1  # of a flight: by how much that of another design within the bounds may be longer
FAR = 10.0  # times the lower bound at the design: what counts for designs whose parts do not fit, or that fail


@dataclasses.dataclass(frozen=True)
class PeakForceBound:
    """A lower limit of the first impact's peak in each load case [N].

    ``simulated`` without a buffer, and ``closed_form``, elastic and frictionless; ``energy`` T_c⁻ [J]; ``lowest``: the
    least that the objective's first impacts can be within the variables' bounds [N], and ``at`` which numbers. NaN
    where a first impact can not be simulated.
    """

    simulated: Float[np.ndarray, " cases"]
    closed_form: Float[np.ndarray, " cases"]
    energy: Float[np.ndarray, " cases"]
    lowest: float
    at: dict[str, float]

    @property
    def highest(self) -> float:
        """Return the largest of all load cases [N]; NaN where one is not known."""
        return float(np.max(self.simulated))

    @property
    def unknown(self) -> int:
        """Return in how many load cases the lower bound is not known."""
        return int(np.sum(~np.isfinite(self.simulated)))


class Flight(NamedTuple):
    """A flight to the first touch.

    ``duration`` of a run that has the first impact [s]; ``undisturbed``: whether the touchdown stays the same without
    the buffer.
    """

    duration: float
    undisturbed: bool


def lower_bound(problem: Problem, scaled: Float[np.ndarray, " variables"]) -> PeakForceBound | None:
    """Compute the lower bound at a design, and the lowest one within the bounds; None for a mechanism without one."""
    known = problem.mechanism.tuning.lower_bound
    if known is None:
        return None
    built = [(built_design(problem, scaled, case), case.scenario) for case in problem.cases]
    pairs = zip(built, problem.cases, strict=True)
    flights = [None if design is None else _flight(problem, design, case) for (design, _), case in pairs]
    simulated = _without_buffer(problem, scaled, flights)[0]
    lowest, best = _lowest(problem, scaled, simulated, flights)
    closed = [None if design is None else known.first_impact(design, scenario) for design, scenario in built]
    at = dict(zip(problem.paths, map(float, problem.values(best)), strict=True))
    return PeakForceBound(
        simulated,
        np.array([np.nan if c is None else float(c.elastic_peak) for c in closed]),
        np.array([np.nan if c is None else float(c.effective_energy) for c in closed]),
        lowest,
        {path: value for path, value in at.items() if path not in _gone(problem.design, known.compliant_parts)},
    )


def _lowest(
    problem: Problem, scaled: np.ndarray, peaks: np.ndarray, flights: Sequence[Flight | None]
) -> tuple[float, np.ndarray]:
    """Search for the least lower bound within the bounds [N] and where it is, from the design with these ``peaks``."""
    here = problem.objective.aggregate(peaks)
    if not np.isfinite(here):
        return np.nan, scaled
    best = (here, scaled)

    def objective(where: np.ndarray) -> tuple[float, np.ndarray]:
        nonlocal best
        peaks, slopes = _without_buffer(problem, where, flights)
        weights = problem.objective.case_weights(peaks)
        value, slope = float(weights @ peaks), weights @ slopes
        # L-BFGS-B takes numbers only: one far above the bound at the start stands for designs that cannot be simulated.
        if not (np.isfinite(value) and np.all(np.isfinite(slope))):
            return FAR * here, np.zeros_like(where)
        # The line search's last point need not be its best, and it may have left the designs that fit.
        best = min(best, (value, where.copy()), key=lambda pair: pair[0])
        return value, slope

    bounds = [(0.0, 1.0)] * len(scaled)
    scipy.optimize.minimize(objective, scaled, jac=True, bounds=bounds, method="L-BFGS-B", tol=1e-6)
    return best


def _without_buffer(
    problem: Problem, scaled: np.ndarray, flights: Sequence[Flight | None]
) -> tuple[np.ndarray, np.ndarray]:
    """Return first peaks [N] of all load cases with the buffer gone, and their slopes by the scaled variables.

    They are NaN where a first impact can not be simulated, and 0 where nothing is touched.
    """
    known, values = problem.mechanism.tuning.lower_bound, problem.values(scaled)
    assert known is not None
    gone = _gone(problem.design, known.compliant_parts)
    peaks, slopes = np.full(len(problem.cases), np.nan), np.full((len(problem.cases), len(scaled)), np.nan)
    for k, case in enumerate(problem.cases):
        if (built := built_design(problem, scaled, case)) is None:
            continue
        run = _first_impact(problem, built, case, flights[k])
        if run is None:
            continue
        factors = dict(case.factors)
        # The compliant parts are taken away whatever their variables say, so the bound has no slope by these.
        scale = [
            v.slope(float(x)) * factors.get(v.path, 1.0) * (v.path not in gone)
            for v, x in zip(problem.variables, values, strict=True)
        ]
        first = int(np.argmin(run.slots))  # a run that goes on for longer may have higher peaks
        peaks[k], slopes[k] = float(run.peaks[first]), run.peaks_slope[first] * np.array(scale)
    return peaks, slopes


def _flight(problem: Problem, built: Part, case: Case) -> Flight | None:
    """Simulate the approach of a design to its first touch; None where the run starts with it, or fails."""
    known = problem.mechanism.tuning.lower_bound
    assert known is not None
    if np.isfinite(float(known.first_impact(built, case.scenario).duration)):
        return None
    with_buffer = simulate(built, case.scenario, problem.duration, rtol=problem.rtol)
    if with_buffer.outcome.failed:
        return None
    end = float(with_buffer.end_time)
    # Nothing is touched, so that there is no touchdown which the buffer could move. A run that ends where it starts has
    # no length to repeat.
    if not int(with_buffer.impact_count):
        whole = problem.mechanism.duration(built) if problem.duration is None else problem.duration
        return Flight(end if end > 0.0 else float(whole), True)
    touch, release = float(with_buffer.impacts.time[0]), float(with_buffer.impacts.release_time[0])
    # A little longer, for the bounds allow other lengths of the flight.
    duration = (1.0 + SPARE) * touch + DURATIONS * (release - touch if np.isfinite(release) else end - touch)
    without = simulate(_without_softeners(problem, built), case.scenario, duration, rtol=problem.rtol)
    undisturbed = int(without.impact_count) > 0 and abs(float(without.impacts.time[0]) - touch) <= LATE * touch
    return Flight(duration, undisturbed)


def _first_impact(problem: Problem, built: Part, case: Case, flight: Flight | None) -> Measurement | None:
    """Simulate the first impact of a design without its buffer; None where that fails.

    Where the buffer takes part in the ``flight`` to it, under thrust say, it stays: it hardly moves within an impact.
    """
    known = problem.mechanism.tuning.lower_bound
    assert known is not None
    design = _without_softeners(problem, built) if flight is None or flight.undisturbed else built
    if flight is None:
        duration = DURATIONS * float(known.first_impact(built, case.scenario).duration)
    else:
        duration = flight.duration
    run = measure(
        (design, case.scenario),
        mechanism=problem.mechanism,
        measured=problem.measured_rest,
        peak=problem.peak_quantity,
        paths=problem.paths,
        duration=duration,
        rtol=SHARPER * problem.rtol,
    )
    return run if run.code < problem.mechanism.outcomes["failed_steps"] else None


def _without_softeners(problem: Problem, built: Part) -> Part:
    assert problem.mechanism.tuning.lower_bound is not None
    return replace(built, _gone(built, problem.mechanism.tuning.lower_bound.compliant_parts))


def _gone(design: Part, compliant_parts: Sequence[str]) -> dict[str, float]:
    """Return what is left of a design's compliant parts by path: of measured curves their values; parts that are not
    there are left out."""
    numbers = dict[str, Any]()
    for path in compliant_parts:
        value = get(design, path)
        if isinstance(value, Curve):
            numbers |= {f"{path}.{address}": value.get(address) for address in value.value_addresses()}
        elif value is not None:
            numbers[path] = value
    return {path: GONE * float(number) for path, number in numbers.items()}
