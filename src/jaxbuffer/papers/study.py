"""What a paper's studies are: cases as data, their runs and rows of numbers, and verdicts on the paper's claims."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from .._types import Figure
from ..mechanisms.run import Run
from ..run.simulate import simulate
from .claims import NONE, Claim, Row


class StudyCase(NamedTuple):
    """One run of a study.

    ``label``: in figures and tables; ``value``: the varied number in the label's unit; ``design``, ``scenario`` of any
    mechanism; ``options``: further arguments of `jaxbuffer.simulate`, such as ``duration``.
    """

    label: str
    value: float
    design: Any
    scenario: Any
    options: Mapping[str, Any] = {}


class Study(NamedTuple):
    """One or several figures of a paper.

    ``name``: in file names; ``figures``: the paper's; ``varied``: what distinguishes the cases, with its unit;
    ``assumed``: what the paper's text leaves open.
    """

    name: str
    figures: str
    title: str
    varied: str
    assumed: str
    cases: tuple[StudyCase, ...]


class Studied(NamedTuple):
    """A study with its runs (histories included) and their rows."""

    study: Study
    captures: tuple[Any, ...]
    rows: tuple[Row, ...]


def simulated(case: StudyCase) -> Run:
    """Simulate a case with its history."""
    # A case's own options come last, because some ask for a history of more rows.
    return simulate(case.design, case.scenario, **{"history": True, **case.options})


class PaperPart(NamedTuple):
    """The studies of one mechanism.

    ``studies``; ``columns``: of a row after study and case, with units; ``shown`` of them in tables; ``row``: the
    numbers of a case and its run; ``claims``; ``figure``: of a study; ``table``: of a study, in place of a row a run,
    written to NAME.csv as well; ``solve``: how a case is run.
    """

    studies: tuple[Study, ...]
    columns: Mapping[str, str]
    shown: tuple[str, ...]
    row: Callable[[StudyCase, Any], Row]
    claims: Sequence[Claim]
    figure: Callable[[Studied], "Figure"]
    table: Callable[[Studied], list[Row]] | None = None
    solve: Callable[[StudyCase], Any] = simulated


class Paper(NamedTuple):
    """A paper: its ``name`` on the command line, ``title``, a ``note`` above its claims, and its parts; ``published``:
    further parts, with its equations as they are printed (``--published``)."""

    name: str
    title: str
    note: str
    parts: tuple[PaperPart, ...]
    published: tuple[PaperPart, ...] = ()

    @property
    def studies(self) -> tuple[Study, ...]:
        """Return the studies of all parts."""
        return tuple(study for part in self.parts for study in part.studies)

    @property
    def columns(self) -> dict[str, str]:
        """Return the columns of all parts' rows, with units."""
        return {name: unit for part in self.parts for name, unit in part.columns.items()}

    def part_of(self, study: Study) -> PaperPart:
        """Return which part a study belongs to."""
        return next(part for part in self.parts if study in part.studies)


def known(row: Row) -> Row:
    """Return a row with `NONE` in place of each NaN."""
    return {name: NONE if isinstance(value, float) and math.isnan(value) else value for name, value in row.items()}


def runs(studies: Sequence[Study]) -> int:
    """Count the runs that studies take."""
    return sum(len(study.cases) for study in studies)


def run(
    part: PaperPart, studies: Sequence[Study] | None = None, done: Callable[[str], None] = lambda _: None
) -> list[Studied]:
    """Simulate every case of a part's studies (default: all of them); ``done`` hears of each."""
    results = []
    for study in part.studies if studies is None else studies:
        made: list[Any] = []
        for case in study.cases:
            made.append(part.solve(case))
            done(f"{study.title}: {case.label}")
        pairs = zip(study.cases, made, strict=True)
        named = (
            {"study": study.name, "case": case.label, "value": case.value, **known(part.row(case, one))}
            for case, one in pairs
        )
        results.append(Studied(study, tuple(made), tuple(named)))
    return results


def run_paper(paper: Paper, done: Callable[[str], None] = lambda _: None) -> list[Studied]:
    """Run all studies of a paper; ``done`` hears of each run."""
    return [studied for part in paper.parts for studied in run(part, done=done)]


def verdicts_of(claims: Sequence[Claim], studied: Sequence[Studied]) -> list[dict[str, str]]:
    """Judge claim by claim: what the text says, what the model says, and whether they agree."""
    rows = {one.study.name: one.rows for one in studied}
    return [
        {"claim": claim.claim, "section": claim.where, "model": judged.finding, "verdict": judged.verdict}
        for claim in claims
        for judged in (claim.judge(rows),)
    ]
