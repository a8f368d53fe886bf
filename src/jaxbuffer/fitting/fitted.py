"""What a fit has found."""

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from ..fields import Part, as_displayed, get, replace
from ..labelled.saved import Saved
from ..tables import table, text
from ..value_text import unit_text

EXPLAINED = 3.0  # deviations of the noise, above which a column's residual leaves its test unexplained
LISTED = 20  # rows that a summary lists
STICKING_OUT = "stick out by more than five deviations, and weigh less"
LONGEST = 8  # decimals of a fitted number in a table


RowsByColumn = Mapping[str, Mapping[str, tuple[int, ...]]]


class FittedNumber(NamedTuple):
    """A fitted number: its ``value`` with the ends ``low`` and ``high`` of its 95 % interval, in SI units, its
    ``unit``, and whether it lies "at low bound" or "at high bound", else ""."""

    value: float
    low: float
    high: float
    unit: str
    at_bound: str = ""


class RecordBesideFit(NamedTuple):
    """A test beside its fit: ``columns``, the ``quantities`` that they recorded and their ``units``; ``times`` [s] of
    the record; ``measured`` and ``fitted`` (columns, rows), and which rows are ``clipped`` and left out."""

    columns: tuple[str, ...]
    quantities: tuple[str, ...]
    units: tuple[str, ...]
    times: Float[np.ndarray, " rows"]
    measured: Float[np.ndarray, "columns rows"]
    fitted: Float[np.ndarray, "columns rows"]
    clipped: Bool[np.ndarray, "columns rows"]

    def residual(self, k: int, noise: float) -> Float[np.ndarray, " rows"]:
        """Return the residuals of column k over its noise [-], NaN of rows that are left out."""
        return np.where(self.clipped[k], np.nan, (self.measured[k] - self.fitted[k]) / noise)


@dataclasses.dataclass(frozen=True)
class Fitted(Saved):
    """A fitted design. Print it for its tables.

    - ``design``: with the fitted numbers; ``start``: that the search began with; ``scenario``: of tests without one.
    - ``parameters``: a `FittedNumber` for each path.
    - ``nuisance``: by test, what is unknown of its sensors: "time_shift" [s], "COLUMN: gain" [-], "COLUMN: offset" in
      the quantity's unit, "COLUMN: filter" and "COLUMN: delay" [s].
    - ``residual``: by test and column, the root mean square of measured less fitted, in deviations of the noise [-].
    - ``noise``: by test and column, that deviation in SI units, given or estimated.
    - ``names``: of all unknowns; ``correlation`` of their estimates, a matrix in this order.
    - ``not_told_apart``: what the data say next to nothing of, and pairs that they hardly tell apart, a line each.
    - ``inflation``: of the variances, where the residuals exceed the noise; else 1.
    - ``records``: by test, what was measured beside what the fitted design gives.
    - ``rows`` of each test; ``evaluations``: runs with derivatives; ``converged``: whether the search came to an end.
    - ``outliers``: by test and column, rows that stick out by more than five deviations and so weigh less; ``clipped``:
      rows at the end of a sensor's range, which are left out. Numbers are those of lines in the test's file, if any.
    - ``doubtful``: where the tests are not explained, a line for each column whose unit or sign may be another.

    **Example:** the tables of a fit of two numbers, as `fit` returns it.

    >>> import dataclasses
    >>> [field.name for field in dataclasses.fields(jb.Fitted)][2:5]
    ['parameters', 'nuisance', 'residual']
    """

    start: Part
    scenario: Part
    parameters: Mapping[str, FittedNumber]
    nuisance: Mapping[str, Mapping[str, FittedNumber]]
    residual: Mapping[str, Mapping[str, float]]
    noise: Mapping[str, Mapping[str, float]]
    names: tuple[str, ...]
    correlation: Float[np.ndarray, "unknowns unknowns"]
    not_told_apart: tuple[str, ...]
    inflation: float
    rows: Mapping[str, int]
    records: Mapping[str, RecordBesideFit]
    evaluations: int
    converged: bool
    doubtful: tuple[str, ...] = ()
    outliers: RowsByColumn = dataclasses.field(default_factory=dict)
    clipped: RowsByColumn = dataclasses.field(default_factory=dict)

    @property
    def explained(self) -> bool:
        """Return whether the fitted design explains the tests: no column's residual is above three deviations."""
        return self.largest_residual <= EXPLAINED

    @property
    def largest_residual(self) -> float:
        """Return the largest `residual` of a column [-]; infinite where one is no number."""
        figures = [figure for columns in self.residual.values() for figure in columns.values()]
        return max(figures) if np.all(np.isfinite(figures)) else float("inf")

    @property
    def verdict(self) -> str:
        """Return in a few words whether the search came to an end that explains the tests."""
        if not self.explained:
            return "test NOT explained"
        return "converged" if self.converged else "NOT converged"

    @property
    def interval_name(self) -> str:
        """Return what the intervals are called: of 95 % only where the tests are explained."""
        return "95 % interval" if self.explained else "interval"

    @property
    def design(self) -> Any:
        """Return the design with the fitted numbers."""
        return replace(self.start, {path: it.value for path, it in self.parameters.items()})

    def own_name(self, test: str, name: str) -> str:
        """Return the name of a column or an unknown of a test: with several tests it begins with the test's."""
        return name if len(self.rows) == 1 else f"{test}: {name}"

    def unlike_rows(self) -> Iterator[tuple[str, str, bool, tuple[int, ...]]]:
        """Yield test, column, whether they are clipped, and the rows that are left out or weigh less."""
        for clipped, table_of_rows in ((True, self.clipped), (False, self.outliers)):
            for test, columns in table_of_rows.items():
                for column, rows in columns.items():
                    yield test, column, clipped, rows

    def __repr__(self) -> str:
        tests = "1 test" if len(self.rows) == 1 else f"{len(self.rows)} tests"
        rows = sum(self.rows.values())
        lines: list[Any] = [f"Fit to {tests}, {rows} rows: {self.verdict} after {self.evaluations} runs"]
        shown = table("Fitted numbers", ("number",), ("start", "fitted", self.interval_name, "unit", ""))
        for path, it in self.parameters.items():
            shown.add_row(path, f"{float(get(self.start, path)):.5g}", *number_cells(it))
        for test, own in self.nuisance.items():
            for name, it in own.items():
                shown.add_row(self.own_name(test, name), "", *number_cells(it))
        lines.append(shown)
        met = table("Residuals", ("test", "column"), ("rms / noise", "noise", "unit"))
        for test, columns in self.residual.items():
            for column, figure in columns.items():
                unit = dict(zip(self.records[test].columns, self.records[test].units, strict=True))[column]
                noise, symbol = as_displayed(self.noise[test][column], unit)
                met.add_row(test, column, f"{figure:.3f}", f"{noise:.3g}", unit_text(symbol, ""))
        lines.append(met)
        for test, column, clipped, lines_of in self.unlike_rows():
            lines.append(rows_line(self.own_name(test, column), clipped, lines_of))
        if not self.explained:
            lines.append(unexplained_line(self.largest_residual))
        elif self.inflation > 1.0:
            lines.append(excess_line(self.inflation))
        lines += [*self.doubtful, *self.not_told_apart]
        return text(*lines)


def rows_line(name: str, clipped: bool, rows: Sequence[int]) -> str:
    """Return what is said of rows of a column that are ``clipped``, or else stick out."""
    how = "have the column's extreme value: clipped, and left out" if clipped else STICKING_OUT
    more = f" and {len(rows) - LISTED} more" if len(rows) > LISTED else ""
    return f"{name}: {len(rows)} rows {how}: {', '.join(map(str, rows[:LISTED]))}{more}."


def unexplained_line(residual: float) -> str:
    """Return what a ``residual`` far above the noise means."""
    return (
        f"The residuals come to {residual:.3g} deviations of the noise: the model does not explain the test,"
        " and these numbers and intervals are no result."
    )


def excess_line(inflation: float) -> str:
    """Return what residuals above the noise mean. ``inflation``: of the variances."""
    return (
        "The residuals exceed the noise: the model lacks something, and the intervals are"
        f" {inflation**0.5:.2g} times as wide as noise alone makes them."
    )


def number_cells(it: FittedNumber) -> tuple[str, ...]:
    """Return value, interval, unit and bound as they stand in a table, with as many decimals as the interval tells."""
    value, symbol = as_displayed(it.value, it.unit)
    low, high = (as_displayed(end, it.unit)[0] for end in (it.low, it.high))
    # Three digits of the interval's width, as many decimals in all three numbers.
    width = max(high - low, 1e-12 * abs(value), 1e-300)
    decimals = 2 - int(np.floor(np.log10(width))) if np.isfinite(width) else LONGEST + 1
    # With "z" a negative number that is rounded to zero is shown without its sign.
    digits = f"z.{max(decimals, 0)}f" if decimals <= LONGEST else ".6g"
    return f"{value:{digits}}", f"{low:{digits}} to {high:{digits}}", unit_text(symbol, ""), it.at_bound
