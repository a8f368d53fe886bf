"""`jaxbuffer reproduce`: a paper's own studies, as figures and as claims that hold or don't."""

import functools
from pathlib import Path
from typing import Any

from ...errors import check_choice
from ...output import style
from ...output.formats import csv_text, json_text
from ...papers import PAPERS, paper_named
from ...papers.study import run_paper, runs, verdicts_of
from ...papers.tables import NAMED, claims_table, markdown
from ...programs import process
from ..exits import OK, fail
from .output import Output
from .progress import counting


def reproduce(output: Path, paper: str, force: bool) -> int:
    """Run a paper's studies, and print claim by claim whether the model bears its text out."""
    check_choice("PAPER", paper, tuple(PAPERS))
    style.require_matplotlib()
    process.configure(cache=process.cache_folder())
    process.check_ready()
    chosen = paper_named(paper)
    figures = [f"{study.name}.png" for study in chosen.studies]
    files = Output(output, ["claims.md", "studies.csv", "studies.json", *figures], force)
    studied = counting(runs(chosen.studies), lambda done: run_paper(chosen, done))
    rows = [row for found in studied for row in found.rows]
    failed = [row for row in rows if str(row["outcome"]).startswith("failed")]
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
    for found in studied:
        contents |= style.both(found.study.name, functools.partial(chosen.part_of(found.study).figure, found))
    files.save_and_show(lambda: contents, claims_table(verdicts))
    return OK
