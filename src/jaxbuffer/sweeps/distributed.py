"""A sweep over a cluster: blocks as tasks, whose workers store what they compute; no numbers pass through here."""

import time
from collections import Counter
from collections.abc import Callable, Generator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..cluster.connect import connected, require
from ..cluster.spread import spread
from ..cluster.workers import Workers
from ..errors import InputError
from ..files import Lock
from .chunk import CHUNK, Settings, columns_of_chunk, runs
from .columns import tally
from .cut import Block, GridSweep, RunsSweep, Template
from .executor import Where
from .store import STORE, Store, begun, check_resumable, resumed
from .stored import StoredInterrupted, StoredSweep

TASK = 512  # runs of a task at most on few threads: about a second
PER_THREAD = 8  # tasks a thread at least there, so that none waits long for the last
BUSY = 2  # runs of a task for each thread at least, so that one scheduler can hand out so many (docs/clusters.md)


class Job(NamedTuple):
    """What all tasks of a sweep share, small enough to go with each of them; ``grid``: whether the blocks are those of
    a `GridSweep`, or of a `RunsSweep`."""

    store: Store
    grid: bool
    template: Template
    settings: Settings


class Report(NamedTuple):
    """A worker's report on a block. ``computed``: False if it was there already; ``outcomes``: how many runs ended with
    each code; ``verdicts``: how many have each verdict of `jb.trust`; ``solving``, ``storing``: how long that took
    [s]."""

    number: int
    runs: int
    computed: bool
    outcomes: dict[int, int]
    verdicts: dict[int, int]
    solving: float
    storing: float


def solve_block(job: Job, block: Block) -> Report:
    """Solve and store a block, unless the store has it whole already."""
    job.store.check()
    columns, begin = job.store.read_done(block), time.perf_counter()
    computed = columns is None
    if columns is None:
        columns = solved(job, block)
    between = time.perf_counter()
    if computed:
        job.store.write(block, columns)
    by_name, ended = dict(zip(job.store.types, columns, strict=True)), time.perf_counter()
    outcomes, verdicts = (tally(by_name[name]) for name in ("code", "trust"))
    return Report(block.number, columns[0].size, computed, outcomes, verdicts, between - begin, ended - between)


def solved(job: Job, block: Block) -> list[np.ndarray]:
    """A block's columns, (runs,) each."""
    batch, duration = (GridSweep if job.grid else RunsSweep).batch(job.template, block)
    own = runs(batch, duration, CHUNK, 1, filled=True)
    parts = []
    for first in range(0, own.places.size, CHUNK):
        room = slice(min(CHUNK, own.places.size - first))
        parts.append([values[room] for values in columns_of_chunk(*own.call(first), job.settings)])
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


def run(cut: Callable[[int], GridSweep | RunsSweep], count: int, settings: Settings, where: Where) -> StoredSweep:
    """Solve all runs, or those that the store lacks; ``cut``: the sweep of ``count`` runs in blocks of at most so
    many."""
    require()
    if where.folder is None:
        raise InputError("a sweep over a scheduler needs a folder, where its workers store what they find")
    path = Path(where.folder).absolute() / STORE
    if where.resume:
        check_resumable(path)
    lock = Lock(path.parent)
    try:
        with connected(where.executor, where.workers) as client:
            if where.resume:
                sweep = cut(CHUNK)
                store, made_on = resumed(path, sweep, settings)
                workers = Workers(client, made_on)
            else:
                workers = Workers(client)
                sweep = cut(task_size(count, max(1, workers.threads)))
                store = begun(path, sweep, settings, workers.kind)
            job = Job(store, isinstance(sweep, GridSweep), sweep.template, settings)
            return _solved(spread(client, workers, solve_block, job, sweep.blocks()), sweep, count, path, where)
    finally:
        lock.release()


def task_size(runs: int, threads: int) -> int:
    """How many runs a task, or a block of the store, has at most."""
    return max(CHUNK, min(TASK, runs // (PER_THREAD * threads)), min(BUSY * threads, runs // threads))


def _solved(
    reports: Generator[Report, None, None], sweep: GridSweep | RunsSweep, count: int, store: Path, where: Where
) -> StoredSweep:
    """Wait for all blocks."""
    outcomes, verdicts, done = Counter[int](), Counter[int](), 0

    def so_far() -> StoredSweep:
        return StoredSweep(store, sweep, count, done, dict(outcomes), dict(verdicts))

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
        there = f"{done} of {count} {name}s are known to be in {store}; resuming goes on with them"
        if error.errno is None:
            raise ConnectionError(f"{error}; {there}") from None
        raise OSError(error.errno, f"{error.strerror}; {there}", error.filename) from None
    finally:
        reports.close()  # tasks under way are cancelled now, while there is a client, not whenever memory is collected
    return so_far()
