"""What a tuning says of its end: how the best search ended, how far others bear it out, and what to do."""

from typing import Literal, NamedTuple

import numpy as np

from .evaluation import Evaluation
from .goal import Goal
from .progress import Progress
from .search import CONVERGED, Branch
from .settings import Settings
from .starts import AGREE
from .why import broken_limits

INFEASIBLE = "no feasible design found: "
Ended = Literal["converged", "limit_of_steps", "stalled", "cliff"]
"""How a search ends: nothing left to gain within its tolerance, at its limit of steps, steps that gain less than the
tolerance though more seems to be left, or where a small change makes a run fail."""


class End(NamedTuple):
    """How a tuning ended; fields as of `Tuned`."""

    ended: Ended
    borne_out: bool
    message: str


def end(goal: Goal, branch: Branch, after: Evaluation, progress: Progress, settings: Settings) -> End:
    """How the best search ended, how far others bear it out, and what to do."""
    agree = progress.searches > 1 and progress.apart <= AGREE
    return End(ending(branch, settings), agree, _message(goal, branch, after, progress, settings))


def _message(goal: Goal, branch: Branch, after: Evaluation, progress: Progress, settings: Settings) -> str:
    more = (
        f"raise starts (now {settings.starts}) or rounds (now {settings.rounds}), or change seed, in [tune] of the"
        " study; starts and seed also by --starts and --seed"
    )
    steps = f"raise iterations (now {settings.iterations}) in [tune] of the study or by --iterations"
    if not goal.feasible(after):
        more = f"{steps}, or {more}" if ending(branch, settings) == "limit_of_steps" else more
        return f"{infeasible(goal, after, _counted(progress.searches))}. To search on within the bounds, {more}"
    further = f". To go on, {steps}" if ending(branch, settings) == "limit_of_steps" else ""
    return f"{_ending(branch, settings)}{further}. {borne_out(progress, more)}"


def infeasible(goal: Goal, after: Evaluation, searched: str) -> str:
    """That no design keeps to the limits, and which limits; ``searched``: by how much searching."""
    found = broken_limits(goal, after)
    broken = "; ".join(limit.heading for limit in found)
    held = dict.fromkeys(path for limit in found for path in limit.held)
    widen = f"widen the bounds of {', '.join(held)}, which hold them back, or relax" if held else "relax"
    return f"{INFEASIBLE}after {searched}, {broken}. To keep the limits, {widen} the limits"


def headline(message: str, feasible: bool) -> str:
    """A tuning's first line."""
    return f"Tuned: {message}" if feasible else f"No feasible design found: {message.removeprefix(INFEASIBLE)}"


def ending(branch: Branch, settings: Settings) -> Ended:
    """How a search ended."""
    if branch.status == CONVERGED:
        return "converged"
    if branch.steps >= settings.iterations:
        return "limit_of_steps"
    return "cliff" if np.any(np.isfinite(branch.cliffs)) else "stalled"


def left_to_gain(branch: Branch) -> str:
    """The first-order residual in words."""
    return f"small changes would gain {100.0 * branch.residual:.2g} % of the objective"


def _ending(branch: Branch, settings: Settings) -> str:
    told: dict[Ended, str] = {
        "converged": "converged",
        "limit_of_steps": f"stopped at the limit of {settings.iterations} steps",
        "stalled": "stalled: steps gain less than the tolerance",
        "cliff": "stopped at a cliff: ahead a small change makes a run fail",
    }
    within = f", the tolerance being {100.0 * settings.tolerance:g} %" if branch.status == CONVERGED else ""
    return f"{told[ending(branch, settings)]}; {left_to_gain(branch)}{within}"


def borne_out(progress: Progress, more: str) -> str:
    """Whether another search found the same; ``more``: what to do for further ones."""
    searches = _counted(progress.searches)
    if progress.searches == 1:
        return f"Only one search was made; for others {more}"
    if not np.isfinite(progress.apart):
        return (
            f"Of {searches} no other that began apart ended feasible within {100.0 * AGREE:g} % of it; "
            f"a better design may exist: {more}"
        )
    percent = f"{100.0 * progress.apart:.2g} %"
    if progress.apart <= AGREE:
        return f"Of {searches} the best two that began apart agree within {percent}"
    return f"Of {searches} the best two that began apart differ by {percent}; a better design may exist: {more}"


def _counted(searches: int) -> str:
    return "1 search" if searches == 1 else f"{searches} searches"
