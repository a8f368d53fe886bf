"""Exit codes, and the one line on stderr that goes with them."""

import sys

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def fail(reason: object, code: int = FAILED) -> int:
    """Say in one line what went wrong; returns ``code``."""
    print(f"error: {' '.join(str(reason).split())}", file=sys.stderr, flush=True)
    return code
