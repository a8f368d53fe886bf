"""What is held against limits, a run or every scenario of a tuning, and how it stands to them."""

import dataclasses
from collections import Counter
from collections.abc import Container, Mapping, Sequence
from typing import Any, NamedTuple

from ..mechanisms.mechanism import Mechanism
from ..output.folder import Record, Results
from .page import Cell, Section, Table, shown
from .records import ROUNDING, by_name, in_figures, same, scenario_of, words

LIMITS = ("limits", "lower_limits", "most_impacts")  # what a record has that its study limits
IMPACTS = "impacts"  # the number of them is limited as quantities are
HEADINGS = ("quantity", "unit", "worst", "in scenario", "limit", "margin", "verdict")
BEYOND = ("scenario", "quantity", "unit", "value", "limit", "beyond it")
CLOSE = 1e-3  # relative margin below which a value is at its limit
MANY = 12  # broken limits; a longer table is folded
KEPT, AT_LIMIT, BROKEN = Cell("kept", "good"), Cell("at the limit", "unsure"), Cell("broken", "bad")
UNKNOWN = Cell("not known", "unsure")
Row = list[str | Cell]


class Limit(NamedTuple):
    """A limit of the quantity called ``name``, its ``value`` in the quantity's unit; ``lowest``: a lower limit."""

    name: str
    value: float
    lowest: bool = False

    def text(self, factor: float = 1.0, symbol: str = "") -> str:
        """Return "≤ 25 mm"; ``factor``: how many of the unit with this ``symbol`` the quantity's own unit is."""
        return f"{'≥' if self.lowest else '≤'} {shown(factor * self.value)} {symbol}".rstrip(" -")

    def broken_by(self, value: float | None) -> bool:
        """Return whether a value is beyond the limit, rounding aside; one that is not known is."""
        if value is None:
            return True
        return value < self.value * (1.0 - ROUNDING) if self.lowest else value > self.value * (1.0 + ROUNDING)

    def margin(self, value: float | None) -> float | None:
        """Return how far a value keeps from the limit, relative to that; None where it is not known."""
        if value is None or self.value == 0.0:
            return None
        return (value / self.value - 1.0) if self.lowest else (1.0 - value / self.value)

    def worst(self, values: Sequence[float | None]) -> float | None:
        """Return the value nearest to the limit or farthest beyond it; None where one is not known."""
        known = [value for value in values if value is not None]
        if len(known) < len(values):
            return None
        return min(known) if self.lowest else max(known)


@dataclasses.dataclass(frozen=True)
class Judged:
    """What is held against limits: ``asked``, the record that has the limits; ``lender``: the folder of that record
    where it is another one's, "" otherwise; ``labels`` of the scenarios, and for each its ``values`` by name, the
    number of impacts among them, and how it ended (``outcomes``); ``success``: how it should end, in a word."""

    mechanism: Mechanism
    asked: Record
    lender: str
    labels: Sequence[str]
    values: Sequence[Mapping[str, Any]]
    outcomes: Sequence[str]
    success: str | None

    @property
    def limits(self) -> list[Limit]:
        """Upper limits, those that always hold first, lower ones, and that of the impacts."""
        always = [name for name in self.mechanism.tuning.always if name in self.values[0]]
        most = self.asked.get("most_impacts")
        named = asked_limits(self.mechanism, self.asked, [*always, *limited(self.asked)])
        return named if most is None else [*named, Limit(IMPACTS, most)]

    @property
    def missed(self) -> list[int]:
        """The scenarios that do not end as they must, that of the smallest margin first where margins are known."""
        successes, margin = self.mechanism.successes, self.mechanism.tuning.margin or ""
        missed = [k for k, it in enumerate(self.outcomes) if successes and it not in successes]
        return sorted(missed, key=lambda k: float(self.values[k].get(margin) or 0.0))

    @property
    def keeping(self) -> list[bool]:
        """Of each scenario, whether its run ends as it must and keeps every limit."""
        missed, limits = set(self.missed), self.limits
        return [k not in missed and not any(_breaks(case, it) for it in limits) for k, case in enumerate(self.values)]

    def title(self, name: str) -> tuple[str, str, float]:
        """A quantity's title, its unit in figures, and how many of those its own unit is."""
        if name == IMPACTS:
            return name, "-", 1
        title, symbol, factor = in_figures(self.mechanism, name, self.asked.get("quantities", {}))
        return (title if name in limited(self.asked) else f"{title} (always)"), symbol, factor


def judged(found: Results, every: Sequence[Results] = (), side: str = "after") -> Judged | None:
    """A folder's tuning, or else its run, with the limits it is held against; None where there are none.

    **Arguments:** ``every``: folders of which the first with limits lends them to a folder that has none; ``side`` of
    a tuning: "after", or "before" for the design it began with.
    """
    record, mechanism = _limiting(found), found.mechanism
    lender = next((it for it in (found, *every) if _has_limits(it)), found)
    asked = _limiting(lender)
    if record is None or asked is None or (found.tuned is None and not _has_limits(lender)):
        return None
    name = "" if lender is found else str(lender.folder)
    if found.tuned is None:
        values = by_name(record) | record.get("limited", {}) | {IMPACTS: len(record[IMPACTS])}
        said = mechanism.view.label(scenario_of(mechanism, record["scenario"]))
        return Judged(mechanism, asked, name, [said], [values], [record["outcome"]], found.success)
    cases = [by_name(case[side]) for case in record["scenarios"]]
    return Judged(mechanism, asked, name, case_labels(found), cases, [case["outcome"] for case in cases], found.success)


def told_already(found: Results, every: Sequence[Results]) -> bool:
    """Whether a folder's run is one of the scenarios of a tuning among ``every``, of the tuned design and held against
    the same limits: what is said of the tuning's limits holds for it."""
    run = found.records.get("run")
    if run is None or found.tuned is not None:
        return False
    return any(other.tuned is not None and _is_a_case(run, other.tuned) for other in every)


def _is_a_case(run: Record, tuned: Record) -> bool:
    own, others = ([of.get(name) or None for name in LIMITS] for of in (run, tuned))
    if any(own) and own != others:
        return False
    design = tuned["design"]
    if not all(same(design.get(name), value) for name, value in run["design"].items()):
        return False
    return any(
        not case.get("factors") and all(same(case.get(name), value) for name, value in run["scenario"].items())
        for case in tuned["scenarios"]
    )


def lender_of(every: Sequence[Results]) -> Record | None:
    """The record of the first folder that has limits of its own."""
    return next((_limiting(found) for found in every if _has_limits(found)), None)


def _limiting(found: Results) -> Record | None:
    """The record of a folder's tuning, or else of its run."""
    return found.tuned if found.tuned is not None else found.records.get("run")


def _has_limits(found: Results) -> bool:
    return any((_limiting(found) or {}).get(name) for name in LIMITS)


def elsewhere(found: Results, scenario: Record) -> list[str]:
    """A line that says in which scenarios of a tuning its limited quantities and the peak force are largest, where a
    run of another ``scenario`` is shown; no line where it is one of those."""
    if found.tuned is None:
        return []
    mechanism, cases = found.mechanism, [by_name(case["after"]) for case in found.tuned["scenarios"]]
    met, labels = [scenario_of(mechanism, case) for case in found.tuned["scenarios"]], case_labels(found)
    names = dict.fromkeys(["peak_force", *found.tuned["limits"]])
    own = found.tuned.get("quantities", {})
    largest = {name: max(range(len(cases)), key=lambda k: cases[k][name] or 0.0) for name in names}
    if scenario_of(mechanism, scenario) in [met[k] for k in largest.values()]:
        return []
    told = ", ".join(f"{in_figures(mechanism, name, own)[0]} at {labels[k]}" for name, k in largest.items())
    return [f"This is not the scenario that decides: over all scenarios of the tuning the largest are {told}."]


def case_labels(found: Results, among: Sequence[Any] = ()) -> list[str]:
    """A tuning's scenarios in words, told apart from those ``among`` which they stand (default: its own), with where
    the built mechanism differs from the drawn one."""
    cases = [] if found.tuned is None else found.tuned["scenarios"]
    met = [scenario_of(found.mechanism, case) for case in cases]
    others = list(among) or met
    return [
        found.mechanism.view.label(scenario, others)
        + "".join(f", {factor:.4g} {path}" for path, factor in case.get("factors", {}).items())
        for case, scenario in zip(cases, met, strict=True)
    ]


def limits(found: Results, every: Sequence[Results] = (), named: bool = False) -> Section | None:
    """What the study limits, of the tuning or of the run; None where nothing is limited.

    **Arguments:** ``every``: as of `judged`; ``named``: whether the table's caption names the folder.
    """
    held = judged(found, every)
    if held is None:
        return None
    of = "The run" if found.tuned is None else "The worst over all scenarios"
    caption = f"{of} against {f'the limits of {held.lender}' if held.lender else 'the limits of its study'}"
    where = f"{found.folder}: " if named else ""
    tables = [Table(f"{where}{caption}", HEADINGS, _rows(held))]
    if found.tuned is None:
        return Section("Limits", tables=tables)
    said = [f"{line[:1].upper()}{line[1:]}." for line in found.tuned["outside_validity"]]
    said = [*(f"Limit {line}." for line in found.tuned.get("why", [])), *said]
    if beyond := _beyond(held):
        told = f"{where}{len(beyond)} times a limit is broken, the worst first"
        tables.append(Table(told, BEYOND, beyond, folded=len(beyond) > MANY))
        said = [_summed(held, beyond), *said]
    return Section("Limits", warnings=said, tables=tables)


class Standing(NamedTuple):
    """How many limits are ``broken``, kept ``at_limit``, and ``unknown``; how many ``runs`` there are, and of these
    ``missed``: ended otherwise than they must."""

    broken: int
    at_limit: int
    unknown: int
    missed: int
    runs: int

    @property
    def faults(self) -> int:
        """Of both kinds."""
        return self.broken + self.missed


def standing(found: Results, every: Sequence[Results] = ()) -> Standing | None:
    """How a folder stands to its limits; None where nothing is limited. ``every``: as of `judged`."""
    held = judged(found, every)
    if held is None:
        return None
    verdicts = [_row(held, limit)[-1] for limit in held.limits]
    broken, at_limit, unknown = map(verdicts.count, (BROKEN, AT_LIMIT, UNKNOWN))
    return Standing(broken, at_limit, unknown, len(held.missed), len(held.outcomes))


def _breaks(case: Mapping[str, Any], limit: Limit) -> bool:
    return limit.name in case and limit.broken_by(case[limit.name])


def _rows(held: Judged) -> list[Row]:
    """A row for each limit, and how runs must end."""
    rows, success = [_row(held, limit) for limit in held.limits], held.success
    if success is not None:
        missed, every = held.missed, len(held.outcomes)
        where = held.labels[missed[0]] if missed else "–"
        verdict = BROKEN if missed else KEPT
        rows.append([words(success), "-", str(every - len(missed)), where, f"of {every}", "–", verdict])
    return rows


def limited(asked: Record) -> list[str]:
    """Return the quantities that a study limits."""
    return [*asked["limits"], *asked.get("lower_limits", {})]


def asked_limits(mechanism: Mechanism, asked: Record, among: Container[str] | None = None) -> list[Limit]:
    """Upper limits, those that always hold before the others, and lower ones; on quantities ``among`` some, or else on
    those that the study limits."""
    among = limited(asked) if among is None else among
    upper = [Limit(name, limit) for name, limit in {**mechanism.tuning.always, **asked["limits"]}.items()]
    lower = [Limit(name, limit, True) for name, limit in asked.get("lower_limits", {}).items()]
    return [limit for limit in (*upper, *lower) if limit.name in among]


def _row(held: Judged, limit: Limit) -> Row:
    name, symbol, factor = held.title(limit.name)
    told = limit.text(factor)
    if limit.name not in held.values[0]:  # a limit of another folder on what this one does not know
        return [name, symbol, "–", "–", told, "–", UNKNOWN]
    values = [case[limit.name] for case in held.values]
    value = limit.worst(values)
    where, of = held.labels[values.index(value)], None if value is None else factor * value
    share = None if limit.name == IMPACTS else limit.margin(value)  # a whole number has no margin to speak of
    margin = "–" if share is None else f"{100 * share:.3g} %"
    close = share is not None and share < CLOSE
    verdict = BROKEN if limit.broken_by(value) else AT_LIMIT if close else KEPT
    return [name, symbol, shown(of), where, told, margin, verdict]


def _beyond(held: Judged) -> list[Row]:
    """Every broken limit of every scenario: first runs that end otherwise than they must, then the farthest beyond."""
    success = words(held.success or "")
    missed: list[Row] = [[held.labels[k], "end", "-", words(held.outcomes[k]), success, "–"] for k in held.missed]
    found: list[tuple[float, Row]] = []
    for limit in held.limits:
        name, symbol, factor = held.title(limit.name)
        for where, case in zip(held.labels, held.values, strict=True):
            if _breaks(case, limit):
                value = case[limit.name]
                share, of = limit.margin(value), None if value is None else factor * value
                by = "–" if share is None else f"{-100 * share:.3g} %"
                row: Row = [where, name, symbol, shown(of), limit.text(factor), by]
                found.append((share or 0.0, row))
    return [*missed, *(row for _, row in sorted(found, key=lambda it: it[0]))]


def _summed(held: Judged, beyond: Sequence[Row]) -> str:
    """In one sentence, how many scenarios break which limit."""
    counts = Counter(str(row[1]) if row[1] != "end" else f"not {words(held.success or '')}" for row in beyond)
    told = "; ".join(f"{name} in {count}" for name, count in counts.items())
    return f"Limits are broken, of {len(held.labels)} scenarios: {told}. The table below names them, the worst first."
