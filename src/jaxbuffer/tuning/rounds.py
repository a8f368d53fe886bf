"""The default search: rounds of local searches, in two stages where a problem has a second objective."""

import dataclasses
from collections.abc import Callable

import numpy as np

from ..errors import InputError
from .evaluation import Evaluation, Evaluator
from .goal import Ceiling, Goal
from .judged import judged
from .message import end
from .problem import Problem
from .progress import Progress
from .record import record
from .search import RUNNING, Branch, Search, advanced, without_hopeless
from .settings import Settings
from .starts import Scaled, Standing, anywhere, around
from .store import Record, Store
from .tuned import Tuned


@dataclasses.dataclass
class Rounds:
    """The rounds of searches of one tuning."""

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
            best = best_branch(search, progress.branches)
            if progress.stage == 0:
                standing = Standing.of(search, progress.branches)
                progress = progress._replace(searches=len(progress.branches), apart=standing.apart)
            if self._unsettled(search, progress):
                progress = self._again(search, progress, best)
            elif self.problem.then is not None and progress.stage == 0 and search.goal.feasible(best.best):
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
        progress = Progress(0, 0, size(goal, points), np.nan, 0, np.inf, points[0], ())
        search = self._search(progress)
        for point in points:
            self._log(0, 0, search, point, None)
        chosen = sorted(points, key=search.rank)[: settings.searches]
        picked = [(point.scaled, k) for k, point in enumerate(chosen)]
        branches = (search.begin(points[0]),) if alone else self._branches(search, progress, picked)
        check_starts(self.problem, [branch.point for branch in branches])
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
        near = self._screened(search, progress.stage, around(best.best.scaled, settings, round_, count))
        picked = [(min(near, key=search.rank).scaled, best.family)]
        if progress.stage == 0:
            scaled = anywhere(settings, round_, len(best.best.scaled), settings.starts - count)
            far = sorted(self._screened(search, 0, scaled), key=search.rank)[: max(1, settings.searches - 1)]
            picked += [(point.scaled, number + k) for k, point in enumerate(far, 1)]
        branches = progress.branches + self._branches(search, progress, picked, round_)
        return progress._replace(branches=branches, captures=self.evaluator.captures)

    def _screened(self, search: Search, stage: int, points: list[Scaled]) -> list[Evaluation]:
        """Designs evaluated without derivatives."""
        found = self.evaluator(points, slopes=False)
        for point in found:
            self._log(stage, 0, search, point, None)
        return found

    def _branches(
        self, search: Search, progress: Progress, picked: list[tuple[Scaled, int]], round_: int = 0
    ) -> tuple[Branch, ...]:
        """New searches from scaled variables, each with its family."""
        branches, points = list[Branch](), self.evaluator([scaled for scaled, _ in picked])
        for k, (point, (_, family)) in enumerate(zip(points, picked, strict=True), len(progress.branches)):
            branches.append(search.begin(point, round_, family))
            self._log(progress.stage, k, search, point, branches[-1])
        return tuple(branches)

    def _second(self, progress: Progress, search: Search, best: Branch) -> Progress:
        """The second stage, from the first one's best design."""
        assert self.problem.then is not None
        lowest = search.goal.value(best.best)
        ceiling = (1.0 + (self.problem.then.slack if lowest >= 0.0 else -self.problem.then.slack)) * lowest
        scale = abs(Goal(self.problem, self.problem.then.objective).value(best.best)) or 1.0
        progress = progress._replace(stage=1, scale=scale, ceiling=ceiling, branches=())
        return progress._replace(branches=(self._search(progress).begin(best.best),))

    def _search(self, progress: Progress) -> Search:
        return stage_search(self.problem, self.settings, progress)

    def _log(self, stage: int, number: int, search: Search, point: Evaluation, branch: Branch | None) -> None:
        """One evaluated design as a line of the log; ``branch`` is None for a start."""
        entry = record(search.goal, point, len(self.store.records), stage, number, branch)
        self.store.append(entry)
        if self.report is not None:
            self.report(entry)

    def finished(self, progress: Progress) -> Tuned:
        """The best design, judged at tight tolerance."""
        search = self._search(progress)
        branch = best_branch(search, progress.branches)
        return judged(
            search.goal,
            self.settings,
            self.evaluator,
            progress.first.scaled,
            branch.best,
            search.scale,
            branch.penalty,
            lambda after: end(search.goal, branch, after, progress, self.settings),
            self.store.records,
        )


def stage_search(problem: Problem, settings: Settings, progress: Progress) -> Search:
    """The rules of the stage that the progress is in."""
    then = problem.then
    if progress.stage == 0 or then is None:
        goal = Goal(problem, problem.objective)
    else:
        goal = Goal(problem, then.objective, Ceiling(problem.objective, progress.ceiling))
    return Search(goal, progress.scale, settings)


def best_branch(search: Search, branches: tuple[Branch, ...]) -> Branch:
    """The search with the best design."""
    return min(branches, key=lambda branch: search.rank(branch.best))


def size(goal: Goal, points: list[Evaluation]) -> float:
    """Size of the objective [N]: the first of its values among the starts that is not zero, without sign; else 1."""
    return next((abs(value) for value in map(goal.value, points) if value != 0.0), 1.0)


def check_starts(problem: Problem, points: list[Evaluation]) -> None:
    """Raise `InputError` where nothing leads on from the starts."""
    reasons = "; ".join(
        sorted({problem.mechanism.outcomes(int(code)).reason for point in points for code in point.code})
    )
    if not any(np.any(point.solved) for point in points):
        raise InputError(
            f"every {problem.mechanism.run_name} of the start fails ({reasons}): there is no slope to climb"
        )
    margin = problem.mechanism.margin
    if margin and problem.limits.captured and not any(np.any(p.succeeded) or np.any(p.margin_slope) for p in points):
        raise InputError(
            f"no {problem.mechanism.run_name} of the start succeeds ({reasons}), and no variable changes that to first "
            "order: start from another design or tune other variables"
        )
