"""What a tuning says of its end: how the best search ended, how far others bear it out, and what to do."""

import numpy as np

from .evaluation import Evaluation
from .goal import Goal
from .progress import Progress
from .search import CONVERGED, Branch
from .settings import Settings
from .starts import AGREE
from .why import broken_limits

INFEASIBLE = "no feasible design found: "


def message(goal: Goal, branch: Branch, after: Evaluation, progress: Progress, settings: Settings) -> str:
    """How the best search ended, how far others bear it out, and what to do."""
    more = (
        f"raise starts (now {settings.starts}) or rounds (now {settings.rounds}), or change seed, in [tune] of the"
        " study; starts and seed also by --starts and --seed"
    )
    if not goal.feasible(after):
        return f"{infeasible(goal, after, _counted(progress.searches))}. To search on, {more}"
    return f"{_ending(branch, settings)}. {borne_out(progress, more)}"


def infeasible(goal: Goal, after: Evaluation, searched: str) -> str:
    """That no design keeps to the limits, and which limits; ``searched``: by how much searching."""
    broken = "; ".join(limit.heading for limit in broken_limits(goal, after))
    return f"{INFEASIBLE}after {searched}, {broken}"


def headline(message: str, feasible: bool) -> str:
    """A tuning's first line."""
    return f"Tuned: {message}" if feasible else f"No feasible design found: {message.removeprefix(INFEASIBLE)}"


def _ending(branch: Branch, settings: Settings) -> str:
    if branch.status == CONVERGED:
        return f"converged: first-order residual {branch.residual:.1e} within {settings.tolerance:g}"
    if branch.steps >= settings.iterations:
        return f"stopped at the limit of {settings.iterations} steps, first-order residual {branch.residual:.1e}"
    where = "stalled: steps gain less than the tolerance"
    if np.any(np.isfinite(branch.cliffs)):
        where = "stopped at a cliff: ahead one bounce more or less makes a run fail"
    return f"{where}; to first order {branch.residual:.1e} of the objective would be left to gain"


def borne_out(progress: Progress, more: str) -> str:
    """Whether another search found the same; ``more``: what to do for further ones."""
    searches = _counted(progress.searches)
    if progress.searches == 1:
        return f"Only one search was made; for others {more}"
    if not np.isfinite(progress.apart):
        return (
            f"Of {searches} no other that began apart came within {100.0 * AGREE:g} % of it; "
            f"a better design may exist: {more}"
        )
    percent = f"{100.0 * progress.apart:.2g} %"
    if progress.apart <= AGREE:
        return f"Of {searches} the best two that began apart agree within {percent}"
    return f"Of {searches} the best two that began apart differ by {percent}; a better design may exist: {more}"


def _counted(searches: int) -> str:
    return "1 search" if searches == 1 else f"{searches} searches"
