"""`tune`: from a design problem to a design, with everything that was tried on the way."""

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError, check_single, check_type, check_whole
from ..mechanisms import Design
from ..outcome import Outcome
from .evaluation import Evaluation, Evaluator
from .floor import floor
from .goal import Ceiling, Goal, Tangent
from .linear import residual
from .message import message
from .problem import QUANTITIES, Problem
from .progress import Progress
from .search import CONVERGED, RUNNING, Branch, Search, Settings, advanced, without_hopeless
from .starts import Places, Standing, anywhere, around
from .store import Record, Store, read_state
from .tuned import Tuned

TIGHT = 1e-9  # rtol at which the result is judged
STATUS = ("running", "converged", "stalled", "behind")


def tune(
    problem: Problem,
    *,
    iterations: int = 40,
    starts: int = Settings.starts,
    searches: int = Settings.searches,
    rounds: int = Settings.rounds,
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

    **Arguments:** ``iterations``: steps of each search at most; ``starts``: designs screened without derivatives in
    each round, the problem's own and a Latin hypercube of the bounds drawn with ``seed`` (1: the problem's own only,
    and no further round); ``searches``: the best of them that are followed, in one batch; ``rounds`` at most: others
    follow the first where cliffs were met or searches disagree; ``tolerance`` [-]: a search has converged when
    first-order information promises no larger decrease of the objective, relative, within a tenth of every range;
    ``folder``: where log and state are kept, an earlier run's files there are overwritten unless ``resume`` goes on
    with it; ``workers``: threads, by default one a core; ``report``: called with the log's record of each evaluation,
    also those of the run that is resumed.

    **Returns:** a `Tuned`, its numbers simulated at rtol 1e-9. The same arguments give the same result, interrupted or
    not. **Raises:** `InputError` for settings out of range, for starts of which no capture can be solved or climbed
    from, and on resuming another problem's run.
    """
    check_type(
        "problem", problem, Problem, "Problem(jb.table2(), [Scenario()], [Variable('buffer.k_A', 100.0, 2000.0)])"
    )
    if workers is not None:
        check_whole("workers", workers, 1)
    if folder is not None and not str(folder):
        raise InputError("folder = '' is empty; name the folder for log and state, or leave it out")
    settings = _checked(Settings(iterations, starts, searches, rounds, seed, tolerance))
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
    for name, low in (("iterations", 1), ("starts", 1), ("searches", 1), ("rounds", 1), ("seed", 0)):
        check_whole(f"tune.{name}", getattr(settings, name), low)
    limits: dict[str, Any] = {"low": 0.0, "high": 1.0, "low_open": True, "high_open": True}
    check_single("tune.tolerance", settings.tolerance, "-", "it holds for all searches", **limits)
    return settings


@dataclasses.dataclass
class _Run:
    problem: Problem
    settings: Settings
    evaluator: Evaluator
    store: Store
    report: Callable[[Record], None] | None

    def searched(self, progress: Progress | None) -> Progress:
        """All rounds of both stages."""
        progress = self._begun() if progress is None else progress
        self.evaluator.captures = progress.captures
        while True:
            search = self._search(progress)
            progress = self._ended(search, progress)
            best = _best(search, progress.branches)
            if progress.stage == 0:
                standing = Standing.of(search, progress.branches)
                progress = progress._replace(searches=len(progress.branches), apart=standing.apart)
            if self._unsettled(search, progress):
                progress = self._again(search, progress, best)
            elif self.problem.then is not None and progress.stage == 0 and search.goal.feasible(best.kept):
                progress = self._second(progress, search, best)
            else:
                return progress
            self.store.keep(progress.written())

    def _ended(self, search: Search, progress: Progress) -> Progress:
        """After all running searches have stopped."""
        while any(branch.status == RUNNING for branch in progress.branches):
            branches = list(progress.branches)
            for k, trial, branch in advanced(search, branches, self.evaluator):
                branches[k] = branch
                self._log(progress.stage, k, search, trial, branch)
            branches = without_hopeless(search, branches)
            progress = progress._replace(branches=tuple(branches), captures=self.evaluator.captures)
            self.store.keep(progress.written())
        return progress

    def _begun(self) -> Progress:
        """The first round, with the problem's own start among the designs screened; alone it needs no screening."""
        goal, own, settings = Goal(self.problem, self.problem.objective), self.problem.start(), self.settings
        alone = settings.starts == 1
        points = self.evaluator([own, *anywhere(settings, 0, len(own), settings.starts - 1)], slopes=alone)
        progress = Progress(0, 0, *_scales(goal, points), np.nan, 0, np.inf, points[0], ())
        search = self._search(progress)
        for point in points:
            self._log(0, 0, search, point, None)
        chosen = sorted(points, key=search.rank)[: settings.searches]
        picked = [(point.places, k) for k, point in enumerate(chosen)]
        branches = (search.begin(points[0]),) if alone else self._branches(search, progress, picked)
        _check_starts(self.problem, [branch.point for branch in branches])
        progress = progress._replace(branches=branches, captures=self.evaluator.captures)
        self.store.keep(progress.written())
        return progress

    def _unsettled(self, search: Search, progress: Progress) -> bool:
        """Whether another round is called for and allowed."""
        latest = max(branch.round for branch in progress.branches)
        if self.settings.starts == 1 or latest + 1 >= self.settings.rounds:
            return False
        return not Standing.of(search, progress.branches).settled(progress.stage)

    def _again(self, search: Search, progress: Progress, best: Branch) -> Progress:
        """Another round: of designs around the best one and, in the first stage, anywhere."""
        settings, round_ = self.settings, max(branch.round for branch in progress.branches) + 1
        count, number = settings.starts // 2, len(progress.branches)
        near = self._screened(search, progress.stage, around(best.kept.places, settings, round_, count))
        picked = [(min(near, key=search.rank).places, best.family)]
        if progress.stage == 0:
            places = anywhere(settings, round_, len(best.kept.places), settings.starts - count)
            far = sorted(self._screened(search, 0, places), key=search.rank)[: max(1, settings.searches - 1)]
            picked += [(point.places, number + k) for k, point in enumerate(far, 1)]
        branches = progress.branches + self._branches(search, progress, picked, round_)
        return progress._replace(branches=branches, captures=self.evaluator.captures)

    def _screened(self, search: Search, stage: int, places: list[Places]) -> list[Evaluation]:
        """Designs evaluated without derivatives."""
        points = self.evaluator(places, slopes=False)
        for point in points:
            self._log(stage, 0, search, point, None)
        return points

    def _branches(
        self, search: Search, progress: Progress, picked: list[tuple[Places, int]], round_: int = 0
    ) -> tuple[Branch, ...]:
        """New searches from places, each with its family."""
        branches, points = list[Branch](), self.evaluator([places for places, _ in picked])
        for k, (point, (_, family)) in enumerate(zip(points, picked, strict=True), len(progress.branches)):
            branches.append(search.begin(point, round_, family))
            self._log(progress.stage, k, search, point, branches[-1])
        return tuple(branches)

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
            message=message(search.goal, branch, after, progress, self.settings),
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


def _scales(goal: Goal, points: list[Evaluation]) -> tuple[float, float]:
    """Sizes of the objective and of contact forces [N]: those of the first start that has both, else 1."""
    sizes = [(goal.value(point), float(np.max(point.peaks))) for point in points]
    return next(((value, peak) for value, peak in sizes if value > 0.0 and peak > 0.0), (1.0, 1.0))


def _check_starts(problem: Problem, points: list[Evaluation]) -> None:
    reasons = "; ".join(sorted({Outcome(int(code)).reason for point in points for code in point.code}))
    if not any(np.any(point.solved) for point in points):
        raise InputError(f"every capture of the start fails ({reasons}): there is no slope to climb")
    if problem.limits.captured and not any(np.any(p.captured) or np.any(p.margin_slope) for p in points):
        raise InputError(
            f"no capture of the start succeeds ({reasons}), and no variable changes that to first order: "
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
