"""What a tuning says of its end: how the best search ended, how far others bear it out, and what to do."""

import numpy as np

from .evaluation import Evaluation
from .goal import Goal
from .progress import Progress
from .search import CONVERGED, Branch
from .settings import Settings
from .starts import AGREE


def message(goal: Goal, branch: Branch, after: Evaluation, progress: Progress, settings: Settings) -> str:
    """How the best search ended, how far others bear it out, and what to do."""
    more = f"raise tune.starts (now {settings.starts}) or tune.rounds (now {settings.rounds}), or change tune.seed"
    if not goal.feasible(after):
        broken = "; ".join(goal.broken(after)[:3])
        return f"no feasible design was found in {_counted(progress.searches)}: {broken}. To search on, {more}"
    return f"{_ending(branch, settings)}. {borne_out(progress, more)}"


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
