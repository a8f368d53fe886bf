"""Whether a run keeps to the study's [problem.constraints]."""

from typing import TYPE_CHECKING, NamedTuple

from .exits import LIMITS_BROKEN, OK, fail

if TYPE_CHECKING:
    from ..mechanisms.quantity import Catalogue
    from ..mechanisms.run import Run
    from ..study.config import Config
    from ..tuning.objective import Limits


class Asked(NamedTuple):
    """A study's limits, and the own quantities that they name."""

    limits: "Limits"
    own: "Catalogue"


def asked_limits(study: "Config") -> Asked | None:
    """The study's limits, or None. Call it before the run: own quantities that they name are read from files, which may
    fail."""
    if "constraints" not in study.table:
        return None
    from ..study.own_quantities import own_quantities
    from ..study.problem_toml import limits

    found = limits(study.table, study.mechanism)
    if not {*found.at_most, *found.at_least} & set(study.table.get("quantities", {})):
        return Asked(found, {})
    own = own_quantities(study.table, study.mechanism, study.folder)
    return Asked(found, {name: derived.as_quantity(name) for name, derived in own.items()})


def keeps_limits(asked: Asked | None, run: "Run") -> int:
    """The exit code: `LIMITS_BROKEN`, with a line that says which limits, where the study has limits and the run does
    not keep to them."""
    if asked is None:
        return OK
    broken = asked.limits.broken_by(run, asked.own)
    return fail(f"[problem.constraints] not kept: {'; '.join(broken)}", LIMITS_BROKEN) if broken else OK
