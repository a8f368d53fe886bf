"""What a page says of sensitivities: elasticities, how sure they are, and what would break a limit."""

import math
from collections.abc import Mapping, Sequence

from ..fields import display_unit
from ..labelled.record import Record
from ..mechanisms.limit import Limit
from ..mechanisms.mechanism import Mechanism
from ..output.folder import Results
from ..sensitivities.evidence import FLOOR
from ..value_text import percent_text, quotient_unit, table_text
from .designs import other_design
from .limit_check import limits_of, source_of_limits
from .page import Cell, PageSection, Table
from .records import by_quantity, display, elsewhere, figure, scenario_of, title, words

MARKS = {"trusted": "good", "check": "unsure", "refused": "bad"}
FAR = 0.5  # relative change beyond which first order says little
Rows = Mapping[str, Sequence[Record]]  # derivatives by quantity


def sensitivity(results: Results, first: Results, every: Sequence[Results] = ()) -> PageSection | None:
    """Return elasticities with their verdicts, at one scenario.

    **Arguments:** ``first``: the page's folder; ``every``: all of them, of which the first with limits says what is
    limited.
    """
    record = results.sensitivity
    if record is None:
        return None
    derivatives = by_quantity(record["derivatives"])
    # What can change sign has no elasticities.
    signed = {name: rows for name, rows in derivatives.items() if all(row["elasticity"] is None for row in rows)}
    relative = {name: rows for name, rows in derivatives.items() if name not in signed}
    tables = [_elasticities(results, relative)] if relative else []
    tables += _slopes(results.mechanism, {title(results.mechanism, name): rows for name, rows in signed.items()})
    tables += _until_broken(results, relative, source_of_limits([results, first, *every]))
    figures = figure(results, "sensitivity", "Elasticities as bars, with their estimated errors")
    return PageSection("Sensitivity", _text(results, first, record), figures, tables)


def _text(results: Results, first: Results, record: Record) -> list[str]:
    """Return where they were computed, how sure they are, and which other impact may become the peak."""
    mechanism, certificate = results.mechanism, record["certificate"]
    text = [f"At {mechanism.view.label(scenario_of(mechanism, record['scenario']))}; {words(record['outcome'])}."]
    text += [*other_design(results, first, record), *elsewhere(first, record["scenario"])]
    if certificate is None:
        return text
    text.append(
        f"Certificate: {certificate['verdict']}; {certificate['reason']}. Errors are relative to the elasticity, those"
        f" below {FLOOR:g} counting as {FLOOR:g}."
    )
    other = certificate.get("runner_up")
    if other is None:
        return text
    second = f"The second largest impact is number {other['impact']} with {other['force']:.4g} N,"
    second += f" {percent_text(other['margin'], '.3g')} below the peak"
    path, change = other["swapped_by"], other["swapped_by_change"]
    if path is not None and change is not None:
        second += f"; to first order {path} {percent_text(change, '+.3g')} would make it the peak, whose elasticities"
        second += " are others"
        second += "; so far that only the direction counts" if abs(change) > FAR else ""
    return [*text, f"{second}."]


def _elasticities(results: Results, of_quantity: Rows) -> Table:
    rows: list[list[str | Cell]] = []
    for name, derivatives in of_quantity.items():
        verdict = derivatives[0]["verdict"] or "not certified"
        errors = [row["estimated_error"] for row in derivatives if row["estimated_error"] is not None]
        worst = f"{max(errors):.1e}" if errors else "–"
        values = [table_text(row["elasticity"]) for row in derivatives]
        rows.append([title(results.mechanism, name), *values, worst, Cell(verdict, MARKS.get(verdict, ""))])
    parameters = [row["parameter"] for row in next(iter(of_quantity.values()))]
    caption = "Elasticities: by how many per cent a quantity grows for one per cent of a number"
    return Table(caption, ("quantity", *parameters, "error at most", "verdict"), rows)


def _until_broken(results: Results, of_quantity: Rows, source: Record | None) -> list[Table]:
    """Return for each limited quantity the number whose smallest relative change breaks the limit, to first order."""
    if source is None or results.sensitivity is None:
        return []
    rows: list[list[str | Cell]] = []
    # Only of quantities with elasticities, which a relative change to the limit is told from.
    for limit in limits_of(results.mechanism, source, of_quantity):
        shown, value = display(results.mechanism, limit.name), results.sensitivity[limit.name]
        verdict = None if limit.keeps(value) else Cell("broken here", "bad")
        verdict = verdict or _smallest(value, limit, of_quantity[limit.name])
        rows.append([shown.title, shown.unit, shown.text(value), limit.bound_text(factor=shown.factor), verdict])
    headings = ("quantity", "unit", "here", "limit", "what breaks it")
    caption = "What smallest change of a number breaks a limit in this scenario, to first order"
    return [Table(caption, headings, rows)] if rows else []


def _smallest(value: float, limit: Limit, rows: Sequence[Record]) -> Cell:
    """Return the number that alone would have to change least, by (limit / value - 1) / elasticity."""
    # Without a value or an elasticity no relative change leads to the limit.
    known = [row for row in rows if value and row["elasticity"]]
    changes = [((limit.bound / value - 1.0) / row["elasticity"], row["parameter"]) for row in known]
    # Where none is known the default lies beyond what is told, and the text is the same.
    change, path = min(changes, key=lambda it: abs(it[0]), default=(math.inf, ""))
    if abs(change) > FAR:
        return Cell(f"no number alone by less than {percent_text(FAR, 'g')}")
    return Cell(f"{path} {percent_text(change, '+.3g')}")


def _slope(mechanism: Mechanism, row: Record) -> tuple[str, str]:
    """Return a derivative and its unit, as people are shown them."""
    _, above, factor = display(mechanism, row["quantity"])
    below, many = display_unit(row["parameter_unit"])
    return table_text(None if row["gradient"] is None else factor / many * row["gradient"]), quotient_unit(above, below)


def _slopes(mechanism: Mechanism, signed: Rows) -> list[Table]:
    """Return derivatives of quantities that have no elasticities."""
    rows = [
        [name, row["parameter"], *_slope(mechanism, row), row["verdict"] or "not certified"]
        for name, derivatives in signed.items()
        for row in derivatives
    ]
    headings = ("quantity", "by", "derivative", "unit", "verdict")
    return [Table("Derivatives of what can change sign", headings, rows)] if rows else []
