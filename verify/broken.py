"""Pytest plugin: break the physics named by ``--broken`` before anything is traced; note what each check said."""

import json
from pathlib import Path

from .breakages import BREAKAGES

HEARD: dict[str, list[str]] = {}


def pytest_addoption(parser):
    """The two options of a broken run."""
    parser.addoption("--broken", required=True)
    parser.addoption("--broken-report", type=Path, required=True)


def pytest_configure(config):
    """Break it."""
    chosen = {breakage.name: breakage for breakage in BREAKAGES}[config.getoption("--broken")]
    chosen.apply()


def pytest_runtest_logreport(report):
    """Remember how each test ended: passed, failed (an assertion) or crashed (anything else)."""
    if report.when == "call" or report.outcome == "failed":
        crash = getattr(report.longrepr, "reprcrash", None)
        asserted = crash is not None and crash.message.startswith(("AssertionError", "assert", "Failed"))
        said = "passed" if report.passed else "failed" if asserted else "crashed"
        HEARD.setdefault(said, []).append(report.nodeid)


def pytest_sessionfinish(session):
    """Write it down."""
    session.config.getoption("--broken-report").write_text(json.dumps(HEARD, indent=1))
