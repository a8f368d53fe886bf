"""The tables of a run, which docs/benchmarks.md includes: ``python -m benchmarks.docs [results.json]``."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
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


def main(arguments: Sequence[str]) -> int:
    """Write the tables; the exit status."""
    file = Path(arguments[0]) if arguments else RESULTS
    if not file.is_file():
        print(f"{file}: no such file; `make bench` writes it", file=sys.stderr)
        return 2
    TABLES.write_text(tables(file.read_text(encoding="utf-8")), encoding="utf-8")
    print(f"wrote {TABLES}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
