"""The badges at the top of a page: what one asks first of each folder."""

from collections.abc import Sequence

from ..output.folder import Record, Results
from .experiments import ON_FRONT, STANDING
from .judged import judged
from .limits import Standing, keeping, standing
from .page import Cell, shown
from .records import ended, words
from .sensitivities import MARKS

INFEASIBLE = "no feasible design"
UNCONFIRMED = "no other search found the same: a better design may exist"
TRUST = {"check": "unsure", "ill-conditioned": "bad", "unknown": "unsure"}  # verdicts on a run's numbers
STOPPED = {
    "limit_of_steps": "the search stopped at its limit of steps",
    "stalled": "the search stalled",
    "cliff": "the search stopped where a small change makes a run fail",
}


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
    allowed = start is None or all(keeping(found.mechanism, start))
    told += f" ({100 * (after / before - 1):+.2g} %)" if before else ""
    told += "" if allowed else ", from a start that breaks limits"
    return Cell(told, "" if not kept else "good" if after <= before or not allowed else "unsure")


def _of_limits(found: Results, held: Standing) -> Cell:
    """Which limits are broken, or how sure it is that all are kept."""
    missed = [f"{held.missed} of {held.runs} not {words(found.mechanism.success or '')}"] if held.missed else []
    if held.faults:
        return Cell(", ".join([*_broken(held), *missed]), "bad")
    return Cell(", ".join(["all limits kept", *_nearly(held)]), "unsure" if _nearly(held) else "good")


def _broken(held: Standing) -> list[str]:
    return [f"{held.broken} limit{'s' if held.broken > 1 else ''} broken"] if held.broken else []


def _nearly(held: Standing) -> list[str]:
    """What is kept, but not for certain."""
    counts = {"at the limit": held.at_limit, "still rising at the end": held.rising, "not known": held.unknown}
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
