"""Pytest plugin: how each test ended and, where wanted, which lines of the package it was the first to reach."""

import json
import time
from pathlib import Path
from typing import Any


class Listener:
    """Writes a line of JSON a test: its name, what it said, its time [s of the processor], and the lines."""

    def __init__(self, notes: Path, tree: Path, reach: bool) -> None:
        self.notes, self.package, self.coverage, self.began = notes, tree / "src" / "jaxbuffer", None, 0.0
        if reach:
            import coverage

            self.coverage = coverage.Coverage(data_file=None, include=[f"{self.package}/*"], config_file=False)
            self.coverage.start()

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """A test starts."""
        self.began = time.process_time()
        if self.coverage:
            self.coverage.switch_context(nodeid)

    def pytest_runtest_logreport(self, report: Any) -> None:
        """A test has ended, or failed to start."""
        if report.when == "call" or report.outcome == "failed":
            crash = getattr(report.longrepr, "reprcrash", None)
            said = str(crash.message if crash else report.longrepr)[:300] if report.failed else ""
            self.note(test=report.nodeid, outcome=report.outcome, said=said, lines=self.lines(report.nodeid))

    def pytest_collectreport(self, report: Any) -> None:
        """A file could not be imported."""
        if report.failed:
            self.note(test="", outcome="unimportable", said=str(report.longrepr)[-300:], lines={})

    def lines(self, test: str) -> dict[str, list[int]]:
        """Those that a test has reached, by file."""
        if not self.coverage:
            return {}
        data, found = self.coverage.get_data(), {}
        data.set_query_context(test)
        for path in data.measured_files():
            if lines := data.lines(path):
                found[str(Path(path).relative_to(self.package))] = sorted(lines)
        return found

    def note(self, **what: Any) -> None:
        """One line."""
        with self.notes.open("a") as file:
            file.write(json.dumps(what | {"seconds": round(time.process_time() - self.began, 3)}) + "\n")
