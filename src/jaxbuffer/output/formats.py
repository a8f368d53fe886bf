"""Formats of result files, and writing them: refused if they exist, each whole, figures last."""

import csv
import errno
import io
import json
import math
import os
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..files import write, write_beside
from .companions import remove_stale

Made = Mapping[str, Any] | None  # how a result came about (`provenance.made`), where that is known
FIGURES = {"png": (".png",), "svg": (".svg",), "both": (".png", ".svg"), "none": ()}  # --format, the first by default
Contents = Mapping[str, Callable[[], str | bytes]]  # a file's name and what makes its content
Writers = dict[str, Callable[[], str | bytes]]
OTHER_FORMS = (".mat", ".nc")  # of what a result's JSON and CSV files hold
# of result files
ENDINGS = (".csv", ".gif", ".html", ".json", ".mat", ".mp4", ".nc", ".npz", ".png", ".svg", ".toml", ".txt")


def json_text(record: Mapping[str, Any]) -> str:
    """Return a record as indented JSON; NaN and infinity, which JSON lacks, must be None already."""
    return json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def compact_json(record: Mapping[str, Any]) -> str:
    """Return a record as JSON in one line, for data that nobody reads."""
    return json.dumps(record, ensure_ascii=False, allow_nan=False, separators=(",", ":")) + "\n"


def table_json(name: str, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Return a table under a name as JSON, a record for each row; what is not finite is null."""
    finite = lambda value: None if isinstance(value, float) and not math.isfinite(value) else value  # noqa: E731
    return json_text({name: [dict(zip(header, map(finite, row), strict=True)) for row in rows]})


def csv_text(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Return a header with units and one line a row, floats to the last digit."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()


def is_figure(name: str) -> bool:
    """Return whether a file is a figure, which shows what other files hold."""
    return name.endswith(FIGURES["both"])


def _turn(name: str) -> int:
    """Return when a file has its turn: first what has all of the numbers, then other forms of them, last the figures.

    The first are written in a moment; netCDF alone takes a second, most of it imports.
    """
    return 2 if is_figure(name) else int(name.endswith(OTHER_FORMS))


def with_figures(contents: Contents, chosen: str) -> Contents:
    """Return the files with their figures in the ``chosen`` format alone, a name in `FIGURES`."""
    return {name: make for name, make in contents.items() if not is_figure(name) or name.endswith(FIGURES[chosen])}


def check_folder(folder: Path, option: str = "folder") -> None:
    """Raise `InputError` for a folder that cannot be made or written to. ``option``: by what it was named."""
    if folder.suffix.lower() in ENDINGS and not folder.exists():
        plain = folder.with_suffix("")
        raise InputError(f"{option} {folder} has the ending of a file and names a folder; write {option} {plain}")
    # The folder need not be there: what counts is the nearest one above it that is.
    parent = next(p for p in (folder, *folder.absolute().parents) if p.exists())
    if not parent.is_dir():
        raise InputError(f"{parent} is a file; {option} needs a folder")
    # A file can be made in a folder only where that may be both written and entered.
    if not os.access(parent, os.W_OK | os.X_OK):
        raise InputError(f"{folder}: no permission to write there")


def check_free(folder: Path, names: Sequence[str], force: bool, ways: str = "") -> None:
    """Raise `InputError` for files that exist, unless ``force``. ``ways``: what else than overwriting can be done."""
    taken = [str(folder / name) for name in names if (folder / name).exists()]
    if taken and not force:
        exist, them = ("exists", "it") if len(taken) == 1 else ("exist", "them")
        listed = taken[0] if len(taken) == 1 else f"{taken[0]} and {len(taken) - 1} more"
        raise InputError(f"{listed} {exist}; {ways or 'force=True overwrites, another folder keeps {}'}".format(them))


def write_all(
    folder: Path,
    contents: Contents,
    force: bool,
    note: Callable[[str], None] = lambda line: None,
    written_so_far: Callable[[list[Path]], None] = lambda written: None,
    own: Collection[str] = (),
) -> tuple[list[Path], Exception | None]:
    """Write every file, figures last; return those that were written, and the first error. ``written_so_far`` is called
    once all numbers are on disk, before their other forms and the figures are made, which takes a while.

    What an earlier result of the same kind left there is removed first, because it would be taken for the new one's. A
    file that cannot be made or written leaves the others alone; the error of a figure that cannot be drawn is an
    `OSError`. Without ``force`` a file that has appeared meanwhile is left as it is, and ``note`` is called with where
    the result is instead; one that the command wrote itself, by its name in ``own``, is replaced.
    """
    written: list[Path] = []
    failure: Exception | None = None
    folder.mkdir(parents=True, exist_ok=True)
    if force:
        try:
            remove_stale(folder, contents)
        except OSError as error:
            failure = error
    # Figures last: the numbers are on disk where one cannot be drawn.
    names, numbers = sorted(contents, key=_turn), sum(not _turn(name) for name in contents)
    for k, name in enumerate(names):
        if k == numbers:
            written_so_far(written)
        path = folder / name
        try:
            text = contents[name]()
            if force or name in own:
                write(path, text)
                written.append(path)
                continue
            written.append(write_beside(path, text))
            if written[-1] != path:
                note(f"{path} appeared meanwhile and is left as it is; the result is in {written[-1]}")
        except OSError as error:
            failure = failure or error
        except Exception as error:
            if failure is None and is_figure(name):
                # matplotlib fails in many ways: the first line of what it says has to do.
                first = next((line for line in str(error).splitlines() if line.strip()), "")
                reason = f"cannot be drawn, {type(error).__name__}: {first}".rstrip(": ")
                failure = OSError(errno.EIO, reason, str(path))
            failure = failure or error
    return written, failure
