"""The assessment of a finished search: its best design at tight tolerance, with the evidence for it."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from .checks import lower_bound
from .corners import CornerRuns, Corners, corners, run_corners
from .evaluation import Evaluation, Evaluator
from .goal import Goal, Tangent
from .message import INFEASIBLE, Ended
from .model_step import residual
from .problem import Problem
from .settings import Settings
from .spread import spreads, tightening
from .store import Record
from .tuned import Tuned


def assess(
    goal: Goal,
    settings: Settings,
    evaluator: Evaluator,
    first: Float[np.ndarray, " variables"],
    best: Evaluation,
    scale: float,
    penalty: float,
    message: Callable[[Evaluation], str],
    records: Sequence[Record],
    *,
    ended: Ended,
    confirmed: bool,
) -> Tuned:
    """Evaluate the best design of a search at tight tolerance, with the evidence for it.

    **Arguments:** ``first``: scaled variables of the problem's own start; ``best``: the best design at the search's
    tolerance; ``scale`` of the objective and ``penalty`` on what is above a limit, for the first-order residual;
    ``message``: how it ended, in words, from the best design at tight tolerance; others as of `Tuned`.
    """
    problem, scaled = goal.problem, best.scaled
    # The start at the tight tolerance too, so that what is gained is none of the search's own error.
    before, after = evaluator([first, scaled], rtol=evaluator.tight)
    # One set of weights for both slopes: which load case is the worst may differ by rounding, which is no error.
    cases = goal.objective.case_weights(after.quantities @ goal.weights(goal.objective))
    exact = goal.slope(after, cases)
    error, largest = float(np.max(np.abs(goal.slope(best, cases) - exact))), float(np.max(np.abs(exact)))
    # Before the count of captures below: the corners are runs, too.
    runs = run_corners(problem, evaluator, scaled, evaluator.tight)
    in_corners = None if runs is None else corners(problem, runs)
    more = {} if runs is None or not problem.tolerances else _of_tolerances(problem, evaluator, scaled, runs)
    return Tuned(
        problem=problem,
        settings=settings,
        goal=goal,
        design=problem.built(scaled),
        before=before,
        after=after,
        residual=residual(goal, Tangent.of(after), scaled, scale, penalty).predicted_reduction,
        gradient_error=error / largest if largest > 0.0 else 0.0 if error == 0.0 else float("nan"),
        ended=ended,
        confirmed=confirmed,
        message=message_with_corners(message(after), in_corners, goal.feasible(after)),
        lower_bound=lower_bound(problem, scaled),
        records=tuple(records),
        captures=evaluator.captures,
        corners=in_corners,
        **more,
        tight=evaluator.tight,
    )


def _of_tolerances(problem: Problem, evaluator: Evaluator, scaled: np.ndarray, runs: CornerRuns) -> dict[str, Any]:
    """Return which tolerances matter."""
    arguments = (problem, evaluator, scaled, runs, evaluator.tight)
    return {"spreads": spreads(*arguments), "tightening": tightening(*arguments)}


def message_with_corners(message: str, in_corners: Corners | None, feasible: bool) -> str:
    """Return a message with the verdict of the corners before it: where they break something, and of tolerances."""
    if in_corners is None:
        return message
    if in_corners.hold and feasible:
        return (
            f"{in_corners.verdict}. {message[:1].upper()}{message[1:]}" if "tolerances" in in_corners.what else message
        )
    if feasible:
        return f"{in_corners.verdict}. {message[:1].upper()}{message[1:]}"
    return f"{INFEASIBLE}{in_corners.verdict}; {message.removeprefix(INFEASIBLE)}" if not in_corners.hold else message
