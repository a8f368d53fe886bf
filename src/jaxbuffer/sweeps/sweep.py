"""`sweep`: many runs, on all cores, in memory that does not grow with what a run remembers.

Runs are solved in small chunks, one after the other within a chunk so that none waits for the slowest, and chunks are
handed to one thread a core: a compiled chunk runs outside Python.
"""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, overload

import jax
import numpy as np

from .._types import Scalar
from ..errors import InputError, check_flag, check_number, check_single, check_whole
from ..fields import POSITIVE, Part
from ..hybrid import Solver, solver_named
from ..mechanisms.registry import mechanism_of
from ..programs.process import check_ready
from ..programs.threads import Pool, cores
from ..progress import counted
from ..run.request import DEFAULT_TOLERANCE, TOLERANCES, check_pair
from .chunk import CHUNK, Runs, Settings, columns_of_chunk, runs
from .found import Sweep as Sweep
from .found import SweepInterrupted as SweepInterrupted
from .found import column_names as column_names
from .found import whole_numbers as whole_numbers
from .grid import Batch, grid
from .store import SweepStore, identity
from .stored import StoredInterrupted as StoredInterrupted
from .stored import StoredSweep as StoredSweep
from .swept import Swept

ONE_FOR_ALL = "all runs of a sweep share it"


class Storing(NamedTuple):
    """How a sweep is stored and watched; fields as in `sweep`."""

    workers: int | None
    progress: Callable[[int, int], None] | None
    folder: str | Path | None
    resume: bool


@overload
def sweep(
    design: Part,
    scenarios: Part,
    duration: Scalar | None = None,
    *,
    over: None = None,
    client: None = None,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    stabilisation: float = 20.0,
    trust: bool = False,
    workers: int | None = None,
    progress: Callable[[int, int], None] | bool | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
) -> Sweep: ...


@overload
def sweep(
    design: Part,
    scenarios: Part,
    duration: Scalar | None = None,
    *,
    over: Mapping[str, Any],
    client: None = None,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    stabilisation: float = 20.0,
    trust: bool = False,
    workers: int | None = None,
    progress: Callable[[int, int], None] | bool | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
) -> Swept: ...


@overload
def sweep(
    design: Part,
    scenarios: Part,
    duration: Scalar | None = None,
    *,
    over: Mapping[str, Any] | None = None,
    client: Any,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    stabilisation: float = 20.0,
    trust: bool = False,
    workers: int | None = None,
    progress: Callable[[int, int], None] | bool | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
) -> StoredSweep: ...


def sweep(
    design: Part,
    scenarios: Part,
    duration: Scalar | None = None,
    *,
    over: Mapping[str, Any] | None = None,
    client: Any = None,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    stabilisation: float = 20.0,
    trust: bool = False,
    workers: int | None = None,
    progress: Callable[[int, int], None] | bool | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
) -> Sweep | Swept | StoredSweep:
    """Simulate many runs of a mechanism.

    **Arguments:**

    - ``design``, ``scenarios``: any of their numbers may be an array of shape (n,), one entry a run.
    - ``duration``: as for `simulate`, or an array of shape (n,) [s].
    - ``over``: values of several fields, all combinations of which are run: by dotted path, "scenario.…" for the
      scenario's, a list of numbers in the field's unit, {"from", "to", "count", "scale"}, or a list of choices.
      ``design`` and ``scenarios`` then have single numbers.
    - ``client``: a `distributed.Client`, the address of Dask's scheduler, "local" (threads) or "processes" on this
      machine: the sweep goes to its workers, which store it in ``folder`` (docs/clusters.md).
    - ``solver``, ``rtol`` [-], ``stabilisation`` [1/s]: as for `simulate`, for all runs.
    - ``trust``: whether to run each again at a tenth of the tolerance, which says how far its numbers can be trusted
      (`Sweep.verdicts`, as of `jb.trust`); takes about twice as long.
    - ``workers``: threads, by default one a core (one on an accelerator, which gets large chunks).
    - ``progress``: called with runs done and asked for, or True for a bar.
    - ``folder``: where runs are stored as they are finished (`SweepStore`), over an earlier sweep's.
    - ``resume``: go on with the sweep in ``folder`` instead.

    **Returns:** a `Sweep`, with ``over`` a `Swept`, with ``client`` a `StoredSweep`; the same bits whether it was
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
    duration = mechanism.defaults.duration if duration is None else duration
    check_number("duration", duration, "s", **POSITIVE)
    check_single("rtol", rtol, "-", ONE_FOR_ALL, **TOLERANCES)
    check_single("stabilisation", stabilisation, "1/s", ONE_FOR_ALL, low=0.0)
    solver = None if solver is None else solver_named(solver)
    if workers is not None:
        check_whole("workers", workers, 1)
    check_flag("trust", trust)
    settings = Settings(np.asarray(rtol, float), np.asarray(stabilisation, float), solver, trust)
    storing = Storing(workers, counted(progress, mechanism.run_name), folder, resume)
    if client is not None:
        return _over_cluster((design, scenarios, duration), over, client, settings, storing)
    if over is None:
        return _run([Batch(None, design, scenarios)], duration, settings, storing)
    check_single("duration", duration, "s", ONE_FOR_ALL)
    asked = grid(over, design, scenarios)
    try:
        found = _run(asked.batches(design, scenarios), duration, settings, storing)
    except SweepInterrupted as stop:
        assert isinstance(stop.found, Sweep)
        raise SweepInterrupted(Swept(asked, design, scenarios, stop.found, stop.done), stop.done) from None
    return Swept(asked, design, scenarios, found, np.ones(len(asked), bool))


def _over_cluster(
    swept: tuple[Part, Part, Any], over: Mapping[str, Any] | None, client: Any, settings: Settings, storing: Storing
) -> StoredSweep:
    """The sweep of a design, scenarios and durations by the workers of a cluster."""
    from .cut import GridSweep, RunsSweep, Template
    from .distributed import Asked, run

    if over is None:
        count = runs(Batch(None, *swept[:2]), swept[2], 1, 1, filled=True).places.size
        return run(Asked(lambda size: RunsSweep(*swept, count, size), count, settings, client, *storing))
    check_single("duration", swept[2], "s", ONE_FOR_ALL)
    asked, template = grid(over, *swept[:2], held=False), Template(*swept)
    return run(Asked(lambda size: GridSweep(asked, template, size), len(asked), settings, client, *storing))


def _run(batches: Sequence[Batch], duration: Any, settings: Settings, storing: Storing) -> Sweep:
    """All runs of all batches."""
    check_ready()
    on_cpu = jax.default_backend() == "cpu"
    most, workers = (CHUNK, cores()) if on_cpu else (4096, 1)
    workers = workers if storing.workers is None else storing.workers
    parts = [runs(batch, duration, most, workers, on_cpu) for batch in batches]
    count, alone = sum(part.places.size for part in parts), batches[0] if len(batches) == 1 else None
    result = Sweep.empty(mechanism_of(batches[0].design), count, *(alone[1:] if alone else (None, None)))
    finished = np.zeros(count, bool)
    columns = list(result.columns.values())
    store, progress = _store(batches, duration, settings, storing, result, finished), storing.progress

    def solve(item: tuple[Runs, int]) -> None:
        part, first = item
        found = columns_of_chunk(*part.call(first), settings)
        its_own = part.places[first : first + part.chunk]
        for mine, values in zip(columns, found, strict=True):
            mine[its_own] = values[: its_own.size]
        finished[its_own] = True

    todo = [
        (part, first)
        for part in parts
        for first in range(0, part.places.size, part.chunk)
        if not finished[part.places[first : first + part.chunk]].all()
    ]
    try:
        if progress is not None and finished.any():
            progress(int(finished.sum()), count)
        for _ in Pool(workers).as_completed(solve, todo):
            if store is not None:
                store.save()
            if progress is not None:
                progress(int(finished.sum()), count)
    except KeyboardInterrupt:
        done = finished.copy()  # calls under way go on for a moment
        found = {name: column.copy() for name, column in result.columns.items()}
        raise SweepInterrupted(dataclasses.replace(result, columns=found), done) from None
    finally:
        if store is not None:
            store.close()
    return result


def _store(
    batches: Sequence[Batch],
    duration: Any,
    settings: Settings,
    storing: Storing,
    result: Sweep,
    finished: np.ndarray,
) -> SweepStore | None:
    """Where runs are stored as they are finished, if anywhere; what an earlier sweep finished is filled in."""
    if storing.folder is None:
        if storing.resume:
            raise InputError("resume needs the folder of the sweep to go on with")
        return None
    alone = len(batches) == 1
    asked = identity(
        design=batches[0].design if alone else [(batch.places, batch.design) for batch in batches],
        scenarios=batches[0].scenarios if alone else [batch.scenarios for batch in batches],
        options=(duration, *settings),
        quantities=tuple(result.columns),
    )
    return SweepStore(Path(storing.folder), asked, list(result.columns.values()), finished, storing.resume)
