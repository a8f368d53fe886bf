"""The default search: rounds of local searches, in two stages where a problem has a second objective.

Slopes do not see a discontinuity, so what lies beyond one is looked for by trying. A round screens a sample of the
bounds, which costs a fraction of as many gradients, and follows the best of it. Rounds after the first also screen
around the best design so far, on all sides of its discontinuities.
"""

import dataclasses
from typing import NamedTuple

import numpy as np
import scipy
from jaxtyping import Float

from ..errors import InputError
from .assessment import assess
from .problem.problem import Problem
from .problem.settings import Settings
from .report.message import ending, search_report
from .report.tuned import Tuned
from .search.constraints import Ceiling
from .search.evaluation import Evaluation, Evaluator
from .search.goal import Goal
from .search.search import AGREE, BEHIND, RUNNING, Branch, Search, advance, without_hopeless
from .search.store import Progress, TuningStore, record_of

WIDEST, NARROWEST = 0.5, 0.01  # half-widths of the boxes around the best design, of each variable's range

Scaled = Float[np.ndarray, " variables"]


@dataclasses.dataclass
class Rounds:
    """The rounds of searches of one tuning.

    ``begin``: scaled variables of the design to begin with; None: the problem's own.
    """

    problem: Problem
    settings: Settings
    evaluator: Evaluator
    store: TuningStore
    begin: Scaled | None = None

    def run(self, progress: Progress | None) -> Progress:
        """Run all rounds of both stages, from stored progress if there is some."""
        progress = self._begin() if progress is None else progress
        self.evaluator.captures = progress.captures
        while True:
            search = self._search(progress)
            progress = self._finish_searches(search, progress)
            best = best_branch(search, progress.branches)
            agreement = Agreement.of(search, progress.branches)
            if progress.stage == 0:
                progress = progress._replace(searches=len(progress.branches), apart=agreement.difference)
            latest = max(branch.round for branch in progress.branches)
            another = self.settings.starts > 1 and latest + 1 < self.settings.rounds
            if another and not agreement.suffices(progress.stage):
                progress = self._next_round(search, progress, best)
            elif self.problem.then is not None and progress.stage == 0 and search.goal.feasible(best.best):
                # The second stage begins from the first one's best design.
                ceiling = self.problem.then.ceiling(search.goal.value(best.best))
                scale = abs(Goal(self.problem, self.problem.then.objective).value(best.best)) or 1.0
                progress = progress._replace(stage=1, scale=scale, ceiling=ceiling, branches=())
                progress = progress._replace(branches=(self._search(progress).begin(best.best),))
            else:
                return progress
            # Each round is stored before its steps, so that an interrupted run goes on with the same searches.
            self.store.keep(progress.arrays())

    def _finish_searches(self, search: Search, progress: Progress) -> Progress:
        """Advance the running searches until all have stopped."""
        while any(branch.status == RUNNING for branch in progress.branches):
            branches = list(progress.branches)
            for k, trial, branch in advance(search, branches, self.evaluator):
                branches[k] = branch
                self._log(progress.stage, k, search, trial, branch)
            branches = without_hopeless(search, branches)
            progress = progress._replace(branches=tuple(branches), captures=self.evaluator.captures)
            self.store.keep(progress.arrays())
        return progress

    def _begin(self) -> Progress:
        """Begin the first round, with the problem's own start among the designs screened; alone it needs none."""
        goal, settings = Goal(self.problem, self.problem.objective), self.settings
        own = self.problem.start() if self.begin is None else self.begin
        alone = settings.starts == 1
        # A lone start is followed in any event and needs its slopes at once; of many, most are only compared.
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
        self.store.keep(progress.arrays())
        return progress

    def _next_round(self, search: Search, progress: Progress, best: Branch) -> Progress:
        """Begin another round, of designs around the best one and, in the first stage, anywhere."""
        settings, round_ = self.settings, max(branch.round for branch in progress.branches) + 1
        count, number = settings.starts // 2, len(progress.branches)
        # The boxes lie on all sides of the best design, so that they reach beyond a discontinuity that stopped its
        # search.
        near = self._screen(search, progress.stage, around(best.best.scaled, settings, round_, count))
        # It keeps the family of the best: a search from around a design is no independent witness for it.
        picked = [(min(near, key=search.rank).scaled, best.family)]
        if progress.stage == 0:
            scaled = anywhere(settings, round_, len(best.best.scaled), settings.starts - count)
            far = sorted(self._screen(search, 0, scaled), key=search.rank)[: max(1, settings.searches - 1)]
            picked += [(point.scaled, number + k) for k, point in enumerate(far, 1)]
        branches = progress.branches + self._branches(search, progress, picked, round_)
        return progress._replace(branches=branches, captures=self.evaluator.captures)

    def _screen(self, search: Search, stage: int, points: list[Scaled]) -> list[Evaluation]:
        """Evaluate designs without derivatives."""
        evaluations = self.evaluator(points, slopes=False)
        for point in evaluations:
            self._log(stage, 0, search, point, None)
        return evaluations

    def _branches(
        self, search: Search, progress: Progress, picked: list[tuple[Scaled, int]], round_: int = 0
    ) -> tuple[Branch, ...]:
        """Begin searches from scaled variables, each with its family."""
        branches, points = list[Branch](), self.evaluator([scaled for scaled, _ in picked])
        for k, (point, (_, family)) in enumerate(zip(points, picked, strict=True), len(progress.branches)):
            branches.append(search.begin(point, round_, family))
            self._log(progress.stage, k, search, point, branches[-1])
        return tuple(branches)

    def _search(self, progress: Progress) -> Search:
        return stage_search(self.problem, self.settings, progress)

    def _log(self, stage: int, number: int, search: Search, point: Evaluation, branch: Branch | None) -> None:
        """Log an evaluated design; ``branch`` is None for a start."""
        records = self.store.records
        captures = records[-1]["captures"] if records else 0
        self.store.append(record_of(search.goal, point, len(records), stage, number, branch, captures))

    def result(self, progress: Progress) -> Tuned:
        """Return the best design, evaluated at tight tolerance."""
        search = self._search(progress)
        branch = best_branch(search, progress.branches)
        return assess(
            search.goal,
            self.settings,
            self.evaluator,
            self.problem.start(),
            branch.best,
            search.scale,
            branch.penalty,
            search_report(branch, progress, self.settings),
            self.store.records,
            ended=ending(branch, self.settings),
            confirmed=progress.searches > 1 and progress.apart <= AGREE,
        )


def stage_search(problem: Problem, settings: Settings, progress: Progress) -> Search:
    """Return the rules of the stage that the progress is in."""
    then = problem.then
    if progress.stage == 0 or then is None:
        goal = Goal(problem, problem.objective)
    else:
        goal = Goal(problem, then.objective, Ceiling(problem, problem.objective, progress.ceiling))
    return Search(goal, progress.scale, settings)


def best_branch(search: Search, branches: tuple[Branch, ...]) -> Branch:
    """Return the search with the best design."""
    return min(branches, key=lambda branch: search.rank(branch.best))


def size(goal: Goal, points: list[Evaluation]) -> float:
    """Return the size of the objective [N]: that of its first value among the starts that is not zero, else 1."""
    return next((abs(value) for value in map(goal.value, points) if value != 0.0), 1.0)


def check_starts(problem: Problem, points: list[Evaluation]) -> None:
    """Raise `InputError` where nothing leads on from the starts."""
    reasons = "; ".join(
        sorted({problem.mechanism.outcomes(int(code)).reason for point in points for code in point.code})
    )
    if not any(np.any(point.solved) for point in points):
        raise InputError(
            f"every {problem.mechanism.view.run_name} of the start fails ({reasons}): there is no slope to climb"
        )
    margin = problem.mechanism.tuning.margin
    if (
        margin
        and problem.limits.require_success
        and not any(np.any(p.succeeded) or np.any(p.margin_slope) for p in points)
    ):
        raise InputError(
            f"no {problem.mechanism.view.run_name} of the start succeeds ({reasons}), and no variable changes that to"
            " first order: start from another design or tune other variables"
        )


def anywhere(settings: Settings, round_: int, size: int, count: int) -> list[Scaled]:
    """Sample the whole range between the bounds by a Latin hypercube, another one in each round."""
    return list(_hypercube((settings.seed, round_, 0), size, count))


def around(best: Scaled, settings: Settings, round_: int, count: int) -> list[Scaled]:
    """Sample boxes around a design, each narrower than the one before, cut off at the bounds."""
    widths = np.geomspace(WIDEST, NARROWEST, count)[:, None]
    shares = _hypercube((settings.seed, round_, 1), len(best), count)
    return list(np.clip(best + widths * (2.0 * shares - 1.0), 0.0, 1.0))


def _hypercube(seed: tuple[int, ...], size: int, count: int) -> np.ndarray:
    return np.asarray(scipy.stats.qmc.LatinHypercube(size, rng=np.random.default_rng(seed)).random(count))


class Agreement(NamedTuple):
    """How well the searches agree.

    ``families``: the best objective [N] of each independent search that ended feasible, rising; searches that began
    around another's design belong to its family. ``difference`` [-]: of the best two, relative, infinite where there
    are none; ``discontinuities``: whether a search met a discontinuity; ``gain`` [-]: by how much the last round
    lowered the best objective, infinite where nothing feasible was known before.
    """

    families: tuple[float, ...]
    difference: float
    discontinuities: bool
    gain: float

    @staticmethod
    def of(search: Search, branches: tuple[Branch, ...]) -> "Agreement":
        """Return how well all searches of a stage agree."""
        latest = max(branch.round for branch in branches)
        families = _families(search, branches)
        earlier = _families(search, tuple(branch for branch in branches if branch.round < latest))
        return Agreement(
            tuple(families),
            _above(families[1], families[0]) if len(families) > 1 else np.inf,
            any(bool(np.any(np.isfinite(branch.discontinuities))) for branch in branches),
            _above(earlier[0], families[0]) if earlier else np.inf,
        )

    def suffices(self, stage: int) -> bool:
        """Return whether nothing tells of a better design elsewhere.

        That is so where no search met a discontinuity, or the last round gained nothing more; and in the first stage
        independent searches agree.
        """
        if not self.families:
            return False
        agree = stage > 0 or self.difference <= AGREE
        return (agree or len(self.families) == 1) if not self.discontinuities else (agree and self.gain <= AGREE)


def _above(value: float, lowest: float) -> float:
    """Return by how much an objective is above the lowest, relative to that one's size [-]."""
    # Also where both are zero, which have no relative difference.
    if value == lowest:
        return 0.0
    return value / abs(lowest) - float(np.sign(lowest)) if lowest else np.inf


def _families(search: Search, branches: tuple[Branch, ...]) -> list[float]:
    """Return the best of each family; of a search that was dropped before its end, only what agrees with the best."""
    feasible = [(search.goal.value(b.best), b) for b in branches if search.goal.feasible(b.best)]
    lowest = min((value for value, _ in feasible), default=np.inf)
    best: dict[int, float] = {}
    for value, branch in feasible:
        if branch.status != BEHIND or _above(value, lowest) <= AGREE:
            best[branch.family] = min(best.get(branch.family, np.inf), value)
    return sorted(best.values())
