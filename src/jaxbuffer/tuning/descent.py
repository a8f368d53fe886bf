"""The plain search: an optax optimiser on the certified gradient, its steps projected on the bounds.

Limits enter by an augmented Lagrangian (Nocedal and Wright, eq. 17.65): f + Σ (max(0, μ + ρ g)² - μ²) / 2ρ, whose
multipliers μ are raised every few steps. Maxima over impacts and load cases have the slope of the largest one.
"""

import warnings
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from jaxtyping import Float

from ..errors import InputError
from .assessment import assess
from .problem.problem import Problem
from .problem.settings import Settings
from .report.message import SearchReport, ending, left_to_gain
from .report.tuned import Tuned
from .rounds import anywhere, check_starts, size
from .search.constraints import ImpactsLimit
from .search.evaluation import Evaluation, Evaluator
from .search.goal import Goal, Tangent
from .search.model_step import residual
from .search.search import CONVERGED, SCREENING_PENALTY, STALLED, Branch, Search
from .search.store import TuningStore, evaluations_of, record_of, stored_evaluations

STIFFNESS = 20.0  # ρ, for an objective of about one and rows relative to their limits
PATIENCE = 10  # steps between two rises of the multipliers
USABLE = (
    "a tuning gives value and gradient of the design it is at, a simulation each: take optax.adam(0.05),"
    " optax.polyak_sgd(0.1) or optax.lbfgs(0.1, linesearch=None) say"
)


def optimizer_named(settings: Settings) -> Any:
    """Return the optimiser of optax that the settings name, None for the default search."""
    if settings.optimizer == "quadratic":
        return None
    import optax  # takes half a second

    return getattr(optax, settings.optimizer)(settings.learning_rate)


class Repeated:
    """Keep what an evaluator evaluates in the store, and begin with what is there.

    A descent that is resumed repeats its steps, which cost nothing but runs, with the numbers of before.
    """

    def __init__(self, evaluator: Evaluator, store: TuningStore) -> None:
        self.evaluator, self.store = evaluator, store
        self.known, self.used = evaluations_of(store.state), 0

    def __call__(self, points: Iterable[np.ndarray], slopes: bool | None = None) -> list[Evaluation]:
        """Evaluate designs, or return them as stored, as of `Evaluator`."""
        points = [np.asarray(point, float) for point in points]
        stored = self.known[self.used : self.used + len(points)]
        # Runs that were done before the interrupt count too: the result is the same whether there was one or not.
        if np.array_equal(points, [point.scaled for point in stored]):
            self.evaluator.captures += len(points) * len(self.evaluator.problem.cases)
        else:
            stored = self.evaluator(points, slopes=slopes)
            self.known = [*self.known[: self.used], *stored]
            self.store.keep(stored_evaluations(self.known))
        self.used += len(points)
        return stored


def check_optimizer(problem: Problem, optimizer: Any) -> None:
    """Raise `InputError` for what is no optimiser, and for what is not offered with one."""
    if not (hasattr(optimizer, "init") and hasattr(optimizer, "update")):
        raise InputError(f"optimizer = {optimizer!r} is not an optax optimizer; write optax.adam(0.05) say")
    if problem.then is not None:
        raise InputError("a tuning by an optimizer has no second objective; leave out problem.then or optimizer")
    at = problem.start()
    try:
        # A step on made-up numbers shows what is wrong before any run is spent.
        change, _ = step_of(optimizer, 0.1 * np.ones_like(at), optimizer.init(at), at, 1.0)
    except InputError:
        raise
    except Exception as error:  # code of others, which fails in many ways; all mean the same
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise InputError(f"the optimizer cannot take a step, {reason}; {USABLE}") from None
    if change.shape != at.shape:
        raise InputError(f"the optimizer's step has the shape {change.shape}, not {at.shape}, a number each variable")


def step_of(
    optimizer: Any,
    slope: Float[np.ndarray, " variables"],
    state: Any,
    at: Float[np.ndarray, " variables"],
    value: float,
) -> tuple[Float[np.ndarray, " variables"], Any]:
    """Return an optimiser's step and its next state; those that ask for the function's value get it too.

    **Raises:** `InputError` for one that evaluates the function by itself, in a line search.
    """
    import optax  # a caller who has an optimiser has it imported

    def no_line_search(*_: Any, **__: Any) -> Any:
        raise InputError(f"the optimizer evaluates the objective by itself, in a line search; {USABLE}")

    update = optax.with_extra_args_support(optimizer).update
    change, state = update(slope, state, at, value=value, grad=slope, value_fn=no_line_search)
    return np.asarray(change, float), state


def descend(
    problem: Problem,
    optimizer: Any,
    settings: Settings,
    evaluator: Evaluator,
    store: TuningStore,
) -> Tuned:
    """Tune by an optimiser.

    It screens ``settings.starts`` designs and follows the best ``settings.searches`` of them for
    ``settings.iterations`` steps each.
    """
    goal, own = Goal(problem, problem.objective), problem.start()
    repeated, logged = Repeated(evaluator, store), list(store.records)
    points = repeated([own, *anywhere(settings, 0, len(own), settings.starts - 1)], slopes=False)
    scale = size(goal, points)
    search = Search(goal, scale, settings)

    def log(number: int, point: Evaluation, branch: Branch | None) -> None:
        if logged:  # a run that is resumed has it already
            logged.pop()
        else:
            store.append(record_of(goal, point, len(store.records), 0, number, branch))

    for point in points:
        log(0, point, None)
    # The best designs are evaluated again, with the slopes that screening spared.
    chosen = repeated([point.scaled for point in sorted(points, key=search.rank)[: settings.searches]])
    check_starts(problem, chosen)
    branches = [_descent(search, optimizer, repeated, start, number, log) for number, start in enumerate(chosen)]
    best = min(branches, key=lambda branch: search.rank(branch.best))
    effort = f"{settings.iterations} steps of the optimizer from each of {len(branches)} starts"
    well = f"{effort}; {left_to_gain(best)}; iterations, in [tune] of a study, allow more steps"
    return assess(
        goal,
        settings,
        evaluator,
        own,
        best.best,
        scale,
        SCREENING_PENALTY,
        SearchReport(well, effort),
        store.records,
        ended=ending(best, settings),
        confirmed=False,
    )


def _descent(
    search: Search,
    optimizer: Any,
    evaluator: Repeated,
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
        value = goal.value(point) / search.scale + np.sum(estimates**2 - multipliers**2) / (2.0 * STIFFNESS)
        if step % PATIENCE == 0:
            multipliers = estimates
        cases = goal.objective.case_weights(point.quantities @ goal.weights)
        slope = goal.slope(point, cases) / search.scale + estimates @ slopes
        change, state = step_of(optimizer, slope, state, point.scaled, float(value))
        if not np.all(np.isfinite(change)):
            warnings.warn(f"step {step} of the optimizer is not finite; its search ends there", stacklevel=2)
            break
        # A step beyond a bound ends on it: the projection on a box.
        (point,) = evaluator([np.clip(point.scaled + change, 0.0, 1.0)])
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
    # A number of impacts has no slope to follow, and no row.
    slopes = [it.slopes(point) for it in goal.constraints if not isinstance(it, ImpactsLimit)]
    return rows, np.concatenate([*slopes, np.zeros((0, size))])
