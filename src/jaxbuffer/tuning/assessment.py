"""The assessment of a finished search: its best design at tight tolerance, then the evidence for it, and its levers.

These are apart, so that the design is on disk before the evidence is computed: that takes runs of its own, in corners
and without a buffer, and whatever fails there leaves the design as it is.
"""

import dataclasses
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import Executor
from typing import TypeVar

import numpy as np
from jaxtyping import Float

from ..hybrid import Solver
from .problem.settings import Settings
from .report.levers import NO_LEVERS, Levers, levers_by_numbers
from .report.message import INFEASIBLE, Ended, SearchReport
from .report.tuned import Tuned
from .search.checks import lower_bound
from .search.evaluation import Evaluation, Evaluator
from .search.goal import Goal, Tangent
from .search.model_step import residual
from .search.store import Record
from .tolerances.corners import CornerRuns, Corners, corners, run_corners
from .tolerances.spread import spreads, tightening

T = TypeVar("T")

NOT_YET = "missing: corners, tolerances and lower bound, which are computed after the design is written"


def assess(
    goal: Goal,
    settings: Settings,
    evaluator: Evaluator,
    first: Float[np.ndarray, " variables"],
    best: Evaluation,
    scale: float,
    penalty: float,
    report: SearchReport,
    records: Sequence[Record],
    *,
    ended: Ended,
    confirmed: bool,
) -> Tuned:
    """Evaluate the best design of a search at tight tolerance, without the evidence that `with_evidence` adds.

    **Arguments:** ``first``: scaled variables of the problem's own start; ``best``: the best design at the search's
    tolerance; ``scale`` of the objective and ``penalty`` on what is above a limit, for the first-order residual;
    ``report``: what the search says of itself; others as of `Tuned`.
    """
    problem, scaled = goal.problem, best.scaled
    # The start at the tight tolerance too, so that what is gained is none of the search's own error.
    before, after = evaluator([first, scaled], rtol=evaluator.tight)
    # One set of weights for both slopes: which load case is the worst may differ by rounding, which is no error.
    cases = goal.objective.case_weights(after.quantities @ goal.weights)
    exact = goal.slope(after, cases)
    error, largest = float(np.max(np.abs(goal.slope(best, cases) - exact))), float(np.max(np.abs(exact)))
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
        report=report,
        message=report.message(goal, after),
        lower_bound=None,
        records=tuple(records),
        captures=evaluator.captures,
        tight=evaluator.tight,
        missing=(NOT_YET,),
    )


def with_evidence(tuned: Tuned, evaluator: Evaluator) -> Tuned:
    """Return a tuning with the evidence for its design: in the corners, by tolerances, and above the lower bound.

    Evidence that cannot be computed is missing, and ``missing`` says why.
    """
    problem, scaled, missing = tuned.problem, tuned.after.scaled, list[str]()

    def evidence(what: str, compute: Callable[[], T]) -> T | None:
        try:
            return compute()
        except Exception as error:  # of any kind: none may cost the design that the search has found
            missing.append(_missing(what, error))
            return None

    def of_corners() -> tuple[CornerRuns, Corners] | None:
        runs = run_corners(problem, evaluator, scaled, evaluator.tight)
        return None if runs is None else (runs, corners(problem, runs))

    each = evidence("the design in the corners of what scatters", of_corners)
    in_corners, scatter, first = None, None, None
    if each is not None:
        runs, in_corners = each
        if problem.tolerances:
            arguments = (problem, evaluator, scaled, runs, evaluator.tight)
            scatter = evidence("the scatter by each tolerance", lambda: spreads(*arguments))
            first = evidence("which tolerance to tighten first", lambda: tightening(*arguments))
    bound = evidence("the lower bound of the peak force", lambda: lower_bound(problem, scaled))
    message = tuned.message if tuned.report is None else tuned.report.message(tuned.goal, tuned.after, bound)
    return dataclasses.replace(
        tuned,
        message=message_with_corners(message, in_corners, tuned.goal.feasible(tuned.after)),
        corners=in_corners,
        spreads=scatter or (),
        tightening=first,
        lower_bound=bound,
        captures=evaluator.captures,
        missing=tuple(missing),
    )


def with_levers(
    tuned: Tuned,
    workers: int | None = None,
    executor: Executor | None = None,
    solver: Solver | str | None = None,
) -> Tuned:
    """Return a tuning with the levers of its limits among all numbers of its design; arguments as of `tune`."""
    levers, missing = levers_of_design(tuned.goal, tuned.after, tuned.problem.paths, workers, executor, solver)
    others = {name: [it for it in each if not it.variable] for name, each in levers.items()}
    return dataclasses.replace(tuned, others=others, missing=(*tuned.missing, *missing))


def levers_of_design(
    goal: Goal,
    after: Evaluation,
    chosen: Collection[str],
    workers: int | None,
    executor: Executor | None,
    solver: Solver | str | None,
) -> tuple[Levers, tuple[str, ...]]:
    """Return the levers of `levers_by_numbers`, and a line that says why where they cannot be computed."""
    try:
        with Evaluator(goal.problem, workers, True, executor, solver) as evaluator:
            return levers_by_numbers(goal, after, evaluator, chosen), ()
    except Exception as error:  # of any kind: none may cost the design that they are of
        return NO_LEVERS, (_missing("levers among all numbers of the design", error),)


def _missing(what: str, error: Exception) -> str:
    """Return the line on a part of the evidence that an error has cost."""
    lines = str(error).strip().splitlines() or [type(error).__name__]
    return f"missing: {what}, which could not be computed: {lines[0]}"


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
