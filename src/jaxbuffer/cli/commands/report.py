"""`jaxbuffer report` and `compare`: what folders of results hold, as text and as a page, without computing it again."""

from pathlib import Path

from ...errors import InputError
from ...output.folder import Results, load_finished, unfinished
from ...pages.compare import compared, comparison, limit_tables
from ...pages.page import Page, write_page
from ...pages.review import review
from ..exits import OK
from ..streams import note, show


def report(folders: list[Path], html: Path | None, title: str) -> int:
    """Make a page of folders of results and print their summaries."""
    page = review([loaded(folder) for folder in folders], title)
    file = _saved(html or folders[0] / "report.html", page)
    for folder in folders:
        for text in sorted(file for file in folder.glob("*.txt") if file.is_file()):
            show(_text(text))
        for figure in sorted(folder.glob("*.png")):
            show(f"figure {figure}")
    show(f"wrote {file}")
    return OK


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


def _text(file: Path) -> str:
    try:
        text = file.read_text(encoding="utf-8").rstrip("\n")
    except UnicodeDecodeError as error:
        raise InputError(f"{file} is damaged: byte {error.start} is not text") from None
    # A file is written whole, so an empty one was cut short by something else.
    if not text:
        raise InputError(f"{file} is damaged: it is empty")
    return text
