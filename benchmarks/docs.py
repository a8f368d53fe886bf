"""The tables of a run between the marks of docs/benchmarks.md: ``python -m benchmarks.docs [results.json]``."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from . import report
from .plan import ROOT

PAGE = ROOT / "docs" / "benchmarks.md"
RESULTS = ROOT / "benchmarks" / "results" / "results.json"
BEGIN, END = "<!-- results: begin -->", "<!-- results: end -->"


def filled(page: str, results: str) -> str:
    """The ``page`` with what stands between its marks replaced by the tables of ``results``, a results.json's text."""
    found = json.loads(results)
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"no {BEGIN} … {END} in the page")
    lines = report.markdown(report.restored(found), found).splitlines()[2:]  # the page has a heading of its own
    deeper = [f"#{line}" if line.startswith("#") else line for line in lines]
    return "\n".join([before + begin, "", *deeper, "", end + after])


def main(arguments: Sequence[str]) -> int:
    """Fill in the page; the exit status."""
    file = Path(arguments[0]) if arguments else RESULTS
    if not file.is_file():
        print(f"{file}: no such file; `make bench` writes it", file=sys.stderr)
        return 2
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), file.read_text(encoding="utf-8")), encoding="utf-8")
    print(f"wrote {PAGE}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
