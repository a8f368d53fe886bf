"""A sweep over a cluster: blocks as tasks, whose workers store what they compute; no numbers pass through here."""

import time
from collections import Counter
from collections.abc import Callable, Generator
from typing import NamedTuple

import numpy as np

from ..cluster.connect import connected
from ..cluster.spread import spread
from ..cluster.workers import Workers
from ..errors import InputError
from ..files import Lock, user_path
from .chunk import CHUNK, SweepSettings, columns_of_chunk, runs, task_size
from .columns import tally
from .cut import Block, BlockSweep, GridSweep, RunsSweep, Template
from .executor import Where
from .store import STORE, SweepStore, begun, check_resumable, resumed
from .stored import StoredInterrupted, StoredSweep


class Job(NamedTuple):
    """What all tasks of a sweep share, small enough to go with each of them; ``grid``: whether the blocks are those of
    a `GridSweep`, or of a `RunsSweep`."""

    store: SweepStore
    grid: bool
    template: Template
    settings: SweepSettings


class Report(NamedTuple):
    """A worker's report on a block: how many ``runs`` it has, how many of them ended with each code (``outcomes``) and
    have each verdict of `jb.trust` (``verdicts``); ``solving``: how long that took [s], 0 if it was stored already."""

    runs: int
    outcomes: dict[int, int]
    verdicts: dict[int, int]
    solving: float


def solve_block(job: Job, block: Block) -> Report:
    """Solve and store a block, unless the store has all of it."""
    job.store.check()
    columns, solving = job.store.read_columns(block), 0.0
    if columns is None:
        begin = time.perf_counter()
        columns = solved(job, block)
        solving = time.perf_counter() - begin
        job.store.write_columns(block, columns)
    by_name = dict(zip(job.store.types, columns, strict=True))
    outcomes, verdicts = (tally(by_name[name]) for name in ("code", "trust"))
    return Report(columns[0].size, outcomes, verdicts, solving)


def solved(job: Job, block: Block) -> list[np.ndarray]:
    """Return a block's columns, (runs,) each."""
    batch, duration = (GridSweep if job.grid else RunsSweep).batch(job.template, block)
    # Every call has the same shape, so that a worker compiles one program for each combination of choices.
    own = runs(batch, duration, CHUNK, 1, filled=True)
    parts = []
    for first in range(0, own.places.size, CHUNK):
        room = slice(min(CHUNK, own.places.size - first))
        parts.append([values[room] for values in columns_of_chunk(*own.call(first), job.settings)])
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


def run(cut: Callable[[int], BlockSweep], count: int, settings: SweepSettings, where: Where) -> StoredSweep:
    """Solve all runs, or those that the store lacks, on the workers of a cluster.

    - ``cut``: returns the sweep in blocks of at most so many runs.
    - ``count``: how many runs the sweep has.
    - ``settings``: what all runs share; ``where``: the cluster, the folder, and who watches.
    """
    if where.folder is None:
        raise InputError("a sweep over a scheduler needs a folder, where its workers store what they find")
    path = user_path(where.folder).absolute() / STORE
    if where.resume:
        check_resumable(path)
    with Lock(path.parent), connected(where.executor, where.workers) as client:
        if where.resume:
            # `resumed` gives the sweep the blocks of the store; until then any size will do.
            sweep = cut(CHUNK)
            store, made_on = resumed(path, sweep, settings)
            # The store's other blocks were computed by this kind of process: another kind might find other bits.
            workers = Workers(client, made_on)
        else:
            workers = Workers(client)
            sweep = cut(task_size(count, max(1, workers.threads)))
            store = begun(path, sweep, settings, workers.kind)
        job = Job(store, isinstance(sweep, GridSweep), sweep.template, settings)
        return _solved(spread(client, workers, solve_block, job, sweep.blocks()), sweep, count, store, where)


def _solved(
    reports: Generator[Report, None, None], sweep: BlockSweep, count: int, store: SweepStore, where: Where
) -> StoredSweep:
    """Add up the reports of all blocks as they come in, and return the stored sweep."""
    outcomes, verdicts, done = Counter[int](), Counter[int](), 0

    def so_far() -> StoredSweep:
        return StoredSweep(store.path, sweep, count, done, dict(outcomes), dict(verdicts), store.head.token)

    try:
        for report in reports:
            done += report.runs
            outcomes.update(report.outcomes)
            verdicts.update(report.verdicts)
            if where.progress is not None:
                where.progress(done, count)
    except KeyboardInterrupt:
        raise StoredInterrupted(so_far()) from None
    except OSError as error:
        name = sweep.mechanism.view.run_name
        there = f"{done} of {count} {name}s are known to be in {store.path}; resuming goes on with them"
        if error.errno is None:
            raise ConnectionError(f"{error}; {there}") from None
        raise OSError(error.errno, f"{error.strerror}; {there}", error.filename) from None
    finally:
        reports.close()  # tasks under way are cancelled now, while there is a client, not whenever memory is collected
    return so_far()
