"""Local searches by first-order models in a trust region: several starts, advanced together, one batch of captures a
step.

Each evaluation gives every impact's peak in every case to first order, so a step knows the runner-up peaks and cases it
will meet. The step minimises that model (`linear` exactly, `curved` with smoothing and curvature; the better of both),
is judged by the true merit, and the region within which the model is believed grows or shrinks by how true it was.

Where one more bounce decides over capture, the outcome jumps, and no slope tells: a design that fell off such a cliff
is remembered, and steps stay nearer to the present design than to it. So a search moves along a cliff instead of
shrinking its steps before it.
"""

import dataclasses
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from .curvature import learnt
from .curved import Pull, Setup, curved_step
from .evaluation import Evaluation, Evaluator
from .goal import ROOM, Goal, Tangent
from .linear import Cuts, best_step, residual

FIRST_RADIUS = 0.2  # of each variable's range
LARGEST_RADIUS = 0.5
SMALLEST_RADIUS = 1e-6
FIRST_PENALTY = 10.0
LARGEST_PENALTY = 1e5
WIDTH = 0.1  # of the smooth maxima, relative to the decrease that the first-order model promises
SMALLEST_WIDTH = 1e-6
CLIFFS = 12  # designs remembered that fell off, the latest ones
PATIENCE = 8  # steps that together must gain more than the tolerance
FAIR_TRIAL = 5  # steps before a search may be given up as hopeless
RUNNING, CONVERGED, STALLED, BEHIND = 0, 1, 2, 3


@dataclasses.dataclass(frozen=True)
class Settings:
    """**Arguments:** ``iterations`` of each local search at most; ``starts``: designs screened in a round, the first
    time the problem's own among them; ``searches``: the best of them that are followed; ``rounds`` at most; ``seed`` of
    the samples; ``tolerance`` [-]: residual that counts as converged."""

    iterations: int = 40
    starts: int = 32
    searches: int = 2
    rounds: int = 6
    seed: int = 0
    tolerance: float = 1e-4


class Branch(NamedTuple):
    """One local search: its best design so far and what it has learnt. All arrays, so that it can be stored.

    ``point``: where it stands; ``kept``: the best design seen, feasible before infeasible; ``cliffs``: places of
    designs that lost a capture against the model's word, NaN where none; ``merits``: of the last steps, latest last;
    ``round`` it began in; ``family``: the number of the search around whose design it began, or its own.
    """

    point: Evaluation
    kept: Evaluation
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


class Move(NamedTuple):
    """A step about to be tried: the ``decrease`` of the merit that the model promises, weights ``pull``."""

    step: Float[np.ndarray, " variables"]
    decrease: float
    pull: Pull


class Search:
    """The rules by which branches move, for one goal."""

    def __init__(self, goal: Goal, scales: tuple[float, float], settings: Settings) -> None:
        self.goal, self.settings = goal, settings
        self.scale, self.peak_scale = scales
        self.setup = Setup.of(goal, *scales, ROOM)

    def begin(self, point: Evaluation, round_: int = 0, family: int = 0) -> Branch:
        """A branch at an evaluated design."""
        size = len(point.places)
        branch = Branch(
            point=point,
            kept=point,
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
        )
        return self._examined(branch)

    def rank(self, point: Evaluation) -> tuple[bool, float]:
        """The order of designs: feasible before infeasible, then by merit."""
        return not self.goal.feasible(point), self.goal.merit(point, self.scale, FIRST_PENALTY)

    def plan(self, branch: Branch) -> Move:
        """The step to try next."""
        tangent, places, n = Tangent.of(branch.point), branch.point.places, len(branch.point.places)
        cuts = _nearer(places, branch.cliffs)
        arguments = (self.goal, tangent, places, branch.radius, self.scale, branch.penalty, cuts)
        linear = best_step(*arguments, room=ROOM)
        box = np.stack([np.maximum(-branch.radius, -places), np.minimum(branch.radius, 1.0 - places)])
        width = max(SMALLEST_WIDTH, WIDTH * linear.promise)
        here = self.goal.promised(tangent, np.zeros(n), self.scale, branch.penalty)

        def model(step: np.ndarray) -> float:
            bend = 0.5 * float(step @ branch.curvature @ step)
            return self.goal.promised(tangent, step, self.scale, branch.penalty) + bend

        steps = [linear.step]
        for start in (linear.step, np.zeros(n)):
            step, pull = curved_step(self.setup, tangent, branch.curvature, start, box, width)
            steps.append(cuts.shortened(step))
        best = min(steps, key=model)
        if model(best) >= here:  # standing within the room: all that is left to gain is there
            best = best_step(*arguments, room=0.1 * ROOM).step
        return Move(best, here - model(best), pull)

    def judge(self, branch: Branch, move: Move, trial: Evaluation) -> Branch:
        """The branch after its step was tried."""
        before, after = (self.goal.merit(point, self.scale, branch.penalty) for point in (branch.point, trial))
        truth = (before - after) / move.decrease if move.decrease > 0.0 else -1.0
        length = float(np.max(np.abs(move.step)))
        radius, cliffs = branch.radius, branch.cliffs
        if self._fell(branch.point, move.step, trial):
            radius = 0.7 * radius
            cliffs = np.vstack([cliffs[1:], trial.places])
        elif truth < 0.25:
            radius = 0.35 * min(length, radius)
        elif truth > 0.7 and length > 0.8 * radius:
            radius = min(2.0 * radius, LARGEST_RADIUS)
        curvature = learnt(branch.curvature, move.step, self._bend(branch.point, trial, move.pull))
        point = trial if truth > 0.05 else branch.point
        moved = branch._replace(
            point=point,
            kept=min(branch.kept, trial, key=self.rank),
            radius=radius,
            curvature=curvature,
            cliffs=cliffs,
            steps=branch.steps + 1,
        )
        return self._examined(moved)

    def _fell(self, point: Evaluation, step: np.ndarray, trial: Evaluation) -> bool:
        """Whether a capture was lost that the model had kept."""
        if not self.goal.problem.limits.captured:
            return False
        expected = Tangent.of(point).after(step)[1]
        return bool(np.any((point.margin >= 0.0) & (expected >= 0.0) & (trial.margin < 0.0)))

    def _examined(self, branch: Branch) -> Branch:
        """With its residual, a penalty that outweighs the objective, and whether it goes on."""
        tangent, places, penalty = Tangent.of(branch.point), branch.point.places, branch.penalty
        feasible, tolerance = self.goal.feasible(branch.point), self.settings.tolerance
        limit = self.settings.iterations

        def model(penalty: float) -> tuple[float, float]:
            """What is promised, and what would still be above its limit."""
            found = residual(self.goal, tangent, places, self.scale, penalty)
            return found.promise, self.goal.excess_after(tangent, found.step)

        left, above = model(penalty)
        while above > ROOM and penalty < LARGEST_PENALTY:
            more = model(10.0 * penalty)
            if more[1] > 0.9 * above:
                break  # no weight helps: slopes lead no further
            penalty, (left, above) = 10.0 * penalty, more
        merits = branch.merits if penalty == branch.penalty else np.full(PATIENCE, np.inf)
        merit, status = self.goal.merit(branch.point, self.scale, penalty), RUNNING
        if left <= tolerance and feasible:
            status = CONVERGED
        elif merit > merits[0] - tolerance or branch.radius < SMALLEST_RADIUS or branch.steps >= limit or left <= 0.0:
            status = STALLED
        merits = np.append(merits[1:], merit)
        return branch._replace(penalty=penalty, residual=left, status=status, merits=merits)

    @staticmethod
    def _bend(point: Evaluation, trial: Evaluation, pull: Pull) -> np.ndarray:
        """Change of the Lagrangian's slope, each impact compared with itself; NaN where weighty ones have gone."""
        matched = np.zeros_like(point.peaks_slope)
        missing = 0.0
        for k, (old, new) in enumerate(zip(point.slots, trial.slots, strict=True)):
            where = {int(slot): i for i, slot in enumerate(new)}
            for i, slot in enumerate(old):
                if (found := where.get(int(slot))) is not None and trial.peaks[k, found] > 0.0:
                    matched[k, i] = trial.peaks_slope[k, found]
                else:
                    missing += abs(pull.peaks[k, i])
        if missing > 0.01 * np.sum(np.abs(pull.peaks)) or not np.all(trial.solved):
            return np.full(len(point.places), np.nan)
        after = Tangent.of(trial)._replace(peaks_slope=matched)
        return pull.slope(after) - pull.slope(Tangent.of(point))


def _nearer(places: np.ndarray, cliffs: np.ndarray) -> Cuts:
    """Steps that stay nearer to ``places`` than to any of the ``cliffs``."""
    normals = cliffs[np.all(np.isfinite(cliffs), axis=1)] - places
    return Cuts(normals, 0.5 * np.sum(normals**2, axis=1))


def without_hopeless(search: Search, branches: list[Branch]) -> list[Branch]:
    """Searches given up whose model promises too little, within a tenth of every range, to overtake the best one."""
    best = min(search.rank(branch.kept)[1] for branch in branches)
    return [
        branch._replace(status=BEHIND)
        if branch.status == RUNNING
        and branch.steps >= FAIR_TRIAL
        and search.rank(branch.point)[1] - branch.residual > best
        else branch
        for branch in branches
    ]


def advanced(search: Search, branches: list[Branch], evaluator: Evaluator) -> list[tuple[int, Evaluation, Branch]]:
    """Move every running branch by one step; the tried designs of all of them are one batch. Returns number, tried
    design and new branch of those that moved."""
    running = [k for k, branch in enumerate(branches) if branch.status == RUNNING]
    moves = [search.plan(branches[k]) for k in running]
    trials = evaluator(
        [np.clip(branches[k].point.places + m.step, 0.0, 1.0) for k, m in zip(running, moves, strict=True)]
    )
    return [
        (k, trial, search.judge(branches[k], move, trial))
        for k, move, trial in zip(running, moves, trials, strict=True)
    ]
