"""Whether a run keeps to the study's [problem.constraints]."""

from typing import TYPE_CHECKING

from .exits import LIMITS_BROKEN, OK, fail

if TYPE_CHECKING:
    from ..mechanisms.run import Run
    from ..study.config import Config
    from ..tuning.asked import Asked


def asked_limits(study: "Config") -> "Asked | None":
    """The study's limits, or None. Call it before the run: own quantities that they name are read from files, which may
    fail."""
    if "constraints" not in study.table:
        return None
    from ..study.own_quantities import own_quantities
    from ..study.problem_toml import limits
    from ..tuning.asked import Asked

    found = limits(study.table, study.mechanism)
    if not {*found.at_most, *found.at_least} & set(study.table.get("quantities", {})):
        return Asked(found, {})
    return Asked(found, own_quantities(study.table, study.mechanism, study.folder))


def keeps_limits(asked: "Asked | None", run: "Run") -> int:
    """The exit code: `LIMITS_BROKEN`, with a line that says which limits, where the study has limits and the run does
    not keep to them."""
    if asked is None:
        return OK
    broken = asked.broken_by(run)
    return fail(f"[problem.constraints] not kept: {'; '.join(broken)}", LIMITS_BROKEN) if broken else OK
