"""Whether a run keeps to the study's [problem.constraints]."""

from typing import TYPE_CHECKING

from .exits import LIMITS_BROKEN, OK, fail

if TYPE_CHECKING:
    from ..mechanisms.run import Run
    from ..study.config import Config
    from ..tuning.objective import Constraints


def study_constraints(study: "Config") -> "Constraints | None":
    """Read the study's constraints, or None.

    Call it before the run: own quantities that they name are read from files, which may fail.
    """
    if "constraints" not in study.table:
        return None
    from ..study.own_quantities import own_quantities
    from ..study.problem_toml import limits
    from ..tuning.objective import Constraints

    of_study = limits(study.table, study.mechanism)
    if not {*of_study.at_most, *of_study.at_least} & set(study.table.get("quantities", {})):
        return Constraints(of_study, {})
    return Constraints(of_study, own_quantities(study.table, study.mechanism, study.folder))


def keeps_limits(constraints: "Constraints | None", run: "Run") -> int:
    """Return the exit code: `LIMITS_BROKEN`, with a line that says which limits, where the run breaks some."""
    if constraints is None:
        return OK
    broken = constraints.broken_by(run)
    return fail(f"[problem.constraints] not kept: {'; '.join(broken)}", LIMITS_BROKEN) if broken else OK
