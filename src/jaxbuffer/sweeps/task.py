"""What a worker of a cluster does for a sweep: solve a block, and store it."""

import functools
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..hybrid import solver_named
from .chunk import CHUNK, Settings, columns_of_chunk, runs
from .columns import tally
from .cut import Block, GridSweep, RunsSweep, Template
from .zarr_store import Store


class Job(NamedTuple):
    """What all tasks of a sweep share, small enough to go with each of them.

    ``grid``: whether the blocks are those of a `GridSweep`, or of a `RunsSweep`; ``solver``: its name; ``rtol`` [-],
    ``stabilisation`` [1/s]; ``trust`` as in `Settings`.
    """

    store: str
    token: str
    columns: tuple[str, ...]
    grid: bool
    template: Template
    rtol: float
    stabilisation: float
    solver: str | None
    trust: bool


class Told(NamedTuple):
    """What a worker says of a block. ``computed``: False if it was there already; ``outcomes``: how many runs ended
    with each code; ``verdicts``: how many have each verdict of `jb.trust`; ``solving``, ``storing``: how long that took
    [s]."""

    number: int
    runs: int
    computed: bool
    outcomes: dict[int, int]
    verdicts: dict[int, int]
    solving: float
    storing: float


def solve_block(job: Job, block: Block) -> Told:
    """Solve and store a block, unless the store has it whole already."""
    store = _store(job.store, job.token, job.columns)
    settings = _settings(job.rtol, job.stabilisation, job.solver, job.trust)
    store.check()
    found, begin = store.read(block), time.perf_counter()
    computed = found is None
    if found is None:
        found = solved(job.template, settings, job.grid, block)
    between = time.perf_counter()
    if computed:
        store.write(block, found)
    columns, ended = dict(zip(job.columns, found, strict=True)), time.perf_counter()
    outcomes, verdicts = (tally(columns[name]) for name in ("code", "trust"))
    return Told(block.number, found[0].size, computed, outcomes, verdicts, between - begin, ended - between)


def solved(template: Template, settings: Settings, grid: bool, block: Block) -> list[np.ndarray]:
    """A block's columns, (runs,) each."""
    batch, duration = (GridSweep if grid else RunsSweep).batch(template, block)
    mine = runs(batch, duration, CHUNK, 1, filled=True)
    parts = []
    for first in range(0, mine.places.size, CHUNK):
        wanted = slice(min(CHUNK, mine.places.size - first))
        parts.append([values[wanted] for values in columns_of_chunk(*mine.call(first), settings)])
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


@functools.lru_cache(maxsize=8)
def _store(path: str, token: str, columns: tuple[str, ...]) -> Store:
    return Store(Path(path), token, columns)


@functools.lru_cache(maxsize=8)
def _settings(rtol: float, stabilisation: float, solver: str | None, trust: bool) -> Settings:
    named = None if solver is None else solver_named(solver)
    return Settings(np.asarray(rtol), np.asarray(stabilisation), named, trust)
