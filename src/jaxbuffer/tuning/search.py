"""Local searches by first-order models in a trust region: several starts, advanced together, one batch of captures a
step.

Each evaluation gives every impact's peak in every case to first order, so a step knows the runner-up peaks and cases it
will meet. The step minimises that model with the Lagrangian's curvature (`model_step`), is judged by the true merit,
and the region within which the model is believed grows or shrinks by the ratio of the actual to the predicted reduction
(Nocedal and Wright, eq. 4.4).

Where one more bounce decides over capture, the outcome jumps, and no slope tells: a design that fell off such a cliff
is refused and remembered, and steps stay nearer to the present design than to it. So a search moves along a cliff
instead of shrinking its steps before it.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from .curvature import learnt
from .evaluation import Evaluation, Evaluator
from .goal import ROOM, Goal, Tangent
from .model_step import Cuts, ModelStep, Multipliers, best_step, residual
from .settings import Settings

FIRST_RADIUS = 0.2  # of each variable's range
LARGEST_RADIUS = 0.5
SMALLEST_RADIUS = 1e-6
RESTART_RADIUS = 0.01
FIRST_PENALTY = 0.1  # raised until the model keeps to the limits; a large one makes steps along curved limits short
LARGEST_PENALTY = 1e5
SCREENING_PENALTY = 10.0  # by which designs are ranked that break a limit
CLIFFS = 12  # designs remembered that fell off, the latest ones
PATIENCE = 8  # steps that together must gain more than the tolerance
FAIR_TRIAL = 5  # steps before a search may be given up as hopeless
RUNNING, CONVERGED, STALLED, BEHIND = 0, 1, 2, 3


class Branch(NamedTuple):
    """One local search: its best design so far and what it has learnt. All arrays, so that it can be stored.

    ``point``: where it stands; ``best``: the best design seen, feasible before infeasible; ``cliffs``: the scaled
    variables of designs that fell off one, NaN where none; ``merits``: of the last steps, latest last; ``round`` it
    began in; ``family``: the number of the search around whose design it began, or its own; ``restarted``: its merit
    when its curvature was last forgotten.
    """

    point: Evaluation
    best: Evaluation
    radius: float
    curvature: Float[np.ndarray, "n n"]
    cliffs: Float[np.ndarray, "cliffs n"]
    merits: Float[np.ndarray, " memory"]
    penalty: float
    residual: float
    status: int
    steps: int
    round: int
    family: int
    restarted: float


class Search:
    """The rules by which branches move, for one goal."""

    def __init__(self, goal: Goal, scale: float, settings: Settings) -> None:
        self.goal, self.scale, self.settings = goal, scale, settings

    def begin(self, point: Evaluation, round_: int = 0, family: int = 0) -> Branch:
        """A branch at an evaluated design."""
        size = len(point.scaled)
        branch = Branch(
            point=point,
            best=point,
            radius=FIRST_RADIUS,
            curvature=np.zeros((size, size)),
            cliffs=np.full((CLIFFS, size), np.nan),
            merits=np.full(PATIENCE, np.inf),
            penalty=FIRST_PENALTY,
            residual=np.inf,
            status=RUNNING,
            steps=0,
            round=round_,
            family=family,
            restarted=np.inf,
        )
        return self._examined(branch)

    def rank(self, point: Evaluation) -> tuple[bool, float]:
        """The order of designs: feasible before infeasible, then by merit."""
        return not self.goal.feasible(point), self.goal.merit(point, self.scale, SCREENING_PENALTY)

    def plan(self, branch: Branch) -> ModelStep:
        """The step to try next."""
        tangent, scaled = Tangent.of(branch.point), branch.point.scaled
        cuts = _nearer(scaled, branch.cliffs)
        arguments = (self.goal, tangent, scaled, branch.radius, self.scale, branch.penalty, cuts)
        found = best_step(*arguments, room=ROOM, curvature=branch.curvature)
        if found.predicted_reduction <= 0.0:  # standing within the room: all that is left to gain is there
            found = best_step(*arguments, room=0.1 * ROOM, curvature=branch.curvature)
        return found

    def judge(self, branch: Branch, move: ModelStep, trial: Evaluation) -> Branch:
        """The branch after its step was tried."""
        before, after = (self.goal.merit(point, self.scale, branch.penalty) for point in (branch.point, trial))
        ratio = (before - after) / move.predicted_reduction if move.predicted_reduction > 0.0 else -1.0
        length = float(np.max(np.abs(move.step)))
        radius, cliffs = branch.radius, branch.cliffs
        fell = self._fell(branch.point, move.step, trial)
        if fell:
            radius = 0.7 * radius
            cliffs = np.vstack([cliffs[1:], trial.scaled])
        elif ratio < 0.25:
            radius = 0.35 * min(length, radius)
        elif ratio > 0.7 and length > 0.8 * radius:
            radius = min(2.0 * radius, LARGEST_RADIUS)
        point, curvature = branch.point, branch.curvature
        if ratio > 0.05 and not fell:
            curvature = learnt(curvature, move.step, self._bend(point, trial, move.multipliers))
            point = trial
        moved = branch._replace(
            point=point,
            best=min(branch.best, trial, key=self.rank),
            radius=radius,
            curvature=curvature,
            cliffs=cliffs,
            steps=branch.steps + 1,
        )
        return self._examined(moved)

    def _fell(self, point: Evaluation, step: np.ndarray, trial: Evaluation) -> bool:
        """Whether something was lost that no slope tells of: a run that succeeds in the model and does not when it is
        simulated, one without numbers, or too many impacts."""
        if np.any(self.goal.without_slopes(trial) > self.goal.without_slopes(point)):
            return True
        expected = Tangent.of(point).after(step)[1]
        failed = (point.margin >= 0.0) & (expected >= 0.0) & (trial.margin < 0.0)
        return self.goal.must_succeed and bool(np.any(failed))

    def _examined(self, branch: Branch) -> Branch:
        """With its residual, a penalty that outweighs the objective, and whether it goes on."""
        tangent, scaled, penalty = Tangent.of(branch.point), branch.point.scaled, branch.penalty
        feasible, tolerance = self.goal.feasible(branch.point), self.settings.tolerance
        limit = self.settings.iterations

        def model(penalty: float) -> tuple[float, float]:
            """The predicted reduction, and what would still be above its limit."""
            found = residual(self.goal, tangent, scaled, self.scale, penalty)
            return found.predicted_reduction, self.goal.excess_after(tangent, found.step)

        left, above = model(penalty)
        while above > ROOM and penalty < LARGEST_PENALTY:
            more = model(10.0 * penalty)
            if more[1] > 0.9 * above:
                break  # no weight helps: slopes lead no further
            penalty, (left, above) = 10.0 * penalty, more
        merits = branch.merits if penalty == branch.penalty else np.full(PATIENCE, np.inf)
        merit = self.goal.merit(branch.point, self.scale, penalty)
        branch = branch._replace(penalty=penalty, residual=left, merits=np.append(merits[1:], merit))
        if left <= tolerance and feasible:
            return branch._replace(status=CONVERGED)
        if branch.steps >= limit or left <= 0.0:
            return branch._replace(status=STALLED)
        if merit > merits[0] - tolerance or branch.radius < SMALLEST_RADIUS:
            return self._restarted(branch, merit)
        return branch

    def _restarted(self, branch: Branch, merit: float) -> Branch:
        """A search that gains no more goes on with the linear model, if it has gained since it last did so: a curvature
        learnt across kinks holds it up."""
        if not np.any(branch.curvature) or merit > branch.restarted - self.settings.tolerance:
            return branch._replace(status=STALLED)
        return branch._replace(
            radius=max(branch.radius, RESTART_RADIUS),
            curvature=0.0 * branch.curvature,
            merits=np.full(PATIENCE, np.inf),
            restarted=merit,
        )

    @staticmethod
    def _bend(point: Evaluation, trial: Evaluation, multipliers: Multipliers) -> np.ndarray:
        """Change of the Lagrangian's slope, each impact compared with itself; NaN where weighty ones have gone."""
        matched = np.zeros_like(point.peaks_slope)
        missing = 0.0
        for k, (old, new) in enumerate(zip(point.slots, trial.slots, strict=True)):
            where = {int(slot): i for i, slot in enumerate(new)}
            for i, slot in enumerate(old):
                if (found := where.get(int(slot))) is not None and trial.peaks[k, found] > 0.0:
                    matched[k, i] = trial.peaks_slope[k, found]
                else:
                    missing += abs(multipliers.peaks[k, i])
        if missing > 0.01 * np.sum(np.abs(multipliers.peaks)) or not np.all(trial.solved):
            return np.full(len(point.scaled), np.nan)
        after = Tangent.of(trial)._replace(peaks_slope=matched)
        moved = multipliers.moved(trial.by_peak - point.by_peak)
        return moved.slope(after) - multipliers.slope(Tangent.of(point))


def _nearer(scaled: np.ndarray, cliffs: np.ndarray) -> Cuts:
    """Steps that stay nearer to ``scaled`` than to any of the ``cliffs``."""
    normals = cliffs[np.all(np.isfinite(cliffs), axis=1)] - scaled
    return Cuts(normals, 0.5 * np.sum(normals**2, axis=1))


def without_hopeless(search: Search, branches: list[Branch]) -> list[Branch]:
    """Searches given up whose model predicts too little, within a tenth of every range, to overtake the best one."""
    best = min(search.rank(branch.best)[1] for branch in branches)
    return [
        branch._replace(status=BEHIND)
        if branch.status == RUNNING
        and branch.steps >= FAIR_TRIAL
        and search.rank(branch.best)[1] - branch.residual > best
        else branch
        for branch in branches
    ]


def advanced(search: Search, branches: list[Branch], evaluator: Evaluator) -> list[tuple[int, Evaluation, Branch]]:
    """Move every running branch by one step; the tried designs of all of them are one batch. Returns number, tried
    design and new branch of those that moved."""
    running = [k for k, branch in enumerate(branches) if branch.status == RUNNING]
    moves = [search.plan(branches[k]) for k in running]
    trials = evaluator(
        [np.clip(branches[k].point.scaled + m.step, 0.0, 1.0) for k, m in zip(running, moves, strict=True)]
    )
    return [
        (k, trial, search.judge(branches[k], move, trial))
        for k, move, trial in zip(running, moves, trials, strict=True)
    ]
