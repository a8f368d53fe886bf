"""Whether a run, or every scenario of a tuning, keeps the limits of a study."""

import dataclasses
from collections import Counter
from collections.abc import Container, Mapping, Sequence
from typing import Any

from ..fields import get
from ..labelled.record import Record
from ..mechanisms.limit import IMPACTS, Limit, both_sides
from ..mechanisms.mechanism import EndCount, Mechanism, RequiredEnd
from ..output.folder import Results
from ..tuning.problem.cases import numbered
from .records import Display, case_labels, display, same, scenario_of

LIMITS = ("limits", "lower_limits", "most_impacts", "ends")  # what a record has that its study limits


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
        return [k not in missed and not any(breaks(case, it) for it in limits) for k, case in enumerate(self.values)]

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
        # Limits may be on own quantities, which the record has apart, and on the number of impacts, which it lists.
        values = Record(record | record.get("limited", {}) | {IMPACTS: len(record[IMPACTS])})
        label = numbered(
            mechanism.view.label(scenario_of(mechanism, record["scenario"])), record.get("scenario_number", "")
        )
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


def breaks(case: Mapping[str, Any], limit: Limit) -> bool:
    """Return whether a scenario breaks a limit; False where the limited quantity is not known."""
    return limit.name in case and not limit.keeps(case[limit.name])
