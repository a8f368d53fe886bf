"""Tunings side by side: scenario by scenario, and where they are held against different limits."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..fields import paths, unit
from ..mechanisms.mechanism import Mechanism
from ..output.folder import Record, Results
from .judged import case_labels, judged
from .limits import Limit, asked_limits, broken, keeping
from .page import Cell, Table, shown
from .records import by_name, in_figures, scenario_of, words

Known = tuple[float | None, bool, bool]  # a value, whether it breaks its limit, whether its run keeps all limits
UNKNOWN: Known = (None, False, False)
COLOURS = "Red: a limit is broken. Green: the lowest of a scenario, where its run keeps all limits."


def differing(every: Sequence[Results]) -> list[str]:
    """A text for each quantity on which the folders' limits differ: "buffer stroke: before ≤ 30 mm, after ≤ 25 mm"."""
    limits = [_limits(found, every) for found in every]
    told = []
    for key in dict.fromkeys(key for known in limits for key in known):
        if len({known.get(key) for known in limits}) > 1:
            title, symbol, factor = _shown(every, key[0])
            said = [_in_words(known.get(key), symbol, factor) for known in limits]
            sides = ", ".join(f"{found.folder} {text}" for found, text in zip(every, said, strict=True))
            told.append(f"{title}: {sides}")
    return told


def _limits(found: Results, every: Sequence[Results]) -> dict[tuple[str, bool], Limit]:
    """What a folder is held against, by the quantity's name and whether it is a lower limit."""
    held = judged(found, every)
    if held is None:
        return {}
    named = [*held.asked["limits"], *held.asked.get("lower_limits", {})]
    return {(it.name, it.lowest): it for it in asked_limits(found.mechanism, held.asked, named)}


def _in_words(limit: Limit | None, symbol: str, factor: float) -> str:
    if limit is None:
        return "not limited"
    return f"{'≥' if limit.lowest else '≤'} {shown(factor * limit.value)} {symbol}".rstrip(" -")


def _shown(every: Sequence[Results], name: str) -> tuple[str, str, float]:
    """A quantity's title, unit in figures and factor; one that a study has made may be known to one folder only."""
    own: dict[str, Any] = {}
    for found in every:
        own |= (found.tuned or found.records.get("run") or {}).get("quantities", {})
    return in_figures(every[0].mechanism, name, own)


def limited_by_scenario(every: Sequence[Results]) -> list[Table]:
    """A folded table for each quantity that any of the folders limits, the peak force apart."""
    names = dict.fromkeys(name for found in every for name, _ in _limits(found, every))
    folders = [str(found.folder) for found in every]
    return [by_scenario(every, folders, name, folded=True) for name in names if name != "peak_force"]


def by_scenario(every: Sequence[Results], folders: Sequence[str], name: str, folded: bool = False) -> Table:
    """A quantity in each scenario that any folder has met: red where it breaks its limit; the lowest one of a row in
    green, if its run keeps all limits."""
    mechanism = every[0].mechanism
    found = [_cells(it, every, name) for it in every]
    met = {
        _case(mechanism, case): label for it, labels in _labels(every) for case, label in zip(it, labels, strict=True)
    }
    title, symbol, factor = _shown(every, name)
    rows: list[list[str | Cell]] = []
    for case, label in met.items():
        known = [value for values in found if (value := values.get(case, UNKNOWN)[0]) is not None]
        least = min(known) if len(known) > 1 else None
        rows.append([label, *(_cell(values.get(case, UNKNOWN), least, factor) for values in found)])
    caption = f"{title[:1].upper()}{title[1:]} [{symbol}] after tuning, by scenario"
    return Table(caption, ("scenario", *folders), rows, folded)


def _cell(known: Known, least: float | None, factor: float) -> Cell:
    value, beyond, kept = known
    if value is None:
        return Cell(shown(None))
    return Cell(shown(factor * value), "bad" if beyond else "good" if kept and value == least else "")


def _cells(found: Results, every: Sequence[Results], name: str) -> Mapping[str, Known]:
    """By scenario: the value, whether it breaks its limit, whether the run keeps all limits."""
    held, limits = judged(found, every), _limits(found, every)
    cases = _cases(found)
    kept = [True] * len(cases) if held is None else keeping(found.mechanism, held)
    sides = [limit for (limited, _), limit in limits.items() if limited == name]
    values = [by_name(case["after"]).get(name) for case in cases]
    beyond = [any(broken(value, it.value, it.lowest) for it in sides) for value in values]
    names = [_case(found.mechanism, case) for case in cases]
    return dict(zip(names, zip(values, beyond, kept, strict=True), strict=True))


def _labels(every: Sequence[Results]) -> list[tuple[list[Record], list[str]]]:
    """Each folder's cases with their labels, which tell all folders' scenarios apart."""
    among = [scenario_of(found.mechanism, record) for found in every for record in _cases(found)]
    return [(_cases(found), case_labels(found, among)) for found in every]


def _cases(found: Results) -> list[Record]:
    return [] if found.tuned is None else list(found.tuned["scenarios"])


def _case(mechanism: Mechanism, record: Record) -> str:
    """All fields of a scenario, and where the built mechanism differs from the drawn one: the same text for the same
    case."""
    scenario = scenario_of(mechanism, record)
    fields = [f"{words(name)} {shown(getattr(scenario, name))} {unit(scenario, name)}" for name in paths(scenario)]
    return ", ".join([*fields, *(f"{factor:.4g} {path}" for path, factor in record.get("factors", {}).items())])
