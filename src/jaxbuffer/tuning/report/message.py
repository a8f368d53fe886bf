"""The words with which a tuning ends: how the best search ended, which limits are broken and why, and what to do."""

from typing import Literal, NamedTuple

import numpy as np

from ...mechanisms.mechanism import EndCount
from ...value_text import percent_text
from ..problem.settings import Settings
from ..search.checks import PeakForceBound
from ..search.evaluation import Evaluation
from ..search.goal import Goal
from ..search.search import AGREE, CONVERGED, Branch
from ..search.store import Progress
from .broken_limits import broken_limits

INFEASIBLE = "no feasible design found: "
Ended = Literal["converged", "limit_of_steps", "stalled", "discontinuity"]
"""How a search ends: nothing left to gain within its tolerance, at its limit of steps, steps that gain less than the
tolerance though more seems to be left, or where a small change makes a run fail."""


class SearchReport(NamedTuple):
    """What a search says of itself.

    ``well``: how it ended, where its design keeps all limits; ``effort``: how much it searched; ``more``: how to search
    on where none does, "" for nothing.
    """

    well: str
    effort: str
    more: str = ""

    def message(self, goal: Goal, after: Evaluation, bound: PeakForceBound | None = None) -> str:
        """Return how the search ended with a design, and what to do. ``bound``: as of `broken_limits`."""
        if goal.feasible(after):
            return self.well
        limits = broken_limits(goal, after, bound)
        broken = "; ".join(f"{limit.heading}; {limit.beneath}" if limit.beneath else limit.heading for limit in limits)
        others = [limit for limit in limits if not limit.beneath]
        advice = ["lower that bound, or relax the limit under it" for limit in limits[:1] if len(others) < len(limits)]
        if others:
            paths = dict.fromkeys(path for limit in others for path in limit.at_bounds)
            widen = f"widen the bounds of {', '.join(paths)}, which hold them back" if paths else "free other numbers"
            advice.append(f"{widen}, or relax the {'other ' if advice else ''}limits")
        # To search on is of no use where all lie under their lower bounds.
        more = self.more if others else ""
        return f"{INFEASIBLE}after {self.effort}, {broken}. To keep the limits, {'; '.join(advice)}{more}"


def search_report(branch: Branch, progress: Progress, settings: Settings) -> SearchReport:
    """Say how the best search ended, whether another one agrees, and what to do."""
    more = (
        f"raise starts (now {settings.starts}) or rounds (now {settings.rounds}), or change seed, in [tune] of the"
        " study; starts and seed also by --starts and --seed"
    )
    steps = f"raise iterations (now {settings.iterations}) in [tune] of the study or by --iterations"
    limited = ending(branch, settings) == "limit_of_steps"
    further = f". To go on, {steps}" if limited else ""
    well = f"{_ending(branch, settings)}{further}. {agreement_in_words(progress, more)}"
    search_on = f". To search on within the bounds, {f'{steps}, or ' if limited else ''}{more}"
    return SearchReport(well, _count(progress.searches), search_on)


def headline(message: str, feasible: bool, ended: EndCount | None = None) -> str:
    """Return a tuning's first line. ``ended``: in how many scenarios its strictest end was reached."""
    counted = "" if ended is None else f", {ended}"
    if feasible:
        return f"Tuned{counted}: {message}"
    return f"No feasible design found{counted}: {message.removeprefix(INFEASIBLE)}"


def ending(branch: Branch, settings: Settings) -> Ended:
    """Return how a search ended."""
    if branch.status == CONVERGED:
        return "converged"
    if branch.steps >= settings.iterations:
        return "limit_of_steps"
    return "discontinuity" if np.any(np.isfinite(branch.discontinuities)) else "stalled"


def left_to_gain(branch: Branch) -> str:
    """Return the first-order residual in words."""
    return f"small changes would gain {percent_text(branch.residual)} of the objective"


def _ending(branch: Branch, settings: Settings) -> str:
    words: dict[Ended, str] = {
        "converged": "converged",
        "limit_of_steps": f"stopped at the limit of {settings.iterations} steps",
        "stalled": "stalled: steps gain less than the tolerance",
        "discontinuity": "stopped at a discontinuity: ahead a small change makes a run fail",
    }
    within = f", the tolerance being {percent_text(settings.tolerance, 'g')}" if branch.status == CONVERGED else ""
    return f"{words[ending(branch, settings)]}; {left_to_gain(branch)}{within}"


def agreement_in_words(progress: Progress, more: str) -> str:
    """Say whether another search agrees; ``more``: what to do for further ones."""
    searches = _count(progress.searches)
    if progress.searches == 1:
        return f"Only one search was made; for others {more}"
    if not np.isfinite(progress.apart):
        return (
            f"Of {searches} no other that began apart ended feasible within {percent_text(AGREE, 'g')} of it; "
            f"a better design may exist: {more}"
        )
    apart = percent_text(progress.apart)
    if progress.apart <= AGREE:
        return f"Of {searches} the best two that began apart agree within {apart}"
    return f"Of {searches} the best two that began apart differ by {apart}; a better design may exist: {more}"


def _count(searches: int) -> str:
    return "1 search" if searches == 1 else f"{searches} searches"
