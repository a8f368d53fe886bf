"""`sweep`: many runs, on all cores, in memory that does not grow with what a run remembers.

Runs are solved in small chunks, one after the other within a chunk so that none waits for the slowest, and chunks are
handed to one thread a core: a compiled chunk runs outside Python.
"""

import contextlib
import functools
import math
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import jax
import numpy as np

from .._types import Scalar
from ..cluster.pool import Pool
from ..errors import InputError, check_flag, check_number, check_single, check_whole
from ..fields import POSITIVE, Part
from ..files import Lock, user_path
from ..hybrid import Solver, solver_named
from ..mechanisms.registry import mechanism_of
from ..programs.process import check_ready
from ..programs.threads import cores
from ..progress import counted
from ..run.request import DEFAULT_TOLERANCE, TOLERANCES, check_assembly, check_pair
from .chunk import CHUNK, SweepSettings, columns_of_chunk, task_size
from .columns import empty_columns
from .grid import Batch, grid
from .result import Sweep, SweepInterrupted
from .spec import SweepSpec
from .store import RESULT, STORE, Saver, begun, check_resumable, check_vacant, fill, resumed

LARGE = 4096  # runs of a call on an accelerator
ONE_FOR_ALL = "all runs of a sweep share it"


def sweep(
    design: Part,
    scenarios: Part,
    duration: Scalar | None = None,
    *,
    over: Mapping[str, Any] | None = None,
    executor: Executor | None = None,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    stabilisation: float = 20.0,
    trust: bool = False,
    workers: int | None = None,
    progress: Callable[[int, int], None] | bool | None = None,
    folder: str | Path | None = None,
    force: bool = False,
    resume: bool = False,
    save: bool = True,
) -> Sweep:
    """Simulate many runs of a mechanism.

    **Arguments:**

    - ``design``, ``scenarios``: any of their numbers may be an array of shape (n,), one entry a run.
    - ``duration``: as for `simulate`, or an array of shape (n,) [s].
    - ``over``: values of several fields, all combinations of which are run: by dotted path, "scenario.…" for the
      scenario's, a list of numbers in the field's unit, {"from", "to", "count", "scale"}, or a list of choices.
      ``design`` and ``scenarios`` then have single numbers.
    - ``executor``: where the runs are computed in place of threads of this process: any executor of
      `concurrent.futures`, such as one of processes that are spawned, or a Dask client's ``get_executor()``
      (docs/clusters.md). A process that might find other bits computes nothing. The executor stays open.
    - ``solver``, ``rtol`` [-], ``stabilisation`` [1/s]: as for `simulate`, for all runs.
    - ``trust``: whether to run each again at a tenth of the tolerance, which says how far its numbers can be trusted
      (`Sweep.verdicts`, as of `jb.trust`); takes about twice as long.
    - ``workers``: threads, by default one a core (one on an accelerator, which gets large chunks), or how many calls
      the executor runs at a time, by which runs are divided into calls.
    - ``progress``: called with runs done and asked for, or True for a bar.
    - ``folder``: where runs are stored as they are finished (``sweep.zarr``), and at the end the result, which `load`
      and `report` read, without figures (``result.save(folder, force=True)`` draws them).
    - ``force``: whether to replace a sweep that is there, as of `jb.save`.
    - ``resume``: go on with the sweep in ``folder`` instead.
    - ``save``: whether the result is written into ``folder``.

    **Returns:** a `Sweep`; the same bits whether it was interrupted and resumed or not, and wherever its runs were
    computed on one kind of machine. A run that fails says so in its ``code``; the others are not touched by it. Each
    combination of choices is a program of its own, compiled once.

    **Raises:** `InputError` for values out of range, arrays of unequal lengths, a folder in use or with a sweep in it,
    and on resuming another sweep; `SweepInterrupted`, a `KeyboardInterrupt` that has what was done, on Ctrl-C;
    `ConnectionError` where the executor ends before the sweep does.

    **Example:**

    >>> swept = jb.sweep(jb.table2(), jb.Scenario(approach_speed=[0.1, 0.2]))
    >>> [f"{force:.2f} N" for force in swept.peak_force]
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
    solver = solver_named(solver)
    if workers is not None:
        check_whole("workers", workers, 1)
    check_flag("trust", trust)
    check_flag("save", save)
    check_flag("force", force)
    check_ready()
    if resume and folder is None:
        raise InputError("resume needs the folder of the sweep to go on with")
    axes = None
    if over is not None:
        check_single("duration", duration, "s", ONE_FOR_ALL)
        axes = grid(over, design, scenarios)
    if folder is not None and not resume:
        check_vacant(user_path(folder), [STORE, *(RESULT if save else ())], force)
    settings = SweepSettings(np.asarray(rtol, float), np.asarray(stabilisation, float), solver, trust)
    spec = SweepSpec(design, scenarios, duration, axes, settings)
    result = Sweep(mechanism, {}, design, scenarios, axes, spec.identity)  # type: ignore[arg-type]
    # An accelerator works on the runs of one large call in parallel.
    at_once = workers or (cores() if jax.default_backend() == "cpu" else 1)
    with Pool(executor, at_once) as pool:
        _run(result, spec, pool, counted(progress, mechanism.view.run_name), folder, resume)
    if np.all(result.columns["code"] >= int(mechanism.outcomes["failed_steps"])):
        # All have failed, maybe because parts of the first one do not go together.
        first, _ = spec.batches[0].chunk(0, 1)
        check_assembly(mechanism, *jax.tree.map(lambda column: float(column[0]), first[:2]))
    if save and folder is not None:
        result.save(folder, force=True, figures=False)
    return result


def _run(
    result: Sweep,
    spec: SweepSpec,
    pool: Pool,
    progress: Callable[[int, int], None] | None,
    folder: str | Path | None,
    resume: bool,
) -> None:
    """Fill a sweep's columns with all its runs, but those that its folder has if it is resumed."""
    count = math.prod(spec.shape)
    result.columns.update(empty_columns(result.mechanism, count))
    columns, finished, saver = list(result.columns.values()), np.zeros(count, bool), None
    # A generator: it looks at `finished` when a call is handed out, after `_saver` has filled in what was stored.
    calls = (call for call in _calls(spec, pool, count) if not finished[call[0].places].all())
    if folder is not None:
        saver = _saver(user_path(folder) / STORE, spec, pool, resume, result.columns, finished)
    try:
        if progress is not None and finished.any():
            progress(int(finished.sum()), count)
        for places, values in pool.completed(functools.partial(_solved, spec.settings), calls):
            for column, those in zip(columns, values, strict=True):
                column[places] = those
            finished[places] = True
            if saver is not None:
                saver.save()
            if progress is not None:
                progress(int(finished.sum()), count)
    except KeyboardInterrupt:
        # it may have come between two columns of a call
        raise SweepInterrupted(result.only(finished), finished) from None
    except ConnectionError as error:
        done = f"{int(finished.sum())} of {count} {result.mechanism.view.run_name}s"
        raise ConnectionError(f"{error}; {done} are kept" if saver is not None else str(error)) from None
    finally:
        if saver is not None:
            saver.close()


def _calls(spec: SweepSpec, pool: Pool, count: int) -> Iterator[tuple[Batch, int]]:
    """Yield the runs that are solved in one call each, and how many of them a program has room for."""
    on_cpu = jax.default_backend() == "cpu"
    # A call in another process takes milliseconds to hand out, in this one next to nothing.
    most = (task_size(count, pool.workers) if pool.given else CHUNK) if on_cpu else LARGE
    for batch in spec.batches:
        size = min(most, -(-batch.places.size // pool.workers))
        for part in batch.parts(size):
            # On an accelerator, whose calls are large, runs that only fill up a chunk would take memory.
            yield part, CHUNK if on_cpu else size


def _solved(settings: SweepSettings, call: tuple[Batch, int]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the places of a call's runs, and their columns."""
    batch, room = call
    count = batch.places.size
    chunks = [columns_of_chunk(*batch.chunk(first, room), settings) for first in range(0, count, room)]
    return batch.places, [np.concatenate(column)[:count] for column in zip(*chunks, strict=True)]


def _saver(
    path: Path, spec: SweepSpec, pool: Pool, resume: bool, columns: dict[str, np.ndarray], finished: np.ndarray
) -> Saver:
    """Begin a store, or with ``resume`` fill in what an earlier sweep finished."""
    if resume:
        check_resumable(path)
    with contextlib.ExitStack() as locked:
        lock = locked.enter_context(Lock(path.parent))
        if resume:
            store, pool.made_on = resumed(path, spec)
            fill(store, columns)
            finished[:] = columns["code"] >= 0
        else:
            store = begun(path, spec, task_size(finished.size, pool.workers), pool.kind)
        # Keep the lock beyond this block; an error before here releases it.
        locked.pop_all()  # until the sweep is stored
    return Saver(store, columns, finished, lock)
