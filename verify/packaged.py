"""The few numbers of a verification that go with the package, for the page of `jaxbuffer report`."""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from jaxbuffer.pages.verification import sources
from jaxbuffer.version import version

Record = dict[str, Any]


def packaged(evidence: Sequence[Record], tests: Path, breakages: Sequence[Record]) -> Record | None:
    """How many claims hold, tests passed and breakages were noticed, each [how many, of how many], and of which state
    of the program; None where a part was not run."""
    if not (evidence and breakages and tests.exists()):
        return None
    cases = list(ElementTree.parse(tests).iter("testcase"))
    passed = [all(case.find(kind) is None for kind in ("failure", "error", "skipped")) for case in cases]
    within = [abs(record["measured"]) <= record["tolerance"] for record in evidence]
    noticed = ["failed" in record["checks"].values() for record in breakages]
    return {
        "jaxbuffer": version(),
        "sources": sources(),
        "date": datetime.now(UTC).date().isoformat(),
        **{
            name: [sum(good), len(good)]
            for name, good in (("claims", within), ("tests", passed), ("breakages", noticed))
        },
    }
