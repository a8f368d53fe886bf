"""Formats of result files, and what a command hands over to be saved."""

import csv
import io
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

Made = Mapping[str, Any] | None  # how a result came about (`provenance.made`), where that is known
Contents = Mapping[str, Callable[[], str | bytes]]  # a file's name and what makes its content


def json_text(record: Mapping[str, Any]) -> str:
    """Indented JSON; NaN and infinity, which JSON lacks, must be None already."""
    return json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def compact_json(record: Mapping[str, Any]) -> str:
    """JSON in one line, for data that nobody reads."""
    return json.dumps(record, ensure_ascii=False, allow_nan=False, separators=(",", ":")) + "\n"


def table_json(name: str, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table under a name as JSON, a record for each row; what is not finite is null."""
    finite = lambda value: None if isinstance(value, float) and not math.isfinite(value) else value  # noqa: E731
    return json_text({name: [dict(zip(header, map(finite, row), strict=True)) for row in rows]})


def csv_text(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A header with units and one line a row, floats to the last digit."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()
