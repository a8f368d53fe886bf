"""The badges at the top of a page: what one asks first of each folder."""

from collections.abc import Callable, Sequence

from ..labelled.record import Record
from ..output.folder import Results
from ..value_text import change_text, percent_text, relative_change, table_text, unit_text
from .choice import choice_badges
from .experiments import ON_FRONT, STATUS, safe_of
from .fit import fit_badges
from .limit_check import end_count, limit_check
from .limits import LimitCounts, corners_verdict, fails_in_corners_alone, limit_counts
from .page import Cell
from .records import ended, main_in_words, words
from .sensitivities import MARKS

INFEASIBLE = "no feasible design"
UNCONFIRMED = "no other search found the same: a better design may exist"
TRUST = {"check": "unsure", "ill-conditioned": "bad", "unknown": "unsure"}  # verdicts on a run's numbers
STOPPED = {
    "limit_of_steps": "the search stopped at its limit of steps",
    "stalled": "the search stalled",
    "discontinuity": "the search stopped where a small change makes a run fail",
}


def badges(every: Sequence[Results], others: Sequence[Results] = ()) -> list[Cell]:
    """Return the badges of the page: for each folder what a reader asks first, the folder's name before it where
    several have results of its kind.

    ``others``: folders of which the first with limits provides those for folders that have none.
    """
    kinds: list[Callable[[Results], Sequence[Cell]]] = [
        lambda results: _of_tuning(results, others),
        choice_badges,
        fit_badges,
        lambda results: _of_run(results, others),
        _of_many,
    ]
    badges_of = [[kind(results) for kind in kinds] for results in every]
    several = [sum(bool(each[k]) for each in badges_of) > 1 for k in range(len(kinds))]
    return [
        Cell(f"{results.folder}: {badge.text}", badge.mark) if several[k] else badge
        for results, each in zip(every, badges_of, strict=True)
        for k, of_kind in enumerate(each)
        for badge in of_kind
    ]


def _of_tuning(results: Results, others: Sequence[Results]) -> list[Cell]:
    tuned = results.tuned
    if tuned is None:
        return []
    counts = limit_counts(results, others)
    # A folder without limits must keep another's, which its design may break though its own search was feasible.
    feasible = tuned["feasible"] and (counts is None or not counts.faults)
    force = _of_objective(results, others, feasible)
    if fails_in_corners_alone(results, others):
        return [Cell(f"the design {corners_verdict(tuned)}", "bad"), force, *_of_search(tuned, True)]
    first = [] if tuned["feasible"] else [Cell(f"{INFEASIBLE} found", "bad")]
    limits = [] if counts is None or not (counts.faults or tuned["feasible"]) else [_of_limits(results, counts)]
    if tuned.get("tolerances"):
        corners = tuned["corners"]
        held = f"holds in {corners['holding']} of {corners['run']} corners"
        first.append(Cell(held, "good" if corners["holds"] else "bad"))
    if counts is None and (count := end_count(results)) is not None:
        limits = [Cell(str(count), "good" if count.complete else "unsure")]
    return [*first, *limits, force, *_of_search(tuned, tuned["feasible"])]


def _of_objective(results: Results, others: Sequence[Results], feasible: bool) -> Cell:
    """Return a badge with the objective before and after.

    A higher one is no fault where the start breaks limits, because to keep them may cost that much.
    """
    tuned = results.tuned or Record()
    before, after, unit = (tuned[f"objective_{name}"] for name in ("before", "after", "unit"))
    text = f"{words(tuned['objective'])}: {table_text(before)} → {table_text(after)}{unit_text(unit)}"
    if before is None or after is None:
        return Cell(text)
    start = limit_check(results, others, "before")
    allowed = start is None or all(start.keeping)
    text += "" if relative_change(before, after) is None else f" ({change_text(before, after, '+.2g')})"
    text += "" if allowed else ", from a start that breaks limits"
    return Cell(text, "" if not feasible else "good" if after <= before or not allowed else "unsure")


def _of_limits(results: Results, counts: LimitCounts) -> Cell:
    """Return a badge that says which limits are broken, or how sure it is that all are kept, and how many runs have the
    strictest end."""
    missed = [f"{counts.missed} of {counts.runs} not {words(counts.success or '')}"] if counts.missed else []
    count = end_count(results)
    reached = [] if count is None else [str(count)]
    if counts.faults:
        return Cell(", ".join([*_broken(counts), *missed, *reached]), "bad")
    unsure = bool(_nearly(counts)) or not (count is None or count.complete)
    kept = "limits kept as far as known" if counts.unknown else "all limits kept"
    return Cell(", ".join([kept, *_nearly(counts), *reached]), "unsure" if unsure else "good")


def _broken(counts: LimitCounts) -> list[str]:
    return [f"{counts.broken} limit{'s' if counts.broken > 1 else ''} broken"] if counts.broken else []


def _nearly(counts: LimitCounts) -> list[str]:
    """Return what is kept, but not for certain."""
    by_verdict = {"at the limit": counts.at_limit, "not known": counts.unknown}
    return [f"{count} {what}" for what, count in by_verdict.items() if count]


def _of_search(tuned: Record, feasible: bool) -> list[Cell]:
    """Return badges for a search that did not converge, and for one whose result no other search found (``confirmed``,
    where it is recorded)."""
    if not feasible:
        return []
    texts = [] if tuned.get("converged", True) else [STOPPED.get(tuned.get("ended", ""), "the search did not converge")]
    texts += [] if tuned.get("confirmed", True) else [UNCONFIRMED]
    return [Cell(text, "unsure") for text in texts]


def _of_run(results: Results, others: Sequence[Results]) -> list[Cell]:
    record, derived, cells = results.records.get("run"), results.sensitivity, []
    if record is not None:
        # A folder with a tuning has its limits in the badges of that.
        counts = limit_counts(results, others) if results.tuned is None else None
        phrases, mark = list[str](), ended(results.mechanism, record["outcome"]).mark
        if counts is not None and counts.faults:
            missed = [f"not {words(counts.success or '')}"] if counts.missed else []
            phrases, mark = [*_broken(counts), *missed], "bad"
        elif counts is not None:
            nearly = _nearly(counts)
            phrases = ["limits kept as far as known" if counts.unknown else "limits kept", *nearly]
            mark = "unsure" if mark == "good" and nearly else mark
        main = main_in_words(results, record)
        most = [] if main is None else [f"{words(main[0])} {main[1]}"]
        larger = [text] if (text := record.get("larger_force")) else []
        text = ", ".join([words(record["outcome"]), *phrases, *most, *larger])
        cells.append(Cell(text, mark))
        # A run of --trust off has no verdict, which is nothing to warn of.
        verdict = (record.get("trust") or {}).get("verdict", "trusted")
        cells += [] if verdict == "trusted" else [Cell(f"numbers: {verdict}", TRUST.get(verdict, "unsure"))]
    if derived is not None and derived["certificate"] is not None:
        verdict = derived["certificate"]["verdict"]
        cells.append(Cell(f"gradients: {verdict}", MARKS.get(verdict, "")))
    return cells


def _of_many(results: Results) -> list[Cell]:
    cells, points = [], results.records.get("front", Record()).get("points")
    if envelope := results.records.get("sweep", Record()).get("envelope"):
        safe, runs = envelope["safe_runs"], envelope["runs"]
        cells.append(Cell(f"{safe_of(envelope)} of the sweep are safe", "good" if safe == runs else "unsure"))
        if (between := envelope.get("between")) and between["unsafe_runs"]:
            count = f"{between['unsafe_runs']} of {between['runs']} runs"
            cells.append(Cell(f"{count} between the study's scenarios are not safe", "bad"))
    for surface in results.records.get("sample", Record()).get("surfaces", ()):
        error = surface["cross_validated"][surface["kind"]]["relative"]
        text = f"surface of {words(surface['quantity'])}: misses {percent_text(error)}"
        cells.append(Cell(text, "good" if surface["trusted"] else "bad"))
    if points:
        marks = [STATUS[point["status"]] for point in points if point["status"] in ON_FRONT]
        unsure = f", {marks.count('unsure')} not converged" if "unsure" in marks else ""
        mark = "unsure" if unsure else "good" if marks else "bad"
        cells.append(Cell(f"front of {len(marks)} point{'' if len(marks) == 1 else 's'}{unsure}", mark))
    return cells
