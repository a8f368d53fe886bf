"""Formats of result files, and what a command hands over to be saved."""

import csv
import io
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

ARRAYS = "sweep.npz"
ENVELOPE = ("envelope.png", "envelope.txt")
Contents = Mapping[str, Callable[[], str | bytes]]  # a file's name and what makes its content


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
