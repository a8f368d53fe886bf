"""Exact enumeration of combinations that leaves out every run which cannot change the ranking of the best.

A combination is dropped as soon as one load case shows it infeasible, or beaten: the objective from the cases run so
far, with nothing for the others, is above that of as many complete feasible combinations as are ranked. With a second
objective it is above the ceiling as well, which is the best objective and the tolerance beside it: all below that are
run at every load case, and the second objective orders them.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from ..tuning.problem.objective import Objective
from ..tuning.search.evaluation import gather
from ..tuning.search.goal import Goal
from .order import Second, order, within
from .runs import Runs

PILOTS = 8  # combinations that are run at every load case at first: they say which cases are the hardest
BATCH = 64  # combinations of a round at least


class Judged(NamedTuple):
    """What the runs of combinations at load cases say: the objective's ``value`` of each, the ``second`` one's, and by
    how much it is above its limits (``excess``, 0 where it keeps them), NaN where it was not run; ``failed``: which
    runs have no numbers."""

    value: Float[np.ndarray, "combinations cases"]
    second: Float[np.ndarray, "combinations cases"]
    excess: Float[np.ndarray, "combinations cases"]
    failed: Bool[np.ndarray, "combinations cases"]

    @property
    def known(self) -> Bool[np.ndarray, "combinations cases"]:
        """Return which runs are done."""
        return ~np.isnan(self.excess)


class RunTally(NamedTuple):
    """How many combinations and runs an enumeration has had.

    ``combinations``; ``priced_out``: above a limit on price or mass, and never run; ``unfit``: their parts or a
    scenario do not go together; ``failed``: a run had no numbers; ``infeasible``: dropped for a limit or for how a run
    ended; ``beaten``;
    ``complete``: run at every load case within all limits; ``runs`` of ``possible`` ones.
    """

    combinations: int
    priced_out: int
    unfit: int
    failed: int
    infeasible: int
    beaten: int
    complete: int
    runs: int
    possible: int

    @property
    def spared(self) -> int:
        """Return how many runs were not needed."""
        return self.possible - self.runs


class Enumeration:
    """The search among combinations for the best few.

    **Arguments:** ``runs``; ``objective``: of the problem's quantities, None where ``constant`` decides alone;
    ``constant``: what price and mass add to it (combinations,); ``allowed``: which keep the limits on these;
    ``ranking``: how many of the best are told apart; ``first``: combinations that are run at every case in any event;
    ``progress``: called with the runs done or spared so far and all there are; ``second``: a second objective, or None.
    """

    def __init__(
        self,
        runs: Runs,
        objective: Objective | None,
        constant: Float[np.ndarray, " combinations"],
        allowed: Bool[np.ndarray, " combinations"],
        ranking: int,
        first: Sequence[int] = (),
        progress: Callable[[int, int], None] | None = None,
        second: Second | None = None,
    ) -> None:
        problem = runs.problem
        self.second = second
        if second is not None and second.objective is not None:
            self.second = second._replace(objective=second.objective.of(problem.main_quantity))
        self.goal, self.allowed = Goal(problem, objective or problem.objective), allowed
        self.runs, self.constant, self.ranking = runs, constant, ranking
        self.objective = None if objective is None else self.goal.objective
        self.cases = len(problem.cases)
        shape = len(allowed), self.cases
        self.judged = Judged(
            value=np.full(shape, np.nan),
            second=np.full(shape, np.nan),
            excess=np.full(shape, np.nan),
            failed=np.zeros(shape, bool),
        )
        self.lower = self.constant + self._least(self.judged.value)
        self.open, self.first, self.progress = allowed.copy(), list(first), progress
        self.order = np.arange(self.cases)

    def run(self) -> None:
        """Decide all combinations."""
        # Those asked for come first, and some that are spread over all.
        allowed = np.flatnonzero(self.allowed)
        spread = [int(allowed[place]) for place in spread_evenly(len(allowed), PILOTS)]
        self._complete(list(dict.fromkeys([*self.first, *spread])))
        self.order = self._hardest_first()
        while chosen := self._most_promising():
            # The best few of those that were run are completed at once: what they reach drops others.
            self._complete([k for k in chosen if np.any(self.judged.known[k])][: self.ranking])
            self._advance([(number, self._next(number)) for number in chosen if self.open[number]])
        # None keeps the limits: those told as nearest need numbers at every load case, not only where they were lost.
        if not len(self.best()):
            self._complete(self.nearest())

    def best(self) -> Int[np.ndarray, " ranked"]:
        """Return the best feasible combinations, the best one first; of equal ones in the order of the catalogues."""
        complete = np.flatnonzero(self.feasible)
        values = self.values[complete]
        seconds = values if self.second is None else self.seconds[complete]
        return np.asarray(complete[order(values, seconds, self.ceiling)][: self.ranking])

    def least(self) -> Int[np.ndarray, " ranked"]:
        """Return the feasible combinations with the least objective, whatever the second one says, the least first."""
        complete = np.flatnonzero(self.feasible)
        return np.asarray(complete[np.argsort(self.values[complete], kind="stable")][: self.ranking])

    def nearest(self) -> Int[np.ndarray, " ranked"]:
        """Return combinations that were seen least far above their limits, where they were run."""
        known = np.flatnonzero(self.allowed & np.any(self.judged.known, axis=1))
        return np.asarray(known[np.argsort(self._farthest[known], kind="stable")][: self.ranking])

    @property
    def feasible(self) -> Bool[np.ndarray, " combinations"]:
        """Return which were run at every load case and keep all limits."""
        # The NaN of a case that was not run equals nothing, so only combinations with all their runs count.
        return np.all(self.judged.excess == 0.0, axis=1) & self.allowed

    @property
    def values(self) -> Float[np.ndarray, " combinations"]:
        """Return the objective of each combination that was run at every load case; NaN of others."""
        value = self.constant + (0.0 if self.objective is None else self._aggregated(self.judged.value))
        return np.where(np.all(self.judged.known, axis=1), value, np.nan)

    @property
    def seconds(self) -> Float[np.ndarray, " combinations"]:
        """Return the second objective of each combination that was run at every load case; NaN of others."""
        assert self.second is not None
        of_runs, constant = self.second.objective, self.second.constant
        value = constant + (0.0 if of_runs is None else self._aggregated(self.judged.second, of_runs))
        return np.where(np.all(self.judged.known, axis=1), value, np.nan)

    def tally(self, verdicts: Mapping[int, bool]) -> RunTally:
        """Return how many combinations were decided in which way, each in one.

        ``verdicts``: whether combinations keep all limits, of those run again at a smaller tolerance. These count: a
        value on its limit is on either side of it at another tolerance.
        """
        again = np.isin(np.arange(len(self.allowed)), list(verdicts))
        keeps = np.array([verdicts.get(k, False) for k in range(len(self.allowed))], bool)
        unfit = np.isin(np.arange(len(self.allowed)), list(self.runs.misfits)) & self.allowed
        failed = np.any(self.judged.failed, axis=1) & self.allowed & ~unfit & ~again
        # Each combination is counted in the first of these ways that is its own.
        left = self.allowed & ~unfit & ~failed
        complete = np.where(again, keeps, self.feasible) & left
        broken = np.where(again, ~keeps, self._farthest > 0.0) & left
        return RunTally(
            combinations=len(self.allowed),
            priced_out=int(np.sum(~self.allowed)),
            unfit=int(np.sum(unfit)),
            failed=int(np.sum(failed)),
            infeasible=int(np.sum(broken)),
            beaten=int(np.sum(left & ~broken & ~complete)),
            complete=int(np.sum(complete)),
            runs=int(np.sum(self.judged.known[~unfit])),
            possible=self.judged.excess.size,
        )

    @property
    def ceiling(self) -> float:
        """Return the objective up to which the second one decides; without any feasible combination there is none."""
        least = self.values[self.least()]
        return np.inf if self.second is None or not len(least) else self.second.ceiling(float(least[0]))

    def beaten(self, values: Float[np.ndarray, "..."]) -> Bool[np.ndarray, "..."]:
        """Return which values of the objective are too high for the ranking."""
        least = self.values[self.least()]
        if len(least) < self.ranking:
            return np.zeros(values.shape, bool)
        above = values > least[-1]
        return above if self.second is None else above & ~within(values, self.ceiling)

    @property
    def _farthest(self) -> Float[np.ndarray, " combinations"]:
        # A case that was not run proves nothing against a combination.
        return np.max(np.nan_to_num(self.judged.excess, nan=0.0), axis=1)

    def _most_promising(self) -> list[int]:
        """Return the open combinations whose objective so far is the lowest; of those that were never run it is 0."""
        waiting = np.flatnonzero(self.open)
        count = max(BATCH, len(waiting) // 4)
        return [int(k) for k in waiting[np.argsort(self.lower[waiting], kind="stable")][:count]]

    def _next(self, number: int) -> int:
        """Return the hardest load case at which a combination was not run."""
        return next(int(case) for case in self.order if not self.judged.known[number, case])

    def _complete(self, numbers: Iterable[int]) -> None:
        """Run combinations at every load case that they were not run at."""
        missing = [(int(k), int(c)) for k in numbers for c in np.flatnonzero(~self.judged.known[k])]
        self._advance(missing)

    def _advance(self, wanted: Sequence[tuple[int, int]]) -> None:
        """Run combinations at load cases and drop what that decides."""
        if wanted:
            problem = self.runs.problem
            cases = [problem.cases[case] for _, case in wanted]
            evaluation = gather(problem, problem.start(), cases, self.runs.each(wanted, done=self._report))
            places = tuple(np.array(wanted).T)
            self.judged.excess[places] = self.goal.excess_by_case(evaluation)
            self.judged.value[places] = evaluation.quantities @ self.goal.weights
            if self.second is not None and self.second.objective is not None:
                self.judged.second[places] = evaluation.quantities @ self.second.objective.vector(
                    self.goal.problem.names
                )
            self.judged.failed[places] = ~evaluation.solved
        least = 0.0 if self.objective is None else self._least(self.judged.value)
        self.lower = self.constant + least
        broken, complete = self._farthest > 0.0, np.all(self.judged.known, axis=1)
        # One that may still equal the last one ranked stays open: among equals the order of the catalogues decides.
        self.open &= ~broken & ~complete & ~self.beaten(self.lower)
        self._report(0)

    def _report(self, done: int) -> None:
        """Say how far it is; ``done``: runs beside those that were judged."""
        if self.progress is not None:
            known = self.judged.known
            self.progress(int(np.sum(known)) + done + int(np.sum(~known[~self.open])), known.size)

    def _least(self, values: Float[np.ndarray, "combinations cases"]) -> Float[np.ndarray, " combinations"]:
        """Return what the objective cannot be below, whatever the load cases say that were not run."""
        if self.objective is None:
            return np.zeros(len(values))
        problem = self.runs.problem
        own = set(self.objective.weights) & set(problem.quantities)
        if own or any(problem.catalogue[name].signed for name in self.objective.weights):
            known = np.where(np.isnan(values), -np.inf, values)
            # Of a number that may be negative the worst case so far bounds the worst of all, and no mean.
            whole = np.all(np.isfinite(known), axis=1)
            worst = np.max(known, axis=1)
            return worst if self.objective.over == "worst" else np.where(whole, self._aggregated(known), -np.inf)
        # None of these quantities can be negative, so a case that was not run counts as 0 at least.
        return self._aggregated(np.nan_to_num(values, nan=0.0))

    def _aggregated(
        self, values: Float[np.ndarray, "combinations cases"], objective: Objective | None = None
    ) -> Float[np.ndarray, " combinations"]:
        """Return an ``objective``, by default the first one, of each combination from its values at all load cases."""
        objective = objective or self.goal.objective
        # The weights depend on the order of the values alone.
        weights = objective.case_weights(-np.arange(float(self.cases)))
        # A weight of zero times the infinity that stands for a missing run would be NaN.
        used = weights > 0.0
        return np.asarray(-np.sort(-values, axis=1)[:, used] @ weights[used])

    def _hardest_first(self) -> Int[np.ndarray, " cases"]:
        """Return the load cases in an order in which each drops most of the pilots that those before have left."""
        ran = np.all(self.judged.known, axis=1)
        value, excess = self.judged.value[ran], self.judged.excess[ran]
        beaten = self.beaten(value + self.constant[ran, None])
        if self.objective is None or self.objective.over != "worst":
            # In a mean, be it of the worst share, no single case shows that a combination is beaten.
            beaten[:] = False
        drops = beaten | (excess > 0.0)
        # Among cases that drop as many, the one with the largest objective on the whole.
        size = np.sum(np.nan_to_num(value / np.maximum(np.max(value, axis=1, keepdims=True), 1e-300)), axis=0)
        left, waiting, order = np.ones(len(drops), bool), list(range(self.cases)), list[int]()
        while waiting:
            hardest = max(waiting, key=lambda case: (int(np.sum(drops[left, case])), size[case]))
            order.append(hardest)
            waiting.remove(hardest)
            left &= ~drops[:, hardest]
        return np.array(order)


def spread_evenly(count: int, several: int) -> list[int]:
    """Return at most ``several`` numbers below ``count``, spread evenly: the same ones each time."""
    # Steps of the golden ratio fill an interval evenly, however many are taken.
    return list(dict.fromkeys(int(count * (k * 0.6180339887498949 % 1.0)) for k in range(several if count else 0)))
