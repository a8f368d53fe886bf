"""One fit under way: the search, the noise, how sure the numbers are, and what comes of them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import InputError
from ..fields import Part, get, unit
from ..tuning.problem.variable import Variable
from .factors import doubts
from .fitted import Fitted, FittedNumber, RecordBesideFit, RowsByColumn
from .intervals import Uncertainty, not_told_apart, uncertainty
from .prediction import SHIFT, Prediction
from .recording import Recording
from .residuals import Block, LeastSquares, mean_squares, minimum, outliers
from .search import FIRST, LAST, MET, StagedSearch

LARGEST_NOISE = 0.1  # of a column's own deviation: an estimate above it is no noise but what the model lacks
AGAIN = 4  # times that unknown noise is estimated anew
SAME = 0.01  # relative change of a noise at which it is known
EXCESS = 4.0  # deviations of the mean square that noise alone may add
LATE = 2.0  # intervals between rows by which a record may be longer than its run

Report = Callable[[str], None]


class Estimation:
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
        self.noise = [it.noise() for it in predictions]
        own = [unknown for it in predictions for unknown in it.unknowns.values()]
        self.unknowns = [*variables, *own]
        self.evaluations = 0
        self.doubtful: list[str] = []
        self._last: tuple[Any, list[Block]] | None = None

    def fitted(self) -> Fitted:
        """Search, and return what is found with its uncertainty."""
        best = self._search()
        best = self._with_noise(best)
        # The stages look at a run's end only where they miss the noise, so the whole records are checked here.
        self.check_ends(best.x, 1.0)
        blocks = self.blocks(best.x, 1.0)
        # What the model does not describe makes estimates less sure than the noise says.
        counts = [
            np.sum(~(it.clipped | outliers(block.values)), axis=1)
            for it, block in zip(self.predictions, blocks, strict=True)
        ]
        free = sum(int(np.sum(it)) for it in counts) - len(best.x)
        squares = [
            float(mean_squares(block.values, ~it.clipped) @ count)
            for it, block, count in zip(self.predictions, blocks, counts, strict=True)
        ]
        chi = sum(squares) / max(free, 1)
        # The mean square of n residuals of noise scatters by √(2/n): a little above one is no sign of a poor model.
        inflation = chi if chi > 1.0 + EXCESS * np.sqrt(2.0 / max(free, 1)) else 1.0
        self.report("how sure each number is")
        known = uncertainty(self.blocks, best, inflation)
        fitted = self._result(best, known, blocks, inflation)
        return fitted if fitted.explained else replace(fitted, doubtful=tuple(self.doubtful or self._doubts(best.x)))

    def _search(self) -> LeastSquares:
        start = [variable.scaled(float(get(self.design, variable.path))) for variable in self.variables]
        numbers = np.array([float(get(self.design, variable.path)) for variable in self.variables])
        for prediction, noise in zip(self.predictions, self.noise, strict=True):
            for name, unknown in prediction.unknowns.items():
                start.append(0.5)
                if name == SHIFT:
                    shift = prediction.start_shift(numbers, noise, FIRST)
                    start[-1] = unknown.scaled(shift)
                    # Before the shift the run is taken to stand still, so shares of the record count from there.
                    prediction.begin = max(prediction.begin, shift)

        # At the start, because a search that tries to meet a column in another unit ends far from any sensible design.
        self.doubtful = self._doubts(np.array(start))

        def told(share: float, chi: float) -> None:
            # A doubt is said before the search ends, which may take long where there is one.
            self.report("; ".join([f"{share:.0%} of the records, {self.evaluations} runs", *self.doubtful]))

        rows = max(len(it.times) for it in self.predictions)
        return StagedSearch(self.blocks, rows, told, self.check_ends)(np.array(start))

    def _rows(self, marks: Sequence[np.ndarray]) -> RowsByColumn:
        """Return rows that are marked in each test, by test and column; without columns that have none."""
        result = {}
        for prediction, mark in zip(self.predictions, marks, strict=True):
            columns = zip(prediction.sensors, mark, strict=True)
            result[prediction.recording.name] = {
                name: _numbers(prediction.recording, rows) for name, rows in columns if np.any(rows)
            }
        return {test: columns for test, columns in result.items() if columns}

    def _doubts(self, x: np.ndarray) -> list[str]:
        """Return a line for each column whose unit or sign may be another, from what a point gives."""
        lines: list[str] = []
        for prediction, simulated in zip(self.predictions, self._simulated(x), strict=True):
            lines += doubts(prediction, simulated, self.design)
        return lines

    def _simulated(self, x: np.ndarray) -> list[np.ndarray]:
        """Return what the model gives for the columns of each test at a point, also in rows that are left out: their
        residuals are no difference."""
        values = np.array([it.value(float(s)) for it, s in zip(self.unknowns, x, strict=True)])
        first, made = len(self.variables), []
        for prediction in self.predictions:
            own = values[first : first + len(prediction.unknowns)]
            made.append(prediction(values[: len(self.variables)], own, 1.0)[0])
            first += len(own)
        return made

    def _with_noise(self, best: LeastSquares) -> LeastSquares:
        """Return the minimum with noise that is not known estimated from the residuals."""
        most = [
            np.maximum(noise, LARGEST_NOISE * np.std(it.values, axis=1))
            for it, noise in zip(self.predictions, self.noise, strict=True)
        ]
        # Minimum and noise depend on each other: a column with less noise weighs more and moves the minimum.
        for _ in range(AGAIN):
            changed = 0.0
            each = zip(self.predictions, self.noise, most, self.blocks(best.x, 1.0), strict=True)
            for prediction, noise, largest, block in each:
                found = np.minimum(np.sqrt(mean_squares(block.values, ~prediction.clipped)) * noise, largest)
                for k, sensor in enumerate(prediction.sensors.values()):
                    if sensor.noise is None:
                        changed = max(changed, abs(found[k] / noise[k] - 1.0))
                        noise[k] = found[k]
            if changed < SAME:
                break
            # The residuals that are kept are over the noise of before.
            self._last = None
            best = minimum(self.blocks, best.x, 1.0, tolerance=LAST)
        return best

    def blocks(self, x: np.ndarray, share: float) -> list[Block]:
        """Return the residuals of the tests, with slopes by all scaled unknowns."""
        # Searches ask again for the point at which they ended, and a run with derivatives is not to be made twice.
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
            # A residual without a number makes its point worse than any other, where NaN would compare as neither.
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
            rows = block.values[:, :late], ~prediction.clipped[:, :late]
            met = late > 0 and float(np.mean(mean_squares(*rows))) < MET
            if late < len(times) and met and not prediction.failed:
                raise InputError(
                    f"{prediction.recording.row(late)}: the time {times[late]:g} s is after the end of the run that"
                    f" fits the rows before it, at {end:g} s of the record; leave out the rows from there on"
                )

    def _result(self, best: LeastSquares, known: Uncertainty, blocks: list[Block], inflation: float) -> Fitted:
        units = [unit(self.design, it.path) for it in self.variables]
        units += [symbol for it in self.predictions for symbol in it.own_units.values()]
        estimates = [
            FittedNumber(
                value=it.value(float(x)),
                low=it.value(float(low)),
                high=it.value(float(high)),
                unit=symbol,
                at_bound=it.at_bound(it.value(float(x))),
            )
            for it, symbol, x, low, high in zip(self.unknowns, units, best.x, known.low, known.high, strict=True)
        ]
        count = len(self.variables)
        parameters = {it.path: one for it, one in zip(self.variables, estimates[:count], strict=True)}
        rest = iter(estimates[count:])
        nuisance = {it.recording.name: {name: next(rest) for name in it.unknowns} for it in self.predictions}
        names = [*parameters, *(f"{test}: {name}" for test, own in nuisance.items() for name in own)]
        residual, noise, records = {}, {}, {}
        each = zip(self.predictions, self.noise, blocks, self._simulated(best.x), strict=True)
        for prediction, sigma, block, simulated in each:
            test, figures = prediction.recording.name, np.sqrt(mean_squares(block.values, ~prediction.clipped))
            residual[test] = dict(zip(prediction.sensors, map(float, figures), strict=True))
            noise[test] = dict(zip(prediction.sensors, map(float, sigma), strict=True))
            records[test] = _compared(prediction, simulated)
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
            outliers=self._rows([outliers(block.values) for block in blocks]),
            clipped=self._rows([it.clipped for it in self.predictions]),
            rows={test: len(record.times) for test, record in records.items()},
            records=records,
            evaluations=self.evaluations,
            converged=bool(best.converged and np.all(np.isfinite(known.deviations))),
        )


def _numbers(recording: Recording, rows: np.ndarray) -> tuple[int, ...]:
    """Return rows by their lines in the file, or by their places where there is none."""
    places = np.flatnonzero(rows).tolist()
    return tuple(recording.lines[k] for k in places) if recording.lines else tuple(places)


def _compared(prediction: Prediction, simulated: np.ndarray) -> RecordBesideFit:
    """Return a test beside what the fitted model gives for its columns."""
    quantities = tuple(it.quantity for it in prediction.sensors.values())
    return RecordBesideFit(
        columns=tuple(prediction.sensors),
        quantities=quantities,
        units=tuple(prediction.units[it] for it in quantities),
        times=prediction.times,
        measured=prediction.values,
        fitted=simulated,
        clipped=prediction.clipped,
    )
