"""The section of limits: a row for each, and what breaks them."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ..labelled.record import Record
from ..output.folder import Results
from ..tuning.report.levers import lever_title
from ..tuning.report.limit_rows import LimitRow, State, limit_rows
from ..value_text import UNKNOWN, number_text, percent_text
from .limit_check import LimitCheck, breaks, limit_check
from .page import Cell, PageSection, Table
from .records import words

HEADINGS = ("quantity", "unit", "worst", "in scenario", "limit", "margin", "verdict")
BEYOND = ("scenario", "quantity", "unit", "value", "limit", "beyond it")
MANY_BROKEN, MANY_LEVERS = 12, 24  # rows: a longer table is folded
VARIABLE, CHOSEN = ("variable", "no variable"), ("chosen", "not chosen")  # kinds of levers
CELLS: Mapping[State, Cell] = {
    "kept": Cell("kept", "good"),
    "at the limit": Cell("at the limit", "unsure"),
    "broken": Cell("broken", "bad"),
    "not known": Cell("not known", "unsure"),
}
Row = list[str | Cell]


def limits(results: Results, every: Sequence[Results] = (), named: bool = False) -> PageSection | None:
    """Return what the study limits, of the tuning or of the run; None where nothing is limited.

    **Arguments:** ``every``: as of `limit_check`; ``named``: whether the table's caption names the folder.
    """
    check = limit_check(results, every)
    if check is None:
        return None
    sampled = results.tuned is not None and "sample" in results.tuned
    over = "The largest over all samples, no bound," if sampled else "The worst over all scenarios"
    of = "The run" if results.tuned is None else over
    caption = (
        f"{of} against {f'the limits of {check.source_folder}' if check.source_folder else 'the limits of its study'}"
    )
    where = f"{results.folder}: " if named else ""
    record = results.records.get("run") if results.tuned is None else results.tuned
    tables = [Table(f"{where}{caption}", HEADINGS, limit_cells(check)), *lever_tables(results, record, VARIABLE)]
    # A run's warnings stand in its own section, and it has one scenario alone to break a limit in.
    if results.tuned is None:
        return PageSection("Limits", tables=tables)
    warnings = [f"{line[:1].upper()}{line[1:]}." for line in results.tuned["outside_validity"]]
    warnings = [*(f"Limit {line}." for line in results.tuned.get("broken_limits", [])), *warnings]
    if beyond := _beyond(check):
        heading = f"{where}{len(beyond)} times a limit is broken, the worst first"
        tables.append(Table(heading, BEYOND, beyond, folded=len(beyond) > MANY_BROKEN))
        warnings = [_summed(check, beyond), *warnings]
    return PageSection("Limits", warnings=warnings, tables=tables)


def lever_tables(results: Results, record: Record | None, kinds: tuple[str, str]) -> list[Table]:
    """Return the table of the numbers that move each limited quantity of a folder's record most; none where they are
    not known. ``kinds``: what a number is that is varied there, and one that is not."""
    levers = {} if record is None else record.get("levers", {})
    if not levers:
        return []
    known = results.mechanism.quantities
    rows: list[Row] = [
        [lever_title(name, known), it["path"], number_text(it["elasticity"], 2, sign=True), kinds[not it["variable"]]]
        for name, each in levers.items()
        for it in each
    ]
    caption = "Levers: the numbers that move what is limited most, in % for 1 % more of each, where it is decided"
    return [Table(caption, ("quantity", "number", "change [%]", "kind"), rows, folded=len(rows) > MANY_LEVERS)]


class LimitCounts(NamedTuple):
    """How many limits are ``broken``, kept ``at_limit``, and ``unknown``; how many ``runs`` there are, and of these
    ``missed``: ended otherwise than they must; ``success``: how they must end, in a word."""

    broken: int
    at_limit: int
    unknown: int
    missed: int
    runs: int
    success: str | None = None

    @property
    def faults(self) -> int:
        """Return how many faults of both kinds there are."""
        return self.broken + self.missed


def limit_counts(results: Results, every: Sequence[Results] = ()) -> LimitCounts | None:
    """Return how a folder stands to its limits; None where nothing is limited. ``every``: as of `limit_check`."""
    check = limit_check(results, every)
    if check is None:
        return None
    states = [row.state for row in limit_rows(check.limits, check.values, check.labels)]
    broken, at_limit, unknown = (states.count(it) for it in ("broken", "at the limit", "not known"))
    return LimitCounts(broken, at_limit, unknown, len(check.missed), len(check.outcomes), check.success)


def corners_verdict(tuned: Record) -> str:
    """Return in how many corners of what scatters a tuned design holds, where it fails in some; "" elsewhere."""
    corners = tuned.get("corners")
    if corners is None:
        return ""
    if corners["holding"] < corners["run"]:
        return f"holds in {corners['holding']} of {corners['run']} corners only"
    return "" if corners.get("holds", True) else "does not hold in the middle of what scatters"


def fails_in_corners_alone(results: Results, every: Sequence[Results] = ()) -> bool:
    """Return whether a tuned design keeps its limits in every scenario, and not in the corners of what scatters."""
    counts = limit_counts(results, every)
    return bool(results.tuned and corners_verdict(results.tuned)) and (counts is None or not counts.faults)


def limit_cells(check: LimitCheck) -> list[Row]:
    """Return a row for each limit, what stands in the way first, and how runs must end."""
    rows = [_cells(check, row) for row in limit_rows(check.limits, check.values, check.labels)]
    success = check.success
    if success is not None:
        missed, every = check.missed, len(check.outcomes)
        where = check.labels[missed[0]] if missed else "–"
        ends = CELLS["broken" if missed else "kept"]
        end: Row = [words(success), "-", str(every - len(missed)), where, f"of {every}", "–", ends]
        rows.insert(0 if missed else len(rows), end)
    return rows


def _cells(check: LimitCheck, row: LimitRow) -> Row:
    shown = check.display(row.limit.name)
    bound, value = row.limit.bound_text(factor=shown.factor), row.value_text(factor=shown.factor)
    return [shown.title, shown.unit, value, row.where or UNKNOWN, bound, row.room_text, CELLS[row.state]]


def _beyond(check: LimitCheck) -> list[Row]:
    """Return every broken limit of every scenario: first runs that end otherwise than they must, then the farthest
    beyond."""
    success = words(check.success or "")
    missed: list[Row] = [[check.labels[k], "end", "-", words(check.outcomes[k]), success, "–"] for k in check.missed]
    excesses: list[tuple[float, Row]] = []
    for limit in check.limits:
        shown = check.display(limit.name)
        for where, case in zip(check.labels, check.values, strict=True):
            if breaks(case, limit):
                value = case[limit.name]
                share = limit.margin(value)
                by = "–" if share is None else percent_text(-share, ".3g")
                text = LimitRow.of(limit, [case], [where]).value_text(factor=shown.factor)
                bound = limit.bound_text(factor=shown.factor)
                row: Row = [where, shown.title, shown.unit, text, bound, by]
                # Sorted by margin below: the most negative one is the farthest beyond.
                excesses.append((share or 0.0, row))
    return [*missed, *(row for _, row in sorted(excesses, key=lambda it: it[0]))]


def _summed(check: LimitCheck, beyond: Sequence[Row]) -> str:
    """Return in one sentence how many scenarios break which limit."""
    counts = Counter(str(row[1]) if row[1] != "end" else f"not {words(check.success or '')}" for row in beyond)
    text = "; ".join(f"{name} in {count}" for name, count in counts.items())
    return f"Limits are broken, of {len(check.labels)} scenarios: {text}. The table below names them, the worst first."
