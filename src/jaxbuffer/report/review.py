"""The page for a design review, from folders of results."""

import dataclasses
from collections import Counter
from collections.abc import Sequence

from ..output.folder import Record, Results
from .designs import design
from .experiments import STANDING, front, sample, sweep
from .limits import broken_limits, limits
from .origin import origin, verification
from .page import Cell, Page, Section
from .records import ended, words
from .runs import MARKS, diagnosis, run, sensitivity
from .tunings import scenarios, search

Parts = list[tuple[Results, Section]]
STOPPED = {
    "limit_of_steps": "the search stopped at its limit of steps",
    "stalled": "the search stalled",
    "cliff": "the search stopped where one bounce more or less makes a run fail",
}


def review(every: Sequence[Results], title: str = "") -> Page:
    """One page of all folders together: the first one's design, then what each of them holds."""
    first = next((found for found in every if found.tuned), next((f for f in every if f.records), every[0]))
    made = [(first, design(first))]
    made += [(found, limits(found, every)) for found in every]
    made += [(found, scenarios(found)) for found in every]
    for found in every:
        made += [(found, run(found, first)), (found, diagnosis(found, every))]
    made += [(found, sensitivity(found, first)) for found in every]
    made += [(found, make(found)) for make in (search, sweep, sample, front) for found in every]
    parts = distinct([(found, section) for found, section in made if section is not None])
    subtitle = f"{first.mechanism.title} · {', '.join(str(found.folder) for found in every)}"
    title = title or f"{first.mechanism.title}: design review"
    return Page(title, subtitle, verdicts(every, every), [*parts, origin(every), verification()])


def distinct(parts: Parts) -> list[Section]:
    """The sections; those of equal titles get their folder's name added."""
    titles = Counter(section.title for _, section in parts)
    folders = {found.folder for found, _ in parts}
    short = len({folder.name for folder in folders}) == len(folders)
    named = lambda folder: folder.name if short else str(folder)  # noqa: E731
    return [
        dataclasses.replace(part, title=f"{part.title}: {named(found.folder)}") if titles[part.title] > 1 else part
        for found, part in parts
    ]


def verdicts(every: Sequence[Results], lenders: Sequence[Results] = ()) -> list[Cell]:
    """What one asks first. ``lenders``: folders that lend their limits to those that have none."""
    told = [(*_of_tuning(found, lenders), *_of_run(found, lenders), *_of_many(found)) for found in every]
    return [verdict for verdicts in told for verdict in verdicts]


def _of_tuning(found: Results, lenders: Sequence[Results]) -> list[Cell]:
    tuned = found.tuned
    if tuned is None:
        return []
    before, after = tuned["objective_before [N]"], tuned["objective_after [N]"]
    told = f"{words(tuned['objective'])}: {before:.4g} → {after:.4g} N ({100 * (after / before - 1):+.2g} %)"
    good = tuned["feasible"] and not broken_limits(found, lenders)
    kept = Cell("all limits kept", "good") if good else Cell(_broken(broken_limits(found, lenders)), "bad")
    stopped = [] if tuned.get("converged", True) else [Cell(_stopped(tuned), "unsure")]
    return [kept, Cell(told, "good" if after <= before else "bad"), *stopped]


def _broken(count: int) -> str:
    """How many limits are broken, where that is known."""
    return f"{count} limit{'s' if count > 1 else ''} broken" if count else "limits broken"


def _stopped(tuned: Record) -> str:
    """Why a search did not converge, in a few words."""
    if not tuned["feasible"]:
        return "the search found no feasible design"
    return STOPPED.get(tuned.get("ended", ""), "the search did not converge")


def _of_run(found: Results, lenders: Sequence[Results]) -> list[Cell]:
    record, derived, told = found.records.get("run"), found.sensitivity, []
    if record is not None:
        many = 0 if found.tuned is not None else broken_limits(found, lenders)
        beyond = f", {_broken(many)}" if many else ""
        text = f"{words(record['outcome'])}{beyond}, peak force {record['peak_force [N]']:.4g} N"
        told.append(Cell(text, "bad" if many else ended(found.mechanism, record["outcome"]).mark))
    if derived is not None and derived["certificate"] is not None:
        verdict = derived["certificate"]["verdict"]
        told.append(Cell(f"gradients: {verdict}", MARKS.get(verdict, "")))
    return told


def _of_many(found: Results) -> list[Cell]:
    told, points = [], found.records.get("front", {}).get("points")
    if envelope := found.records.get("sweep", {}).get("envelope"):
        safe, runs = envelope["safe_runs"], envelope["runs"]
        told.append(Cell(f"{safe} of {runs} runs of the sweep are safe", "good" if safe == runs else "unsure"))
    for surface in found.records.get("sample", {}).get("surfaces", ()):
        error = surface["cross_validated"][surface["kind"]]["relative"]
        text = f"surface of {words(surface['quantity'])}: misses {100 * error:.2g} %"
        told.append(Cell(text, "good" if surface["trusted"] else "bad"))
    if points:
        kept = sum(point["standing"] in STANDING for point in points)
        told.append(Cell(f"front of {kept} points", "good" if kept else "bad"))
    return told
