"""Local searches in a trust region: several starts, advanced together, one batch of runs a step.

Each evaluation gives every impact's peak in every case to first order, so a step knows the runner-up peaks and load
cases it will meet. The step minimises that model with the Lagrangian's curvature (`model_step`) and is compared by the
true merit; the trust region grows or shrinks by the ratio of the actual to the predicted reduction (Nocedal and Wright,
eq. 4.4).

Where one more bounce decides over capture, the outcome is discontinuous, and no slope tells: a design beyond such a
discontinuity is refused and remembered, and steps stay nearer to the present design than to it. So a search moves along
a discontinuity instead of shrinking its steps before it.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..problem.settings import Settings
from .evaluation import Evaluation, Evaluator
from .goal import ROOM, Goal, Tangent
from .model_step import Cuts, ModelStep, Multipliers, best_step, residual, updated_curvature

FIRST_RADIUS = 0.2  # of the trust region, as a share of each variable's range
LARGEST_RADIUS = 0.5
SMALLEST_RADIUS = 1e-6
RESTART_RADIUS = 0.01
FIRST_PENALTY = 0.1  # raised until the model is within the limits; a large one makes steps along curved limits short
LARGEST_PENALTY = 1e5
SCREENING_PENALTY = 10.0  # by which designs are ranked that break a limit
AGREE = 0.01  # relative difference of objectives below which two searches agree
DISCONTINUITIES = 12  # designs beyond a discontinuity that are remembered, the latest ones
PATIENCE = 8  # steps that together must gain more than the tolerance
FAIR_TRIAL = 5  # steps before a search may be dropped as hopeless
RUNNING, CONVERGED, STALLED, BEHIND = 0, 1, 2, 3


class Branch(NamedTuple):
    """One local search: its best design so far, its trust region and its model. All arrays, so that it can be stored.

    ``point``: its present design; ``best``: the best one so far, feasible before infeasible; ``discontinuities``: the
    scaled variables of designs beyond a discontinuity, NaN where none; ``merits``: of the last steps, latest last;
    ``round`` it began in; ``family``: the number of the search around whose design it began, or its own; ``restarted``:
    its merit when its curvature was last set to zero.
    """

    point: Evaluation
    best: Evaluation
    radius: float
    curvature: Float[np.ndarray, "n n"]
    discontinuities: Float[np.ndarray, "discontinuities n"]
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
        """Begin a branch at an evaluated design."""
        size = len(point.scaled)
        branch = Branch(
            point=point,
            best=point,
            radius=FIRST_RADIUS,
            curvature=np.zeros((size, size)),
            discontinuities=np.full((DISCONTINUITIES, size), np.nan),
            merits=np.full(PATIENCE, np.inf),
            penalty=FIRST_PENALTY,
            residual=np.inf,
            status=RUNNING,
            steps=0,
            round=round_,
            family=family,
            restarted=np.inf,
        )
        return self._examine(branch)

    def rank(self, point: Evaluation) -> tuple[bool, float]:
        """Return the key that orders designs: feasible before infeasible, then by merit."""
        return not self.goal.feasible(point), self.goal.merit(point, self.scale, SCREENING_PENALTY)

    def plan(self, branch: Branch) -> ModelStep:
        """Return the step to try next."""
        tangent, scaled = Tangent.of(branch.point), branch.point.scaled
        # Steps stay nearer to the present design than to any one beyond a discontinuity.
        normals = branch.discontinuities[np.all(np.isfinite(branch.discontinuities), axis=1)] - scaled
        cuts = Cuts(normals, 0.5 * np.sum(normals**2, axis=1))
        arguments = (self.goal, tangent, scaled, branch.radius, self.scale, branch.penalty, cuts)
        move = best_step(*arguments, room=ROOM, curvature=branch.curvature)
        if move.predicted_reduction <= 0.0:  # the design is within the room: all that is left to gain is there
            move = best_step(*arguments, room=0.1 * ROOM, curvature=branch.curvature)
        return move

    def judge(self, branch: Branch, move: ModelStep, trial: Evaluation) -> Branch:
        """Return the branch after its step was tried."""
        before, after = (self.goal.merit(point, self.scale, branch.penalty) for point in (branch.point, trial))
        # A model that predicts nothing is taken for a failure, which shrinks the trust region.
        ratio = (before - after) / move.predicted_reduction if move.predicted_reduction > 0.0 else -1.0
        length = float(np.max(np.abs(move.step)))
        radius, discontinuities = branch.radius, branch.discontinuities
        beyond = self._is_beyond(branch.point, move.step, trial)
        # The cut that `plan` makes of the refused design does most, so that the radius shrinks little.
        if beyond:
            radius = 0.7 * radius
            discontinuities = np.vstack([discontinuities[1:], trial.scaled])
        elif ratio < 0.25:
            radius = 0.35 * min(length, radius)
        elif ratio > 0.7 and length > 0.8 * radius:
            radius = min(2.0 * radius, LARGEST_RADIUS)
        point, curvature = branch.point, branch.curvature
        if ratio > 0.05 and not beyond:
            curvature = updated_curvature(curvature, move.step, self._bend(point, trial, move.multipliers))
            point = trial
        moved = branch._replace(
            point=point,
            # A trial that the merit refuses may be the best by rank: the two weigh broken limits differently.
            best=min(branch.best, trial, key=self.rank),
            radius=radius,
            curvature=curvature,
            discontinuities=discontinuities,
            steps=branch.steps + 1,
        )
        return self._examine(moved)

    def _is_beyond(self, point: Evaluation, step: np.ndarray, trial: Evaluation) -> bool:
        """Return whether a discontinuity lies between two designs.

        Then a run succeeds in the model and not when it is simulated, has no numbers, or too many impacts.
        """
        # More impacts, or a run without numbers: no slope announces either.
        if np.any(self.goal.without_slopes(trial) > self.goal.without_slopes(point)):
            return True
        expected = Tangent.of(point).after(step)[1]
        failed = (point.margin >= 0.0) & (expected >= 0.0) & (trial.margin < 0.0)
        return self.goal.require_success and bool(np.any(failed))

    def _examine(self, branch: Branch) -> Branch:
        """Return the branch with its residual, a penalty that outweighs the objective, and whether it goes on."""
        tangent, scaled, penalty = Tangent.of(branch.point), branch.point.scaled, branch.penalty
        feasible, tolerance = self.goal.feasible(branch.point), self.settings.tolerance
        limit = self.settings.iterations

        def model(penalty: float) -> tuple[float, float]:
            """Return the predicted reduction, and what would still be above its limit."""
            move = residual(self.goal, tangent, scaled, self.scale, penalty)
            return move.predicted_reduction, self.goal.excess_after(tangent, move.step)

        left, above = model(penalty)
        while above > ROOM and penalty < LARGEST_PENALTY:
            more = model(10.0 * penalty)
            if more[1] > 0.9 * above:
                break  # no weight helps: slopes lead no further
            penalty, (left, above) = 10.0 * penalty, more
        # Merits of another penalty cannot be compared with the next ones, so their memory begins anew.
        merits = branch.merits if penalty == branch.penalty else np.full(PATIENCE, np.inf)
        merit = self.goal.merit(branch.point, self.scale, penalty)
        branch = branch._replace(penalty=penalty, residual=left, merits=np.append(merits[1:], merit))
        if left <= tolerance and feasible:
            return branch._replace(status=CONVERGED)
        if branch.steps >= limit or left <= 0.0:
            return branch._replace(status=STALLED)
        if not (merit > merits[0] - tolerance or branch.radius < SMALLEST_RADIUS):
            return branch
        # A search that gains no more goes on with the linear model, if it has gained since it last did so: a curvature
        # estimated across kinks slows it down.
        if not np.any(branch.curvature) or merit > branch.restarted - tolerance:
            return branch._replace(status=STALLED)
        return branch._replace(
            # A trust region that has shrunk to its least would stop the search again at once.
            radius=max(branch.radius, RESTART_RADIUS),
            curvature=0.0 * branch.curvature,
            merits=np.full(PATIENCE, np.inf),
            restarted=merit,
        )

    @staticmethod
    def _bend(point: Evaluation, trial: Evaluation, multipliers: Multipliers) -> np.ndarray:
        """Return the change of the Lagrangian's slope; NaN where impacts with a large weight have gone."""
        matched = np.zeros_like(point.peaks_slope)  # each impact's slope in the trial, where it stands in the point
        missing = 0.0
        for k, (old, new) in enumerate(zip(point.slots, trial.slots, strict=True)):
            where = {int(slot): i for i, slot in enumerate(new)}
            for i, slot in enumerate(old):
                # Lists are in order of height, so that the same impact may stand elsewhere in the other one.
                if (j := where.get(int(slot))) is not None and trial.peaks[k, j] > 0.0:
                    matched[k, i] = trial.peaks_slope[k, j]
                else:
                    missing += abs(multipliers.peaks[k, i])
        if missing > 0.01 * np.sum(np.abs(multipliers.peaks)) or not np.all(trial.solved):
            return np.full(len(point.scaled), np.nan)
        after = Tangent.of(trial)._replace(peaks_slope=matched)
        moved = multipliers.moved(trial.by_peak - point.by_peak)
        return moved.slope(after) - multipliers.slope(Tangent.of(point))


def without_hopeless(search: Search, branches: list[Branch]) -> list[Branch]:
    """Drop searches that cannot overtake the best one even by their own model within a tenth of every range."""
    best = min(search.rank(branch.best)[1] for branch in branches)
    return [
        branch._replace(status=BEHIND)
        if branch.status == RUNNING
        and branch.steps >= FAIR_TRIAL
        and search.rank(branch.best)[1] - branch.residual > best
        else branch
        for branch in branches
    ]


def advance(search: Search, branches: list[Branch], evaluator: Evaluator) -> list[tuple[int, Evaluation, Branch]]:
    """Move every running branch by one step; the designs that they try are one batch.

    **Returns:** number, design tried and new branch of those that moved.
    """
    running = [k for k, branch in enumerate(branches) if branch.status == RUNNING]
    moves = [search.plan(branches[k]) for k in running]
    trials = evaluator(
        [np.clip(branches[k].point.scaled + m.step, 0.0, 1.0) for k, m in zip(running, moves, strict=True)]
    )
    return [
        (k, trial, search.judge(branches[k], move, trial))
        for k, move, trial in zip(running, moves, trials, strict=True)
    ]
