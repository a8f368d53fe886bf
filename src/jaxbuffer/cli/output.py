"""Result files: refused before anything is computed if they exist, written in one go at the end."""

import csv
import io
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError

SUMMARIES = ("capture.txt", "sensitivity.txt", "tune.txt")  # what a command printed, for `jaxbuffer report`
ARRAYS = "sweep.npz"


class Output:
    """The files of one command in a folder, or nothing at all without a folder."""

    def __init__(self, folder: Path | None, names: Sequence[str], force: bool) -> None:
        self.folder, self.force = folder, force
        if folder is None:
            return
        parent = next(p for p in (folder, *folder.absolute().parents) if p.exists())
        if not parent.is_dir():
            raise InputError(f"{parent} is a file; --output needs a folder")
        taken = [str(folder / name) for name in names if (folder / name).exists()]
        if taken and not force:
            raise InputError(f"{', '.join(taken)} exist{'s' if len(taken) == 1 else ''}; --force overwrites")
        if not os.access(parent, os.W_OK | os.X_OK):
            raise InputError(f"{folder}: no permission to write there")

    def write(self, contents: Mapping[str, str | bytes]) -> list[Path]:
        """Write every file; returns their paths."""
        if self.folder is None:
            return []
        self.folder.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            # "x" fails on a file that appeared while we computed
            with (self.folder / name).open("wb" if self.force else "xb") as file:
                file.write(content.encode() if isinstance(content, str) else content)
        return [self.folder / name for name in contents]


def json_text(record: Mapping[str, Any]) -> str:
    """Indented JSON; NaN and infinity, which JSON lacks, must be None already."""
    return json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def csv_text(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A header with units and one line a row, floats to the last digit."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()
