"""`fit`: the numbers of a design that measured tests tell."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from .._types import Scalar
from ..errors import InputError, check_type, suggest
from ..fields import Part, get, in_unit, limits_of, unit
from ..mechanisms.registry import mechanism_of
from ..run.request import DEFAULT_TOLERANCE, check_pair
from ..tuning.problem import SCALES, Variable
from .fitted import Comparison, Estimate, Fitted
from .intervals import Uncertainty, not_told_apart, uncertainty
from .prediction import SHIFT, Prediction
from .quantities import recorded_quantities
from .recording import Recording
from .residuals import Block, Minimum, minimum
from .search import FIRST, LAST, MET, Search
from .signals import Parameters

AGAIN = 4  # times that unknown noise is estimated anew
SAME = 0.01  # relative change of a noise at which it is known
EXCESS = 4.0  # deviations of the mean square that noise alone may add
MEDIAN = 1.4826  # of a normal distribution: its deviation over the median of sizes
LATE = 2.0  # intervals between rows by which a record may be longer than its run

Report = Callable[[str], None]


def fit(
    design: Part,
    scenario: Part | None,
    measurements: Recording | Sequence[Recording],
    parameters: Mapping[str, Any],
    *,
    duration: Scalar | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    report: Report = lambda line: None,
) -> Fitted:
    """Fit numbers of a design to measured tests, all together, by least squares.

    Levenberg and Marquardt's method runs on exact derivatives. It begins with the first rows of the records, up to
    shortly after the first impact, and goes on with more and more of them; where it does not come down to the noise
    it begins at further points.

    **Arguments:**

    - ``design``: its own numbers are where the search starts.
    - ``scenario``: of the tests that have none of their own (default: the mechanism's).
    - ``measurements``: a `Recording`, or several of tests of one design.
    - ``parameters``: bounds by path: ``{"buffer.k_A": (100.0, 3000.0)}``, also with units, or with a scale, "linear" or
      "log" (default where the low bound is above zero).
    - ``duration``: after which a run is over [s] (default: the mechanism's).
    - ``rtol``: local error allowed in a step [-].
    - ``report``: is told in a line how far the search is.

    **Returns:** a `Fitted`: estimates with 95 % intervals, residuals, correlation, the fitted design.

    **Raises:** `InputError` for paths, quantities and bounds that are not right, and for a record that is longer than
    its run.

    **Example:** gravity's bar falls as its record says, whatever the spring that it lands on is.

    >>> import numpy as np
    >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.2, history=True)
    >>> sorted(jb.recorded_quantities(jb.BarDrop()))[:2]
    ['bar_acceleration_angle', 'bar_acceleration_x']
    """
    mechanism = mechanism_of(design)
    scenario = mechanism.scenario() if scenario is None else scenario
    recordings = [measurements] if isinstance(measurements, Recording) else list(measurements)
    duration = float(in_unit("duration", mechanism.duration(design) if duration is None else duration, "s"))
    variables = [_variable(design, path, given) for path, given in parameters.items()]
    if not recordings or not variables:
        raise InputError("a fit needs a test and a parameter: fit(design, scenario, [test], {'buffer.k_A': (100, 3000)})")
    predictions = [
        _prediction(design, scenario, recording, [it.path for it in variables], duration, rtol)
        for recording in recordings
    ]
    return Fit(design, scenario, variables, predictions, report).fitted()


def _variable(design: Part, path: str, given: Any) -> Variable:
    """Return a parameter with its bounds, between which the design's own number must lie."""
    if isinstance(given, Variable):
        variable = given
    else:
        parts = list(given) if isinstance(given, (list, tuple)) else []
        scale = parts.pop() if len(parts) == 3 else None
        if len(parts) != 2 or scale not in (None, *SCALES):
            raise InputError(f"{path}: expected two bounds, (100.0, 3000.0) say, and perhaps a scale, found {given!r}")
        variable = Variable(path, *parts)
        if scale is not None:
            variable = dataclasses.replace(variable, scale=scale)
    start = get(design, path)
    variable = variable.read(design)
    if unit(design, path) and start is None:
        raise InputError(f"{path} is not set: give the design a number there, at which the search starts")
    if not unit(design, path):
        raise InputError(f"{path} = {start!r} is not a number that can be fitted")
    low, high = float(variable.low), float(variable.high)
    if variable.scale == "log" and low <= 0.0:
        variable = dataclasses.replace(variable, scale="linear")
    limits = limits_of(design, path)
    for side, end in (("low", low), ("high", high)):
        in_unit(f"{path}: {side} bound", end, unit(design, path), **limits)
    if not low < high:
        raise InputError(f"{path}: the low bound {low:g} must be below the high one, {high:g}")
    if not low <= float(start) <= high:
        raise InputError(f"{path} = {float(start):g} is outside of its bounds {low:g} and {high:g}: the search starts there")
    return dataclasses.replace(variable, low=low, high=high)


def _prediction(
    design: Part, scenario: Part, recording: Recording, paths: Sequence[str], duration: float, rtol: float
) -> Prediction:
    """Return a test's prediction, once its quantities and its length are known to be right."""
    check_type("measurements", recording, Recording, "jb.read_recording(file, channels)")
    own = scenario if recording.scenario is None else recording.scenario
    mechanism = mechanism_of(design)
    check_pair(mechanism, design, own)
    units = recorded_quantities(design, own)
    for column, channel in recording.channels.items():
        if channel.quantity not in units:
            hint = suggest(channel.quantity, units)
            raise InputError(f'{recording.name}: column "{column}": quantity {channel.quantity} is unknown{hint}')
    prediction = Prediction(Parameters(mechanism, design, own, tuple(paths), rtol), recording, units)
    shift = prediction.shift.high if isinstance(prediction.shift, Variable) else prediction.shift
    if (late := int(np.searchsorted(recording.times - shift, duration, side="right"))) < len(recording.times):
        raise InputError(
            f"{where(recording, late)}: the time {recording.times[late]:g} s is after the end of the run at {duration:g} s"
            " (duration in [options])"
        )
    return prediction


def where(recording: Recording, row: int) -> str:
    """Return a row as a message names it: by its line in the file, if it is from one."""
    return f"{recording.name}, line {recording.lines[row]}" if recording.lines else f"{recording.name}, row {row}"


class Fit:
    """One fit under way: its scaled unknowns are those of the design, then each test's own."""

    def __init__(
        self,
        design: Part,
        scenario: Part,
        variables: Sequence[Variable],
        predictions: Sequence[Prediction],
        report: Report,
    ) -> None:
        self.design, self.scenario, self.variables, self.predictions = design, scenario, variables, predictions
        self.report = report
        self.noise = [_noise(it) for it in predictions]
        own = [unknown for it in predictions for unknown in it.unknowns.values()]
        self.unknowns = [*variables, *own]
        self.evaluations = 0
        self._last: tuple[Any, list[Block]] | None = None

    def fitted(self) -> Fitted:
        """Search, and return what is found with its uncertainty."""
        best = self._search()
        best = self._with_noise(best)
        self.check_ends(best.x, 1.0)
        blocks = self.blocks(best.x, 1.0)
        counts = [block.values.shape[1] for block in blocks]
        # What the model does not describe makes estimates less sure than the noise says.
        free = sum(block.values.size for block in blocks) - len(best.x)
        chi = sum(float(np.sum(block.values**2)) for block in blocks) / max(free, 1)
        inflation = chi if chi > 1.0 + EXCESS * np.sqrt(2.0 / max(free, 1)) else 1.0
        self.report("how sure each number is")
        known = uncertainty(lambda x, share: self.blocks(x, share), best, inflation)
        return self._result(best, known, blocks, counts, inflation)

    def _search(self) -> Minimum:
        start = [variable.scaled(float(get(self.design, variable.path))) for variable in self.variables]
        numbers = np.array([float(get(self.design, variable.path)) for variable in self.variables])
        for prediction, noise in zip(self.predictions, self.noise, strict=True):
            for name, unknown in prediction.unknowns.items():
                start.append(0.5)
                if name == SHIFT:
                    shift = prediction.start_shift(numbers, noise, FIRST)
                    start[-1] = unknown.scaled(shift)
                    prediction.begin = max(prediction.begin, shift)

        def told(share: float, chi: float) -> None:
            self.report(f"{share:.0%} of the records, {self.evaluations} runs")

        rows = max(len(it.times) for it in self.predictions)
        return Search(self.blocks, rows, told, self.check_ends)(np.array(start))

    def _with_noise(self, best: Minimum) -> Minimum:
        """Return the minimum with noise that is not known estimated from the residuals."""
        for _ in range(AGAIN):
            changed = 0.0
            for prediction, noise, block in zip(self.predictions, self.noise, self.blocks(best.x, 1.0), strict=True):
                found = np.sqrt(np.mean(block.values**2, axis=1)) * noise
                for k, sensor in enumerate(prediction.sensors.values()):
                    if sensor.noise is None:
                        changed = max(changed, abs(found[k] / noise[k] - 1.0))
                        noise[k] = found[k]
            if changed < SAME:
                break
            self._last = None
            best = minimum(self.blocks, best.x, 1.0, tolerance=LAST)
        return best

    def blocks(self, x: np.ndarray, share: float) -> list[Block]:
        """Return the residuals of the tests, with slopes by all scaled unknowns."""
        key = (x.tobytes(), share)
        if self._last is not None and self._last[0] == key:
            return self._last[1]
        values = np.array([it.value(float(s)) for it, s in zip(self.unknowns, x, strict=True)])
        stretch = np.array([it.slope(float(v)) for it, v in zip(self.unknowns, values, strict=True)])
        count, first, found = len(self.variables), len(self.variables), []
        for prediction, noise in zip(self.predictions, self.noise, strict=True):
            mine = slice(first, first + len(prediction.unknowns))
            block = prediction.block(values[:count], values[mine], share, noise)
            slopes = np.zeros((*block.values.shape, len(x)))
            slopes[..., :count], slopes[..., mine] = block.slopes[..., :count], block.slopes[..., count:]
            residuals = np.where(np.isfinite(block.values), block.values, np.inf)
            found.append(Block(residuals, np.nan_to_num(slopes * stretch, nan=0.0, posinf=0.0, neginf=0.0)))
            first = mine.stop
            self.evaluations += 1
        self._last = key, found
        return found

    def check_ends(self, x: np.ndarray, share: float) -> None:
        """Raise `InputError` for a record that goes on, up to a share, after a run that meets it has ended."""
        self._last = None
        first = len(self.variables)
        for prediction, block in zip(self.predictions, self.blocks(x, share), strict=True):
            names, times = list(prediction.unknowns), prediction.times[: block.values.shape[1]]
            shift = prediction.shift
            if isinstance(shift, Variable):
                shift = shift.value(float(x[first + names.index(SHIFT)]))
            first += len(names)
            end = prediction.end_time + shift
            late = int(np.searchsorted(times, end + LATE * float(np.median(np.diff(times))), side="right"))
            met = late > 0 and float(np.mean(block.values[:, :late] ** 2)) < MET
            if late < len(times) and met and not prediction.failed:
                raise InputError(
                    f"{where(prediction.recording, late)}: the time {times[late]:g} s is after the end of the run that"
                    f" fits the rows before it, at {end:g} s of the record; leave out the rows from there on"
                )

    def _result(
        self, best: Minimum, known: Uncertainty, blocks: list[Block], counts: list[int], inflation: float
    ) -> Fitted:
        estimates = [
            Estimate(
                value=it.value(float(x)),
                low=it.value(float(low)),
                high=it.value(float(high)),
                unit=unit(self.design, it.path) if k < len(self.variables) else _own_unit(it.path),
                at_bound=it.at_bound(it.value(float(x))),
            )
            for k, (it, x, low, high) in enumerate(zip(self.unknowns, best.x, known.low, known.high, strict=True))
        ]
        count = len(self.variables)
        parameters = {it.path: one for it, one in zip(self.variables, estimates[:count], strict=True)}
        nuisance: dict[str, dict[str, Estimate]] = {}
        rest = iter(estimates[count:])
        residual, noise, records = {}, {}, {}
        names = list(parameters)
        for prediction, sigma, block in zip(self.predictions, self.noise, blocks, strict=True):
            test = prediction.recording.name
            nuisance[test] = {name: next(rest) for name in prediction.unknowns}
            names += [f"{test}: {name}" for name in prediction.unknowns]
            figures = np.sqrt(np.mean(block.values**2, axis=1))
            residual[test] = dict(zip(prediction.sensors, map(float, figures), strict=True))
            noise[test] = dict(zip(prediction.sensors, map(float, sigma), strict=True))
            quantities = tuple(it.quantity for it in prediction.sensors.values())
            records[test] = Comparison(
                columns=tuple(prediction.sensors),
                quantities=quantities,
                units=tuple(prediction.units[it] for it in quantities),
                times=prediction.times,
                measured=prediction.values,
                fitted=prediction.values + block.values * sigma[:, None],
            )
        return Fitted(
            start=self.design,
            scenario=self.scenario,
            parameters=parameters,
            nuisance=nuisance,
            residual=residual,
            noise=noise,
            names=tuple(names),
            correlation=known.correlation,
            not_told_apart=tuple(not_told_apart(names, known)),
            inflation=float(inflation),
            rows=dict(zip(residual, counts, strict=True)),
            records=records,
            evaluations=self.evaluations,
            converged=bool(best.converged and np.all(np.isfinite(known.deviations))),
        )


def _own_unit(path: str) -> str:
    return "-" if path.endswith("gain") else "s"


def _noise(prediction: Prediction) -> np.ndarray:
    """Return the deviation of each column's noise; where it is not known, that of its second differences."""
    noise = []
    for sensor, values in zip(prediction.sensors.values(), prediction.values, strict=True):
        if sensor.noise is not None:
            noise.append(sensor.noise)
            continue
        # Impacts are few: the median does not see them. A record without noise has the rounding of its digits.
        rough = MEDIAN * float(np.median(np.abs(np.diff(values, 2)))) / np.sqrt(6.0) if len(values) > 2 else 0.0
        noise.append(max(rough, 1e-6 * float(np.max(np.abs(values))), 1e-300))
    return np.array(noise)
