"""Whether a run keeps to the study's [problem.constraints]."""

from typing import TYPE_CHECKING

from .exits import LIMITS_BROKEN, OK, fail

if TYPE_CHECKING:
    from ..mechanisms.run import Run
    from ..study.config import Config


def keeps_limits(study: "Config", run: "Run") -> int:
    """The exit code: `LIMITS_BROKEN`, with a line that says which limits, where the study has limits and the run does
    not keep to them."""
    if "constraints" not in study.table:
        return OK
    from ..study.problem_toml import limits

    broken = limits(study.table, study.mechanism).broken_by(run)
    return fail(f"[problem.constraints] not kept: {'; '.join(broken)}", LIMITS_BROKEN) if broken else OK
