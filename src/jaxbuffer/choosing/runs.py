"""Runs of combinations at load cases: solved in chunks on all cores or by an executor, each once, kept in a store."""

import functools
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..cluster.pool import Pool
from ..errors import InputError
from ..hybrid import Solver, solver_named
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.outcome import RunOutcome
from ..mechanisms.registry import mechanism_of
from ..programs.cache import Static
from ..sweeps.chunk import CHUNK, SweepSettings, solve_chunk, task_size
from ..sweeps.grid import Batch
from ..tuning.problem.problem import Problem
from ..tuning.search.measurement import Measurement
from .combinations import Combinations, stacked
from .store import ChoiceStore, Columns, Row

STABILISATION = 20.0  # 1/s, as of `simulate`
PERIOD = 1.0  # s between the moments at which finished runs are stored


def _solved(names: tuple[str, ...], settings: SweepSettings, batch: Batch) -> tuple[np.ndarray, Columns]:
    """Run some combinations and return their places with these quantities."""
    mechanism, made = mechanism_of(batch.design), []
    options = settings.rtol, settings.stabilisation, settings.solver, Static(names)
    for first in range(0, batch.places.size, CHUNK):
        chunk, enabled = batch.chunk(first, CHUNK)
        code, *values, _, impacts, _ = solve_chunk(mechanism, chunk, enabled, *options)
        made.append([np.asarray(it)[enabled] for it in (code, impacts, np.stack(values, axis=1))])
    code, impacts, numbers = (np.concatenate(it) for it in zip(*made, strict=True))
    return batch.places, Columns(code.astype(np.int64), impacts.astype(np.int64), numbers.astype(float))


class Runs:
    """The runs of combinations at a problem's load cases.

    **Arguments:** ``problem``: its cases and what is measured; ``combinations``; ``pool``: where runs are computed;
    ``store``: of the runs that are done, or None; ``solver``: as for `simulate`. ``misfits``: why the parts of a
    combination do not go together, by its number; ``computed``: how many runs were made here.
    """

    def __init__(
        self,
        problem: Problem,
        combinations: Combinations,
        pool: Pool,
        store: ChoiceStore | None = None,
        solver: Solver | str | None = None,
    ) -> None:
        self.problem, self.combinations, self.pool, self.store = problem, combinations, pool, store
        self.computed, self.misfits = 0, dict[int, str]()
        margin = problem.mechanism.tuning.margin
        # The margin is read even where nothing limits it: by it a run is judged that does not end as it must.
        self.names = tuple(dict.fromkeys([*problem.measured, *([] if margin is None else [margin])]))
        self._solver = solver_named(solver)

    def each(
        self, wanted: Sequence[tuple[int, int]], rtol: float | None = None, done: Callable[[int], None] | None = None
    ) -> list[Measurement]:
        """Return the measurement of each pair of a combination's number and a load case's place, in this order.

        Those whose parts or scenario do not fit are not run. ``rtol`` [-]: by default the problem's; ``done``: called
        with how many there are so far.
        """
        problem, cases = self.problem, self.problem.cases
        rtol, made = problem.rtol if rtol is None else rtol, dict[int, Measurement]()
        pairs, missing = list[Any](), list[int]()
        for place, key in enumerate(wanted):
            pairs.append(pair := self.combinations.pair(key[0], cases[key[1]]))
            if isinstance(pair, InputError):
                self.misfits.setdefault(key[0], str(pair))
                made[place] = Measurement.lost(problem)
            elif self.store is not None and (row := self.store.row(key, rtol)) is not None:
                made[place] = self._measurement(pair, *row)
            else:
                missing.append(place)
        for places, rows in self._computed([wanted[k] for k in missing], [pairs[k] for k in missing], rtol):
            for place, row in zip(places, rows, strict=True):
                made[missing[place]] = self._measurement(pairs[missing[place]], *row)
            if done is not None:
                done(len(made))
        return [made[place] for place in range(len(wanted))]

    def _computed(
        self, keys: list[tuple[int, int]], pairs: list[Any], rtol: float
    ) -> Iterator[tuple[list[int], list[Row]]]:
        """Compute runs and yield the places and rows of some of them, whichever are done first."""
        settings = SweepSettings(np.asarray(rtol), np.asarray(STABILISATION), self._solver)
        one, due = functools.partial(_solved, self.names, settings), time.monotonic() + PERIOD
        try:
            for places, columns in self.pool.completed(one, self._calls(pairs)) if pairs else ():
                rows = list(zip(columns.code.tolist(), columns.impacts.tolist(), columns.values, strict=True))
                self.computed += len(rows)
                if self.store is not None:
                    self.store.add([keys[place] for place in places], rtol, columns)
                    if time.monotonic() >= due:
                        self.store.save()
                        due = time.monotonic() + PERIOD
                yield places.tolist(), rows
        finally:
            # After an error or an interrupt too, so that runs that are done need not be computed again.
            if self.store is not None:
                self.store.save()

    def _calls(self, pairs: list[Any]) -> Iterator[Batch]:
        """Yield the runs that are solved in one call each."""
        workers = self.pool.workers
        # As in a sweep: a call in another process takes milliseconds to hand out, in this one next to nothing.
        most = task_size(len(pairs), workers) if self.pool.given else CHUNK
        for places, (design, scenarios) in stacked(pairs):
            duration = np.full(len(places), float(self.problem.duration or 0.0))
            # Few runs are shared out among all workers, of whom some would otherwise be idle.
            yield from Batch(places, design, scenarios, duration).parts(max(1, min(most, -(-len(places) // workers))))

    def _measurement(self, pair: Any, code: int, impacts: int, values: np.ndarray) -> Measurement:
        """Return a run's numbers as a search has them, without derivatives."""
        problem, numbers = self.problem, dict(zip(self.names, values.tolist(), strict=True))
        ending = Ended(problem.mechanism, problem.mechanism.outcomes(code), pair[0])
        return Measurement.of_numbers(problem, ending, impacts, numbers)


class Ended(NamedTuple):
    """How a run of a design has ended."""

    mechanism: Mechanism
    outcome: RunOutcome
    design: Any
