"""What was verified for these sources: `python -m verify` writes it into a small file, which a wheel built then has."""

import functools
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..version import version

PACKAGE = Path(__file__).parent.parent
FILE = Path(__file__).parent / "verified.json"
HOW = "`make verify` in a checkout runs them all; docs/verification.md says what they are."
TELLING = ("cli", "output", "pages", "papers")  # folders that show numbers and compute none


@functools.cache
def sources() -> str:
    """Return a digest of the program text, without the folders that only show numbers."""
    digest = hashlib.sha256()
    # Sorted, and with "/" in names below: the digest must not depend on the file system.
    for path in sorted(PACKAGE.rglob("*.py")):
        inside = path.relative_to(PACKAGE)
        if inside.parts[0] not in TELLING:
            digest.update(f"{inside.as_posix()}\n".encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def verified(file: Path = FILE) -> Mapping[str, Any] | None:
    """Return what the last verification counted; None if none was run with these sources."""
    if not file.is_file():
        return None
    try:
        counted = json.loads(file.read_text(encoding="utf-8"))
    except ValueError:
        return None
    return counted if isinstance(counted, dict) and counted.get("sources") == sources() else None


def lines(counted: Mapping[str, Any] | None) -> list[str]:
    """Return the same in a few sentences. ``counted``: as of `verified`."""
    if counted is None:
        return [f"No checks have been run for these sources (jaxbuffer {version()}, digest {sources()}). {HOW}"]
    count = lambda name: f"{counted[name][0]} of {counted[name][1]}"  # noqa: E731
    return [
        f"Verified on {counted['date']}, as jaxbuffer {counted['jaxbuffer']}; these very equations and solvers.",
        f"{count('claims')} measured errors against closed forms, published numbers and independent programs are within"
        f" their tolerances; {count('tests')} tests passed; {count('breakages')} deliberate breakages of the equations"
        " were noticed.",
        "What each claim is, and where no evidence exists: docs/verification.md.",
    ]
