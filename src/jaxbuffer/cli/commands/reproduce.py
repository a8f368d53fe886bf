"""`jaxbuffer reproduce`: a paper's own studies, as figures and as claims that hold or don't."""

import functools
from pathlib import Path
from typing import Any

from ...errors import InputError, check_choice
from ...files import cache_folder
from ...output import style
from ...output.formats import csv_text, json_text
from ...papers import PAPERS, paper_named
from ...papers.study import run_paper, runs, verdicts_of
from ...papers.tables import NAMED, claims_table, markdown
from ...programs import process
from ..exits import OK, fail
from .output import Output
from .progress import counting


def reproduce(output: Path, paper: str, published: bool, force: bool, figures: str | None) -> int:
    """Run a paper's studies, and print claim by claim whether the model bears its text out."""
    check_choice("PAPER", paper, tuple(PAPERS))
    chosen = paper_named(paper)
    if published and not chosen.published:
        others = [name for name in PAPERS if paper_named(name).published]
        raise InputError(f"--published: {paper} has no second set of equations; {', '.join(others)} has: leave it out")
    chosen = chosen._replace(parts=chosen.parts + chosen.published * published)
    process.configure(cache=cache_folder() or True)
    process.check_ready()
    drawn = [f"{study.name}.png" for study in chosen.studies]
    tables = [f"{study.name}.csv" for study in chosen.studies if chosen.part_of(study).table is not None]
    files = Output(output, ["claims.md", "studies.csv", "studies.json", *tables, *drawn], force, figures)
    studied = counting(runs(chosen.studies), lambda done: run_paper(chosen, done))
    rows = [row for result in studied for row in result.rows]
    failed = [row for row in rows if str(row["outcome"]).startswith("failed")]
    # Claims cannot be judged over runs that have no result.
    if failed:
        return fail("; ".join(f"{row['study']}, {row['case']}: {row['outcome']}" for row in failed))
    verdicts = verdicts_of([claim for part in chosen.parts for claim in part.claims], studied)
    columns = {**NAMED, **chosen.columns}
    heads = [f"{name} [{unit}]" if unit else name for name, unit in columns.items()]
    contents: dict[str, Any] = {
        "claims.md": lambda: markdown(chosen, studied, verdicts),
        "studies.csv": lambda: csv_text(heads, ([row.get(name, "") for name in columns] for row in rows)),
        "studies.json": lambda: json_text({"units": columns, "captures": rows, "claims": verdicts}),
    }
    for result in studied:
        part = chosen.part_of(result.study)
        if part.table is not None:
            own = part.table(result)
            cells = [list(one.values()) for one in own]
            contents[f"{result.study.name}.csv"] = functools.partial(csv_text, list(own[0]), cells)
        contents |= style.both(result.study.name, functools.partial(part.figure, result))
    files.save_and_show(lambda: contents, claims_table(verdicts))
    return OK
