"""What was found, in plain words: a few sentences on each folder of a page."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..fields import ends_as_typed, unit
from ..labelled.record import Record
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.quantity import END_TIME, PEAK_FORCE
from ..output.folder import Results
from ..value_text import change_text, percent_text, range_text, relative_change, table_text, unit_text, with_unit
from .choice import choice_abstract
from .experiments import ON_FRONT, OPEN, outcome_counts, safe_of, strictest_count, swept_fields
from .fit import fit_abstract
from .limit_check import end_count
from .limits import fails_in_corners_alone, limit_counts
from .records import by_quantity, main_in_words, main_quantity, run_in_sentence, same, title, words

MANY = 4  # variables that are named


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
    if (main := main_in_words(results, record)) is not None:
        larger = f"; {it}" if (it := record.get("larger_force")) else ""
        text += f" Its {_largest(mechanism, main[0])} is {main[1]}{larger}."
    # The paragraph of a folder's tuning tells its limits, so that of its run need not.
    counts = limit_counts(results, every) if results.tuned is None else None
    if counts is None:
        return text
    faults = [f"{counts.broken} limit{'s are' if counts.broken > 1 else ' is'} broken."] if counts.broken else []
    faults += [f"It does not end {words(counts.success or '')}, as it must."] if counts.missed else []
    unknown = f"It keeps the limits that are known; {counts.unknown} are not."
    return " ".join([text, *(faults or [unknown if counts.unknown else "It keeps every limit."])])


def _largest(mechanism: Mechanism, name: str) -> str:
    """Return what a sentence calls a quantity: the peak is the largest force of all runs that it is about."""
    return "largest contact force" if name == mechanism.name_of(PEAK_FORCE) else title(mechanism, name)


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
