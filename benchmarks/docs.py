"""The tables of a run, which docs/benchmarks.md includes: ``python -m benchmarks docs``."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from . import report
from .plan import ROOT

PAGE = ROOT / "docs" / "benchmarks.md"
TABLES = ROOT / "benchmarks" / "measured.md"
RESULTS = ROOT / "benchmarks" / "results" / "results.json"


def tables(results: str) -> str:
    """Return the tables of ``results``, a results.json's text, as Markdown for below a heading of second order."""
    record = json.loads(results)
    lines = report.markdown(report.restored(record), record).splitlines()[2:]  # the page has a heading of its own
    return "\n".join(f"#{line}" if line.startswith("#") else line for line in lines) + "\n"


def main(file: Path = RESULTS) -> int:
    """Write the tables; the exit status."""
    if not file.is_file():
        print(f"{file}: no such file; `make bench` writes it", file=sys.stderr)
        return 2
    TABLES.write_text(tables(file.read_text(encoding="utf-8")), encoding="utf-8")
    print(f"wrote {TABLES}")
    return 0
