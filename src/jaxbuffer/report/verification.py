"""What is known of how far this version's numbers can be trusted: a small file that `python -m verify` makes."""

import functools
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..version import version

PACKAGE = Path(__file__).parent.parent
FILE = Path(__file__).parent / "verified.json"
COMPUTING = (
    *("process", "cache", "program_files", "identity", "structure", "threads"),
    *("plane", "multibody", "contact", "hybrid", "mechanisms", "run", "sensitivities"),
)
UNKNOWN = "Nothing is known of how this version was verified: it was packaged without the results of python -m verify."


@functools.cache
def sources() -> str:
    """A digest of the program text of the rooms that compute, by which a state of them is known again."""
    found = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE)
        if name.parts[0].removesuffix(".py") in COMPUTING:
            found.update(f"{name.as_posix()}\n".encode() + path.read_bytes())
    return found.hexdigest()[:16]


def verified(file: Path = FILE) -> Mapping[str, Any] | None:
    """What the last verification counted, None where that is not known."""
    if not file.is_file():
        return None
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except ValueError:
        return None
    return found if isinstance(found, dict) else None


def lines(found: Mapping[str, Any] | None) -> list[str]:
    """The same in a few sentences. ``found``: as of `verified`."""
    if found is None:
        return [UNKNOWN]
    if found["sources"] == sources():
        told = [f"Verified on {found['date']}, as jaxbuffer {found['jaxbuffer']}; these very equations and solvers."]
    else:
        told = [
            f"The checks were run on {found['date']} on an earlier state of version {found['jaxbuffer']} (digest"
            f" {found['sources']}); the computing code has changed since (jaxbuffer {version()}, digest {sources()});"
            " what follows need not hold for it. Run `make verify` to check what is installed."
        ]
    count = lambda name: f"{found[name][0]} of {found[name][1]}"  # noqa: E731
    told.append(
        f"{count('claims')} measured errors against closed forms, published numbers and independent programs are within"
        f" their tolerances; {count('tests')} tests passed; {count('breakages')} deliberate breakages of the equations"
        " were noticed."
    )
    told.append("What each claim is, and where no evidence exists: docs/verification.md.")
    return told
