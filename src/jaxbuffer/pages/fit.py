"""What a page says of a fit: numbers with intervals, residuals, and what the data cannot tell apart."""

import itertools
import math
from collections.abc import Sequence

from ..fields import as_displayed
from ..fitting.fitted import EXPLAINED, FittedNumber, excess_line, number_cells, rows_line, unexplained_line
from ..fitting.intervals import CLOSE
from ..labelled.record import Record
from ..output.folder import Results
from ..value_text import table_text, unit_text
from .page import Cell, PageSection, Table
from .records import figure, sentence, words

NOT_CONVERGED = "the fit has not converged"
NOT_EXPLAINED = "the fit does not explain the test"
ABOVE_NOISE = 1.1  # residual in deviations of the noise, from which on the model lacks something


def fit(results: Results) -> PageSection | None:
    """Return the fitted numbers with their intervals, and how near the model comes to the tests."""
    record = results.records.get("fit")
    if record is None:
        return None
    warnings = [] if record["converged"] else [f"{sentence(NOT_CONVERGED)} These numbers and intervals are no result."]
    if not record["explained"]:
        warnings.append(unexplained_line(_worst(record)))
    elif record["variance_factor"] > 1.0:
        warnings.append(excess_line(record["variance_factor"]))
    warnings += record["doubtful"]
    for clipped, kind in ((True, "clipped"), (False, "outliers")):
        warnings += [rows_line(name, clipped, rows) for name, rows in record[kind].items()]
    warnings += [sentence(line) for line in record["not_told_apart"]]
    warnings += [
        f"{path} lies {it['at_bound'].replace('at ', 'at its ')}: its given range ends there, and with it the interval."
        for path, it in record["parameters"].items()
        if it["at_bound"]
    ]
    tables = [_numbers(record), _residuals(record)]
    if len(record["correlation"]["names"]) > 1:
        tables.append(_correlation(record))
    text = [f"{_counts(record)}."]
    if record["explained"]:
        text = [f"{text[0]} An interval holds the true number in 95 of 100 such tests, if model and noise are right."]
    if not record["not_told_apart"]:
        text.append("The data tell all these numbers apart.")
    caption = "Each column as measured and as fitted, and the residuals in deviations of the noise"
    return PageSection("Fit", text, figure(results, "fit", caption), tables, warnings=warnings)


def fit_badges(results: Results) -> list[Cell]:
    """Return what a reader asks first of a fit: whether it converged, and how near it comes."""
    record = results.records.get("fit")
    if record is None:
        return []
    problem = fit_problem(record)
    cells = [Cell(problem, "bad") if problem else Cell("fit converged", "good")]
    worst = _worst(record)
    near = "" if problem else "good"  # a search that has not ended proves nothing
    mark = near if worst < ABOVE_NOISE else "unsure" if record["explained"] else "bad"
    cells.append(Cell(f"residuals at most {worst:.3g} of the noise", mark))
    if record["not_told_apart"]:
        cells.append(Cell("the data do not tell all numbers", "unsure"))
    return cells


def fit_abstract(results: Results, every: Sequence[Results] = ()) -> str:
    """Return the fitted numbers with their intervals in a sentence; it is the same whatever ``every`` holds."""
    record = results.records.get("fit")
    if record is None:
        return ""
    # Numbers of a search that has not ended are not quoted: they would be read as the result.
    if problem := fit_problem(record):
        return f"{_counts(record)}: {problem}, so that its numbers are no result."
    numbers = (f"{path} {_interval(it)}" for path, it in record["parameters"].items())
    return f"{_counts(record)}, with 95 % intervals: {', '.join(numbers)}."


def fit_problem(record: Record) -> str:
    """Return why a fit's numbers are no result, "" where they are one."""
    if not record["explained"]:
        return NOT_EXPLAINED
    return "" if record["converged"] else NOT_CONVERGED


def _counts(record: Record) -> str:
    tests = [*record["rows"]]
    of = tests[0] if len(tests) == 1 else f"{len(tests)} tests"
    return f"{len(record['parameters'])} numbers fitted to {of}, {sum(record['rows'].values())} rows"


def _interval(it: Record) -> str:
    _, interval, symbol, _ = number_cells(_number(it))
    return f"{interval}{unit_text(symbol)}"


def _number(it: Record) -> FittedNumber:
    return FittedNumber(it["value"], it["low"], it["high"], it["unit"], it["at_bound"])


def _numbers(record: Record) -> Table:
    """Return parameters, then what else was unknown: sensors and trigger."""
    rows: list[list[str | Cell]] = []
    for kind in ("parameters", "nuisance"):
        for name, it in record[kind].items():
            value, interval, symbol, bound = number_cells(_number(it))
            start = as_displayed(it["start"], it["unit"])[0] if "start" in it else None
            of = "the design" if kind == "parameters" else "the test"
            rows.append([name, symbol, table_text(start), value, interval, Cell(bound, "unsure") if bound else of])
    interval = "95 % interval" if record["explained"] else "interval"
    return Table("Fitted numbers", ("number", "unit", "start", "fitted", interval, "of"), rows)


def _residuals(record: Record) -> Table:
    rows: list[list[str | Cell]] = []
    for name, figure_of in record["residual"].items():
        column = record["columns"][name]
        noise, symbol = as_displayed(record["noise"][name], column["unit"])
        bad = figure_of is None or figure_of > EXPLAINED
        mark = "bad" if bad else "good" if figure_of < ABOVE_NOISE else "unsure"
        text = "–" if figure_of is None else f"{figure_of:.3f}"
        rows.append([name, words(column["quantity"]), Cell(text, mark), table_text(noise), symbol])
    headings = ("column", "quantity", "rms / noise", "noise", "unit")
    return Table("Residuals, in deviations of the noise: 1 where noise is all that is left", headings, rows)


def _correlation(record: Record) -> Table:
    """Return each pair of estimates with its correlation, the closest first."""
    names, matrix = record["correlation"]["names"], record["correlation"]["matrix"]
    pairs = [(matrix[i][j], names[i], names[j]) for i, j in itertools.combinations(range(len(names)), 2)]
    rows: list[list[str | Cell]] = [
        [f"{one}, {other}", Cell(f"{value:+.3f}", "unsure" if abs(value) > CLOSE else "")]
        for value, one, other in sorted(pairs, key=lambda pair: -abs(pair[0]))
    ]
    caption = "Correlations of the estimates: near 1 or -1 the data tell only a combination of the two"
    return Table(caption, ("numbers", "correlation"), rows, folded=True)


def _worst(record: Record) -> float:
    # A figure that is no number is of a run that could not be solved.
    return max(math.inf if it is None else it for it in record["residual"].values())
