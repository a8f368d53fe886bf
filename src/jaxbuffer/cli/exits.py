"""Exit codes, and the one line on stderr that goes with them."""

import sys
from pathlib import Path

from .streams import note

OK, LIMITS_BROKEN, BAD_INPUT, FAILED, INTERRUPTED = 0, 1, 2, 3, 130
"""Done; limits are not kept, or a test is not explained; input that can't be used;
the solver failed or a file could not be written; Ctrl-C."""


def fail(reason: object, code: int = FAILED) -> int:
    """Say in one line what went wrong; returns ``code``."""
    print(f"error: {' '.join(str(reason).split())}", file=sys.stderr, flush=True)
    return code


def interrupted(folder: Path | None, kept: str = "") -> int:
    """Say what an interrupted command has ``kept`` in its folder, and how it goes on there; returns the code."""
    note("nothing is kept without --output DIR" if folder is None else goes_on(folder, kept))
    return INTERRUPTED


def goes_on(folder: Path, kept: str = "") -> str:
    """Return what is ``kept`` in a folder, in words, and how it goes on there."""
    return "; ".join(filter(None, (kept, f"the same command with --resume goes on in {folder}")))
