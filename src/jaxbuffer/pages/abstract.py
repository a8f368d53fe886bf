"""The top of a page: badges, what one asks first of each folder, and what was found in plain words."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..fields import as_typed, unit
from ..mechanisms.mechanism import Mechanism
from ..output.folder import Record, Results
from .experiments import ON_FRONT, OPEN, STANDING, outcome_counts, swept_fields
from .limits import Standing, judged, standing
from .page import Cell, shown
from .records import by_name, ended, same, scenario_of, title, words
from .sensitivities import MARKS

INFEASIBLE = "no feasible design"
UNCONFIRMED = "no other search found the same: a better design may exist"
TRUST = {"check": "unsure", "ill-conditioned": "bad", "unknown": "unsure"}  # verdicts on a run's numbers
STOPPED = {
    "limit_of_steps": "the search stopped at its limit of steps",
    "stalled": "the search stalled",
    "cliff": "the search stopped where a small change makes a run fail",
}
MANY = 4  # variables that are named


def badges(every: Sequence[Results], lenders: Sequence[Results] = ()) -> list[Cell]:
    """What one asks first. ``lenders``: folders that lend their limits to those that have none."""
    told = [(*_of_tuning(found, lenders), *_of_run(found, lenders), *_of_many(found)) for found in every]
    return [badge for badges in told for badge in badges]


def _of_tuning(found: Results, lenders: Sequence[Results]) -> list[Cell]:
    tuned = found.tuned
    if tuned is None:
        return []
    held = standing(found, lenders)
    kept = tuned["feasible"] and (held is None or not held.faults)
    force = _of_objective(found, lenders, kept)
    first = [] if tuned["feasible"] else [Cell(f"{INFEASIBLE} found", "bad")]
    limits = [] if held is None or not (held.faults or tuned["feasible"]) else [_of_limits(found, held)]
    return [*first, *limits, force, *_of_search(tuned)]


def _of_objective(found: Results, lenders: Sequence[Results], kept: bool) -> Cell:
    """The objective before and after. A higher one is no fault: limits that the start breaks may cost that much."""
    tuned = found.tuned or {}
    before, after, unit = (tuned[f"objective_{name}"] for name in ("before", "after", "unit"))
    told = f"{words(tuned['objective'])}: {shown(before)} → {shown(after)} {unit}"
    if before is None or after is None:
        return Cell(told)
    start = judged(found, lenders, "before")
    allowed = start is None or all(start.keeping)
    told += f" ({100 * (after / before - 1):+.2g} %)" if before else ""
    told += "" if allowed else ", from a start that breaks limits"
    return Cell(told, "" if not kept else "good" if after <= before or not allowed else "unsure")


def _of_limits(found: Results, held: Standing) -> Cell:
    """Which limits are broken, or how sure it is that all are kept."""
    missed = [f"{held.missed} of {held.runs} not {words(found.success or '')}"] if held.missed else []
    if held.faults:
        return Cell(", ".join([*_broken(held), *missed]), "bad")
    return Cell(", ".join(["all limits kept", *_nearly(held)]), "unsure" if _nearly(held) else "good")


def _broken(held: Standing) -> list[str]:
    return [f"{held.broken} limit{'s' if held.broken > 1 else ''} broken"] if held.broken else []


def _nearly(held: Standing) -> list[str]:
    """What is kept, but not for certain."""
    counts = {"at the limit": held.at_limit, "not known": held.unknown}
    return [f"{count} {what}" for what, count in counts.items() if count]


def _of_search(tuned: Record) -> list[Cell]:
    """Whether a search converged, and whether another one found the same (``borne_out``, where it is recorded)."""
    if not tuned["feasible"]:
        return []
    told = [] if tuned.get("converged", True) else [STOPPED.get(tuned.get("ended", ""), "the search did not converge")]
    told += [] if tuned.get("borne_out", True) else [UNCONFIRMED]
    return [Cell(text, "unsure") for text in told]


def _of_run(found: Results, lenders: Sequence[Results]) -> list[Cell]:
    record, derived, told = found.records.get("run"), found.sensitivity, []
    if record is not None:
        held = standing(found, lenders) if found.tuned is None else None
        end = ended(found.mechanism, record["outcome"])
        kept, mark = _with_limits(held, end.mark)
        text = ", ".join([words(record["outcome"]), *kept, f"peak force {record['peak_force [N]']:.4g} N"])
        told.append(Cell(text, mark))
        verdict = (record.get("trust") or {}).get("verdict", "trusted")
        told += [] if verdict == "trusted" else [Cell(f"numbers: {verdict}", TRUST.get(verdict, "unsure"))]
    if derived is not None and derived["certificate"] is not None:
        verdict = derived["certificate"]["verdict"]
        told.append(Cell(f"gradients: {verdict}", MARKS.get(verdict, "")))
    return told


def _with_limits(held: Standing | None, mark: str) -> tuple[list[str], str]:
    """What to say of a run's limits, and how to mark a run that ended as ``mark`` says."""
    if held is None:
        return [], mark
    if held.faults:
        return _broken(held), "bad"
    return ["limits kept", *_nearly(held)], "unsure" if mark == "good" and _nearly(held) else mark


def _of_many(found: Results) -> list[Cell]:
    told, points = [], found.records.get("front", {}).get("points")
    if envelope := found.records.get("sweep", {}).get("envelope"):
        safe, runs = envelope["safe_runs"], envelope["runs"]
        told.append(Cell(f"{safe} of {runs} runs of the sweep are safe", "good" if safe == runs else "unsure"))
        if (between := envelope.get("between")) and between["unsafe_runs"]:
            count = f"{between['unsafe_runs']} of {between['runs']} runs"
            told.append(Cell(f"{count} between the study's scenarios are not safe", "bad"))
    for surface in found.records.get("sample", {}).get("surfaces", ()):
        error = surface["cross_validated"][surface["kind"]]["relative"]
        text = f"surface of {words(surface['quantity'])}: misses {100 * error:.2g} %"
        told.append(Cell(text, "good" if surface["trusted"] else "bad"))
    if points:
        marks = [STANDING[point["standing"]] for point in points if point["standing"] in ON_FRONT]
        unsure = f", {marks.count('unsure')} not converged" if "unsure" in marks else ""
        mark = "unsure" if unsure else "good" if marks else "bad"
        told.append(Cell(f"front of {len(marks)} point{'' if len(marks) == 1 else 's'}{unsure}", mark))
    return told


def abstract(every: Sequence[Results]) -> list[str]:
    """A few sentences on each result, the folder's name before them where several have results of its kind."""
    kinds = (_tuning, _run, _sensitivity, _sweep, _sample, _front)
    by_kind = [[(found, text) for found in every if (text := kind(found, every))] for kind in kinds]
    return [f"{found.folder}: {text}" if len(some) > 1 else text for some in by_kind for found, text in some]


def _tuning(found: Results, every: Sequence[Results]) -> str:
    """From where to where the objective went, whether limits are kept, by which numbers, and how the search ended."""
    tuned, mechanism = found.tuned, found.mechanism
    if tuned is None:
        return ""
    if not tuned["feasible"]:
        return f"No design was found that keeps every limit: {'; '.join(tuned.get('why') or [tuned['message']])}."
    count = len(tuned["scenarios"])
    limits = standing(found, every)
    kept = " keeps every limit" if limits is None or not limits.faults else " does not keep every limit"
    where = "its scenario" if count == 1 else f"the {count} scenarios"
    text = f"{_objective(mechanism, tuned)}; the design{kept} in {where}."
    ended = (
        "The search converged." if tuned.get("converged", True) else f"The search {tuned['message'].split('. ')[0]}."
    )
    texts = [text, _variables(mechanism, tuned), ended]
    if (corners := tuned.get("corners")) is not None:  # how far samples say what is worst
        texts.append(f"The scenarios are {tuned['sample']['count']} samples, which are no bound: {corners['said'][0]}.")
    return " ".join(texts)


def _objective(mechanism: Mechanism, tuned: Record) -> str:
    """From where to where the objective went; only where to, if runs of the start failed."""
    before, after = tuned["objective_before"], tuned["objective_after"]
    symbol, factor = tuned["objective_unit"], 1.0
    known = mechanism.quantities.get(tuned["objective"].partition(",")[0])
    if known is not None and known.unit == symbol:
        symbol, factor = known.in_figures
    objective = words(tuned["objective"]).replace("over the cases", "over the scenarios")
    end = f"to {factor * after:.4g} {symbol}".rstrip(" -")
    if before is None:
        return f"Tuning brought {objective} {end}, from a start whose runs failed"
    way = "left" if same(before, after) else "lowered" if after < before else "raised"
    change = f" ({100.0 * (after / before - 1.0):+.2g} %)" if before > 0.0 else ""
    return f"Tuning {way} {objective}, from {factor * before:.4g} {end}{change}"


def _variables(mechanism: Mechanism, tuned: Record) -> str:
    """What became of the variables that changed, the first ones."""
    usual, texts = mechanism.design(), list[str]()
    moved = [it for it in tuned["variables"] if not same(it["before"], it["value"])]
    for it in moved[:MANY]:
        symbol, typed = unit(usual, it["path"]), it.get("shown_in", "")
        (first, shown_in), (last, _) = (as_typed(it[name], symbol, typed) for name in ("before", "value"))
        texts.append(f"{it['path']} from {shown(first)} to {shown(last)} {shown_in}".rstrip(" -"))
    left = len(moved) - len(texts)
    return f"It changes {', '.join(texts) or 'no number'}{f' and {left} more' if left else ''}."


def _run(found: Results, every: Sequence[Results]) -> str:
    record, mechanism = found.records.get("run"), found.mechanism
    if record is None:
        return ""
    values, label = by_name(record), mechanism.view.label(scenario_of(mechanism, record["scenario"]))
    reason = mechanism.outcomes[record["outcome"]].reason
    text = f"At {label} the {mechanism.view.run_name} ends after {values['end_time']:.4g} s: {reason}."
    if values.get("peak_force") is not None:
        text += f" Its largest contact force is {values['peak_force']:.4g} N."
    limits = standing(found, every) if found.tuned is None else None
    if limits is None:
        return text
    faults = [f"{limits.broken} limit{'s are' if limits.broken > 1 else ' is'} broken."] if limits.broken else []
    faults += [f"It does not end {words(found.success or '')}, as it must."] if limits.missed else []
    return " ".join([text, *(faults or ["It keeps every limit."])])


def _sensitivity(found: Results, every: Sequence[Results]) -> str:
    """Which number moves the first quantity most."""
    record, mechanism = found.sensitivity, found.mechanism
    if record is None or not record["derivatives"]:
        return ""
    name = record["derivatives"][0]["quantity"]
    rows = [row for row in record["derivatives"] if row["quantity"] == name and row["elasticity [-]"] is not None]
    if not rows:
        return ""
    most, verdict = max(rows, key=lambda row: abs(row["elasticity [-]"])), rows[0]["verdict"]
    change = f"{most['elasticity [-]']:+.2g} % ({'not certified' if verdict is None else verdict})"
    moved = f"{most['parameter']} moves the {title(mechanism, name)} most"
    return f"Of {len(rows)} numbers {moved}: 1 % more of it changes it by {change}."


def _sweep(found: Results, every: Sequence[Results]) -> str:
    """How the runs ended, how far the largest force goes, and how many runs are safe."""
    if found.sweep is None:
        return ""
    over = " and ".join(swept_fields(found))
    over = f"over {over}" if over else "of runs given one by one"
    text = f"{_ended(found.mechanism, outcome_counts(found))} in a sweep {over}."
    force = np.asarray(found.sweep["peak_force"].values, float) if "peak_force" in found.sweep else np.zeros(0)
    if np.any(np.isfinite(force)):
        text += f" The largest contact force is {np.nanmin(force):.4g} to {np.nanmax(force):.4g} N."
    envelope = found.records.get("sweep", {}).get("envelope")
    safe = "" if envelope is None else f" {envelope['safe_runs']} of {envelope['runs']} keep every limit."
    return text + safe


def _sample(found: Results, every: Sequence[Results]) -> str:
    """How the runs ended, and whose scatter matters most for each quantity."""
    record, mechanism = found.records.get("sample"), found.mechanism
    if record is None:
        return ""
    text = f"{_ended(mechanism, record['outcomes'])} in a sample of {len(record['ranges'])} numbers."
    largest: dict[str, Record] = {}
    for row in record["indices"]:
        if row["total [-]"] > largest.get(row["quantity"], {"total [-]": -np.inf})["total [-]"]:
            largest[row["quantity"]] = row
    for name, row in largest.items():
        share = f"{100.0 * row['total [-]']:.2g} % of its variance"
        text += f" The {title(mechanism, name)} is scattered most by {row['number']} ({share})."
    return text


def _front(found: Results, every: Sequence[Results]) -> str:
    """How many designs are on a front, and between which ends it trades."""
    record, mechanism = found.records.get("front"), found.mechanism
    if record is None:
        return ""
    points = [point for point in record["points"] if point["standing"] in ON_FRONT]
    text = f"{len(points)} of {len(record['points'])} tuned designs are on the front of"
    text += f" {' and '.join(map(words, record['objectives']))}."
    open_ends = sum(not point["converged"] for point in points)
    for name in record["objectives"] if points else ():
        values = [by_name(point)[f"worst {name}"] for point in points]
        known = mechanism.quantities.get(name)
        symbol, factor = ("", 1.0) if known is None else known.in_figures
        ends = dict.fromkeys(f"{factor * end:.4g}" for end in (min(values), max(values)))
        text += f" The worst {title(mechanism, name)} on it is {' to '.join(ends)} {symbol}".rstrip(" -") + "."
    return text + (f" {open_ends} of them did not converge." if open_ends else "")


def _ended(mechanism: Mechanism, counts: Mapping[str, Any]) -> str:
    """How many runs ended as they should."""
    should, every = mechanism.successes or (mechanism.outcomes.time_is_up(),), sum(counts.values())
    good = sum(counts.get(name, 0) for name in should)
    ends = [words(name) for name in should if name in counts] or [words(should[0])]
    text = f"{good} of {every} {mechanism.view.run_name}s end {' or '.join(ends)}"
    return text + (f", {counts[OPEN]} are {OPEN}" if OPEN in counts else "")
