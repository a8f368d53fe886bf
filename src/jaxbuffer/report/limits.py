"""Results against limits: the worst value of each limited quantity, its margin, kept or broken."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..mechanisms.mechanism import Mechanism
from ..output.folder import Record, Results
from .page import Cell, Section, Table, shown
from .records import ROUNDING, by_name, in_figures, words

SHOWN = 12  # broken limits by scenario
HEADINGS = ("quantity", "unit", "worst", "limit", "margin", "verdict")


def limits(found: Results) -> Section | None:
    """What the study limits, of the tuning or of the run; None where nothing is limited."""
    tuned, run = found.tuned, found.records.get("run")
    if tuned is not None:
        return _of_tuning(found.mechanism, tuned)
    if run is None or not (run.get("limits") or run.get("lower_limits")):
        return None
    rows = _rows(found.mechanism, run, [run["limited"]], [run["outcome"]], [len(run["impacts"])])
    return Section("Limits", tables=[Table("The run against its study's limits", HEADINGS, rows)])


def _of_tuning(mechanism: Mechanism, tuned: Record) -> Section:
    cases = [case["after"] for case in tuned["scenarios"]]
    outcomes, impacts = ([case[name] for case in cases] for name in ("outcome", "impacts"))
    rows = _rows(mechanism, tuned, [by_name(case) for case in cases], outcomes, impacts)
    said = [f"{line[:1].upper()}{line[1:]}." for line in tuned["outside_validity"]]
    why = [f"Limit {line}." for line in tuned.get("why", [])]
    broken = [f"Broken: {line}." for line in tuned["broken"][:SHOWN]]
    broken += [f"And {len(tuned['broken']) - SHOWN} more." for _ in tuned["broken"][SHOWN : SHOWN + 1]]
    return Section(
        "Limits", warnings=[*why, *broken, *said], tables=[Table("Worst over all scenarios", HEADINGS, rows)]
    )


def _rows(
    mechanism: Mechanism,
    record: Record,
    values: Sequence[Mapping[str, Any]],
    outcomes: Sequence[str],
    impacts: Sequence[int],
) -> list[list[str | Cell]]:
    """A row for each upper limit, each lower one, the number of impacts, and how runs must end."""
    titles = lambda name: in_figures(mechanism, name, record.get("quantities", {}))  # noqa: E731
    always = {name: limit for name, limit in mechanism.always.items() if name in values[0]}
    rows: list[list[str | Cell]] = []
    for name, limit in {**always, **record["limits"]}.items():
        rows.append(_row(titles(name), worst([case[name] for case in values]), limit))
    for name, limit in record.get("lower_limits", {}).items():
        rows.append(_row(titles(name), worst([case[name] for case in values], lowest=True), limit, lowest=True))
    if (most := record.get("most_impacts")) is not None:
        rows.append(["impacts", "-", str(max(impacts)), f"≤ {most}", "–", _verdict(max(impacts) <= most)])
    if mechanism.success is not None:
        count = sum(outcome == mechanism.success for outcome in outcomes)
        every = len(outcomes)
        ends = f"{mechanism.run_name}s that end {words(mechanism.success)}"
        rows.append([ends, "-", str(count), f"of {every}", "–", _verdict(count == every)])
    return rows


def worst(values: Sequence[float | None], lowest: bool = False) -> float | None:
    """The largest of some values, or the ``lowest``; None where one is not known."""
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return None
    return min(known) if lowest else max(known)


def _row(title: tuple[str, str, float], value: float | None, limit: float, lowest: bool = False) -> list[str | Cell]:
    name, symbol, factor = title
    share = None if value is None else (value / limit - 1.0) if lowest else (1.0 - value / limit)
    margin, of = ("–" if share is None else f"{100 * share:.3g} %"), None if value is None else factor * value
    verdict = _verdict(not broken(value, limit, lowest))
    return [name, symbol, shown(of), f"{'≥' if lowest else '≤'} {shown(factor * limit)}", margin, verdict]


def broken(value: float | None, limit: float | None, lowest: bool = False) -> bool:
    """Whether a value is beyond its limit, rounding aside; one that is not known is."""
    if limit is None:
        return False
    if value is None:
        return True
    return value < limit * (1.0 - ROUNDING) if lowest else value > limit * (1.0 + ROUNDING)


def _verdict(good: bool) -> Cell:
    return Cell("kept", "good") if good else Cell("broken", "bad")
