"""`jaxbuffer report` and `compare`: what folders of results hold, as text and as a page, without computing it again."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import InputError
from .exits import OK
from .streams import note, show

if TYPE_CHECKING:
    from ..output.folder import Results
    from ..pages.page import Page


Folders = Annotated[list[Path], typer.Argument(metavar="DIR…", help="Folders that --output named.")]
Html = Annotated[
    Path | None, typer.Option("--html", metavar="FILE", help="Where the page goes; default: in the first DIR.")
]


def loaded(folder: Path) -> "Results":
    """Return what a folder holds; a note on stderr says what in it is not finished."""
    from ..output.folder import load_finished, unfinished

    results = load_finished(folder)
    if begun := unfinished(folder):
        note(begun)
    return results


def report(
    folders: Folders,
    html: Html = None,
    title: Annotated[str, typer.Option(metavar="TEXT", help="The page's title.")] = "",
) -> int:
    """Make a page for a design review of the results in DIR, and print their summaries again.

    The page, report.html, is one file that needs no network: the design, limits, scenarios, forces over time, why a
    run did not succeed, elasticities, the search, the envelope, samples, fronts, and where the numbers come from.
    Several folders make one page: of a tuning, of a run of the tuned design, of its sensitivities, of a sweep.

    \b
    Examples:
      jaxbuffer report results/table2
      jaxbuffer report results/tuned results/run results/sensitivity results/sweep --title "Probe B, review 2"
    """
    from ..pages.review import review

    page = review([loaded(folder) for folder in folders], title)
    file = _saved(html or folders[0] / "report.html", page)
    for folder in folders:
        _print(folder)
    show(f"wrote {file}")
    return OK


def compare(folders: Folders, html: Html = None) -> int:
    """Put the designs of several folders side by side: where they differ, what they reach, which limits they keep,
    their forces over time.

    \b
    Example: jaxbuffer compare results/before results/after
    """
    from ..pages.compare import compared, comparison, kept

    if len(folders) < 2:
        raise InputError("compare needs two folders at least")
    every = [loaded(folder) for folder in folders]
    page = comparison(every)
    file = _saved(html or folders[0] / "compare.html", page)
    for one in [*compared(every), *kept(every)]:
        show(one.as_text())
    show(f"wrote {file}")
    return OK


def _saved(file: Path, page: "Page") -> Path:
    """Write a page; another one of ours may be replaced, and a note says so, nothing else."""
    from ..pages.page import write_page  # jinja2 takes a tenth of a second to import

    if write_page(page, file, "--html FILE"):
        note(f"the page {file} is made anew")
    return file


def _print(folder: Path) -> None:
    for file in sorted(file for file in folder.glob("*.txt") if file.is_file()):
        show(_text(file))
    for figure in sorted(folder.glob("*.png")):
        show(f"figure {figure}")


def _text(file: Path) -> str:
    try:
        text = file.read_text(encoding="utf-8").rstrip("\n")
    except UnicodeDecodeError as error:
        raise InputError(f"{file} is damaged: byte {error.start} is not text") from None
    if not text:
        raise InputError(f"{file} is damaged: it is empty")
    return text
