"""What is held against limits: a run, or every scenario of a tuning."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from ..mechanisms.mechanism import Mechanism
from ..output.folder import Record, Results
from .records import by_name, in_figures, same, scenario_of

LIMITS = ("limits", "lower_limits", "most_impacts")  # what a record has that its study limits


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
        said = found.mechanism.label(scenario_of(found.mechanism, record["scenario"]))
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
    return mechanism.label(scenario, among) + "".join(f", {factor:.4g} {path}" for path, factor in factors)
