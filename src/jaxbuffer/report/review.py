"""The page for a design review, from folders of results."""

import dataclasses
from collections import Counter
from collections.abc import Sequence

from ..output.folder import Results
from .abstract import abstract
from .asked import asked
from .badges import INFEASIBLE, badges
from .designs import design
from .experiments import front, sample, sweep
from .judged import told_already
from .limits import limits
from .origin import origin, verification
from .page import Page, Section
from .runs import diagnosis, run
from .sensitivities import sensitivity
from .tunings import scenarios, search

Parts = list[tuple[Results, Section]]


def review(every: Sequence[Results], title: str = "") -> Page:
    """One page of all folders together: the first one's design, then what each of them holds."""
    first = next((found for found in every if found.tuned), next((f for f in every if f.records), every[0]))
    made = [(first, asked(first, every)), (first, design(first))]
    made += [(found, limits(found, every)) for found in every if not told_already(found, every)]
    made += [(found, scenarios(found)) for found in every]
    for found in every:
        made += [(found, run(found, first)), (found, diagnosis(found, every))]
    made += [(found, sensitivity(found, first, every)) for found in every]
    made += [(found, make(found)) for make in (search, sweep, sample, front) for found in every]
    parts = distinct([(found, section) for found, section in made if section is not None])
    subtitle = f"{first.mechanism.view.title} · {', '.join(str(found.folder) for found in every)}"
    if first.tuned is None or first.tuned["feasible"]:
        title = title or f"{first.mechanism.view.title}: design review"
    else:
        title = f"{title or f'{first.mechanism.view.title}, design review'}: {INFEASIBLE}"
    return Page(title, subtitle, badges(every, every), [*parts, origin(every), verification()], abstract(every))


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
