"""`sweep`: many runs, on all cores, in memory that does not grow with what a run remembers.

Runs are solved in small chunks, one after the other within a chunk so that none waits for the slowest, and chunks are
handed to one thread a core: a compiled chunk runs outside Python.
"""

import contextlib
import functools
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, TypedDict, Unpack, overload

import jax
import numpy as np

from .._types import Scalar
from ..cluster.extra import require
from ..errors import InputError, check_flag, check_number, check_single, check_whole
from ..fields import POSITIVE, Part
from ..files import Lock, user_path
from ..hybrid import Solver, solver_named
from ..mechanisms.registry import mechanism_of
from ..programs.process import check_ready, kind
from ..programs.threads import cores
from ..progress import counted
from ..run.request import DEFAULT_TOLERANCE, TOLERANCES, check_pair
from .chunk import CHUNK, SweepSettings, columns_of_chunk, runs, task_size
from .columns import empty_columns
from .cut import BlockSweep, GridSweep, RunsSweep, Template
from .executor import Where, check_executor, completed
from .grid import Batch, grid
from .result import Sweep, SweepInterrupted
from .store import STORE, Saver, begun, check_resumable, fill, identity, resumed
from .stored import StoredSweep

Cutter = Callable[[int], BlockSweep]  # a sweep in blocks of at most so many runs
ONE_FOR_ALL = "all runs of a sweep share it"


class SweepOptions(TypedDict, total=False):
    """The keywords of `sweep` but the client."""

    over: Mapping[str, Any] | None
    executor: Executor | None
    solver: Solver | str | None
    rtol: float
    stabilisation: float
    trust: bool
    workers: int | None
    progress: Callable[[int, int], None] | bool | None
    folder: str | Path | None
    resume: bool
    save: bool


@overload
def sweep(
    design: Part,
    scenarios: Part,
    duration: Scalar | None = None,
    *,
    client: None = None,
    **options: Unpack[SweepOptions],
) -> Sweep: ...


@overload
def sweep(
    design: Part, scenarios: Part, duration: Scalar | None = None, *, client: Any, **options: Unpack[SweepOptions]
) -> StoredSweep: ...


def sweep(
    design: Part,
    scenarios: Part,
    duration: Scalar | None = None,
    *,
    over: Mapping[str, Any] | None = None,
    executor: Executor | None = None,
    client: Any = None,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    stabilisation: float = 20.0,
    trust: bool = False,
    workers: int | None = None,
    progress: Callable[[int, int], None] | bool | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
    save: bool = True,
) -> Sweep | StoredSweep:
    """Simulate many runs of a mechanism.

    **Arguments:**

    - ``design``, ``scenarios``: any of their numbers may be an array of shape (n,), one entry a run.
    - ``duration``: as for `simulate`, or an array of shape (n,) [s].
    - ``over``: values of several fields, all combinations of which are run: by dotted path, "scenario.…" for the
      scenario's, a list of numbers in the field's unit, {"from", "to", "count", "scale"}, or a list of choices.
      ``design`` and ``scenarios`` then have single numbers.
    - ``executor``: where the runs are computed in place of threads of this process: any executor of
      `concurrent.futures`, such as one of processes that are spawned, or a Dask client's ``get_executor()``. Its
      processes must find the same bits; it stays open. ``workers`` says how many calls it runs at a time.
    - ``client``: a `distributed.Client`, the address of Dask's scheduler, "local" (threads) or "processes" on this
      machine: the sweep goes to its workers, which store it in ``folder`` (docs/clusters.md).
    - ``solver``, ``rtol`` [-], ``stabilisation`` [1/s]: as for `simulate`, for all runs.
    - ``trust``: whether to run each again at a tenth of the tolerance, which says how far its numbers can be trusted
      (`Sweep.verdicts`, as of `jb.trust`); takes about twice as long.
    - ``workers``: threads, by default one a core (one on an accelerator, which gets large chunks).
    - ``progress``: called with runs done and asked for, or True for a bar.
    - ``folder``: where runs are stored as they are finished (``sweep.zarr``), over an earlier sweep's, and at the end
      the result, which `load` and `report` read, without figures (``result.save(folder, force=True)`` draws them).
    - ``resume``: go on with the sweep in ``folder`` instead.
    - ``save``: whether the result is written into ``folder``.

    **Returns:** a `Sweep`, with ``client`` a `StoredSweep`; the same bits whether it was
    interrupted and resumed or not. A run that fails says so in its ``code``; the others are not touched by it. Each
    combination of choices is a program of its own, compiled once.

    **Raises:** `InputError` for values out of range, arrays of unequal lengths, a folder in use, and on resuming
    another sweep; `SweepInterrupted`, a `KeyboardInterrupt` that has what was done, on Ctrl-C (`StoredInterrupted` with
    ``client``).

    **Example:**

    >>> found = jb.sweep(jb.table2(), jb.Scenario(approach_speed=[0.1, 0.2]))
    >>> [f"{force:.2f} N" for force in found.peak_force]
    ['253.13 N', '325.18 N']
    >>> bar = jb.replace(jb.BarDrop(), {"impact.exponent": 1.5})
    >>> over = {"scenario.height": [0.1, 0.194], "impact.law": ["adams", "hertz"]}
    >>> forces = jb.sweep(bar, jb.BarDropScenario(), 0.22, over=over).to_xarray().peak_force
    >>> f"{float(forces.sel({'scenario.height': 0.1, 'impact.law': 'hertz'})):.1f} {forces.units}"
    '3894.2 N'
    """
    mechanism = mechanism_of(design)
    check_pair(mechanism, design, scenarios)
    varied = over if isinstance(over, Mapping) else ()  # `grid` says what is wrong with others
    duration = mechanism.duration(design, varied) if duration is None else duration
    check_number("duration", duration, "s", **POSITIVE)
    check_single("rtol", rtol, "-", ONE_FOR_ALL, **TOLERANCES)
    check_single("stabilisation", stabilisation, "1/s", ONE_FOR_ALL, low=0.0)
    solver = None if solver is None else solver_named(solver)
    if workers is not None:
        check_whole("workers", workers, 1)
    check_flag("trust", trust)
    check_flag("save", save)
    if executor is not None:
        check_executor(executor)
        if client is not None:
            raise InputError("executor and client contradict; keep one")
    settings = SweepSettings(np.asarray(rtol, float), np.asarray(stabilisation, float), solver, trust)
    where = Where(
        executor if client is None else client, workers, counted(progress, mechanism.view.run_name), folder, resume
    )
    if over is None:
        count = runs(Batch(None, design, scenarios), duration, 1, 1, filled=True).places.size
        axes = None
        cut: Cutter = functools.partial(RunsSweep, design, scenarios, duration, count)
    else:
        check_single("duration", duration, "s", ONE_FOR_ALL)
        axes = grid(over, design, scenarios, in_memory=client is None)
        count = len(axes)
        cut = functools.partial(GridSweep, axes, Template(design, scenarios, duration))
    if client is not None:
        require()
        from .distributed import run as run_distributed  # imports Dask, an optional package

        return run_distributed(cut, count, settings, where)
    # The identity says nothing of the blocks, so that any size gives the same.
    result = Sweep(mechanism, {}, design, scenarios, axes, identity(settings, cut(CHUNK)))  # type: ignore[arg-type]
    _run(result, cut, duration, settings, where)
    if save and folder is not None:
        result.save(folder, force=True, figures=False)
    return result


def _run(result: Sweep, cut: Cutter, duration: Any, settings: SweepSettings, where: Where) -> Sweep:
    """Fill a sweep's columns with all its runs, but those that its folder has if it is resumed."""
    check_ready()
    design, scenarios, over = result.design, result.scenarios, result.grid
    batches = [Batch(None, design, scenarios)] if over is None else over.batches(design, scenarios)
    on_cpu = jax.default_backend() == "cpu"
    # An accelerator gets one large call at a time: it works on the runs of a call in parallel.
    most, workers = (CHUNK, cores()) if on_cpu else (4096, 1)
    workers = workers if where.workers is None else where.workers
    parts = [runs(batch, duration, most, workers, on_cpu) for batch in batches]
    count = sum(part.places.size for part in parts)
    result.columns.update(empty_columns(result.mechanism, count))
    finished = np.zeros(count, bool)
    columns = list(result.columns.values())
    progress = where.progress
    # A generator: it looks at `finished` when a call is handed out, after `_saver` has filled in what was stored.
    calls = (
        (part.places[first : first + part.chunk], part.call(first))
        for part in parts
        for first in range(0, part.places.size, part.chunk)
        if not finished[part.places[first : first + part.chunk]].all()
    )
    saver = None
    if where.folder is not None:
        sweep = cut(task_size(count, workers))
        saver = _saver(user_path(where.folder) / STORE, sweep, settings, where.resume, result.columns, finished)
    elif where.resume:
        raise InputError("resume needs the folder of the sweep to go on with")
    try:
        if progress is not None and finished.any():
            progress(int(finished.sum()), count)
        for places, values in completed(functools.partial(_solved, settings), calls, workers, where.executor):
            for column, those in zip(columns, values, strict=True):
                column[places] = those[: places.size]
            finished[places] = True
            if saver is not None:
                saver.save()
            if progress is not None:
                progress(int(finished.sum()), count)
    except KeyboardInterrupt:
        # it may have come between two columns of a call
        raise SweepInterrupted(result.only(finished), finished) from None
    finally:
        if saver is not None:
            saver.close()
    return result


def _solved(
    settings: SweepSettings, call: tuple[np.ndarray, tuple[Any, np.ndarray]]
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the places of a call's runs, and their columns."""
    places, chunk = call
    return places, columns_of_chunk(*chunk, settings)


def _saver(
    path: Path,
    sweep: BlockSweep,
    settings: SweepSettings,
    resume: bool,
    columns: dict[str, np.ndarray],
    finished: np.ndarray,
) -> Saver:
    """Begin a store, or with ``resume`` fill in what an earlier sweep finished."""
    if resume:
        check_resumable(path)
    with contextlib.ExitStack() as locked:
        lock = locked.enter_context(Lock(path.parent))
        store = resumed(path, sweep, settings)[0] if resume else begun(path, sweep, settings, kind())
        if resume:
            fill(store, sweep, columns)
            finished[:] = columns["code"] >= 0
        # Keep the lock beyond this block; an error before here releases it.
        locked.pop_all()  # until the sweep is stored
    return Saver(store, sweep, columns, finished, lock)
