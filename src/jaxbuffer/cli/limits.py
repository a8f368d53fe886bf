"""Whether a run keeps to the study's [problem.constraints]."""

from typing import TYPE_CHECKING

from .exits import LIMITS_BROKEN, OK, fail

if TYPE_CHECKING:
    from ..mechanisms.run import Run
    from ..study.config import Config
    from ..tuning.objective import Limits


def limits_of(study: "Config") -> "Limits | None":
    """The study's own limits, None where it has none."""
    if "constraints" not in study.table:
        return None
    from ..study.problem_toml import limits

    return limits(study.table, study.mechanism)


def keeps_limits(study: "Config", run: "Run") -> int:
    """The exit code: `LIMITS_BROKEN`, with a line that says which limits, where the study has limits and the run does
    not keep to them."""
    limits = limits_of(study)
    broken = [] if limits is None else limits.broken_by(run)
    return fail(f"[problem.constraints] not kept: {'; '.join(broken)}", LIMITS_BROKEN) if broken else OK
