"""The best design of a search, judged at tight tolerance."""

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float

from .corners import corners
from .evaluation import Evaluation, Evaluator
from .floor import floor
from .goal import Goal, Tangent
from .message import End
from .model_step import residual
from .settings import Settings
from .store import Record
from .tuned import Tuned

TIGHT = 1e-9  # rtol at which the result is judged, where the mechanism does not say otherwise


def judged(
    goal: Goal,
    settings: Settings,
    evaluator: Evaluator,
    first: Float[np.ndarray, " variables"],
    best: Evaluation,
    scale: float,
    penalty: float,
    end: Callable[[Evaluation], End],
    records: Sequence[Record],
) -> Tuned:
    """The result of a tuning.

    **Arguments:** ``first``: scaled variables of the problem's own start; ``best``: the best design at the search's
    tolerance; ``scale`` of the objective and ``penalty`` on what is above a limit, for the first-order residual;
    ``end``: how it ended, from the best design at tight tolerance; ``records``: as of `Tuned`.
    """
    problem, scaled = goal.problem, best.scaled
    stepping = problem.mechanism.stepping
    tight = TIGHT if stepping is None else stepping.tight
    before, after = evaluator([first, scaled], rtol=tight)
    in_corners = corners(goal, evaluator, scaled, tight)
    return Tuned(
        problem=problem,
        settings=settings,
        goal=goal,
        design=problem.built(scaled),
        before=before,
        after=after,
        residual=residual(goal, Tangent.of(after), scaled, scale, penalty).predicted_reduction,
        gradient_error=disagreement(goal, best, after),
        **end(after)._asdict(),
        floor=floor(problem, scaled),
        records=tuple(records),
        captures=evaluator.captures,
        corners=in_corners,
    )


def objective_slope(
    goal: Goal, point: Evaluation, cases: Float[np.ndarray, " cases"]
) -> Float[np.ndarray, " variables"]:
    """The objective's slope by the scaled variables, with given weights of the cases."""
    by_case = np.einsum("q,cqn->cn", goal.weights(goal.objective), point.quantities_slope)
    return np.asarray(cases @ by_case)


def disagreement(goal: Goal, usual: Evaluation, tight: Evaluation) -> float:
    """Difference of the objective's slopes between the search's tolerance and the tight one, relative [-]."""
    cases = goal.objective.case_weights(tight.quantities @ goal.weights(goal.objective))
    exact = objective_slope(goal, tight, cases)
    apart = np.abs(objective_slope(goal, usual, cases) - exact)
    return float(np.max(apart) / max(float(np.max(np.abs(exact))), 1e-300))
