"""Limits, and whether a run or every scenario of a tuning keeps them."""

import dataclasses
from collections import Counter
from collections.abc import Container, Mapping, Sequence
from typing import Any, NamedTuple

from ..fields import get
from ..labelled.record import Record
from ..mechanisms.limit import IMPACTS, Limit, both_sides
from ..mechanisms.mechanism import EndCount, Mechanism, RequiredEnd
from ..output.folder import Results
from ..tuning.cases import built_label
from ..value_text import percent_text, with_unit
from .page import Cell, PageSection, Table
from .records import Display, display, same, scenario_of, words

LIMITS = ("limits", "lower_limits", "most_impacts", "ends")  # what a record has that its study limits
HEADINGS = ("quantity", "unit", "worst", "in scenario", "limit", "margin", "verdict")
BEYOND = ("scenario", "quantity", "unit", "value", "limit", "beyond it")
CLOSE = 1e-3  # relative margin below which a value is at its limit
MANY = 12  # broken limits; a longer table is folded
KEPT, AT_LIMIT, BROKEN = Cell("kept", "good"), Cell("at the limit", "unsure"), Cell("broken", "bad")
UNKNOWN = Cell("not known", "unsure")
Row = list[str | Cell]


def _value(value: float | None, limit: Limit, shown: Display) -> str:
    """Return a value beside its limit: with as many digits as tell it from a bound that it breaks."""
    text = shown.text(value)
    if value is None or limit.keeps(value) or text != with_unit(shown.factor * limit.bound, ""):
        return text
    return limit.told_apart(value, factor=shown.factor)


@dataclasses.dataclass(frozen=True)
class LimitCheck:
    """Runs and the limits that they must keep.

    ``source``: the record that has the limits; ``source_folder``: its folder where it is another one's, "" otherwise;
    ``labels`` of the scenarios, and for each its ``values`` by name, the number of impacts among them, and how it
    ended (``outcomes``); ``success``: how it should end, in a word.
    """

    mechanism: Mechanism
    source: Record
    source_folder: str
    labels: Sequence[str]
    values: Sequence[Mapping[str, Any]]
    outcomes: Sequence[str]
    success: str | None

    @property
    def limits(self) -> list[Limit]:
        """Return upper limits, those that always hold first, lower ones, and that of the impacts."""
        # What always holds can be judged only where its quantity was recorded.
        always = [name for name in self.mechanism.tuning.always if name in self.values[0]]
        most = self.source.get("most_impacts")
        named = limits_of(self.mechanism, self.source, [*always, *limited(self.source)])
        return named if most is None else [*named, Limit(IMPACTS, most)]

    @property
    def end(self) -> RequiredEnd | None:
        """Return the end that the limits ask for beside success, or that a limited quantity waits for; None for
        none."""
        return required_end(self.mechanism, self.source)

    @property
    def missed(self) -> list[int]:
        """Return the numbers of the scenarios that do not end as they must, the smallest margin first where margins are
        known."""
        margin, end = self.mechanism.tuning.margin or "", self.end
        successes = self.mechanism.successes if end is None else end.outcomes
        successes = () if self.success is None else successes
        # A failed run ends in no way that will do, also where any end would.
        failed = [name for name in self.mechanism.outcomes.__members__ if self.mechanism.outcomes[name].failed]
        missed = [k for k, it in enumerate(self.outcomes) if (successes and it not in successes) or it in failed]
        return sorted(missed, key=lambda k: float(self.values[k].get(margin) or 0.0))

    @property
    def keeping(self) -> list[bool]:
        """Return for each scenario whether its run ends as it must and keeps every limit."""
        missed, limits = set(self.missed), self.limits
        return [k not in missed and not any(_breaks(case, it) for it in limits) for k, case in enumerate(self.values)]

    def display(self, name: str) -> Display:
        """Return how people are shown a quantity."""
        if name == IMPACTS:
            return Display(name, "-", 1)
        shown = display(self.mechanism, name, self.source.get("quantities", {}))
        return shown if name in limited(self.source) else shown._replace(title=f"{shown.title} (always)")


def limit_check(results: Results, every: Sequence[Results] = (), side: str = "after") -> LimitCheck | None:
    """Return a folder's tuning, or else its run, with the limits that it must keep; None where there are none.

    **Arguments:** ``every``: folders of which the first with limits provides those for a folder without; ``side`` of
    a tuning: "after", or "before" for the design it began with.
    """
    record, mechanism = _limiting(results), results.mechanism
    limiting = next((it for it in (results, *every) if _has_limits(it)), results)
    source = _limiting(limiting)
    # A tuning without limits still says how runs must end; a run without any has nothing to keep.
    if record is None or source is None or (results.tuned is None and not _has_limits(limiting)):
        return None
    name = "" if limiting is results else str(limiting.folder)
    success = required_success(results, source)
    if results.tuned is None:
        values = Record(record | record.get("limited", {}) | {IMPACTS: len(record[IMPACTS])})
        label = mechanism.view.label(scenario_of(mechanism, record["scenario"]))
        return LimitCheck(mechanism, source, name, [label], [values], [record["outcome"]], success)
    cases = [case[side] for case in record["scenarios"]]
    outcomes = [case["outcome"] for case in cases]
    return LimitCheck(mechanism, source, name, case_labels(results), cases, outcomes, success)


def required_end(mechanism: Mechanism, source: Record) -> RequiredEnd | None:
    """Return the end that a record's limits ask for beside success, or that what they limit waits for; None for
    none."""
    return mechanism.required_end(source.get("ends", ()), limited(source))


def required_success(results: Results, source: Record) -> str | None:
    """Return how a folder's runs must end by a record's limits, in a word; None where any end will do."""
    if (end := required_end(results.mechanism, source)) is not None:
        return end.name
    return results.success if source.get("require_success", True) else None


def end_count(results: Results, side: str = "after") -> EndCount | None:
    """Return in how many runs of a folder the strictest end was reached that its design can have; None where there is
    none.

    ``side``: of a tuning, as of `limit_check`.
    """
    design = results.design
    if design is None:
        return None
    if results.tuned is not None:
        outcomes = [case[side]["outcome"] for case in results.tuned["scenarios"]]
    elif "run" in results.records:
        outcomes = [results.records["run"]["outcome"]]
    else:
        return None
    return results.mechanism.end_count(lambda path: get(design, path), Counter(outcomes))


def repeats_tuning(results: Results, every: Sequence[Results]) -> bool:
    """Return whether a folder's run is one of the scenarios of a tuning among ``every``.

    The designs must be the same, and the limits too: what is said of the tuning's limits then holds for the run.
    """
    run = results.records.get("run")
    if run is None or results.tuned is not None:
        return False
    return any(other.tuned is not None and _is_a_case(run, other.tuned) for other in every)


def _is_a_case(run: Record, tuned: Record) -> bool:
    own, others = ([of.get(name) or None for name in LIMITS] for of in (run, tuned))
    # A run without limits of its own must keep those of the tuning.
    if any(own) and own != others:
        return False
    design = tuned["design"]
    if not all(same(design.get(name), value) for name, value in run["design"].items()):
        return False
    return any(
        # A run simulates the design as drawn, which a case with factors does not.
        not any(case.get(it) for it in ("factors", "shifts", "values"))
        and all(same(case.get(name), value) for name, value in run["scenario"].items())
        for case in tuned["scenarios"]
    )


def source_of_limits(every: Sequence[Results]) -> Record | None:
    """Return the record of the first folder that has limits of its own."""
    return next((_limiting(results) for results in every if _has_limits(results)), None)


def _limiting(results: Results) -> Record | None:
    """Return the record of a folder's tuning, or else of its run."""
    return results.tuned if results.tuned is not None else results.records.get("run")


def _has_limits(results: Results) -> bool:
    return any((_limiting(results) or Record()).get(name) for name in LIMITS)


def elsewhere(results: Results, scenario: Record) -> list[str]:
    """Return a line that says in which scenarios of a tuning its limited quantities and the peak force are largest.

    There is no line where the run that is shown, of ``scenario``, is one of those.
    """
    if results.tuned is None:
        return []
    mechanism, cases = results.mechanism, [case["after"] for case in results.tuned["scenarios"]]
    met, labels = [scenario_of(mechanism, case) for case in results.tuned["scenarios"]], case_labels(results)
    names = dict.fromkeys(["peak_force", *results.tuned["limits"]])
    own = results.tuned.get("quantities", {})
    # A value that is not known counts as zero, so that it is never the largest.
    largest = {name: max(range(len(cases)), key=lambda k: cases[k][name] or 0.0) for name in names}
    if scenario_of(mechanism, scenario) in [met[k] for k in largest.values()]:
        return []
    places = ", ".join(f"{display(mechanism, name, own).title} at {labels[k]}" for name, k in largest.items())
    return [f"This is not the scenario that decides: over all scenarios of the tuning the largest are {places}."]


def case_labels(results: Results, among: Sequence[Any] = ()) -> list[str]:
    """Return a tuning's scenarios in words, with where the built mechanism differs from the drawn one.

    They are told apart from the scenarios ``among`` which they are shown, by default each other.
    """
    cases = [] if results.tuned is None else results.tuned["scenarios"]
    met = [scenario_of(results.mechanism, case) for case in cases]
    others = list(among) or met
    design = results.mechanism.design()
    built = [[case.get(name, {}).items() for name in ("factors", "shifts", "values")] for case in cases]
    return [
        results.mechanism.view.label(scenario, others) + built_label(design, *differing)
        for differing, scenario in zip(built, met, strict=True)
    ]


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
    tables = [Table(f"{where}{caption}", HEADINGS, limit_rows(check))]
    if results.tuned is None:
        return PageSection("Limits", tables=tables)
    warnings = [f"{line[:1].upper()}{line[1:]}." for line in results.tuned["outside_validity"]]
    warnings = [*(f"Limit {line}." for line in results.tuned.get("broken_limits", [])), *warnings]
    if beyond := _beyond(check):
        heading = f"{where}{len(beyond)} times a limit is broken, the worst first"
        tables.append(Table(heading, BEYOND, beyond, folded=len(beyond) > MANY))
        warnings = [_summed(check, beyond), *warnings]
    return PageSection("Limits", warnings=warnings, tables=tables)


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
    verdicts = [_row(check, limit)[-1] for limit in check.limits]
    broken, at_limit, unknown = map(verdicts.count, (BROKEN, AT_LIMIT, UNKNOWN))
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


def _breaks(case: Mapping[str, Any], limit: Limit) -> bool:
    return limit.name in case and not limit.keeps(case[limit.name])


def limit_rows(check: LimitCheck) -> list[Row]:
    """Return a row for each limit, and how runs must end."""
    rows, success = [_row(check, limit) for limit in check.limits], check.success
    if success is not None:
        missed, every = check.missed, len(check.outcomes)
        where = check.labels[missed[0]] if missed else "–"
        verdict = BROKEN if missed else KEPT
        rows.append([words(success), "-", str(every - len(missed)), where, f"of {every}", "–", verdict])
    return rows


def limited(source: Record) -> list[str]:
    """Return the quantities that a study limits."""
    return [*source["limits"], *source.get("lower_limits", {})]


def limits_of(mechanism: Mechanism, source: Record, among: Container[str] | None = None) -> list[Limit]:
    """Return upper limits, those that always hold before the others, and then lower ones.

    They are those on quantities ``among`` some, by default on those that the study limits.
    """
    among = limited(source) if among is None else among
    every = both_sides({**mechanism.tuning.always, **source["limits"]}, source.get("lower_limits", {}))
    return [limit for limit in every if limit.name in among]


def _row(check: LimitCheck, limit: Limit) -> Row:
    shown = check.display(limit.name)
    name, symbol, bound = shown.title, shown.unit, limit.bound_text(factor=shown.factor)
    if limit.name not in check.values[0]:  # a limit of another folder on what this one does not know
        return [name, symbol, "–", "–", bound, "–", UNKNOWN]
    values = [case[limit.name] for case in check.values]
    value = limit.worst(values)
    where = check.labels[values.index(value)]
    share = None if limit.name == IMPACTS else limit.margin(value)  # a whole number has no margin to speak of
    margin = "–" if share is None else percent_text(share, ".3g")
    close = share is not None and share < CLOSE
    verdict = BROKEN if not limit.keeps(value) else AT_LIMIT if close else KEPT
    return [name, symbol, _value(value, limit, shown), where, bound, margin, verdict]


def _beyond(check: LimitCheck) -> list[Row]:
    """Return every broken limit of every scenario: first runs that end otherwise than they must, then the farthest
    beyond."""
    success = words(check.success or "")
    missed: list[Row] = [[check.labels[k], "end", "-", words(check.outcomes[k]), success, "–"] for k in check.missed]
    excesses: list[tuple[float, Row]] = []
    for limit in check.limits:
        shown = check.display(limit.name)
        for where, case in zip(check.labels, check.values, strict=True):
            if _breaks(case, limit):
                value = case[limit.name]
                share = limit.margin(value)
                by = "–" if share is None else percent_text(-share, ".3g")
                text, bound = _value(value, limit, shown), limit.bound_text(factor=shown.factor)
                row: Row = [where, shown.title, shown.unit, text, bound, by]
                # Sorted by margin below: the most negative one is the farthest beyond.
                excesses.append((share or 0.0, row))
    return [*missed, *(row for _, row in sorted(excesses, key=lambda it: it[0]))]


def _summed(check: LimitCheck, beyond: Sequence[Row]) -> str:
    """Return in one sentence how many scenarios break which limit."""
    counts = Counter(str(row[1]) if row[1] != "end" else f"not {words(check.success or '')}" for row in beyond)
    text = "; ".join(f"{name} in {count}" for name, count in counts.items())
    return f"Limits are broken, of {len(check.labels)} scenarios: {text}. The table below names them, the worst first."
