"""The page for a design review, from folders of results."""

import dataclasses
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from ..errors import InputError, check_flag
from ..experiments.what_if import RUNS
from ..files import user_path
from ..output.folder import Results, load_finished
from .abstract import abstract
from .badges import INFEASIBLE, badges
from .choice import NONE_KEEPS, choice
from .designs import design, requirements
from .experiments import front, sample, sweep
from .fit import fit, fit_problem
from .limit_check import repeats_tuning
from .limits import fails_in_corners_alone, limits
from .origin import origin, verification
from .page import Page, PageSection, write_page
from .runs import diagnosis, run, scenarios, search
from .sensitivities import sensitivity
from .tolerances import tolerances
from .what_if import make_what_if, tuned_folder
from .what_if import what_if as sliders

Parts = list[tuple[Results, PageSection]]


def report(
    *folders: str | Path, to: str | Path | None = None, title: str = "", what_if: bool = False, runs: int = RUNS
) -> Path:
    """Make a page for a design review of the results in some folders; only ``what_if`` computes anything.

    The page is one HTML file that needs nothing else: limits, the design, scenarios, forces over time, elasticities,
    the search, samples, fronts, and where the numbers come from (docs/report.md).

    **Arguments:**

    - ``folders``: of commands, of `save`, or of `tune`, `sweep`, `sample` and `pareto` with ``folder``; the design of
      the first tuning, or else of the first folder, is that of the page.
    - ``to``: the page's file; default: ``report.html`` in the first folder. A page of ours is replaced.
    - ``title``: of the page.
    - ``what_if``: whether to make sliders first: models of the tuned design's quantities, fitted to ``runs`` of each
      scenario and kept in the tuned folder.

    **Returns:** the page's path.

    **Raises:** `InputError` as `load` does, and for a file that is there and no page of ours.

    **Example:**

    >>> import tempfile
    >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run.save(folder)[0].name, jb.report(folder, title="Bar, first drop").name
    ('drop.json', 'report.html')
    """
    if not folders:
        raise InputError("report needs a folder of results, as in jb.report('results')")
    check_flag("what_if", what_if)
    if what_if:
        make_what_if(tuned_folder(folders), runs)
    page = review([load_finished(folder) for folder in folders], title)
    file = user_path(folders[0] if to is None else to)
    file = file / "report.html" if to is None else file
    write_page(page, file, "file, to=…")
    return file


def review(every: Sequence[Results], title: str = "") -> Page:
    """Return one page of all folders together: the first one's design, then what each of them holds."""
    # The tuned design is the page's, wherever its folder stands: other folders may be of the start.
    first = next((results for results in every if results.tuned), next((f for f in every if f.records), every[0]))
    # Margins first. A run that repeats a scenario of a tuning would say the same a second time.
    made = [(results, limits(results, every)) for results in every if not repeats_tuning(results, every)]
    made += [(first, requirements(first, every)), (first, design(first))]
    made += [(results, scenarios(results)) for results in every]
    made += [(results, make(results)) for make in (tolerances, choice, fit) for results in every]
    for results in every:
        made += [(results, run(results, first)), (results, diagnosis(results, every))]
    made += [(results, sliders(results)) for results in every]
    made += [(results, sensitivity(results, first, every)) for results in every]
    made += [(results, make(results)) for make in (search, sweep, sample, front) for results in every]
    parts = distinct([(results, section) for results, section in made if section is not None])
    subtitle = f"{first.mechanism.view.title} · {', '.join(str(results.folder) for results in every)}"
    if failure := _failure(first, every):
        title = f"{title or f'{first.mechanism.view.title}, design review'}: {failure}"
    else:
        title = title or f"{first.mechanism.view.title}: design review"
    return Page(title, subtitle, badges(every, every), [*parts, origin(every), verification()], abstract(every))


def _failure(first: Results, every: Sequence[Results]) -> str:
    """Return what the page's title says of a search that has found nothing; "" elsewhere."""
    if first.tuned is not None:
        return "" if first.tuned["feasible"] or fails_in_corners_alone(first, every) else INFEASIBLE
    found = {name: record for name, record in first.records.items() if name in ("choice", "fit")}
    if "choice" in found and not found["choice"]["feasible"]:
        return NONE_KEEPS
    return fit_problem(found["fit"]) if "fit" in found else ""


def distinct(parts: Parts) -> list[PageSection]:
    """Return the sections; those of equal titles get their folder's name added."""
    titles = Counter(section.title for _, section in parts)
    folders = {results.folder for results, _ in parts}
    # The last part of a path is enough where it tells the folders apart.
    short = len({folder.name for folder in folders}) == len(folders)
    named = lambda folder: folder.name if short else str(folder)  # noqa: E731
    return [
        dataclasses.replace(part, title=f"{part.title}: {named(results.folder)}") if titles[part.title] > 1 else part
        for results, part in parts
    ]
