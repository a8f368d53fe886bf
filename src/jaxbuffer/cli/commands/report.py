"""`jaxbuffer report` and `compare`: what folders of results hold, as text and as a page, without computing it again."""

from pathlib import Path

from ...errors import InputError
from ...experiments.what_if import LEAST, MOST, RUNS, most_runs
from ...files import cache_folder
from ...output.folder import Results, load_finished, unfinished
from ...pages.compare import compared, comparison, limit_tables
from ...pages.page import Page, write_page
from ...pages.review import review
from ...pages.what_if import make_what_if, tuned_folder, tuned_problem
from ...programs import process
from ..exits import OK
from ..streams import note, show
from .progress import sweeping


def report(folders: list[Path], html: Path | None, title: str, what_if: bool, runs: str | None) -> int:
    """Make a page of folders of results and print its abstract."""
    if runs is not None and not what_if:
        raise InputError("--runs are those of --what-if; give both")
    # The page shows what the folder holds, so the models must lie there first.
    if what_if:
        _make_sliders(folders, runs)
    page = review([loaded(folder) for folder in folders], title)
    file = _saved(html or folders[0] / "report.html", page)
    # Each folder's own summary was printed by its command and lies in the folder.
    for text in filter(None, ("; ".join(cell.text for cell in page.verdicts), *page.abstract)):
        show(text)
    show(f"wrote {file}")
    return OK


def _make_sliders(folders: list[Path], typed: str | None) -> None:
    """Run a tuned design's neighbours, and keep what the page's sliders show."""
    if typed is not None and not (typed.isdecimal() and LEAST <= int(typed) <= MOST):
        raise InputError(f"--runs {typed} must be a whole number from {LEAST} to {MOST}")
    process.configure(cache=cache_folder() or True)
    process.check_ready()
    runs, folder = int(typed or RUNS), tuned_folder(folders)
    words = ["report", *map(str, folders), "--what-if", *(["--runs", typed] if typed else [])]
    most = most_runs(tuned_problem(folder), runs)
    file = sweeping(most, lambda report: make_what_if(folder, runs, report, words), "simulating at most")
    show(f"wrote {file}")


def compare(folders: list[Path], html: Path | None) -> int:
    """Put the designs of several folders side by side."""
    if len(folders) < 2:
        raise InputError("compare needs two folders at least")
    every = [loaded(folder) for folder in folders]
    page = comparison(every)
    file = _saved(html or folders[0] / "compare.html", page)
    for one in [*compared(every), *limit_tables(every)]:
        show(one.as_text())
    show(f"wrote {file}")
    return OK


def loaded(folder: Path) -> Results:
    """Return what a folder holds; a note on stderr says what in it is not finished."""
    results = load_finished(folder)
    if begun := unfinished(folder):
        note(begun)
    return results


def _saved(file: Path, page: Page) -> Path:
    """Write a page; another one of ours may be replaced, and a note says so, nothing else."""
    if write_page(page, file, "--html FILE"):
        note(f"the page {file} is overwritten")
    return file
