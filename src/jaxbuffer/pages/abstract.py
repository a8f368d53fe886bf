"""The top of a page: badges, what one asks first of each folder, and what was found in plain words."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..fields import ends_as_typed, unit
from ..labelled.record import Record
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.quantity import END_TIME, PEAK_FORCE
from ..output.folder import Results
from ..value_text import change_text, percent_text, range_text, relative_change, table_text, unit_text, with_unit
from .choice import choice_abstract, choice_badges
from .experiments import ON_FRONT, OPEN, STATUS, outcome_counts, safe_of, strictest_count, swept_fields
from .fit import fit_abstract, fit_badges
from .limit_check import end_count, limit_check
from .limits import LimitCounts, corners_verdict, fails_in_corners_alone, limit_counts
from .page import Cell
from .records import by_quantity, ended, main_quantity, run_in_sentence, same, title, words
from .sensitivities import MARKS

INFEASIBLE = "no feasible design"
UNCONFIRMED = "no other search found the same: a better design may exist"
TRUST = {"check": "unsure", "ill-conditioned": "bad", "unknown": "unsure"}  # verdicts on a run's numbers
STOPPED = {
    "limit_of_steps": "the search stopped at its limit of steps",
    "stalled": "the search stalled",
    "discontinuity": "the search stopped where a small change makes a run fail",
}
MANY = 4  # variables that are named


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
        main = _main(results, record)
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


def abstract(every: Sequence[Results]) -> list[str]:
    """Return a few sentences on each result, the folder's name before them where several have results of its kind."""
    kinds = (_tuning, choice_abstract, fit_abstract, _run, _sensitivity, _sweep, _sample, _front)
    by_kind = [[(results, text) for results in every if (text := kind(results, every))] for kind in kinds]
    return [f"{results.folder}: {text}" if len(some) > 1 else text for some in by_kind for results, text in some]


def _tuning(results: Results, every: Sequence[Results]) -> str:
    """Return from where to where the objective went, whether limits are kept, by which numbers, and how the search
    ended."""
    tuned, mechanism = results.tuned, results.mechanism
    if tuned is None:
        return ""
    if not tuned["feasible"] and not fails_in_corners_alone(results, every):
        reasons = tuned.get("broken_limits") or [tuned["message"]]
        return f"No design was found that keeps every limit: {'; '.join(reasons)}."
    count = len(tuned["scenarios"])
    counts = limit_counts(results, every)
    verdict = " keeps every limit" if counts is None or not counts.faults else " does not keep every limit"
    where = "its scenario" if count == 1 else f"the {count} scenarios"
    ends = end_count(results)
    text = f"{_objective(mechanism, tuned)}; the design{verdict} in {where}{'' if ends is None else f', {ends}'}."
    # The message begins with the verdict of the corners, where there are some.
    ending = next(it for it in tuned["message"].split(". ") if not it.startswith("the design holds"))
    search = f"The search {'converged' if tuned.get('converged', True) else f'{ending[:1].lower()}{ending[1:]}'}."
    texts = [text, _variables(mechanism, tuned), search]
    if (corners := tuned.get("corners")) is not None:  # how far samples say what is worst
        sample = tuned.get("sample")
        samples = "" if sample is None else f"The scenarios are {sample['count']} samples, which are no bound: "
        line = corners["lines"][0]
        texts.append(f"{samples}{line if samples else line[:1].upper() + line[1:]}.")
    return " ".join(texts)


def _objective(mechanism: Mechanism, tuned: Record) -> str:
    """Return from where to where the objective went; only where to, if runs of the start failed."""
    before, after = tuned["objective_before"], tuned["objective_after"]
    symbol, factor = tuned["objective_unit"], 1.0
    # Only an objective of a single quantity with a weight of 1 has that quantity's name and unit.
    known = mechanism.quantities.get(tuned["objective"].partition(",")[0])
    if known is not None and known.unit == symbol:
        symbol, factor = known.in_figures
    objective = words(tuned["objective"]).replace("over the cases", "over the scenarios")
    if before is None:
        end = with_unit(factor * after, symbol, 4)
        return f"Tuning brought {objective} to {end}, from a start whose runs failed"
    way = "left" if same(before, after) else "lowered" if after < before else "raised"
    change = "" if relative_change(before, after) is None else f" ({change_text(before, after, '+.2g')})"
    return f"Tuning {way} {objective}, from {range_text(factor * before, factor * after, symbol, 4)}{change}"


def _variables(mechanism: Mechanism, tuned: Record) -> str:
    """Return what became of the variables that changed, the first ones."""
    usual, texts = mechanism.design(), list[str]()
    moved = [it for it in tuned["variables"] if not same(it["before"], it["value"])]
    for it in moved[:MANY]:
        typed = it.get("display_unit", "")
        first, last, symbol = ends_as_typed(it["before"], it["value"], unit(usual, it["path"]), typed)
        texts.append(f"{it['path']} from {table_text(first)} to {table_text(last)}{unit_text(symbol)}")
    left = len(moved) - len(texts)
    return f"It changes {', '.join(texts) or 'no number'}{f' and {left} more' if left else ''}."


def _run(results: Results, every: Sequence[Results]) -> str:
    record, mechanism = results.records.get("run"), results.mechanism
    if record is None:
        return ""
    reason = mechanism.outcomes[record["outcome"]].reason
    end = record.get(mechanism.name_of(END_TIME) or "")
    after = "" if end is None else f" after {end:.4g} s"
    text = f"At {run_in_sentence(mechanism, record)} the {mechanism.view.run_name} ends{after}: {reason}."
    if (main := _main(results, record)) is not None:
        text += f" Its {_largest(mechanism, main[0])} is {main[1]}{_larger(record)}."
    # The paragraph of a folder's tuning tells its limits, so that of its run need not.
    counts = limit_counts(results, every) if results.tuned is None else None
    if counts is None:
        return text
    faults = [f"{counts.broken} limit{'s are' if counts.broken > 1 else ' is'} broken."] if counts.broken else []
    faults += [f"It does not end {words(counts.success or '')}, as it must."] if counts.missed else []
    unknown = f"It keeps the limits that are known; {counts.unknown} are not."
    return " ".join([text, *(faults or [unknown if counts.unknown else "It keeps every limit."])])


def _main(results: Results, record: Record) -> tuple[str, str] | None:
    """Return the name and the value of a run's main quantity; None where it is not known."""
    name = main_quantity(results, record)
    value = record.get(name)
    return None if value is None else (name, results.mechanism.quantities[name].in_words(value, 4))


def _largest(mechanism: Mechanism, name: str) -> str:
    """Return what a sentence calls a quantity: the peak is the largest force of all runs that it is about."""
    return "largest contact force" if name == mechanism.name_of(PEAK_FORCE) else title(mechanism, name)


def _larger(record: Record) -> str:
    """Return what of a run is larger than its contact force, to go on with."""
    return f"; {text}" if (text := record.get("larger_force")) else ""


def _sensitivity(results: Results, every: Sequence[Results]) -> str:
    """Return which number moves the first quantity most."""
    record, mechanism = results.sensitivity, results.mechanism
    if record is None or not record["derivatives"]:
        return ""
    name = record["derivatives"][0]["quantity"]
    rows = [row for row in record["derivatives"] if row["quantity"] == name and row["elasticity"] is not None]
    # The first quantity may change sign, and has no elasticities then.
    if not rows:
        return ""
    most, verdict = max(rows, key=lambda row: abs(row["elasticity"])), rows[0]["verdict"]
    change = f"{most['elasticity']:+.2g} % ({'not certified' if verdict is None else verdict})"
    moved = f"{most['parameter']} moves the {title(mechanism, name)} most"
    return f"Of the {len(rows)} numbers differentiated {moved}: 1 % more of it changes it by {change}."


def _sweep(results: Results, every: Sequence[Results]) -> str:
    """Return how the runs ended, how far the main quantity goes, and how many runs are safe."""
    if results.sweep is None:
        return ""
    over = " and ".join(swept_fields(results))
    over = f"over {over}" if over else "of runs given one by one"
    counts = outcome_counts(results)
    text = f"{_ended(results.mechanism, counts)} in a sweep {over}{_strictest(results, counts)}."
    if main := main_quantity(results, [*map(str, results.sweep)]):
        symbol, factor = results.mechanism.quantities[main].in_figures
        values = factor * np.asarray(results.sweep[main].values, float)
        if np.any(np.isfinite(values)):
            ends = range_text(np.nanmin(values), np.nanmax(values), symbol, 4)
            text += f" The {_largest(results.mechanism, main)} is {ends}."
    envelope = results.records.get("sweep", Record()).get("envelope")
    safe = "" if envelope is None else f" {safe_of(envelope).removesuffix(' runs')} keep every limit."
    return text + safe


def _sample(results: Results, every: Sequence[Results]) -> str:
    """Return how the runs ended, and whose scatter matters most for each quantity."""
    record, mechanism = results.records.get("sample"), results.mechanism
    if record is None:
        return ""
    left = record["runs"] - record["done"]
    # A sample's record counts computed runs only; of an interrupted one the others are told as well.
    counts = {**record["outcomes"], **({OPEN: left} if left else {})}
    text = f"{_ended(mechanism, counts)} in a sample of {len(record['ranges'])} numbers{_strictest(results, counts)}."
    # Indices of a surface that is not to be trusted are no fact; shares add up for first-order indices alone.
    doubtful = {it["quantity"] for it in record["surfaces"] if not it["trusted"]}
    known = [row for row in record["indices"] if row["from"] == "runs" or row["quantity"] not in doubtful]
    for name, rows in by_quantity(known).items():
        # An index that is not known is never the largest.
        row = max(rows, key=lambda row: -np.inf if (alone := row["first_order"]) is None else alone)
        text += f" The {title(mechanism, name)} is scattered most by {row['number']}: {_share(row)}."
    return text


def _share(row: Record) -> str:
    """Return what a number alone has of a quantity's variance, and what it has in all."""
    alone, total = row["first_order"], row["total"]
    if alone is None or not alone > 0.0:
        return "alone it scatters nothing, only together with others"
    return f"alone {percent_text(alone)} of the variance (total index {total:.2g}, its share with all others)"


def _front(results: Results, every: Sequence[Results]) -> str:
    """Return how many designs are on a front, and between which ends it trades."""
    record, mechanism = results.records.get("front"), results.mechanism
    if record is None:
        return ""
    # Dominated points would widen the ends between which the front trades.
    points = [point for point in record["points"] if point["status"] in ON_FRONT]
    text = f"{len(points)} of {len(record['points'])} tuned designs are on the front of"
    text += f" {' and '.join(map(words, record['objectives']))}."
    open_ends = sum(not point["converged"] for point in points)
    for name in record["objectives"] if points else ():
        values = [point[f"worst {name}"] for point in points]
        known = mechanism.quantities.get(name)
        symbol, factor = ("", 1.0) if known is None else known.in_figures
        # Two ends that read the same are said once.
        ends = dict.fromkeys(f"{factor * end:.4g}" for end in (min(values), max(values)))
        text += f" The worst {title(mechanism, name)} on it is {' to '.join(ends)}{unit_text(symbol)}."
    return text + (f" {open_ends} of them did not converge." if open_ends else "")


def _ended(mechanism: Mechanism, counts: Mapping[str, Any]) -> str:
    """Return how many runs ended as they should."""
    good, ends = _successes(mechanism, counts)
    text = f"{good} of {sum(counts.values())} {mechanism.view.run_name}s end {' or '.join(map(words, ends))}"
    return text + (f", {counts[OPEN]} are {OPEN}" if OPEN in counts else "")


def _strictest(results: Results, counts: Mapping[str, Any]) -> str:
    """Return in how many runs the strictest end was reached, after a comma; "" where `_ended` has said it."""
    _, ends = _successes(results.mechanism, counts)
    end = strictest_count(results, counts)
    return "" if end is None or ends == [end.name] else f", {end}"


def _successes(mechanism: Mechanism, counts: Mapping[str, Any]) -> tuple[int, list[str]]:
    """Return how many runs ended as they should, and the names of these ends."""
    should = mechanism.successes or (mechanism.outcomes.time_is_up(),)
    ends = [name for name in should if name in counts] or [should[0]]
    return sum(counts.get(name, 0) for name in ends), ends
