"""`jaxbuffer reproduce`: a paper's own studies, as figures and as claims that hold or don't."""

import functools
from pathlib import Path
from typing import Annotated, Any

import typer

from .exits import OK, fail


def reproduce(
    output: Annotated[Path, typer.Option("--output", metavar="DIR", help="Folder for figures and tables.")],
    paper: Annotated[str, typer.Argument(metavar="[PAPER]", help="docking or impact.")] = "docking",
    force: Annotated[bool, typer.Option("--force", help="Overwrite result files that exist.")] = False,
) -> int:
    """Run a paper's studies, and print claim by claim whether the model bears its text out.

    \b
    docking  the buffer: rigid against buffered probe, approach speed, angular velocity, misalignment, friction,
             welded against free tip
    impact   a bar dropped on a plate: damping, plate and bar that bend, coarse steps;
             a slider-crank with play in a pin: exponent, stiffness, a rod that bends

    \b
    Files in DIR:
      claims.md     every claim and every study's numbers
      studies.csv, studies.json  the same for machines
      NAME.png, .svg  a figure a study

    \b
    Example: jaxbuffer reproduce impact --output results/impact
    """
    from ..errors import check_choice
    from ..output.formats import csv_text, json_text
    from ..output.style import both, require_matplotlib
    from ..papers import PAPERS, paper_named
    from ..programs.process import cache_folder, check_ready, configure
    from .output import Output

    check_choice("PAPER", paper, tuple(PAPERS))
    require_matplotlib()
    configure(cache=cache_folder())
    check_ready()
    from ..papers.study import run_paper, runs, verdicts_of
    from ..papers.tables import NAMED, claims_table, markdown
    from .progress import counting

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
        contents |= both(found.study.name, functools.partial(chosen.part_of(found.study).figure, found))
    files.save_and_show(lambda: contents, claims_table(verdicts))
    return OK
