"""The plain search: an optax optimiser on the certified gradient, its steps projected on the bounds.

Limits enter by an augmented Lagrangian (Nocedal and Wright, eq. 17.65): f + Σ (max(0, μ + ρ g)² - μ²) / 2ρ, whose
multipliers μ are raised every few steps. Maxima over impacts and load cases have the slope of the largest one.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float

from ..errors import InputError
from .evaluation import Evaluation, Evaluator
from .goal import Goal, Tangent
from .message import End, ending, infeasible, left_to_gain
from .model_step import residual
from .problem import Problem, Settings
from .rounds import anywhere, check_starts, size
from .search import CONVERGED, SCREENING_PENALTY, STALLED, Branch, Search
from .store import Store, record_of
from .tuned import Tuned, assess

STIFFNESS = 20.0  # ρ, for an objective of about one and rows relative to their limits
PATIENCE = 10  # steps between two rises of the multipliers


def check_optimizer(problem: Problem, optimizer: Any, resume: bool) -> None:
    """Raise `InputError` for what is no optimiser, and for what is not offered with one."""
    if not (hasattr(optimizer, "init") and hasattr(optimizer, "update")):
        raise InputError(f"optimizer = {optimizer!r} is not an optax optimizer; write optax.adam(0.05) say")
    if resume:
        raise InputError("a tuning by an optimizer cannot be resumed; leave out resume or optimizer")
    if problem.then is not None:
        raise InputError("a tuning by an optimizer has no second objective; leave out problem.then or optimizer")


def descend(
    problem: Problem,
    optimizer: Any,
    settings: Settings,
    evaluator: Evaluator,
    store: Store,
) -> Tuned:
    """Tune by an optimiser.

    It screens ``settings.starts`` designs and follows the best ``settings.searches`` of them for
    ``settings.iterations`` steps each.
    """
    goal, own = Goal(problem, problem.objective), problem.start()
    points = evaluator([own, *anywhere(settings, 0, len(own), settings.starts - 1)], slopes=False)
    scale = size(goal, points)
    search = Search(goal, scale, settings)

    def log(number: int, point: Evaluation, branch: Branch | None) -> None:
        store.append(record_of(goal, point, len(store.records), 0, number, branch))

    for point in points:
        log(0, point, None)
    chosen = evaluator([point.scaled for point in sorted(points, key=search.rank)[: settings.searches]])
    check_starts(problem, chosen)
    branches = [_descent(search, optimizer, evaluator, start, number, log) for number, start in enumerate(chosen)]
    best = min(branches, key=lambda branch: search.rank(branch.best))
    ended = f"{settings.iterations} steps of the optimizer from each of {len(branches)} starts"
    return assess(
        goal,
        settings,
        evaluator,
        own,
        best.best,
        scale,
        SCREENING_PENALTY,
        lambda after: End(ending(best, settings), False, _message(goal, after, ended, best)),
        store.records,
    )


def _message(goal: Goal, after: Evaluation, ended: str, best: Branch) -> str:
    if not goal.feasible(after):
        return infeasible(goal, after, ended)
    return f"{ended}; {left_to_gain(best)}; iterations, in [tune] of a study, allow more steps"


def _descent(
    search: Search,
    optimizer: Any,
    evaluator: Evaluator,
    start: Evaluation,
    number: int,
    log: Callable[[int, Evaluation, Branch], None],
) -> Branch:
    """Search from one evaluated start."""
    goal, settings = search.goal, search.settings
    branch, point = search.begin(start), start
    state, multipliers = optimizer.init(start.scaled), np.zeros(len(_rows(goal, start)[0]))
    for step in range(1, settings.iterations + 1):
        rows, slopes = _rows(goal, point)
        # The multipliers of the augmented Lagrangian's slope; they become its own only every few steps, because
        # estimates far from the optimum are no good.
        estimates = np.maximum(0.0, multipliers + STIFFNESS * rows)
        if step % PATIENCE == 0:
            multipliers = estimates
        weights = goal.weights(goal.objective)
        cases = goal.objective.case_weights(point.quantities @ weights)
        slope = goal.slope(point, cases) / search.scale + estimates @ slopes
        change, state = optimizer.update(slope, state, point.scaled)
        (point,) = evaluator([np.clip(point.scaled + np.asarray(change), 0.0, 1.0)])
        left = residual(goal, Tangent.of(point), point.scaled, search.scale, SCREENING_PENALTY).predicted_reduction
        converged = left <= settings.tolerance and goal.feasible(point)
        branch = branch._replace(
            point=point,
            best=min(branch.best, point, key=search.rank),
            residual=left,
            status=CONVERGED if converged else STALLED,
            steps=step,
        )
        log(number, point, branch)
        if converged:
            break
    return branch


def _rows(goal: Goal, point: Evaluation) -> tuple[Float[np.ndarray, " rows"], Float[np.ndarray, "rows variables"]]:
    """Return the constraints g ≤ 0 at a design, and their slopes."""
    tangent, size = Tangent.of(point), len(point.scaled)
    rows = goal.rows(*tangent.after(np.zeros(size)))
    slopes = [point.quantities_slope[:, quantity] / limit for quantity, limit in goal.signed_limits()]
    if goal.must_succeed:
        slopes.append(-point.margin_slope)
    return rows, np.concatenate([*slopes, np.zeros((0, size))])
