"""What is held against limits, a run or every scenario of a tuning, and how it stands to them."""

import dataclasses
from collections.abc import Container, Mapping, Sequence
from typing import Any, NamedTuple

from ..mechanisms.mechanism import Mechanism
from ..output.folder import Record, Results
from .page import Cell, Section, Table, shown
from .records import ROUNDING, by_name, in_figures, same, scenario_of, words

LIMITS = ("limits", "lower_limits", "most_impacts")  # what a record has that its study limits
HEADINGS = ("quantity", "unit", "worst", "in scenario", "limit", "margin", "verdict")
BEYOND = ("scenario", "quantity", "unit", "value", "limit", "beyond it")
CLOSE = 1e-3  # relative margin below which a value is at its limit
MANY = 12  # broken limits; a longer table is folded
KEPT, AT_LIMIT, BROKEN = Cell("kept", "good"), Cell("at the limit", "unsure"), Cell("broken", "bad")
RISING = Cell("kept; still rising at the end", "unsure")  # it would go on to rise, had the run gone on
UNKNOWN = Cell("not known", "unsure")


@dataclasses.dataclass(frozen=True)
class Judged:
    """What is held against limits: ``asked``, the record that has the limits; ``lender``: the folder of that record
    where it is another one's, "" otherwise; ``labels`` of the scenarios, and for each its ``values`` by name, how it
    ended (``outcomes``), its number of ``impacts``, and which quantities were still ``rising`` at its end."""

    asked: Record
    lender: str
    labels: Sequence[str]
    values: Sequence[Mapping[str, Any]]
    outcomes: Sequence[str]
    impacts: Sequence[int]
    rising: Sequence[Sequence[str]]


def judged(found: Results, every: Sequence[Results] = (), side: str = "after") -> Judged | None:
    """A folder's tuning, or else its run, with the limits it is held against; None where there are none.

    **Arguments:** ``every``: folders of which the first with limits lends them to a folder that has none; ``side`` of
    a tuning: "after", or "before" for the design it began with.
    """
    record = _limiting(found)
    if record is None:
        return None
    lender = found if has_limits(found) else next((other for other in every if has_limits(other)), found)
    asked = _limiting(lender)
    if asked is None or (found.tuned is None and not has_limits(lender)):
        return None
    name = "" if lender is found else str(lender.folder)
    if found.tuned is None:
        values = by_name(record) | record.get("limited", {})
        said = found.mechanism.view.label(scenario_of(found.mechanism, record["scenario"]))
        return Judged(
            asked, name, [said], [values], [record["outcome"]], [len(record["impacts"])], [record.get("rising", ())]
        )
    cases = [case[side] for case in record["scenarios"]]
    outcomes, impacts = ([case[name] for case in cases] for name in ("outcome", "impacts"))
    rising = [case.get("rising", ()) for case in cases]
    return Judged(asked, name, case_labels(found), [by_name(case) for case in cases], outcomes, impacts, rising)


def has_limits(found: Results) -> bool:
    """Whether a folder's tuning, or else its run, has limits of its own."""
    record = _limiting(found)
    if record is None:
        return False
    return bool(record.get("limits") or record.get("lower_limits")) or record.get("most_impacts") is not None


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
    return next((_limiting(found) for found in every if has_limits(found)), None)


def _limiting(found: Results) -> Record | None:
    return found.tuned if found.tuned is not None else found.records.get("run")


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
    """A tuning's scenarios in words, told apart from those ``among`` which they stand (default: its own)."""
    cases = [] if found.tuned is None else found.tuned["scenarios"]
    met = [scenario_of(found.mechanism, case) for case in cases]
    return [
        _label(found.mechanism, scenario, list(among) or met, case) for case, scenario in zip(cases, met, strict=True)
    ]


def _label(mechanism: Mechanism, scenario: Any, among: list[Any], record: Record) -> str:
    """The scenario in words, and where the built mechanism differs from the drawn one."""
    factors = record.get("factors", {}).items()
    return mechanism.view.label(scenario, among) + "".join(f", {factor:.4g} {path}" for path, factor in factors)


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
        return broken(value, self.value, self.lowest)


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
    tables = [Table(f"{where}{caption}", HEADINGS, _rows(found.mechanism, held))]
    if found.tuned is None:
        return Section("Limits", tables=tables)
    said = [f"{line[:1].upper()}{line[1:]}." for line in found.tuned["outside_validity"]]
    said = [*(f"Limit {line}." for line in found.tuned.get("why", [])), *said]
    if beyond := _beyond(found.mechanism, held):
        told = f"{where}{len(beyond)} times a limit is broken, the worst first"
        tables.append(Table(told, BEYOND, beyond, folded=len(beyond) > MANY))
        said = [_summed(found.mechanism, held), *said]
    return Section("Limits", warnings=said, tables=tables)


class Standing(NamedTuple):
    """How many limits are ``broken``, kept ``at_limit``, kept by what is still ``rising`` at a run's end, and
    ``unknown``; how many ``runs`` there are, and of these ``missed``: ended otherwise than they must."""

    broken: int
    at_limit: int
    rising: int
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
    verdicts = [row[-1] for row in _limit_rows(found.mechanism, held)]
    beyond, at_limit, rising, unknown = map(verdicts.count, (BROKEN, AT_LIMIT, RISING, UNKNOWN))
    missed = len(_missed(found.mechanism, held))
    return Standing(beyond, at_limit, rising, unknown, missed, len(held.outcomes))


def keeping(mechanism: Mechanism, held: Judged) -> list[bool]:
    """Of each scenario, whether its run ends as it must and keeps every limit."""
    beyond = {k for k, case in enumerate(held.values) if any(_breaks(case, it) for it in _asked(mechanism, held))}
    most = held.asked.get("most_impacts")
    beyond |= set() if most is None else {k for k, count in enumerate(held.impacts) if count > most}
    beyond |= set(_missed(mechanism, held))
    return [k not in beyond for k in range(len(held.values))]


def _breaks(case: Mapping[str, Any], limit: Limit) -> bool:
    return limit.name in case and limit.broken_by(case[limit.name])


def _rows(mechanism: Mechanism, held: Judged) -> list[list[str | Cell]]:
    """A row for each limit, and how runs must end."""
    rows = _limit_rows(mechanism, held)
    if mechanism.success is not None:
        missed, every = _missed(mechanism, held), len(held.outcomes)
        where = held.labels[missed[0]] if missed else "–"
        end = words(mechanism.success)
        rows.append([end, "-", str(every - len(missed)), where, f"of {every}", "–", BROKEN if missed else KEPT])
    return rows


def _missed(mechanism: Mechanism, held: Judged) -> list[int]:
    """The scenarios that do not end as they must, that of the smallest margin first where margins are known."""
    missed = [k for k, it in enumerate(held.outcomes) if mechanism.success is not None and it != mechanism.success]
    margins = {k: float(held.values[k].get(mechanism.tuning.margin or "") or 0.0) for k in missed}
    return sorted(missed, key=lambda k: margins[k])


def _limit_rows(mechanism: Mechanism, held: Judged) -> list[list[str | Cell]]:
    """A row for each upper limit, each lower one, and the number of impacts."""
    rows = [_row(_title(mechanism, held, limit.name), held, limit) for limit in _asked(mechanism, held)]
    if (most := held.asked.get("most_impacts")) is not None:
        count = max(held.impacts)
        where = held.labels[list(held.impacts).index(count)]
        rows.append(["impacts", "-", str(count), where, f"≤ {most}", "–", KEPT if count <= most else BROKEN])
    return rows


def _asked(mechanism: Mechanism, held: Judged) -> list[Limit]:
    always = [name for name in mechanism.tuning.always if name in held.values[0]]
    return asked_limits(mechanism, held.asked, [*always, *limited(held.asked)])


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


def _title(mechanism: Mechanism, held: Judged, name: str) -> tuple[str, str, float]:
    title, symbol, factor = in_figures(mechanism, name, held.asked.get("quantities", {}))
    return (title if name in limited(held.asked) else f"{title} (always)"), symbol, factor


def _row(title: tuple[str, str, float], held: Judged, limit: Limit) -> list[str | Cell]:
    name, symbol, factor = title
    told = limit.text(factor)
    if limit.name not in held.values[0]:  # a limit of another folder on what this one does not know
        return [name, symbol, "–", "–", told, "–", UNKNOWN]
    values = [case[limit.name] for case in held.values]
    value = worst(values, limit.lowest)
    where, of = held.labels[values.index(value)], None if value is None else factor * value
    share = _margin(value, limit)
    margin = "–" if share is None else f"{100 * share:.3g} %"
    verdict = _verdict(value, limit)
    if verdict == KEPT and not limit.lowest and limit.name in held.rising[values.index(value)]:
        verdict = RISING
    return [name, symbol, shown(of), where, told, margin, verdict]


def _margin(value: float | None, limit: Limit) -> float | None:
    """How far a value keeps from its limit, relative to that; None where it is not known."""
    if value is None or limit.value == 0.0:
        return None
    return (value / limit.value - 1.0) if limit.lowest else (1.0 - value / limit.value)


def worst(values: Sequence[float | None], lowest: bool = False) -> float | None:
    """The largest of some values, or the ``lowest``; None where one is not known."""
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return None
    return min(known) if lowest else max(known)


def broken(value: float | None, limit: float | None, lowest: bool = False) -> bool:
    """Whether a value is beyond its limit, rounding aside; one that is not known is."""
    if limit is None:
        return False
    if value is None:
        return True
    return value < limit * (1.0 - ROUNDING) if lowest else value > limit * (1.0 + ROUNDING)


def _verdict(value: float | None, limit: Limit) -> Cell:
    if limit.broken_by(value):
        return BROKEN
    share = _margin(value, limit)
    return AT_LIMIT if share is not None and share < CLOSE else KEPT


def _beyond(mechanism: Mechanism, held: Judged) -> list[list[str | Cell]]:
    """Every broken limit of every scenario: first runs that end otherwise than they must, then the farthest beyond."""
    missed: list[list[str | Cell]] = [
        [held.labels[k], "end", "-", words(held.outcomes[k]), words(mechanism.success or ""), "–"]
        for k in _missed(mechanism, held)
    ]
    found = sorted(_each_broken(mechanism, held), key=lambda it: -it[0])
    return [*missed, *(row for _, row in found)]


def _each_broken(mechanism: Mechanism, held: Judged) -> list[tuple[float, list[str | Cell]]]:
    """Limits on quantities and on impacts, each with how far it is broken relative to it."""
    found: list[tuple[float, list[str | Cell]]] = []
    most = held.asked.get("most_impacts")
    asked = [*_asked(mechanism, held), *([] if most is None else [Limit("impacts", most)])]
    cases: list[Mapping[str, Any]] = [
        {**case, "impacts": count} for case, count in zip(held.values, held.impacts, strict=True)
    ]
    for limit in asked:
        name, symbol, factor = ("impacts", "-", 1) if limit.name == "impacts" else _title(mechanism, held, limit.name)
        told = limit.text(factor)
        for where, case in zip(held.labels, cases, strict=True):
            if _breaks(case, limit):
                value = case[limit.name]
                share, of = _margin(value, limit), None if value is None else factor * value
                by = "–" if share is None else f"{-100 * share:.3g} %"
                found.append((0.0 if share is None else -share, [where, name, symbol, shown(of), told, by]))
    return found


def _summed(mechanism: Mechanism, held: Judged) -> str:
    """In one sentence, how many scenarios break which limit."""
    counts: dict[str, int] = {}
    for row in _beyond(mechanism, held):
        name = str(row[1]) if row[1] != "end" else f"not {words(mechanism.success or '')}"
        counts[name] = counts.get(name, 0) + 1
    told = "; ".join(f"{name} in {count}" for name, count in counts.items())
    return f"Limits are broken, of {len(held.labels)} scenarios: {told}. The table below names them, the worst first."
