"""Exit codes, and the one line on stderr that goes with them."""

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..sweeps.columns import RunTable

OK, LIMITS_BROKEN, BAD_INPUT, FAILED, INTERRUPTED = 0, 1, 2, 3, 130
"""Done; limits are not kept; input that can't be used; the solver failed or a file could not be written; Ctrl-C."""


def any_solved(runs: "RunTable") -> int:
    """The exit code of many runs: `FAILED`, with a line that says so, where not one of them was solved."""
    if runs.solved.any():
        return OK
    return fail(f"none of the {int(runs.done.sum())} {runs.mechanism.view.run_name}s was solved; the outcomes say why")


def fail(reason: object, code: int = FAILED) -> int:
    """Say in one line what went wrong; returns ``code``."""
    print(f"error: {' '.join(str(reason).split())}", file=sys.stderr, flush=True)
    return code
