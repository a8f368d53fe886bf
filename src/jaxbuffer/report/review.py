"""The page for a design review, from folders of results."""

from collections.abc import Sequence

from .designs import design
from .folder import Results
from .page import Cell, Page, Section
from .records import ended
from .runs import MARKS, origin, run, sensitivity, sweep
from .tunings import limits, scenarios, search


def review(every: Sequence[Results], title: str = "") -> Page:
    """One page of all folders together: the first one's design, then what each of them holds."""
    first = next((found for found in every if found.tuned), next((f for f in every if f.records), every[0]))
    parts: list[Section | None] = [design(first)]
    parts += [make(found) for make in (limits, scenarios) for found in every]
    parts += [make(found, first) for make in (run, sensitivity) for found in every]
    parts += [make(found) for make in (search, sweep) for found in every]
    parts.append(origin(every))
    subtitle = f"{first.mechanism.title} · {', '.join(str(found.folder) for found in every)}"
    title = title or f"{first.mechanism.title}: design review"
    return Page(title, subtitle, verdicts(every), [part for part in parts if part is not None])


def verdicts(every: Sequence[Results]) -> list[Cell]:
    """What one asks first."""
    found: list[Cell] = []
    for results in every:
        tuned, record, derived = results.tuned, results.run, results.sensitivity
        if tuned is not None:
            before, after = tuned["objective_before [N]"], tuned["objective_after [N]"]
            told = f"{tuned['objective']}: {before:.4g} → {after:.4g} N ({100 * (after / before - 1):+.2g} %)"
            found.append(Cell("all limits kept", "good") if tuned["feasible"] else Cell("limits broken", "bad"))
            found.append(Cell(told, "good" if after <= before else "bad"))
        if record is not None:
            told = f"{record['outcome']}, peak force {record['peak_force [N]']:.4g} N"
            found.append(Cell(told, ended(results.mechanism, record["outcome"]).mark))
        if derived is not None and derived["certificate"] is not None:
            verdict = derived["certificate"]["verdict"]
            found.append(Cell(f"gradients: {verdict}", MARKS.get(verdict, "")))
    return found
