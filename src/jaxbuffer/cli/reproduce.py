"""`jaxbuffer reproduce`: the paper's own studies, as figures and as claims that hold or don't."""

import functools
from pathlib import Path
from typing import Annotated

import typer

from .exits import OK, fail
from .request import cache_folder


def reproduce(
    output: Annotated[Path, typer.Option("--output", metavar="DIR", help="Folder for figures and tables.")],
    force: Annotated[bool, typer.Option("--force", help="Overwrite result files that exist.")] = False,
) -> int:
    """Run the paper's studies: rigid against buffered probe, approach speed, angular velocity, misalignment, friction,
    welded against free tip. Prints claim by claim whether the model bears the paper's text out.

    \b
    Files in DIR:
      claims.md     every claim and every study's numbers
      studies.csv, studies.json  the same for machines
      NAME.png      a figure a study

    \b
    Example: jaxbuffer reproduce --output results/paper
    """
    from ..compiling.process import configure
    from ..output.formats import Contents, csv_text, json_text
    from ..output.style import require_matplotlib
    from .output import Output

    require_matplotlib()
    configure(cache=cache_folder())
    from ..paper import STUDIES, judged, run
    from ..paper.run import COLUMNS, captures
    from ..paper.tables import claims_table, markdown
    from .progress import counting

    figures = [f"{study.name}.png" for study in STUDIES]
    files = Output(output, ["claims.md", "studies.csv", "studies.json", *figures], force)
    studied = counting(captures(), lambda done: run(done=done))
    failed = [row for found in studied for row in found.rows if str(row["outcome"]).startswith("failed")]
    if failed:
        return fail("; ".join(f"{row['study']}, {row['case']}: {row['outcome']}" for row in failed))
    from ..paper.figures import figure

    verdicts = judged(studied)
    rows = [row for found in studied for row in found.rows]
    heads = [f"{name} [{unit}]" if unit else name for name, unit in COLUMNS.items()]
    contents: Contents = {
        "claims.md": lambda: markdown(studied, verdicts),
        "studies.csv": lambda: csv_text(heads, ([row[name] for name in COLUMNS] for row in rows)),
        "studies.json": lambda: json_text({"units": COLUMNS, "captures": rows, "claims": verdicts}),
        **{f"{found.study.name}.png": functools.partial(figure, found) for found in studied},
    }
    files.save_and_show(lambda: contents, claims_table(verdicts))
    return OK
