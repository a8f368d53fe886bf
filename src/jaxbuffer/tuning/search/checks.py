"""The lower bound of the peak force, a check of a tuned design beside its search.

The lower bound of the peak contact force is the first impact, which no buffer softens: it is over before a spring or
damper has moved, and sets the peak of a buffer gone soft. Friction and hysteresis lower its closed form
(`first_impact`) by some per cent; so the bound itself is the first impact *simulated* with the buffer taken away, and
the closed form stands beside it and says what it is made of.
"""

import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import scipy
from jaxtyping import Float

from ...errors import InputError
from ...fields import Curve, Part, get, paths, replace
from ...mechanisms.limit import Limit
from ...run.simulate import simulate
from ..problem.cases import Case
from ..problem.objective import Objective
from ..problem.problem import Problem
from .evaluation import built_design
from .measurement import Measurement, measure

GONE = 1e-6  # what is left of the buffer's springs and dampers
DURATIONS = 4.0  # of an undamped Hertz impact, 2.943 δ/v each
SHARPER = 0.1  # of the problem's tolerance
LATE = 1e-3  # of a flight: by how much the touchdown may move without the buffer
SPARE = 0.1  # of a flight: by how much that of another design within the bounds may be longer
STEP = 0.01  # of a number, for central differences: far above what a run's tolerance leaves
NOISE = 1e-5  # elasticity by such differences below which it is what a run's tolerance leaves
FAR = 10.0  # times the lower bound at the design: what counts for designs whose parts do not fit, or that fail


class LeastValue(NamedTuple):
    """The lower bound of a quantity: the least that its largest value over all load cases can be in their first impacts
    within the variables' bounds.

    ``value``, in the quantity's unit; ``case``: the load case that has it; ``scaled``: the variables there, and
    ``slope`` of the value by them; ``elasticities`` of it by the design's numbers, by path, where a limit lies under
    it.
    """

    value: float
    case: int
    scaled: Float[np.ndarray, " variables"]
    slope: Float[np.ndarray, " variables"]
    elasticities: Mapping[str, float] = MappingProxyType({})


@dataclasses.dataclass(frozen=True)
class PeakForceBound:
    """A lower limit of the first impact's peak in each load case [N].

    ``simulated`` without a buffer, and ``closed_form``, elastic and frictionless; ``energy`` T_c⁻ [J]; ``lowest``: the
    least that the objective's first impacts can be within the variables' bounds [N], and ``at`` which numbers. NaN
    where a first impact can not be simulated. ``least``: lower bounds of the limited quantities that the first impact
    alone reaches, by name; ``elasticities`` of it by the design's numbers in the worst load case, by path.
    """

    simulated: Float[np.ndarray, " cases"]
    closed_form: Float[np.ndarray, " cases"]
    energy: Float[np.ndarray, " cases"]
    lowest: float
    at: dict[str, float]
    least: Mapping[str, LeastValue] = dataclasses.field(default_factory=dict)
    elasticities: Mapping[str, float] = dataclasses.field(default_factory=dict)

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
    known, peak = problem.mechanism.tuning.lower_bound, problem.peak_quantity
    if known is None or peak is None:
        return None
    built = [(built_design(problem, scaled, case), case.scenario) for case in problem.cases]
    pairs = zip(built, problem.cases, strict=True)
    flights = [None if design is None else _flight(problem, design, case) for (design, _), case in pairs]
    first_peaks = functools.partial(_first_impacts, problem, flights=flights, quantity=peak)
    simulated = first_peaks(scaled)[0]
    lowest, best = _lowest(problem.objective, scaled, first_peaks)
    closed = [None if design is None else known.first_impact(design, scenario) for design, scenario in built]
    at = dict(zip(problem.paths, map(float, problem.values(best)), strict=True))
    gone = _gone(problem.design, known.compliant_parts)
    return PeakForceBound(
        simulated,
        np.array([np.nan if c is None else float(c.elastic_peak) for c in closed]),
        np.array([np.nan if c is None else float(c.effective_energy) for c in closed]),
        lowest,
        {path: value for path, value in at.items() if path not in gone},
        _least(problem, scaled, flights),
        _elasticities(problem, built, simulated, flights),
    )


def _least(
    problem: Problem, scaled: Float[np.ndarray, " variables"], flights: Sequence[Flight | None]
) -> dict[str, LeastValue]:
    """Return the lower bounds of the quantities that have an upper limit and that the first impact alone reaches."""
    known = problem.mechanism.tuning.lower_bound
    assert known is not None
    least = dict[str, LeastValue]()
    for name in problem.limits.at_most:
        if name not in (problem.peak_quantity, *known.quantities):
            continue
        evaluate = functools.partial(_first_impacts, problem, flights=flights, quantity=name)
        # A limit holds in every load case, so that the largest of them counts, whatever the objective makes of them.
        value, best = _lowest(Objective({name: 1.0}), scaled, evaluate)
        if np.isfinite(value) and value > 0.0:
            values, slopes = evaluate(best)
            case = int(np.argmax(values))
            it = LeastValue(value, case, best, slopes[case])
            beneath = not Limit(name, problem.limits.at_most[name]).keeps(value)
            built = built_design(problem, best, problem.cases[case]) if beneath else None
            levers = {} if built is None else _levers(problem, name, value, built, case, flights[case])
            least[name] = it._replace(elasticities=levers)
    return least


def _levers(
    problem: Problem, name: str, least: float, built: Part, case: int, flight: Flight | None
) -> Mapping[str, float]:
    """Return the elasticities of a quantity's lower bound by the numbers of the design that move the first impact: in
    closed form of the peak force where there is one, else by central differences of the first impact.

    **Arguments:** ``least``: the lower bound, of the ``built`` design in a load case.
    """
    known, scenario = problem.mechanism.tuning.lower_bound, problem.cases[case].scenario
    assert known is not None
    closed, alone = known.elasticities(built, scenario), name == problem.peak_quantity
    if closed and alone:
        return closed
    elasticities = dict[str, float]()

    def value(path: str, factor: float) -> float:
        try:
            changed = replace(built, {path: factor * float(get(built, path))})
            run = _first_impact(problem, changed, problem.cases[case], flight, alone, slopes=False)
        except InputError:  # beyond the number's range, or parts that do not fit
            return np.nan
        if run is None:
            return np.nan
        return float(run.peaks[np.argmin(run.slots)] if alone else run.rest[problem.measured_rest.index(name)])

    # A free start has no closed form, which else tells the numbers that move the first impact from the others.
    for path in closed or _numbers(built):
        change = (value(path, 1.0 + STEP) - value(path, 1.0 - STEP)) / (2.0 * STEP * least)
        if abs(change) > NOISE:  # NaN compares as not above
            elasticities[path] = change
    return elasticities


def _numbers(design: Part) -> list[str]:
    """Return the paths of the numbers of a design that a factor changes."""
    values = {path: get(design, path) for path in paths(design)}
    return [path for path, it in values.items() if it and not isinstance(it, (str, bool, int, Curve))]


def _elasticities(
    problem: Problem,
    built: Sequence[tuple[Part | None, Part]],
    simulated: Float[np.ndarray, " cases"],
    flights: Sequence[Flight | None],
) -> Mapping[str, float]:
    """Return the elasticities of the first impact in the load case where it is largest."""
    peak = problem.peak_quantity
    if peak is None or not np.any(simulated > 0.0):  # NaN compares as not above
        return {}
    case = int(np.nanargmax(simulated))
    design, _ = built[case]
    return {} if design is None else _levers(problem, peak, float(simulated[case]), design, case, flights[case])


def _lowest(
    over: Objective,
    scaled: Float[np.ndarray, " variables"],
    evaluate: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
) -> tuple[float, np.ndarray]:
    """Search within the bounds for the least value that load cases put together have, and where it is.

    **Arguments:** ``over``: how they are put together; ``scaled``: where the search begins; ``evaluate``: returns the
    load cases' values and their slopes.
    """
    here = over.aggregate(evaluate(scaled)[0])
    if not np.isfinite(here):
        return np.nan, scaled
    best = (here, scaled)

    def objective(where: np.ndarray) -> tuple[float, np.ndarray]:
        nonlocal best
        values, slopes = evaluate(where)
        weights = over.case_weights(values)
        value, slope = float(weights @ values), weights @ slopes
        # L-BFGS-B takes numbers only: one far above the bound at the start stands for designs that cannot be simulated.
        if not (np.isfinite(value) and np.all(np.isfinite(slope))):
            return FAR * here, np.zeros_like(where)
        # The line search's last point need not be its best, and it may have left the designs that fit.
        best = min(best, (value, where.copy()), key=lambda pair: pair[0])
        return value, slope

    bounds = [(0.0, 1.0)] * len(scaled)
    scipy.optimize.minimize(objective, scaled, jac=True, bounds=bounds, method="L-BFGS-B", tol=1e-6)
    return best


def _first_impacts(
    problem: Problem, scaled: np.ndarray, *, flights: Sequence[Flight | None], quantity: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return a quantity of all load cases in their first impacts, and its slopes by the scaled variables.

    The peak force is that with the buffer gone. A run that is cut off after the first impact has other quantities with
    the buffer as it is, for that may lower them by some per cent: the whole run's largest value is no less. They are
    NaN where a first impact can not be simulated, and 0 where nothing is touched.
    """
    known, values = problem.mechanism.tuning.lower_bound, problem.values(scaled)
    assert known is not None
    alone = quantity == problem.peak_quantity
    # The compliant parts are taken away whatever their variables say, so the bound has no slope by these.
    gone = _gone(problem.design, known.compliant_parts) if alone else {}
    numbers, slopes = np.full(len(problem.cases), np.nan), np.full((len(problem.cases), len(scaled)), np.nan)
    for k, case in enumerate(problem.cases):
        if (built := built_design(problem, scaled, case)) is None:
            continue
        run = _first_impact(problem, built, case, flights[k], alone)
        if run is None:
            continue
        factors = dict(case.factors)
        scale = [
            v.slope(float(x)) * factors.get(v.path, 1.0) * (v.path not in gone)
            for v, x in zip(problem.variables, values, strict=True)
        ]
        if alone:
            first = int(np.argmin(run.slots))  # a run that goes on for longer may have higher peaks
            numbers[k], slope = float(run.peaks[first]), run.peaks_slope[first]
        else:
            place = problem.measured_rest.index(quantity)
            numbers[k], slope = float(run.rest[place]), run.rest_slope[place]
        slopes[k] = slope * np.array(scale)
    return numbers, slopes


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


def _first_impact(
    problem: Problem, built: Part, case: Case, flight: Flight | None, alone: bool = True, slopes: bool = True
) -> Measurement | None:
    """Simulate the first impact of a design, ``alone``, without its buffer, or with it; None where that fails.
    ``slopes``: whether derivatives are wanted.

    Where the buffer takes part in the ``flight`` to it, under thrust say, it stays: it hardly moves within an impact.
    """
    known = problem.mechanism.tuning.lower_bound
    assert known is not None
    without = alone and (flight is None or flight.undisturbed)
    design = _without_softeners(problem, built) if without else built
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
        slopes=slopes,
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
