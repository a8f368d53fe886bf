"""Exit codes, and the one line on stderr that goes with them."""

import sys

OK, LIMITS_BROKEN, BAD_INPUT, FAILED, INTERRUPTED = 0, 1, 2, 3, 130
"""Done; limits are not kept; input that can't be used; the solver failed or a file could not be written; Ctrl-C."""


def fail(reason: object, code: int = FAILED) -> int:
    """Say in one line what went wrong; returns ``code``."""
    print(f"error: {' '.join(str(reason).split())}", file=sys.stderr, flush=True)
    return code
