"""`tune`: from a design problem to a design, with everything that was tried on the way."""

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..mechanisms import Design
from ..outcome import Outcome
from .evaluation import Evaluation, Evaluator
from .floor import floor
from .goal import Ceiling, Goal, Tangent
from .linear import residual
from .problem import QUANTITIES, Problem
from .progress import Progress
from .search import CONVERGED, RUNNING, Branch, Search, Settings, advanced, chosen, first_places, without_hopeless
from .store import Record, Store, read_state
from .tuned import Tuned

TIGHT = 1e-9  # rtol at which the result is judged
STATUS = ("running", "converged", "stalled", "behind")


def tune(
    problem: Problem,
    *,
    iterations: int = 40,
    starts: int = 4,
    searches: int = 2,
    seed: int = 0,
    tolerance: float = 1e-4,
    folder: str | Path | None = None,
    resume: bool = False,
    workers: int | None = None,
    report: Callable[[Record], None] | None = None,
) -> Tuned:
    """Find the best design of a problem.

    Steps minimise a model that is first-order in every impact's peak of every case, with the curvature seen so far,
    inside a region that shrinks where the model was wrong (docs/tuning.md). An infeasible start is led to feasibility
    first. ``problem.then`` is a second search from the first one's best.

    **Arguments:** ``iterations``: steps of each search at most, in each stage; ``starts``: designs tried first, the
    problem's own and a Latin hypercube of the bounds drawn with ``seed``; ``searches``: the best of them that are
    followed, in one batch; ``tolerance`` [-]: a search has converged when first-order information promises no larger
    decrease of the objective, relative, within a tenth of every range; ``folder``: where log and state are kept, an
    earlier run's files there are overwritten unless ``resume`` goes on with it; ``workers``: threads, by default one a
    core; ``report``: called with the log's record of each evaluation, also those of the run that is resumed.

    **Returns:** a `Tuned`, its numbers simulated at rtol 1e-9. The same arguments give the same result, interrupted or
    not. **Raises:** `InputError` for settings out of range, for a start of which no capture can be solved or climbed
    from, and on resuming another problem's run.
    """
    settings = _checked(Settings(iterations, starts, searches, seed, tolerance))
    with (
        Store(None if folder is None else Path(folder), _fingerprint(problem, settings), resume) as store,
        Evaluator(problem, workers) as evaluator,
    ):
        if report is not None:
            for record in store.records:
                report(record)
        run = _Run(problem, settings, evaluator, store, report)
        return run.finished(run.searched(Progress.read(store.state)))


class Unfinished(NamedTuple):
    """The best design of a run that was interrupted: ``objective`` [N] of the stage it was in, 0 for the first;
    ``feasible``: whether it keeps to every constraint; ``evaluations`` so far."""

    design: Design
    objective: float
    feasible: bool
    stage: int
    evaluations: int


def best_so_far(problem: Problem, folder: str | Path, **settings: Any) -> Unfinished | None:
    """The best design of an interrupted run, or None before its first designs were evaluated. Changes nothing.

    **Arguments:** as for `tune`; ``settings``: those that the run was started with.
    """
    chosen = _checked(Settings(**settings))
    state, lines = read_state(Path(folder), _fingerprint(problem, chosen))
    progress = Progress.read(state or None)
    if progress is None:
        return None
    search = _search(problem, chosen, progress)
    best = _best(search, progress.branches).kept
    return Unfinished(
        problem.built(best.places),
        search.goal.value(best),
        search.goal.feasible(best),
        progress.stage,
        lines.count(b"\n"),
    )


def _fingerprint(problem: Problem, settings: Settings) -> str:
    return f"{problem.fingerprint()}-{settings}"


def _checked(settings: Settings) -> Settings:
    for name, low in (("iterations", 1), ("starts", 1), ("searches", 1), ("seed", 0)):
        value = getattr(settings, name)
        if isinstance(value, bool) or not isinstance(value, int) or value < low:
            raise InputError(f"tune.{name} = {value!r} must be a whole number of at least {low}")
    if not 0.0 < settings.tolerance < 1.0:
        raise InputError(f"tune.tolerance = {settings.tolerance!r} is out of range; allowed: (0, 1)")
    return settings


@dataclasses.dataclass
class _Run:
    problem: Problem
    settings: Settings
    evaluator: Evaluator
    store: Store
    report: Callable[[Record], None] | None

    def searched(self, progress: Progress | None) -> Progress:
        """All stages, from the start or from stored progress."""
        if progress is None:
            progress = self._begun()
        self.evaluator.captures = progress.captures
        while True:
            search = self._search(progress)
            while any(branch.status == RUNNING for branch in progress.branches):
                branches = list(progress.branches)
                for k, trial, branch in advanced(search, branches, self.evaluator):
                    branches[k] = branch
                    self._log(progress.stage, k, search, trial, branch)
                branches = without_hopeless(search, branches)
                progress = progress._replace(branches=tuple(branches), captures=self.evaluator.captures)
                self.store.keep(progress.written())
            if self.problem.then is None or progress.stage > 0:
                return progress
            best = _best(search, progress.branches)
            if not search.goal.feasible(best.kept):
                return progress
            progress = self._second(progress, search, best)
            self.store.keep(progress.written())

    def _begun(self) -> Progress:
        """The starts, evaluated in one batch."""
        goal = Goal(self.problem, self.problem.objective)
        points = self.evaluator(first_places(self.problem.start(), self.settings))
        _check_start(self.problem, points[0])
        scales = (_scale(goal, points), max(float(np.max(p.peaks)) for p in points[:1]))
        progress = Progress(0, self.evaluator.captures, *scales, np.nan, points[0], ())
        search = self._search(progress)
        for k, point in enumerate(points):
            self._log(0, k, search, point, None)
        branches = tuple(chosen(search, points))
        progress = progress._replace(branches=branches)
        self.store.keep(progress.written())
        return progress

    def _second(self, progress: Progress, search: Search, best: Branch) -> Progress:
        """The second stage, from the first one's best design."""
        assert self.problem.then is not None
        ceiling = (1.0 + self.problem.then.slack) * search.goal.value(best.kept)
        scale = Goal(self.problem, self.problem.then.objective).value(best.kept)
        progress = progress._replace(stage=1, scale=scale, ceiling=ceiling, branches=())
        return progress._replace(branches=(self._search(progress).begin(best.kept),))

    def _search(self, progress: Progress) -> Search:
        return _search(self.problem, self.settings, progress)

    def _log(self, stage: int, number: int, search: Search, point: Evaluation, branch: Branch | None) -> None:
        """One evaluated design as a line of the log; ``branch`` is None for a start."""
        goal = search.goal
        values = map(float, self.problem.values(point.places))
        record: Record = {
            "evaluation": len(self.store.records),
            "stage": stage,
            "search": number,
            "step": 0 if branch is None else branch.steps,
            "accepted": branch is None or branch.point is point,
            "objective": goal.value(point),
            "feasible": goal.feasible(point),
            "excess": float(np.sum(goal.excess(point))),
            "radius": None if branch is None else branch.radius,
            "residual": None if branch is None else branch.residual,
            "status": "start" if branch is None else STATUS[branch.status],
            "captures": len(self.problem.cases) * (len(self.store.records) + 1),
            "values": dict(zip(self.problem.paths, values, strict=True)),
            "outcome": [Outcome(int(code)).name for code in point.code],
            "impacts": [int(count) for count in point.impacts],
            "margin": point.margin.tolist(),
            **{name: point.quantities[:, q].tolist() for q, name in enumerate(QUANTITIES)},
        }
        self.store.append(record)
        if self.report is not None:
            self.report(record)

    def finished(self, progress: Progress) -> Tuned:
        """The best design, judged at tight tolerance."""
        search = self._search(progress)
        branch = _best(search, progress.branches)
        places = branch.kept.places
        before, after = self.evaluator([progress.first.places, places], rtol=TIGHT)
        left = residual(search.goal, Tangent.of(after), places, search.scale, branch.penalty).promise
        return Tuned(
            problem=self.problem,
            settings=self.settings,
            goal=search.goal,
            design=self.problem.built(places),
            before=before,
            after=after,
            residual=left,
            gradient_error=_disagreement(search.goal, branch.kept, after),
            converged=branch.status == CONVERGED,
            message=_message(search.goal, branch, after, self.settings),
            floor=floor(self.problem, places),
            records=tuple(self.store.records),
            captures=self.evaluator.captures,
        )


def _search(problem: Problem, settings: Settings, progress: Progress) -> Search:
    """The rules of the stage that the progress is in."""
    then = problem.then
    if progress.stage == 0 or then is None:
        goal = Goal(problem, problem.objective)
    else:
        goal = Goal(problem, then.objective, Ceiling(problem.objective, progress.ceiling))
    return Search(goal, (progress.scale, progress.peak_scale), settings)


def _best(search: Search, branches: tuple[Branch, ...]) -> Branch:
    return min(branches, key=lambda branch: search.rank(branch.kept))


def _scale(goal: Goal, points: list[Evaluation]) -> float:
    """The objective's size: its value at the first start that has one."""
    values = [goal.value(point) for point in points if np.any(point.solved)]
    return next((value for value in values if value > 0.0), 1.0)


def _check_start(problem: Problem, point: Evaluation) -> None:
    reasons = sorted({Outcome(int(code)).reason for code in point.code})
    if not np.any(point.solved):
        raise InputError(f"every capture of the start fails ({'; '.join(reasons)}): there is no slope to climb")
    if problem.limits.captured and not np.any(point.captured) and not np.any(point.margin_slope):
        raise InputError(
            f"no capture of the start succeeds ({'; '.join(reasons)}), and no variable changes that to first order: "
            "start from another design or tune other variables"
        )


def _disagreement(goal: Goal, usual: Evaluation, tight: Evaluation) -> float:
    """Difference of the objective's slopes between the search's tolerance and the tight one, relative [-]."""

    def slope(point: Evaluation) -> np.ndarray:
        weights = goal.objective.vector()
        cases = goal.objective.case_weights(tight.quantities @ weights)
        by_case = weights[0] * point.peaks_slope[:, 0] + np.einsum("q,cqn->cn", weights[1:], point.rest_slope)
        return np.asarray(cases @ by_case)

    exact = slope(tight)
    return float(np.max(np.abs(slope(usual) - exact)) / max(float(np.max(np.abs(exact))), 1e-300))


def _message(goal: Goal, branch: Branch, after: Evaluation, settings: Settings) -> str:
    if not goal.feasible(after):
        return "no feasible design was found: " + "; ".join(goal.broken(after)[:3])
    if branch.status == CONVERGED:
        return f"converged: first-order residual {branch.residual:.1e} within {settings.tolerance:g}"
    if branch.steps >= settings.iterations:
        return f"stopped at the limit of {settings.iterations} steps, first-order residual {branch.residual:.1e}"
    where = "stalled: steps gain less than the tolerance"
    if np.any(np.isfinite(branch.cliffs)):
        where = "stopped at a cliff: the designs ahead lose a capture by one bounce more or less"
    return f"{where}; to first order {branch.residual:.1e} of the objective would be left to gain"
